# SPDX-License-Identifier: Apache-2.0
"""Logs of candump, read and judged by tools of other projects."""

import io
import pathlib
import re
import subprocess

import can

TOOLS = ("7FE#EE", "7FF#FF")  # Probe and sentinel of the recorder.
FD_FLAG = 0x4  # candump shows the kernel's mark of an FD frame among its flags; our log has the frame's own flags only.
REPORT = re.compile(r" [2-3][0-9A-F]{7}#")  # The report of a controller is no frame of the bus.


def frames(path, interface):
    """Identifiers and data of an interface, in order; flags of FD frames without the mark that they are FD."""
    found = []
    for line in pathlib.Path(path).read_text().splitlines():
        _, name, frame = line.split()[:3]
        if name == interface and frame not in TOOLS:
            found.append(re.sub("##(.)", lambda match: f"##{int(match[1], 16) & ~FD_FLAG:X}", frame))
    return found


def of_interface(path, interface):
    """Two logs side by side: that of one interface out of a log of several, without the recorder's marks and
    alignment blanks."""
    own = pathlib.Path(path).with_name(f"{interface}.log")
    with open(path) as source, open(own, "w") as sink:
        rows = (line.split() for line in source)
        sink.writelines(" ".join(row) + "\n" for row in rows if row[1] == interface and row[2] not in TOOLS)
    return own


def assert_database_knows_all(path, database):
    """cantools finds each frame's message, of its length and format, and a value for each signal."""
    lines = [line for line in path.read_text().splitlines() if not REPORT.search(line)]
    count = 0
    for count, frame in enumerate(can.CanutilsLogReader(io.StringIO("\n".join(lines))), 1):
        message = database.get_message_by_frame_id(frame.arbitration_id)  # KeyError: unknown
        assert (len(frame.data), frame.is_fd) == (message.length, message.is_fd), frame
        message.decode(bytes(frame.data), allow_truncated=False)
    assert count == len(lines)


def assert_wireshark_names_all(path):
    """Each frame is CANopen and none is malformed; the remaining frames are reports of a controller."""
    arguments = ["tshark", "-r", path, "-d", "can.subdissector,canopen", "-T", "fields",
                 "-e", "_ws.col.Protocol", "-e", "can.flags.err", "-e", "_ws.malformed", "-e", "_ws.col.Info"]
    told = subprocess.run(arguments, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout.splitlines()
    assert len(told) == len(path.read_text().splitlines())
    seen = [line.split("\t") for line in told]
    assert {protocol for protocol, error, _, _ in seen if error in ("0", "False", "")} == {"CANopen"}
    assert not [frame for frame in seen if frame[2] or not frame[3].strip()]
