# SPDX-License-Identifier: Apache-2.0
"""Authenticated telecommands: TC transfer frames (CCSDS 232.0-B) with Space Data Link Security (CCSDS 355.0-B), AES-256-GCM.

A key is a file of 32 octets, raw or as 64 hexadecimal digits, which only its owner can read. Its directory contains two marks: FILE.sent,
the highest session number that the ground has used, and FILE.received, that of the spacecraft. Each connection uses a session of its
own, whose number is written to the disk before its first frame is sent, so that no initialization vector is used twice.
docs/ground-link-security.md describes the layout of frames and marks."""

import fcntl
import os
import pathlib
import secrets
import struct
import zlib

from .session import LinkLost

SPACECRAFT, SPI = 1, 1
KEY_OCTETS, MAC_OCTETS, FRAME_MAX = 32, 16, 1024
HEAD = struct.Struct(">HHBBHIII")  # Header words, number, segment header, SPI, and the vector: zero, session, count.
PART_MAX = FRAME_MAX - HEAD.size - MAC_OCTETS
BYPASS = 0x2000  # Type-BD: TCP preserves the order.
MIDDLE, FIRST, LAST, WHOLE = 0x00, 0x40, 0x80, 0xC0
NUMBER_MAX = 0xFFFFFFFF
RECORD = struct.Struct(">4sB3xI8s8x")  # A mark: magic, version, session number, check value of the key.
MAGIC, VERSION = b"SDLS", 1
APART = 512  # Offset of the second copy of a mark in its file: the copies are in different sectors.
OTHERS = 0o077  # Permissions of group and others.


class SecurityError(Exception):
    """A key or a mark that cannot be used; the text names the file, the reason and the next step."""


def _cipher(key):
    try:
        from cryptography.hazmat.primitives.ciphers.aead import AESGCM
    except ImportError as error:
        raise SecurityError("authenticated commands need the Python package cryptography: run make, then build/venv/bin/gse") from error
    return AESGCM(key)


def key_check(key):
    """A check value that distinguishes keys without revealing them, computed with a vector that no frame uses."""
    return _cipher(key).encrypt(bytes(12), b"", None)[:8]


def read_key(path):
    """The 32 octets of a key file. Raises SecurityError."""
    try:
        with open(path, "rb") as file:
            mode = os.fstat(file.fileno()).st_mode
            octets = file.read(KEY_OCTETS * 2 + 2)
    except OSError as error:
        raise SecurityError(f"{path}: cannot read the key: {error.strerror}; `gse key make FILE` makes one") from error
    if mode & OTHERS:
        raise SecurityError(f"{path}: other users than its owner have access to the key; run chmod 600 {path}")
    if len(octets) == KEY_OCTETS:
        return octets
    try:
        text = octets.decode("ascii").removesuffix("\n")
        if len(text) == 2 * KEY_OCTETS:
            return bytes.fromhex(text)
    except ValueError:
        pass
    raise SecurityError(f"{path}: not a key; expected {KEY_OCTETS} octets or {2 * KEY_OCTETS} hexadecimal digits")


def _record(session, check):
    body = RECORD.pack(MAGIC, VERSION, session, check)
    return body + zlib.crc32(body).to_bytes(4, "big")


def _session_of(record, check):
    """Session number of a copy that is complete and belongs to this key; otherwise None."""
    if len(record) != RECORD.size + 4:
        return None
    session = RECORD.unpack_from(record)[2]
    return session if record == _record(session, check) else None


def _put(descriptor, session, check):
    """Write both copies, one after the other, the damaged or older one first: a power cut destroys at most the copy that is being written,
    and the other one is sound."""
    known = [_session_of(os.pread(descriptor, RECORD.size + 4, copy * APART), check) for copy in (0, 1)]
    first = 0 if known[0] is None or (known[1] is not None and known[0] < known[1]) else 1
    for copy in (first, 1 - first):
        os.pwrite(descriptor, _record(session, check), copy * APART)
        os.fsync(descriptor)


def read_mark(descriptor, check):
    """Highest session of an open mark, or None: lost, damaged, or of another key."""
    found = [_session_of(os.pread(descriptor, RECORD.size + 4, copy * APART), check) for copy in (0, 1)]
    return max((session for session in found if session is not None), default=None)


def make_key(path):
    """A new key and its marks. Raises SecurityError; nothing is overwritten."""
    path, key = pathlib.Path(path), secrets.token_bytes(KEY_OCTETS)
    check, made = key_check(key), []
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        for name in (f"{path}.received", f"{path}.sent", path):  # The key is made last, so that it never exists without its marks.
            descriptor = os.open(name, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
            made.append(name)
            with open(descriptor, "wb", buffering=0) as file:
                if name == path:
                    file.write(key.hex().encode("ascii") + b"\n")
                    os.fsync(descriptor)
                else:
                    _put(descriptor, 0, check)
    except OSError as error:
        for name in made:
            os.unlink(name)
        hint = "; use another file name for a new key" if isinstance(error, FileExistsError) else ""
        raise SecurityError(f"{error.filename or path}: cannot make the key: {error.strerror}{hint}") from error


def next_session(path, check):
    """Reserve the next session number of a key. It is written to the disk before it is used. Several processes may call
    this function at the same time. Raises SecurityError."""
    mark = f"{path}.sent"
    try:
        descriptor = os.open(mark, os.O_RDWR)
    except OSError as error:
        raise SecurityError(f"{mark}: {error.strerror}: without it numbers could be used twice; make a new key: gse key make") from error
    try:
        if os.fstat(descriptor).st_mode & OTHERS:
            raise SecurityError(f"{mark}: other users than its owner have access to the mark of the key; run chmod 600 {mark}")
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        last = read_mark(descriptor, check)
        if last is None or last >= NUMBER_MAX:
            raise SecurityError(f"{mark}: damaged, of another key, or used up; make a new key: gse key make")
        _put(descriptor, last + 1, check)
    except OSError as error:
        raise SecurityError(f"{mark}: {error.strerror}: the number could not be reserved; nothing was sent") from error
    finally:
        os.close(descriptor)
    return last + 1


def frame(cipher, session, count, part, octets, spi=SPI):
    """One protected frame."""
    length = HEAD.size + len(octets) + MAC_OCTETS
    head = HEAD.pack(BYPASS | SPACECRAFT, length - 1, 0, part, spi, 0, session, count)
    return head + cipher.encrypt(head[8:20], bytes(octets), head)


class Sender:
    """Protects the telecommands of one connection; its session begins with the first telecommand."""

    def __init__(self, path):
        """Raises SecurityError."""
        self._path, key = path, read_key(path)
        self._check, self._cipher = key_check(key), _cipher(key)
        self.begin_anew()

    def begin_anew(self):
        """The following telecommands use another connection, with a session of its own."""
        self._session = None
        self._count = 0

    def __call__(self, packet):
        """The frames of one telecommand packet. Raises SecurityError, LinkLost."""
        if self._session is None:
            self._session = next_session(self._path, self._check)
        parts = [packet[at : at + PART_MAX] for at in range(0, len(packet), PART_MAX)]
        if self._count + len(parts) > NUMBER_MAX:
            raise LinkLost("all numbers of this connection are used; connect again")
        octets = bytearray()
        for index, part in enumerate(parts):
            flags = (FIRST if index == 0 else 0) | (LAST if index == len(parts) - 1 else 0)
            octets += frame(self._cipher, self._session, self._count, flags, part)
            self._count += 1
        return bytes(octets)
