# SPDX-License-Identifier: Apache-2.0
"""Scenario scripts: refused files, steps in stepped and in real time, and texts of failures."""

import contextlib
import json
import pathlib
import resource
import signal
import socket
import struct
import threading
import types

import pytest
from hirosco_gse import packets
from hirosco_gse.cli import main
from hirosco_gse.dictionary import Dictionary
from hirosco_gse.link import RealDriver, StepClock, StepDriver
from hirosco_gse.script import Script, ScriptError, ScriptFailure, _failure_code
from hirosco_gse.session import LinkLost, Request, RequestLost, Session, TimedOut
from spacecraft import Spacecraft, failure, success
from tm_packets import build_tm

ROOT = pathlib.Path(__file__).resolve().parents[4]
SECOND = 1_000_000_000


@pytest.mark.parametrize("path", sorted((ROOT / "sim" / "scenarios").glob("*.scn")), ids=lambda path: path.stem)
def test_the_scenarios_of_the_repository_load(path, dictionary_path_of):
    """Each is loaded with the dictionary of the mission that has its name or the first word of its name,
    otherwise with that of rokviss."""
    missions = {file.stem for file in (ROOT / "descriptors" / "missions").glob("*.xml")}
    mission = next((name for name in (path.stem, path.stem.split("-")[0]) if name in missions), "rokviss")
    Script.load(path, Dictionary.load(dictionary_path_of(mission)))


def test_an_expected_refusal_may_have_a_name_of_the_addressee(dictionary_path_of, tmp_path):
    ur5e = Dictionary.load(dictionary_path_of("ur5e"))
    path = tmp_path / "some.scn"
    path.write_text("0 operator expect-refusal LINE cmd UR5E.STOP\n", encoding="utf-8")
    (step,) = Script.load(path, ur5e).steps
    assert _failure_code(step, step.command, ur5e) == 0x8003
    path.write_text("0 operator expect-refusal LIME cmd UR5E.STOP\n", encoding="utf-8")
    with pytest.raises(ScriptError, match="found 'LIME', expected a failure code such as 0x0111, or of: JOINT_RANGE, JOINT_SPEED, LINE"):
        Script.load(path, ur5e)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("soon operator ping", "found 'soon', expected a time"),
        ("-1 operator ping", "expected a time"),
        ("nan operator ping", "expected a time"),
        ("1 pilot ping", "found 'pilot', expected"),
        ("1 operator", "expected <time>"),
        ("1 operator dance", "no command 'dance'"),
        ("1 operator state MANIPULATOR FLYING", "not a state that can be requested"),
        ("1 operator wait-state MANIPULATOR FLYING 1", "no state 'FLYING'"),
        ("1 operator wait-state MANIPULATOR OFFLINE", "usage: wait-state"),
        ("1 operator wait-state MANIPULATOR OFFLINE long", "found 'long'"),
        ("1 operator wait-event JOYSTICK PARTY 1", "no event of JOYSTICK 'PARTY'"),
        ("1 operator expect-refusal state MANIPULATOR OFFLINE", "expected a failure code"),
        ("1 operator expect-refusal 0x0111", "usage: expect-refusal"),
        ("1 operator nowait fly", "no command 'fly'"),
        ("1 operator try", "usage: try"),
        ("1 operator ping 'all", "No closing quotation in '1 operator ping 'all': close the quotation, or put a"),
        ("1 operator try nowait fly", "no command 'fly'"),
        ("1 operator nowait at +60 ping SUPERVISOR", "has to wait for answers"),
        ("1 operator end now", "usage: end"),
        ("2 operator ping\n1 operator ping", "before the operator's line above, expected at least 2"),
    ],
)
def test_a_line_that_is_no_step_is_refused(dictionary, text, message):
    with pytest.raises(ScriptError, match=message) as error:
        Script.parse("# a comment\n" + text, "some.scn", dictionary)
    assert str(error.value).startswith("some.scn:")
    assert f":{1 + len(text.splitlines())}:" in str(error.value)


def test_other_actors_are_skipped(dictionary):
    script = Script.parse("5 hand press 15 0.02 # hard\n1 operator ping\n64 fault unplug joystick 0x21\n", "x", dictionary)
    assert [step.text for step in script.steps] == ["ping"]


