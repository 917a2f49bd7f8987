# SPDX-License-Identifier: Apache-2.0
"""Keys, marks and frames of the ground: the frames of the spacecraft's tests, numbers that are used only
once, refused files."""

import concurrent.futures
import os
import zlib

import pytest
from hirosco_gse import sdls
from hirosco_gse.sdls import SecurityError

KEY = bytes(range(32))
PACKET = bytes.fromhex("1801c0000006190811010001c5d2")


@pytest.fixture
def key(tmp_path):
    """A key that the command has made."""
    path = tmp_path / "ground.key"
    sdls.make_key(path)
    return path


def _numbers(octets):
    """(session, count, part) of each frame."""
    found = []
    while octets:
        words = sdls.HEAD.unpack_from(octets)
        found.append((words[6], words[7], words[3]))
        octets = octets[words[1] + 1 :]
    return found


# The same frames are in test/unit/fsw/framework/sdls/test_sdls.c for the spacecraft's side, which uses
# another library.
@pytest.mark.parametrize(
    ("session", "count", "part", "text", "octets"),
    [
        (1, 0, sdls.WHOLE, PACKET.hex(), "2001003100c00001000000000000000100000000290aa47d319bc59af5529e9a7be54538e048770377ec5a9c6d922351acba"),
        (0xFFFFFFFF, 0xFFFFFFFF, sdls.WHOLE, "55", "2001002400c0000100000000ffffffffffffffff577a24c457db7bd8742aa304c98340643d"),
        (7, 0, sdls.FIRST, "616263", "20010026004000010000000000000007000000008317ae457af0ad7502a7c483e925565fb06fb9"),
        (7, 1, sdls.LAST, "64656667", "200100270080000100000000000000070000000162dfb75b881091d14bcf67a8a11544b308c506bf"),
    ],
)
def test_frames_equal_those_of_the_spacecraft_s_tests(session, count, part, text, octets):
    assert sdls.frame(sdls._cipher(KEY), session, count, part, bytes.fromhex(text)).hex() == octets
    assert sdls.key_check(KEY).hex() == "f05d76ae4ab99fe5"


def test_only_their_owner_has_access_to_key_and_marks(key):
    for ending in ("", ".sent", ".received"):
        assert os.stat(f"{key}{ending}").st_mode & 0o777 == 0o600
    assert len(sdls.read_key(key)) == 32
    with pytest.raises(SecurityError, match="use another file name"):
        sdls.make_key(key)


def test_a_key_is_made_completely_or_not_at_all(tmp_path):
    sdls.make_key(tmp_path / "new" / "keys" / "ground.key")
    assert (tmp_path / "new" / "keys").stat().st_mode & 0o777 == 0o700
    (tmp_path / "half.sent").touch()
    with pytest.raises(SecurityError, match="half.sent: cannot make the key: File exists"):
        sdls.make_key(tmp_path / "half")
    assert sorted(path.name for path in tmp_path.glob("half*")) == ["half.sent"]


def test_a_key_is_octets_or_digits(key):
    octets = sdls.read_key(key)
    key.write_bytes(octets)
    assert sdls.read_key(key) == octets
    for wrong in (b"", octets[:31], octets + b"x", octets.hex().encode() + b"00", b"g" * 64, octets.hex().encode() + b"\n\n"):
        key.write_bytes(wrong)
        with pytest.raises(SecurityError, match="not a key"):
            sdls.read_key(key)


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o620, 0o601])
def test_a_key_that_others_can_read_is_refused(key, mode):
    key.chmod(mode)
    with pytest.raises(SecurityError, match="chmod 600"):
        sdls.Sender(key)


def test_each_connection_has_a_session_that_begins_with_its_first_command(key):
    first, second, silent = sdls.Sender(key), sdls.Sender(key), sdls.Sender(key)
    assert _numbers(second(PACKET)) == [(1, 0, sdls.WHOLE)]
    assert _numbers(first(PACKET) + first(PACKET)) == [(2, 0, sdls.WHOLE), (2, 1, sdls.WHOLE)]
    assert _numbers(second(PACKET)) == [(1, 1, sdls.WHOLE)]
    assert _numbers(silent(PACKET)) == [(3, 0, sdls.WHOLE)]


