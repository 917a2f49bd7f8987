# SPDX-License-Identifier: Apache-2.0
"""The housekeeping structures that stations have enabled in one flight, and still use for their pages.

Each station keeps its own list in a file of the run directory, `station-*.display`, under a lock that the kernel releases however the process
ends. So a station knows what others use, and what a station that was killed has left enabled. A line is the name of a subsystem and the id of a
structure; the newest line counts, and one that begins with `-` ends the use."""

import contextlib
import fcntl
import os
import pathlib
import tempfile

PREFIX, SUFFIX = "station-", ".display"


def _listed(text):
    """Set of (subsystem, id). A station that was killed may have left the last line incomplete."""
    found = set()
    for line in text.split("\n")[:-1]:
        name, _, number = line.removeprefix("-").partition(" ")
        if number.isdecimal() and number.isascii():
            (found.discard if line.startswith("-") else found.add)((name, int(number)))
    return found


class Uses:
    """The list of one station in a run directory. A directory that cannot be written has no lists: stations then know nothing of each other."""

    def __init__(self, run):
        self._run, self._file = pathlib.Path(run), None

    def note(self, use, is_used=True):
        """Note that this station uses (subsystem, id) from now on, or no longer."""
        if self._file is None and is_used:
            with contextlib.suppress(OSError):
                self._create()
        if self._file:
            with contextlib.suppress(OSError):
                os.write(self._file[0], f"{'' if is_used else '-'}{use[0]} {use[1]}\n".encode())

    def _create(self):
        """Create the file; it gets its name when it is locked."""
        handle, hidden = tempfile.mkstemp(prefix=f".{PREFIX}", dir=self._run)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX)
            path = self._run / f"{PREFIX}{os.getpid()}-{pathlib.Path(hidden).name.rpartition('-')[2]}{SUFFIX}"
            os.rename(hidden, path)
        except OSError:
            os.close(handle)
            os.unlink(hidden)
            raise
        self._file = handle, path

    def clear(self):
        """This station uses nothing any more."""
        if self._file:
            handle, path = self._file
            self._file = None
            with contextlib.suppress(OSError):
                path.unlink()
            os.close(handle)

    def of_others(self):
        """(uses of other stations, uses of stations that have died). The lists of dead stations are removed: the caller takes their uses over."""
        living, left = set(), set()
        for path in self._run.glob(f"{PREFIX}*{SUFFIX}"):
            if self._file and path == self._file[1]:
                continue
            with contextlib.suppress(OSError), path.open(encoding="utf-8", errors="replace") as file:
                found = living
                with contextlib.suppress(BlockingIOError):
                    fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
                    path.unlink()
                    found = left
                found |= _listed(file.read())
        return living, left
