// SPDX-License-Identifier: Apache-2.0
/// Image of the EEPROM of an emulated board: a file in the storage directory of the run, which the emulator
/// reads and writes. It keeps the records of the program from one life to the next, and from one flight to
/// the next.
#ifndef LAUNCHER_EEPROM_IMAGE_H
#define LAUNCHER_EEPROM_IMAGE_H

#include "osal/include/osal/file.h"
#include "osal/include/osal/target_eeprom.h"

typedef struct {        // Private; both are closed at first.
    osal_file_t file;   ///< For reading and writing. Has the lock.
    osal_file_t reader; ///< For reading: QEMU opens an image for reading before it opens it for writing.
} eeprom_image_t;

/// Open `<storage>/<component>.eeprom`, and create it if it is missing: blank, all octets 0xFF. It is locked
/// until it is closed here and in each process that has inherited its descriptors. STATUS_OK; for other
/// statuses, the image is closed: STATUS_BUSY (another flight uses it, or still the emulator of the earlier
/// life of the component), STATUS_TOO_LARGE (the path, or the file: it is not an image), STATUS_DENIED,
/// STATUS_FULL, STATUS_IO, STATUS_NOT_FOUND (the directory).
MUST_USE status_t eeprom_image_open(eeprom_image_t* image, const char* storage, const char* component);
void eeprom_image_close(eeprom_image_t* image);

#endif // LAUNCHER_EEPROM_IMAGE_H
