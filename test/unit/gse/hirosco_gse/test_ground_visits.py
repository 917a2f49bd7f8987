# SPDX-License-Identifier: Apache-2.0
"""Lines of the actor `ground` in a script, and their recording from the packet log of a flight."""

import contextlib
import signal
import socket
import threading

import pytest
from hirosco_gse import packets, visits
from hirosco_gse.cli import main
from hirosco_gse.script import Script, ScriptError
from hirosco_gse.session import Session
from tm_packets import build_tm

CONNECTED, LOST = b"\0\1", b"\0\2"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 ground dance", "x:1: found 'ground dance', expected ground connect, ground send HEX or ground hang-up"),
        ("1 ground send", "x:1: found 'ground send', expected ground connect"),
        ("1 ground connect once more", "found 'ground connect once more', expected"),
        ("1 ground send 18z1", "x:1: found '18z1', expected octets as hexadecimal digits"),
        ("2 ground connect\n1 ground hang-up", "x:2: time 1 is before the line of `ground` above, expected at least 2"),
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


def _run(directory, *events):
    """A run whose packet log has these events of COMMUNICATION: (time [s], event)."""
    lines = []
    for sequence, (seconds, event) in enumerate(events):
        lines.append(f"{seconds:.9f} TM {build_tm(2, sequence, 5, 1, event).hex()}\n")
    (directory / "packets.log").write_text("".join(lines), encoding="ascii")
    return directory


def test_one_other_user_is_recorded_a_millisecond_before_the_effect(tmp_path):
    run = _run(tmp_path, (1.0, CONNECTED), (2.0, LOST), (3.0, LOST))
    assert visits.recorded(run) == [(0.999, "0.999000000 ground connect"), (1.999, "1.999000000 ground hang-up")]


def test_the_first_connection_is_that_of_the_operator(tmp_path):
    run = _run(tmp_path, (1.0, CONNECTED), (2.0, CONNECTED), (3.0, LOST))
    (run / "operator.log").write_text("", encoding="utf-8")
    assert [line for _, line in visits.recorded(run)] == ["1.999000000 ground connect", "2.999000000 ground hang-up"]


def _send(user, sequence):
    return packets.build_tc(16, sequence, 17, 1, source=user)


def _log(directory, *entries):
    """A packet log with events of COMMUNICATION and telecommands: (time [s], octets)."""
    lines = [f"{seconds:.9f} {'TC' if octets[0] & 0x10 else 'TM'} {octets.hex()}\n" for seconds, octets in entries]
    (directory / "packets.log").write_text("".join(lines), encoding="ascii")
    return directory


def test_each_user_has_a_connection_of_its_own(tmp_path):
    """A station connects, then two commands of the command line one after the other; then the station sends
    again and disconnects."""
    came, gone = build_tm(2, 0, 5, 1, CONNECTED), build_tm(2, 0, 5, 1, LOST)
    sent = [_send(3, 1), _send(1, 7), _send(1, 8), _send(3, 2)]
    run = _log(tmp_path, (1.0, came), (1.1, sent[0]), (2.0, came), (2.1, sent[1]), (2.2, gone), (3.0, came), (3.1, sent[2]), (3.2, gone), (4.0, sent[3]), (5.0, gone))
    words = [line.split()[2:] for _, line in visits.recorded(run)]
    assert words == [["connect", "1"], ["send", sent[0].hex(), "1"], ["connect", "2"], ["send", sent[1].hex(), "2"], ["hang-up", "2"], ["connect", "3"],
                     ["send", sent[2].hex(), "3"], ["hang-up", "3"], ["send", sent[3].hex(), "1"], ["hang-up", "1"]]


def test_the_connection_that_goes_on_sending_has_not_ended(tmp_path):
    """The older connection has ended, because the newer one sends afterwards."""
    came, gone = build_tm(2, 0, 5, 1, CONNECTED), build_tm(2, 0, 5, 1, LOST)
    run = _log(tmp_path, (1.0, came), (1.1, _send(3, 1)), (2.0, came), (2.1, _send(4, 7)), (2.2, gone), (2.3, _send(4, 8)), (3.0, gone))
    lines = [line.split() for _, line in visits.recorded(run)]
    assert [[words[2], words[-1]] for words in lines] == [  # Verb and name of the connection.
        ["connect", "1"], ["send", "1"], ["connect", "2"], ["send", "2"], ["hang-up", "1"], ["send", "2"], ["hang-up", "2"]]