class Flight:
    """Runs a script without sockets: answer(packet) -> reports, which are delivered `delay_ns` later."""

    def __init__(self, dictionary, answer=success, delay_ns=1_000_000):
        self.dictionary, self.answer, self.delay_ns = dictionary, answer, delay_ns
        self.session = Session(dictionary, first_sequence=0)
        self.sent, self.entries, self.pending = [], [], []

    def at(self, time_s, *reports):
        """Deliver reports without a request: (apid, service, subtype, data)."""
        for apid, service, subtype, data in reports:
            self.pending.append((round(time_s * SECOND), build_tm(apid, 0, service, subtype, data, 0, 0)))
        return self

    def run(self, text, timeout_s=1.0):
        script = Script.parse(text, "test.scn", self.dictionary)
        procedure = script.procedure(self.session, round(timeout_s * SECOND), self.entries.append)
        with contextlib.suppress(StopIteration):
            wake = procedure.send(None)
            while True:
                for raw in packets.Splitter().feed(self.session.outbox):
                    packet = packets.parse(raw)
                    self.sent.append((self.session.now_ns, packet))
                    for apid, service, subtype, data, user in self.answer(packet):
                        raw = build_tm(apid, 0, service, subtype, data, user, 0)
                        self.pending.append((self.session.now_ns + self.delay_ns, raw))
                self.session.outbox.clear()
                self.pending.sort(key=lambda item: item[0])
                due = [item for item in self.pending if wake is None or item[0] <= wake]
                if due:
                    self.pending.remove(due[0])
                    self.session.now_ns = max(self.session.now_ns, due[0][0])
                    self.session.feed(due[0][1])
                else:
                    self.session.now_ns = wake
                wake = procedure.send(None)
        return self


def transition(apid, state):
    """TM[129,2]."""
    return apid, 129, 2, struct.pack(">BBBHBHI", 0, state, 0, 0, 0, 0, 0)


def test_steps_run_in_order_and_not_before_their_time(dictionary):
    flight = Flight(dictionary, lambda p: success(p, (17, 2, b"")) if p.service == 17 else success(p))
    flight.run("1 operator ping MANIPULATOR\n1 operator mode SAFE\n2.5 operator mode NOMINAL\n")
    assert [packet.message for _, packet in flight.sent] == [(17, 1), (131, 1), (131, 1)]
    times = [time for time, _ in flight.sent]
    assert times[0] == SECOND
    assert times[1] == SECOND + 1_000_000  # After the verification of the ping.
    assert times[2] == 2_500_000_000
    assert [entry["outcome"] for entry in flight.entries][0] == "MANIPULATOR is alive"
    assert all({"time", "end", "line", "verb", "words", "outcome"} <= set(entry) for entry in flight.entries)


def test_every_line_of_an_answer_is_kept(dictionary):
    flight = Flight(dictionary, lambda p: success(p, (17, 2, b"")) if p.service == 17 else success(p))
    flight.run("1 operator ping all\n")
    lines = [f"{name} is alive" for name in ("JOYSTICK", "MANIPULATOR", "SUPERVISOR", "COMMUNICATION")]
    assert sorted(flight.entries[0]["outcome"].splitlines()) == sorted(lines)
    assert flight.entries[0]["text"].splitlines()[0].endswith("ping all:")
    assert sorted(line.strip() for line in flight.entries[0]["text"].splitlines()[1:]) == sorted(lines)


def test_sequence_counts_start_at_zero_per_apid(dictionary):
    flight = Flight(dictionary).run("0 operator mode SAFE\n0 operator mode NOMINAL\n0 operator state JOYSTICK OFFLINE\n")
    assert [(p.apid, p.sequence) for _, p in flight.sent] == [(1, 0), (1, 1), (17, 0)]


