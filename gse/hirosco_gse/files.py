# SPDX-License-Identifier: Apache-2.0
"""Files on ground that a command sends or stores: those of this machine, or the one that a page has sent to its station."""

import contextlib
import errno
import os
import pathlib

from .command import UsageError
from .session import SessionError
from .values import quoted, shortened

PAGE_FILE = "{}"  # Stands for the file of a page in the words of its command.


class MachineFiles:
    """All files that the user of this process may read and write."""

    def read(self, path, most):
        """Octets of a file; it may have `most` at most. Raises UsageError."""
        try:
            with pathlib.Path(path).open("rb") as file:
                octets = file.read(most + 1)
        except (OSError, ValueError) as problem:
            raise UsageError(f"cannot read {quoted(path)}: {_reason(problem)}") from problem
        return _bounded(octets, path, most)

    def write(self, path, octets):
        """Store a received file. Raises SessionError."""
        try:
            write_whole(path, lambda stream: stream.write(octets))
        except (OSError, ValueError) as problem:
            raise SessionError(f"cannot write {quoted(path)}: {_reason(problem)}") from problem


class PageFiles:
    """The file that a page has sent with its command, or None. Other users of this machine can open the page, but must not use
    files of the user who has started the station."""

    def __init__(self, octets=None):
        self._octets = octets

    def read(self, path, most):
        """Octets of the file of the page; it may have `most` at most. Raises UsageError."""
        if path != PAGE_FILE or self._octets is None:
            raise UsageError(f"a page cannot send {quoted(path)}, a file of the machine of the station; select a file in the tab On board, or use gse")
        return _bounded(self._octets, "the file", most)

    def write(self, path, octets):
        """Refuse to store a file. Raises SessionError."""
        raise SessionError(f"a page cannot write {quoted(path)}, a file of the machine of the station, which would have {len(octets)} octets; use gse")


MACHINE = MachineFiles()


def next_step(problem):
    """The next step of a user if a packet log is absent, or if the user may not read or write a file. The words follow the error; they are
    empty for other errors."""
    if problem.errno == errno.ENOENT and os.path.basename(problem.filename or "") == "packets.log":
        return f"; for a flight that was killed, make it: build/bin/packet-archive-sqlite merge {os.path.dirname(problem.filename) or '.'}"
    if problem.errno not in (errno.EACCES, errno.EPERM, errno.EROFS) or not problem.filename:
        return ""
    if os.path.exists(problem.filename) and not os.access(problem.filename, os.R_OK):
        return "; expected a file that this user may read: change its permissions"
    return "; expected a directory that this user may write: copy the run to such a directory, and name the copy"


def write_whole(path, write):
    """Call write(stream) with a new file that then gets this path. If it fails, for example because the disk is full, an older file of this path
    remains. Raises OSError with the path."""
    path = pathlib.Path(path)
    is_special = path.exists() and not path.is_file()  # Such as /dev/null and pipes, which must remain.
    part = path if is_special else path.with_name(path.name + ".part")
    try:
        with part.open("wb") as stream:
            write(stream)
        if not is_special:
            os.replace(part, path)
    except OSError as error:
        _discard(part, path)
        raise OSError(error.errno, error.strerror, str(path)) from error
    except BaseException:  # Ctrl-C as well.
        _discard(part, path)
        raise


def _discard(part, path):
    if part != path:
        with contextlib.suppress(OSError):
            part.unlink()


def _bounded(octets, path, most):
    if len(octets) > most:
        raise UsageError(f"{shortened(path)} has more than {most} octets, which is the most that can be sent")
    return octets


def _reason(problem):
    return getattr(problem, "strerror", None) or problem