def test_named_connections_are_performed_side_by_side():
    pairs = [socket.socketpair() for _ in range(2)]
    near = [pair[0] for pair in pairs]
    texts = ("connect a", "connect b", "send 01 a", "send 02 b", "hang-up a", "send 03 b")
    others = visits.Visits([visits.parse("x:1", 1, text.split()) for text in texts], lambda: near.pop(0))
    others.act(1)
    assert [pairs[0][1].recv(9), pairs[0][1].recv(9)] == [b"\1", b""]
    pairs[1][1].settimeout(10)
    heard = b""
    while len(heard) < 2:
        heard += pairs[1][1].recv(9)
    assert heard == b"\2\3"
    others.close()
    for _, far in pairs:
        far.close()


def test_a_log_without_the_connection_and_protected_telecommands_are_refused(tmp_path):
    run = _log(tmp_path, (2.0, _send(3, 1)))
    with pytest.raises(visits.VisitError, match="at 2.0000 s came on no connection of the packet log"):
        visits.recorded(run)
    (run / "ground.key-file").write_text("key", encoding="ascii")
    with pytest.raises(visits.VisitError, match="protected by a key"):
        visits.recorded(run)


def test_a_malformed_report_is_skipped_and_a_damaged_log_of_the_operator_is_refused(tmp_path):
    run = _log(tmp_path, (1.0, build_tm(2, 0, 5, 1, CONNECTED)), (1.5, bytes(9)), (2.0, _send(3, 1)))
    assert [line.split()[2] for _, line in visits.recorded(run)] == ["connect", "send"]
    (run / "operator.log").write_bytes(b"\xff\n")
    with pytest.raises(visits.VisitError, match="operator.log:1: found .* expected a step of the operator"):
        visits.recorded(run)


def test_a_script_without_a_step_lasts_until_the_last_action_of_other_users(dictionary):
    """Otherwise the flight would end before their actions."""
    session = Session(dictionary, 1)
    procedure = Script.parse("1 ground connect\n3 ground hang-up\n", "x", dictionary).procedure(session, 0)
    for session.now_ns in (0, 2_999_999_999):
        assert next(procedure) == 3_000_000_000
    session.now_ns = 3_000_000_000
    assert list(procedure) == []
    assert list(Script.parse("0 hand rest\n", "x", dictionary).procedure(session, 0)) == []


def test_a_flight_without_an_operator_is_repeated_without_its_connection(dictionary_path, tmp_path):
    """Only the recorded user connects: another connection would be in the packet log. The operator takes part in the scheduler without a port,
    and leaves in a grant after the last action."""
    (tmp_path / "s.scn").write_text("0.1 hand rest\n0.002 ground connect\n0.004 ground send 0102\n")
    ground = socket.create_server(("127.0.0.1", 0))
    scheduler = socket.socket(socket.AF_UNIX)
    scheduler.bind(str(tmp_path / "cosim"))
    scheduler.listen(1)
    said, received = [], []

    def grant():
        client = scheduler.accept()[0]
        lines = client.makefile("rw")
        said.append(lines.readline())
        for time_ns in (0, 2_000_000, 4_000_000, 4_500_000):
            lines.write(f"grant {time_ns} 0 0 0\n")
            lines.flush()
            said.append(lines.readline())
        stream = ground.accept()[0]
        received.append(stream.recv(2))
        ground.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            received.append(ground.accept()[1])
        for one in (stream, lines, client):
            one.close()

    thread, before = threading.Thread(target=grant), signal.getsignal(signal.SIGTERM)
    thread.start()
    try:
        words = ["--port", str(ground.getsockname()[1]), "--dictionary", str(dictionary_path), "--run", str(tmp_path)]
        assert main([*words, "--cosimulation", str(tmp_path / "cosim"), "script", str(tmp_path / "s.scn")]) == 0
    finally:
        signal.signal(signal.SIGTERM, before)
        thread.join()
        for one in (ground, scheduler):
            one.close()
    assert received == [b"\1\2"]
    assert said == ["join operator 0\n", "done 2000000 0 0\n", "done 4000000 0 0\n", "done 4000000 0 0\n", "leave\n"]
    assert not (tmp_path / "operator.log").exists()  # visits.py takes a flight without this file for one without an operator.
