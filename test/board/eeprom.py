# SPDX-License-Identifier: Apache-2.0
"""Files on the image of the EEPROM of an emulated board, read by littlefs-python, which is independent of the port."""

import littlefs

OCTETS, BLOCK = 131072, 256
BLOCKS = OCTETS // BLOCK - 1  # The last page has the mark that the EEPROM was formatted.
MARK = b"littlefs"


def files(image):
    """Content of each file, by its name, of an image that is not in use. An image whose files cannot be read is an error."""
    octets = image.read_bytes()
    assert len(octets) == OCTETS and octets[BLOCKS * BLOCK:].startswith(MARK), image
    store = littlefs.LittleFS(context=littlefs.UserContext(buffer=bytearray(octets)), block_size=BLOCK, block_count=BLOCKS, mount=True)
    found = {}
    for name in store.listdir("/"):
        with store.open(name, "rb") as file:
            found[name] = file.read()
    return found