def test_rejection_ends_the_script_with_file_and_line(dictionary):
    flight = Flight(dictionary, lambda p: failure(p, 4, 0x0204, 0))  # TM[1,4], PUS_FAILURE_STATE.
    with pytest.raises(ScriptFailure, match=r"test.scn:2: state JOYSTICK OFFLINE: refused at start .*\[0x0204\]"):
        flight.run("# x\n0 operator state JOYSTICK OFFLINE\n1 operator mode SAFE\n")
    assert len(flight.sent) == 1
    assert flight.entries[-1]["outcome"].startswith("FAILED")


def test_a_step_that_times_out_ends_the_script(dictionary):
    with pytest.raises(ScriptFailure, match="end of verification did not come within 1 s"):
        Flight(dictionary, lambda p: []).run("0 operator mode SAFE\n")


def test_an_expected_refusal_is_required(dictionary):
    text = "0 operator expect-refusal 0x0111 state MANIPULATOR SAFE_OPERATIONAL\n"
    flight = Flight(dictionary, lambda p: failure(p, 2, 0x0111, 16 << 16 | 2)).run(text)
    assert "HAND_POSITION" in flight.entries[0]["outcome"]
    with pytest.raises(ScriptFailure, match="expected refusal 0x0111, came: .*0x0110"):
        Flight(dictionary, lambda p: failure(p, 2, 0x0110, 0)).run(text)
    with pytest.raises(ScriptFailure, match="expected refusal 0x0111 .*carried out"):
        Flight(dictionary).run(text)


def test_a_tried_step_may_fail(dictionary):
    text = "0 operator try state MANIPULATOR SAFE_OPERATIONAL\n0 operator try nowait ping MANIPULATOR\n"
    flight = Flight(dictionary, lambda p: failure(p, 2, 0x0111, 16 << 16 | 2)).run(text)
    assert flight.entries[0]["outcome"].startswith("not carried out: ")
    assert "HAND_POSITION" in flight.entries[0]["outcome"]
    assert flight.entries[1]["outcome"] == "sent"
    assert "completed" in Flight(dictionary).run("0 operator try state MANIPULATOR OFFLINE\n").entries[0]["outcome"]


def test_wait_state_waits_for_a_transition(dictionary):
    text = "0 operator wait-state MANIPULATOR OFFLINE 2\n"
    flight = Flight(dictionary).at(0.5, transition(16, 6)).at(1.5, transition(16, 0)).run(text)
    assert flight.entries[0]["end"] == 1.5
    with pytest.raises(ScriptFailure, match="did not reach OFFLINE within 2 s; its state is ERROR_OPERATIONAL"):
        Flight(dictionary).at(0.5, transition(16, 6)).at(2.5, transition(16, 0)).run(text)


def test_expect_state_checks_the_present_state(dictionary):
    text = "1 operator expect-state MANIPULATOR OPERATIONAL\n"
    Flight(dictionary).at(0.5, transition(16, 5)).run(text)
    with pytest.raises(ScriptFailure, match="its state is SAFE_OPERATIONAL"):
        Flight(dictionary).at(0.5, transition(16, 5)).at(0.7, transition(16, 4)).run(text)


def note(dictionary):
    """TM[5,2] with OPERATOR_NOTE of the joystick."""
    return 17, 5, 2, struct.pack(">H", dictionary.subsystem("JOYSTICK").event("OPERATOR_NOTE").id)


def test_an_event_ends_one_wait_only(dictionary):
    wait = "1 operator wait-event JOYSTICK OPERATOR_NOTE 1\n"
    Flight(dictionary).at(0.5, note(dictionary)).run(wait)  # The event came before the wait.
    Flight(dictionary).at(0.5, note(dictionary)).at(1.5, note(dictionary)).run(wait + wait)
    with pytest.raises(ScriptFailure, match="the last event was OPERATOR_NOTE of JOYSTICK"):
        Flight(dictionary).at(0.5, note(dictionary)).run(wait + wait)
    with pytest.raises(ScriptFailure, match="no event at all"):
        Flight(dictionary).run("1 operator expect-event JOYSTICK OPERATOR_NOTE\n")