def test_long_packets_are_sent_in_parts(key):
    sender = sdls.Sender(key)
    parts = [sdls.FIRST, sdls.MIDDLE, sdls.MIDDLE, sdls.MIDDLE, sdls.LAST]
    assert _numbers(sender(bytes(4096))) == [(1, count, part) for count, part in enumerate(parts)]
    assert _numbers(sender(bytes(sdls.PART_MAX))) == [(1, 5, sdls.WHOLE)]


def test_programs_at_the_same_time_have_different_sessions(key):
    check = sdls.key_check(sdls.read_key(key))
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        sessions = list(pool.map(lambda _: sdls.next_session(key, check), range(64)))
    assert sorted(sessions) == list(range(1, 65))


def _mark(key):
    return key.with_name(key.name + ".sent")


@pytest.mark.parametrize("mode", [0o666, 0o660, 0o602, 0o644])
def test_a_mark_to_which_others_have_access_is_refused(key, mode):
    _mark(key).chmod(mode)
    with pytest.raises(SecurityError, match=r"\.sent: other users .*chmod 600"):
        sdls.Sender(key)(PACKET)
    _mark(key).chmod(0o600)
    assert _numbers(sdls.Sender(key)(PACKET)) == [(1, 0, sdls.WHOLE)]


@pytest.mark.parametrize("damage", [lambda path: path.unlink(), lambda path: path.write_bytes(b""), lambda path: path.write_bytes(bytes(544))])
def test_a_lost_mark_is_not_made_again(key, damage):
    damage(_mark(key))
    with pytest.raises(SecurityError, match="gse key make"):
        sdls.Sender(key)(PACKET)
    assert not _mark(key).exists() or len(_mark(key).read_bytes()) in (0, 544)


def test_a_mark_of_another_key_is_refused(key, tmp_path):
    sdls.make_key(tmp_path / "other")
    _mark(key).write_bytes((tmp_path / "other.sent").read_bytes())
    with pytest.raises(SecurityError, match="of another key"):
        sdls.Sender(key)(PACKET)


def test_no_number_is_used_again_after_a_torn_write(key):
    """The power may be cut during each write of the mark; no number is used twice."""
    sdls.Sender(key)(PACKET)
    check, before = sdls.key_check(sdls.read_key(key)), _mark(key).read_bytes()
    sdls.next_session(key, check)
    after = _mark(key).read_bytes()
    for first, second in ((0, 512), (512, 0)):
        for cut in range(33):
            torn = bytearray(before)
            torn[first : first + cut] = after[first : first + cut]
            _mark(key).write_bytes(torn)
            assert sdls.next_session(key, check) in (2, 3)
            torn[first : first + 32] = after[first : first + 32]
            torn[second : second + cut] = after[second : second + cut]
            _mark(key).write_bytes(torn)
            assert sdls.next_session(key, check) == 3


def test_a_key_whose_session_numbers_are_used_up_is_refused(key):
    check = sdls.key_check(sdls.read_key(key))
    body = sdls.RECORD.pack(sdls.MAGIC, sdls.VERSION, 0xFFFFFFFE, check)
    record = body + zlib.crc32(body).to_bytes(4, "big")
    _mark(key).write_bytes(record + bytes(480) + record)
    assert sdls.next_session(key, check) == 0xFFFFFFFF
    with pytest.raises(SecurityError, match="used up"):
        sdls.next_session(key, check)


def test_another_connection_is_another_session(key):
    sender = sdls.Sender(key)
    first = _numbers(sender(PACKET) + sender(PACKET))
    sender.begin_anew()
    assert first == [(1, 0, sdls.WHOLE), (1, 1, sdls.WHOLE)]
    assert _numbers(sender(PACKET)) == [(2, 0, sdls.WHOLE)]
