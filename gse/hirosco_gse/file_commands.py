# SPDX-License-Identifier: Apache-2.0
"""Transfer files between the ground and the file store on board, through the supervisor's buffer, with requests of ST[06] and ST[23]."""

from . import packets
from .command import Command, UsageError, answers, replies_of
from .dictionary import SUPERVISOR_APID
from .session import Rejected, Request, SessionError
from .values import quoted, shortened

BUFFER = 3  # Memory id.
BUFFER_OCTETS = 131072
PIECE_OCTETS = 3840  # Octets of a file in one request, whose packet has at most 4096 octets.
VERIFY = 0x0401  # Failure code: the octets differ. The detail is the checksum of the octets on board.
USAGE = "file upload FILE PATH, file download PATH FILE, file list [DIRECTORY], file delete PATH"


def _request(dictionary, message, given, text):
    return Request(SUPERVISOR_APID, *message, dictionary.catalogue.encode("TC", *message, given), text)


def _named(path):
    """Fields for the path of a file on board."""
    directory, slash, name = path.rpartition("/")
    if not slash or not name:
        raise UsageError(f"found {quoted(path)}, expected the path of a file on board, /DIRECTORY/NAME")
    return {"repository_path": directory or "/", "file_name": name}


def _load(dictionary, path, offset, length, checksum):
    """Request that loads a part of a file into the buffer, if the part has this checksum."""
    area = {"start_address": 0, "offset_in_file": offset, "length": length, "checksum": checksum}
    return _request(dictionary, (6, 19), {"memory_id": BUFFER, **_named(path), "n": [area]}, f"load the buffer from {path}")


def _upload_requests(dictionary, octets, path):
    """Requests that fill the buffer, write it to a file, and compare the file with the sent octets on board."""
    if not octets:
        yield _request(dictionary, (23, 1), {**_named(path), "maximum_size": 0, "file_locked_status": 0}, f"create {path}")
        return
    for start in range(0, len(octets), PIECE_OCTETS):
        piece = octets[start : start + PIECE_OCTETS]
        area = {"start_address": start, "data": piece, "checksum": packets.crc16(piece)}
        yield _request(dictionary, (6, 2), {"memory_id": BUFFER, "n": [area]}, f"load the buffer at {start}")
    area = {"start_address": 0, "length": len(octets)}
    yield _request(dictionary, (6, 20), {"memory_id": BUFFER, **_named(path), "n": [area]}, f"write {path}")
    yield _load(dictionary, path, 0, len(octets), packets.crc16(octets))


def _upload(dictionary, source, path):
    octets = dictionary.files.read(source, BUFFER_OCTETS)
    requests = tuple(_upload_requests(dictionary, octets, path))
    text = f"file upload {path}"

    def procedure(session, timeout_ns):
        for request in requests:
            yield from session.execute(request, timeout_ns)
        return [{"text": f"{text}: {len(octets)} octets, checked on board"}]

    return Command(text, procedure, requests[:1])


def _fetch(session, dictionary, path, span, timeout_ns):
    """Procedure: read a part of a file through the buffer."""
    checksum = 0
    while True:
        try:
            yield from session.execute(_load(dictionary, path, *span, checksum), timeout_ns)
            break
        except Rejected as refusal:  # The failure of the first attempt contains the checksum of the octets in the file.
            if refusal.failure.code != VERIFY or refusal.failure.detail == checksum:
                raise
            checksum = refusal.failure.detail
    area = {"start_address": 0, "length": span[1]}
    dump = _request(dictionary, (6, 5), {"memory_id": BUFFER, "n": [area]}, "dump the buffer")
    done = yield from session.execute(dump, timeout_ns)
    octets = b"".join(bytes.fromhex(area["data"]) for _, decoded in replies_of(done, (6, 6)) for area in decoded["n"])
    if len(octets) != span[1] or packets.crc16(octets) != checksum:
        raise SessionError(f"{shortened(path)}: {len(octets)} octets were received, which are not those of the file: another user uses the buffer; try again")
    return octets


def _download(dictionary, path, target):
    about = _request(dictionary, (23, 3), _named(path), f"attributes of {path}")
    text, files = f"file download {path}", dictionary.files

    def procedure(session, timeout_ns):
        (_, found), = (yield from answers(session, about, (23, 4), timeout_ns))[:1]
        if "error" in found:
            raise SessionError(f"{about.text}: {found['error']}")
        size = found["file_size"]
        octets = b""
        for start in range(0, size, BUFFER_OCTETS):
            span = start, min(BUFFER_OCTETS, size - start)
            octets += yield from _fetch(session, dictionary, path, span, timeout_ns)
        files.write(target, octets)
        return [{"text": f"{text}: {len(octets)} octets"}]

    return Command(text, procedure, (about,))


def _list(dictionary, directory):
    request = _request(dictionary, (23, 12), {"repository_path": directory}, f"file list {directory}")

    def procedure(session, timeout_ns):
        found = yield from session.execute(request, timeout_ns)
        entries = [entry for _, decoded in replies_of(found, (23, 13)) for entry in decoded["n"]]
        return [{"text": f"{entry['object_type']:9} {entry['object_name']}", **entry} for entry in entries]

    return Command(request.text, procedure, (request,))


def _delete(dictionary, path):
    request = _request(dictionary, (23, 2), _named(path), f"file delete {path}")

    def procedure(session, timeout_ns):
        yield from session.execute(request, timeout_ns)
        return [{"text": f"{request.text}: completed"}]

    return Command(request.text, procedure, (request,))


def _file(dictionary, words):
    forms = {("upload", 3): _upload, ("download", 3): _download, ("list", 2): _list, ("delete", 2): _delete}
    if words == ["list"]:
        words = ["list", "/"]
    form = forms.get((words[0] if words else "", len(words)))
    if form is None:
        raise UsageError(f"usage: {USAGE}")
    return form(dictionary, *words[1:])


VERBS = {"file": (_file, USAGE, "upload, download, list or delete files on board, through the supervisor's buffer")}