def test_a_step_with_nowait_is_judged_at_the_end(dictionary):
    text = "0 operator nowait mode SAFE\n0 operator nowait mode NOMINAL\n1 operator mode NOMINAL\n"
    assert [time for time, _ in Flight(dictionary).run(text).sent] == [0, 0, SECOND]
    with pytest.raises(ScriptFailure, match="test.scn:1: expected success of mode SAFE, came: .*aborted"):
        Flight(dictionary, lambda p: failure(p, 8, 0x0405, 0) if p.data == b"\0" else success(p)).run(text)


def test_end_skips_the_remaining_steps(dictionary):
    assert len(Flight(dictionary).run("0 operator mode SAFE\n1 operator end\n2 operator mode NOMINAL\n").sent) == 1


class CosimulationPort(threading.Thread):
    """The side of the scheduler: it grants the times that the operator names, and reads the octets that each answer announces."""

    def __init__(self, path, port):
        super().__init__(daemon=True)
        self.server = socket.socket(socket.AF_UNIX)
        self.server.bind(str(path))
        self.server.listen(1)
        self.station = socket.create_server(("127.0.0.1", port))
        self.lines, self.error, self.served = [], None, 0

    def run(self):
        try:
            self._run()
        except (OSError, AssertionError, ValueError) as error:
            self.error = error

    def _run(self):
        stream, address = self.station.accept()
        connection, _ = self.server.accept()
        connection.settimeout(10)
        stream.settimeout(10)
        lines = connection.makefile("rw")
        self.served = address[1]
        assert lines.readline().split() == ["join", "operator", str(self.served)]
        time_ns, octets = 0, b""
        while True:
            # Octets are on the stream before they are announced; first one half of them is announced, then the
            # rest.
            half = len(octets) // 2
            stream.sendall(octets)
            if half:
                assert self._grant(lines, time_ns, half)[1] == 0, "half a packet must have no effect"
                time_ns += 500_000
            wake, sent = self._grant(lines, time_ns, len(octets) - half)
            received = b""
            while len(received) < sent:
                received += stream.recv(sent - len(received))
            octets = b""
            for raw in packets.Splitter().feed(received):
                packet = packets.parse(raw)
                self.lines.append((time_ns, packet.message))
                for apid, service, subtype, data, user in success(packet):
                    octets += build_tm(apid, 0, service, subtype, data, user, time_ns)
            if wake == "leave":
                assert stream.recv(1) == b"", "it closes its connection before it leaves, so that both happen in one grant"
                return
            time_ns = time_ns + 1_000_000 if octets else max(int(wake), time_ns + 500_000)

    def _grant(self, lines, time_ns, octets):
        lines.write(f"grant {time_ns} 0 {octets} {self.served}\n")
        lines.flush()
        words = lines.readline().split()
        if words == ["leave"]:
            return "leave", 0
        assert words[0] == "done" and words[3] == str(self.served)
        return words[1], int(words[2])


def test_a_script_runs_in_stepped_time_through_the_cosimulation_port(dictionary_path, tmp_path, capsys):
    cosimulation = CosimulationPort(tmp_path / "cosim", 0)
    port = cosimulation.station.getsockname()[1]
    cosimulation.start()
    (tmp_path / "s.scn").write_text("0 operator mode SAFE\n0.25 operator mode NOMINAL\n")
    words = ["--port", str(port), "--dictionary", str(dictionary_path), "--cosimulation", str(tmp_path / "cosim")]
    before = signal.getsignal(signal.SIGTERM)
    try:
        code = main([*words, "--run", str(tmp_path), "script", str(tmp_path / "s.scn")])
        # The launcher's signal that the run is over must be ignored until the process has ended: at its end
        # the interpreter would reset a handler.
        assert signal.getsignal(signal.SIGTERM) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGTERM, before)
    cosimulation.join(60)
    assert cosimulation.error is None
    assert code == 0
    assert cosimulation.lines == [(0, (131, 1)), (250_000_000, (131, 1))]
    entries = [json.loads(line) for line in (tmp_path / "operator.log").read_text().splitlines()]
    assert [entry["verb"] for entry in entries] == ["mode", "mode"]
    assert entries[1]["time"] == 0.25
    assert "mode SAFE" in capsys.readouterr().out


