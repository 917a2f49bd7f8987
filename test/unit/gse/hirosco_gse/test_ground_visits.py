# SPDX-License-Identifier: Apache-2.0
"""Lines of the actor `ground`, and what of a flight cannot be recorded."""

import socket

import pytest
from hirosco_gse import visits
from hirosco_gse.script import Script, ScriptError
from tm_packets import build_tm

CONNECTED, LOST = b"\0\1", b"\0\2"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 ground dance", "x:1: found 'ground dance', expected ground connect, ground send HEX or ground hang-up"),
        ("1 ground send", "x:1: found 'ground send', expected ground connect"),
        ("1 ground connect twice", "found 'ground connect twice', expected"),
        ("1 ground send 18z1", "x:1: found '18z1', expected octets as hexadecimal digits"),
        ("2 ground connect\n1 ground hang-up", "x:2: time 1 is before the line of `ground` above"),
    ],
)
def test_bad_lines_are_named(text, message, dictionary):
    with pytest.raises(ScriptError) as error:
        Script.parse(text, "x", dictionary)
    assert message in str(error.value)


def test_lines_act_at_their_times_and_in_their_order():
    near, far = socket.socketpair()
    lines = [visits.parse("x:1", time_ns, words) for time_ns, words in ((5, ["connect"]), (5, ["send", "0102"]), (7, ["send", "03"]), (9, ["hang-up"]))]
    others = visits.Visits(lines, lambda: near)
    assert others.next_ns == 5
    others.act(4)
    assert others.next_ns == 5
    others.act(6)
    assert (others.next_ns, far.recv(9)) == (7, b"\1\2")
    others.act(9)
    assert (others.next_ns, far.recv(9), far.recv(9)) == (None, b"\3", b"")
    far.close()


def test_octets_without_a_connection_are_refused():
    others = visits.Visits([visits.parse("x:1", 5, ["send", "00"])], None)
    with pytest.raises(visits.VisitError, match="there is no connection"):
        others.act(5)


def _run(folder, *events):
    """A run whose packet log has these events of COMMUNICATION: (time in s, event)."""
    lines = []
    for sequence, (seconds, event) in enumerate(events):
        lines.append(f"{seconds:.9f} TM {build_tm(2, sequence, 5, 1, event).hex()}\n")
    (folder / "packets.log").write_text("".join(lines), encoding="ascii")
    return folder


def test_one_other_user_is_recorded_a_millisecond_before_the_effect(tmp_path):
    run = _run(tmp_path, (1.0, CONNECTED), (2.0, LOST), (3.0, LOST))
    assert visits.recorded(run) == [(0.999, "0.999000000 ground connect"), (1.999, "1.999000000 ground hang-up")]


def test_the_first_connection_is_that_of_the_operator(tmp_path):
    run = _run(tmp_path, (1.0, CONNECTED), (2.0, CONNECTED), (3.0, LOST))
    (run / "operator.log").write_text("", encoding="utf-8")
    assert [line for _, line in visits.recorded(run)] == ["1.999000000 ground connect", "2.999000000 ground hang-up"]


def test_two_others_at_once_and_protected_telecommands_are_refused(tmp_path):
    run = _run(tmp_path, (1.0, CONNECTED), (2.0, CONNECTED))
    with pytest.raises(visits.VisitError, match="connected at 2.0000 s; their telecommands cannot be told apart"):
        visits.recorded(run)
    (run / "ground.key-file").write_text("key", encoding="ascii")
    with pytest.raises(visits.VisitError, match="protected by a key"):
        visits.recorded(run)
