# SPDX-License-Identifier: Apache-2.0
"""Logs of candump, read and checked by tools of other projects."""

import io
import pathlib
import re
import subprocess

import can

TOOLS = ("7FE#EE", "7FF#FF")  # Frames that mark the beginning and the end of a recording.
# candump shows the kernel's mark of an FD frame among its flags; the simulator's log has only the flags of
# the frame.
FD_FLAG = 0x4
REPORT = re.compile(r" [2-3][0-9A-F]{7}#")  # The report of a controller is not a frame of the bus.


def frames(path, interface):
    """Identifiers and data of an interface, in order; flags of FD frames without the mark that they are FD."""
    found = []
    for line in pathlib.Path(path).read_text().splitlines():
        _, name, frame = line.split()[:3]
        if name == interface and frame not in TOOLS:
            found.append(re.sub("##(.)", lambda match: f"##{int(match[1], 16) & ~FD_FLAG:X}", frame))
    return found


def of_interface(path, interface):
    """Extract the log of one interface from a log of several, without the recorder's marks and alignment
    blanks. Returns the path of a file beside it."""
    own = pathlib.Path(path).with_name(f"{interface}.log")
    with open(path) as source, open(own, "w") as sink:
        rows = (line.split() for line in source)
        sink.writelines(" ".join(row) + "\n" for row in rows if row[1] == interface and row[2] not in TOOLS)
    return own


def assert_database_knows_all(path, database):
    """Expect that cantools finds the message of each frame, with its length and format, and a value for each
    signal."""
    lines = [line for line in path.read_text().splitlines() if not REPORT.search(line)]
    count = 0
    for count, frame in enumerate(can.CanutilsLogReader(io.StringIO("\n".join(lines))), 1):
        message = database.get_message_by_frame_id(frame.arbitration_id)  # KeyError: unknown
        assert (len(frame.data), frame.is_fd) == (message.length, message.is_fd), frame
        message.decode(bytes(frame.data), allow_truncated=False)
    assert count == len(lines)


def assert_wireshark_names_all(path):
    """Expect that Wireshark decodes each frame as CANopen and none as malformed; the remaining frames are
    reports of a controller."""
    arguments = ["tshark", "-r", path, "-d", "can.subdissector,canopen", "-T", "fields",
                 "-e", "_ws.col.Protocol", "-e", "can.flags.err", "-e", "_ws.malformed", "-e", "_ws.col.Info"]
    output = subprocess.run(arguments, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout.splitlines()
    assert len(output) == len(path.read_text().splitlines())
    seen = [line.split("\t") for line in output]
    assert {protocol for protocol, error, _, _ in seen if error in ("0", "False", "")} == {"CANopen"}
    assert not [frame for frame in seen if frame[2] or not frame[3].strip()]