@pytest.mark.parametrize("room", [0, 100])
def test_a_full_disk_ends_the_log_and_not_the_script(dictionary_path, tmp_path, capsys, room):
    """The log contains no part of a line; here it is empty."""
    craft = Spacecraft(success)
    (tmp_path / "s.scn").write_text("0 operator mode SAFE\n0 operator mode NOMINAL\n")
    before, handler = resource.getrlimit(resource.RLIMIT_FSIZE), signal.getsignal(signal.SIGTERM)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))
        code = main(["--port", str(craft.port), "--dictionary", str(dictionary_path), "--run", str(tmp_path), "script", str(tmp_path / "s.scn")])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGTERM, handler)
    craft.close()
    assert code == 0
    assert "later steps are not in it" in capsys.readouterr().out
    assert (tmp_path / "operator.log").read_text() == ""


def test_a_script_that_fails_exits_with_1(dictionary_path, tmp_path, capsys):
    craft = Spacecraft(lambda p: failure(p, 2, 0x0110, 0))
    (tmp_path / "s.scn").write_text("0 operator mode SAFE\n")
    code = main(["--port", str(craft.port), "--dictionary", str(dictionary_path), "script", str(tmp_path / "s.scn")])
    craft.close()
    assert code == 1
    assert "s.scn:1: mode SAFE" in capsys.readouterr().err


def test_a_link_that_is_lost_is_a_success_only_for_a_shutdown(dictionary_path, tmp_path, capsys):
    craft = Spacecraft(lambda p: None)
    (tmp_path / "s.scn").write_text("0 operator shutdown\n")
    code = main(["--port", str(craft.port), "--dictionary", str(dictionary_path), "script", str(tmp_path / "s.scn")])
    assert code == 0
    (tmp_path / "t.scn").write_text("0 operator mode SAFE\n")
    code = main(["--port", str(craft.port), "--dictionary", str(dictionary_path), "script", str(tmp_path / "t.scn")])
    craft.close()
    assert code == 3
    capsys.readouterr()


def test_a_script_that_does_not_load_is_a_usage_error(dictionary_path, tmp_path, capsys):
    words = ["--port", "1", "--dictionary", str(dictionary_path), "script"]
    assert main([*words, str(tmp_path / "none.scn")]) == 2
    (tmp_path / "s.scn").write_text("0 operator dance\n")
    assert main([*words, str(tmp_path / "s.scn")]) == 2
    assert "s.scn:1:" in capsys.readouterr().err


def test_a_missing_scheduler_is_reported(tmp_path):
    with pytest.raises(LinkLost, match="no scheduler at .*none: No such file or directory; expected the socket of a run in stepped time"):
        StepClock(tmp_path / "none", 1)


def test_the_end_of_the_run_is_a_lost_link(dictionary, tmp_path):
    server = socket.socket(socket.AF_UNIX)
    server.bind(str(tmp_path / "cosim"))
    server.listen(1)
    clock = StepClock(tmp_path / "cosim", 1)
    server.accept()[0].close()
    driver = StepDriver(None, Session(dictionary, 0), clock)
    with pytest.raises(LinkLost, match="run has ended|connection to the scheduler was lost"):
        driver.run(Session(dictionary, 0).wait_until(1))
    server.close()


def test_a_command_to_a_spacecraft_that_closed_the_link_is_a_lost_link(dictionary, tmp_path):
    """In stepped time the client does not read the stream before it has something to send. Here it cannot
    connect again."""
    server = socket.socket(socket.AF_UNIX)
    server.bind(str(tmp_path / "cosim"))
    server.listen(1)
    clock = StepClock(tmp_path / "cosim", 1)
    connection = server.accept()[0]
    connection.sendall(b"grant 0 0 0 1\n")
    ours, theirs = socket.socketpair()
    theirs.close()
    session = Session(dictionary, 0)

    def procedure():
        session.send(Request(16, 17, 1))
        yield None

    with pytest.raises(LinkLost, match="closed the link"):
        StepDriver(ours, session, clock).run(procedure())
    for stream in (connection, server, ours):
        stream.close()


class Scheduler:
    """A scheduler whose grants a test sends, and the ground port of a spacecraft."""

    def __init__(self, tmp_path):
        server = socket.socket(socket.AF_UNIX)
        server.bind(str(tmp_path / "cosim"))
        server.listen(1)
        self.port = socket.create_server(("127.0.0.1", 0))
        self.stream = self.connect()
        self.first = self.stream.getsockname()[1]
        self.clock = StepClock(tmp_path / "cosim", self.first)
        self.client = server.accept()[0]
        self.answers = self.client.makefile("r")
        assert self.answers.readline() == f"join operator {self.first}\n"
        self.accepted = [self.port.accept()[0]]
        server.close()

    def connect(self):
        """Connect as the operator's reconnect() does."""
        return socket.create_connection(self.port.getsockname())

    def grant(self, time_ns, octets, served):
        """Send a grant. The driver answers grants in their order, so a test may send several in advance."""
        self.client.sendall(f"grant {time_ns} 0 {octets} {served}\n".encode())

    def close(self):
        """Close all sockets."""
        for stream in (self.client, self.port, *self.accepted):
            stream.close()


def test_a_link_is_lost_and_opened_by_the_scheduler_and_not_by_the_socket(dictionary, tmp_path):
    """The request in progress is reported as lost; a request that is issued meanwhile waits for the next
    connection."""
    scheduler, session, reports = Scheduler(tmp_path), Session(dictionary, 0), []
    connections = []

    def reconnect():
        connections.append(scheduler.connect())
        scheduler.accepted.append(scheduler.port.accept()[0])
        scheduler.grant(3000, 0, 0)  # The request is in transit.
        scheduler.grant(4000, 0, connections[-1].getsockname()[1])
        return connections[-1]

    def procedure():
        with pytest.raises(RequestLost, match="0.0000 s.*may have carried it out"):
            yield from session.execute(Request(16, 17, 1, text="ping"), 10 * SECOND)
        later = session.send(Request(17, 17, 1))
        yield from session.wait_until(4000)
        assert not later.is_finished

    scheduler.grant(0, 0, 0)  # The new connection is not served yet, so the request waits.
    scheduler.grant(1000, 3, scheduler.first)
    scheduler.accepted[0].sendall(b"\x08\x10\xc0")  # The beginning of a packet that never ends.
    scheduler.grant(2000, 0, 0)
    driver = StepDriver(scheduler.stream, session, scheduler.clock, reconnect, reports.append)
    ended = threading.Thread(target=lambda: driver.run(procedure()))
    ended.start()
    asked = packets.build_tc(16, 0, 17, 1, b"", 1)
    assert scheduler.answers.readline() == f"done {10 * SECOND} 0 {scheduler.first}\n"
    assert scheduler.answers.readline() == f"done {10 * SECOND} {len(asked)} {scheduler.first}\n"
    answer = scheduler.answers.readline()
    port = connections[0].getsockname()[1]
    assert answer == f"done 4000 0 {port}\n"
    assert scheduler.accepted[0].recv(100) == asked
    assert scheduler.answers.readline() == f"done 4000 0 {port}\n"
    assert scheduler.answers.readline() == f"done 4000 {len(asked)} {port}\n"
    assert scheduler.accepted[1].recv(100) == packets.build_tc(17, 0, 17, 1, b"", 1)
    scheduler.grant(5000, 0, port)
    assert scheduler.answers.readline() == "leave\n"
    ended.join()
    assert reports == ["the link is lost; 1 request has no end of verification", "the link is open again"]
    assert not session.malformed
    scheduler.close()


def test_a_wait_continues_when_telemetry_sets_the_clock_forward(dictionary):
    session = Session(dictionary, 0)
    driver = RealDriver(None, session, epoch_ns=0)
    waiting = session.wait_for(lambda: False, 20 * SECOND, "an answer")
    due = next(waiting)
    # The mission is faster than wall-clock time, or started before this client connected.
    for seconds in (470, 471, 500):
        session.follow(types.SimpleNamespace(time_ns=seconds * SECOND))
        session.now_ns = seconds * SECOND
        due = next(waiting)
        assert abs(due - (seconds + 20) * SECOND) < SECOND
    assert driver is not None
    session.now_ns = due
    with pytest.raises(TimedOut):
        next(waiting)


def _alive(session, count):
    """Feed TM[17,2] of the manipulator to this user, with this sequence count."""
    session.feed(build_tm(16, count & 0x3FFF, 17, 2, b"", session.source))


def test_requests_without_a_further_report_are_removed(dictionary):
    """After the refusal of an instruction, a request may get further reports or none: only the newest such requests accept
    them. A request that has timed out accepts none."""
    session = Session(dictionary, 0)
    old = session.send(Request(16, 3, 27, bytes(2), "old"))
    for count in range(100):
        asked = session.send(Request(16, 3, 27, bytes(2), "hk")) if count else old
        session.feed(build_tm(16, count, 1, 4, asked.request_id + struct.pack(">HHI", 0x0201, 1, 0), session.source))
        assert asked.is_finished and asked.failure.instruction == 1
    _alive(session, 100)
    assert not old.replies and len(asked.replies) == 1
    silent = session.send(Request(16, 17, 1, b"", "ping"))
    waiting = session.finish(silent, SECOND)
    next(waiting)
    session.now_ns = 2 * SECOND
    with pytest.raises(TimedOut):
        next(waiting)
    _alive(session, 101)
    assert not silent.replies


@pytest.mark.parametrize(
    "ignores, listens, most, found_in_order",
    [
        (False, False, 100, ["done 0", "decoded 1000", "done 1000", "done 3000"]),
        (True, False, 100, ["done 0", "done 1000", "decoded 3000", "done 3000"]),
        (True, False, 2, ["done 0", "done 1000", "decoded 1000", "done 3000"]),
        (True, True, 100, ["done 0", "done 1000", "decoded 1000", "done 3000"]),
    ],
)
def test_telemetry_that_the_procedure_ignores_is_decoded_when_the_grant_is_returned(
    dictionary, tmp_path, monkeypatch, ignores, listens, most, found_in_order
):
    """They are decoded at the end of the pause, but at once if there is a listener or if there are many octets."""
    scheduler, session, found = Scheduler(tmp_path), Session(dictionary, 0), []
    feed, done = session.feed, scheduler.clock.done

    def fed(octets):
        found.extend([f"decoded {session.now_ns}"] if octets else [])
        feed(octets)

    def returned(wake_ns, sent):
        found.append(f"done {session.now_ns}")
        done(wake_ns, sent)

    def procedure():
        yield from session.wait_until(3000) if ignores else session.wait_for(lambda: session.now_ns >= 3000, 3000, "the time")

    monkeypatch.setattr("hirosco_gse.link.UNDECODED_MAX", most)
    session.listeners.extend([lambda packet, decoded: None] if listens else [])
    session.feed, scheduler.clock.done = fed, returned
    scheduler.grant(0, 0, scheduler.first)
    scheduler.grant(1000, 3, scheduler.first)
    scheduler.accepted[0].sendall(b"\x08\x10\xc0")  # The beginning of a packet.
    scheduler.grant(3000, 0, scheduler.first)
    scheduler.grant(4000, 0, scheduler.first)
    StepDriver(scheduler.stream, session, scheduler.clock).run(procedure())
    assert found == found_in_order
    assert [line.split()[:2] for line in scheduler.answers.read().splitlines()] == [["done", "3000"]] * 3 + [["leave"]]
    scheduler.close()


def test_a_run_that_ends_in_a_pause_leaves_its_last_reports_to_the_procedure(dictionary, tmp_path):
    scheduler, session = Scheduler(tmp_path), Session(dictionary, 0)
    report = build_tm(16, 0, 17, 2, b"", session.source)

    def procedure():
        asked = session.send(Request(16, 17, 1))
        with pytest.raises(LinkLost):
            yield from session.wait_until(3000)
        return len(asked.replies)

    scheduler.grant(0, 0, scheduler.first)
    scheduler.grant(1000, len(report), scheduler.first)
    scheduler.accepted[0].sendall(report)
    scheduler.client.shutdown(socket.SHUT_WR)
    assert StepDriver(scheduler.stream, session, scheduler.clock).run(procedure()) == 1
    scheduler.close()
