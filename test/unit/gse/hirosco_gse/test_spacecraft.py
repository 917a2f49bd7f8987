# SPDX-License-Identifier: Apache-2.0
"""The client class with a simulated spacecraft: its requests, its results, its exceptions; and its pytest
fixture."""

import socket
import struct
import threading

import pytest
from conftest import ROOT
from hirosco_gse import dictionary as dictionary_module
from hirosco_gse import telemetry
from hirosco_gse.command import UsageError
from hirosco_gse.link import RealDriver, StepDriver
from hirosco_gse.live import LiveRefused
from hirosco_gse.session import LinkLost, Rejected, Request, Session, TimedOut
from hirosco_gse.spacecraft import Spacecraft
from spacecraft import Spacecraft as Simulated
from spacecraft import failure, success
from tm_packets import build_tm

pytest_plugins = ["pytester"]
MANIPULATOR = 16


@pytest.fixture
def crafts(dictionary_path, tmp_path):
    """connect(answer, **options) -> (client, simulated spacecraft)."""
    made = []

    def connect(answer, **options):
        simulated = Simulated(answer, dictionary_module.Dictionary.load(dictionary_path).epoch_ns)
        craft = Spacecraft(tmp_path, port=simulated.port, dictionary=dictionary_path, timeout_s=60, **options).connect()
        made.extend((craft, simulated))
        return craft, simulated

    yield connect
    for one in made:
        one.close()


def test_a_function_is_performed_with_named_arguments(crafts):
    craft, simulated = crafts(success, user=7, first_sequence=3)
    craft.cmd("manipulator.move_to", position=[0.5, -0.25], duration=2)
    request = simulated.received[0]
    assert (request.user, request.sequence) == (7, 3)
    assert request.data == b"MOVE_TO\0" + struct.pack(">BHddHd", 2, 1, 0.5, -0.25, 2, 2.0)


@pytest.mark.parametrize("call", [
    lambda craft: craft.cmd("MANIPULATOR.DANCE"),
    lambda craft: craft.cmd("MANIPULATOR.MOVE_TO", position=1),
    lambda craft: craft.do("state MANIPULATOR"),
    lambda craft: craft.set("MANIPULATOR.TORQUE_LIMIT", [1, "x"]),
    lambda craft: craft.get("MANIPULATOR.NOTHING"),
    lambda craft: craft.wait_value("MANIPULATOR.CUR_VALUES.NOTHING"),
    lambda craft: craft.wait_event("MANIPULATOR", "NOTHING"),
])
def test_a_name_that_the_dictionary_does_not_have_is_not_sent(crafts, call):
    craft, simulated = crafts(success)
    with pytest.raises((UsageError, dictionary_module.DictionaryError)):
        call(craft)
    assert not simulated.received


def test_a_refusal_has_its_reason_in_words(crafts):
    craft, _ = crafts(lambda packet: failure(packet, 4, 0x0110, 1 << 8 | 3))  # PUS_FAILURE_PERMISSION, mode and state.
    with pytest.raises(Rejected, match="not permitted in mode NOMINAL while in state PRE_OPERATIONAL"):
        craft.cmd("MANIPULATOR.TARE")


def test_several_requests_are_under_way_at_once(crafts):
    """The simulated spacecraft completes the first request together with the second."""
    waiting = []

    def answer(packet):
        waiting.append(packet)
        return [report for one in waiting for report in success(one)] if len(waiting) == 2 else []

    craft, simulated = crafts(answer)
    first = craft.send("MANIPULATOR.TARE")
    second = craft.send("MANIPULATOR.STOP")
    assert not first.is_finished and not second.is_finished
    assert craft.finish(first).stages == craft.finish(second).stages == [1, 3, 7]
    assert [packet.data[:4] for packet in simulated.received] == [b"TARE", b"STOP"]


def test_parameters_are_scalars_lists_and_dicts(crafts, dictionary):
    manipulator = dictionary.subsystem("MANIPULATOR")
    octets = {name: struct.pack(">HI", 1, item.parameter_id) + bytes(item.size) for name, item in manipulator.parameters.items()}

    def answer(packet):
        asked = next(item for item in manipulator.parameters.values() if item.parameter_id == int.from_bytes(packet.data[1:5], "big"))
        return success(packet, (20, 2, octets[asked.name]))

    craft, _ = crafts(answer)
    assert craft.get("MANIPULATOR.LINK_AGE") == 0
    assert craft.get("MANIPULATOR.TORQUE_LIMIT") == [0.0, 0.0]
    assert craft.get("MANIPULATOR.CUR_VALUES")["POSITION"] == [0.0, 0.0]
    assert craft.get("MANIPULATOR.CUR_VALUES.POSITION") == [0.0, 0.0]


def test_tc_returns_the_report_that_answers_it(crafts):
    craft, simulated = crafts(lambda packet: success(packet, (12, 14, struct.pack(">H", 0))))
    assert craft.tc("MANIPULATOR", 12, 13)["n"] == []
    assert simulated.received[0].message == (12, 13)


def _reporting(dictionary):
    """Reports that come with each answer: a state, an event, and housekeeping whose DES_POSITION begins with
    the number of earlier requests."""
    manipulator = dictionary.subsystem("MANIPULATOR")
    structure = manipulator.configurations["STAND_ALONE"].structures[4711]
    numbers = []

    def answer(packet):
        numbers.append(len(numbers))
        current = bytes(structure.once[0].size) + struct.pack(">10d", *[0.0] * 8, numbers[-1], 2.5)
        event = manipulator.event("TARE_DONE")
        reports = [
            (MANIPULATOR, 129, 5, struct.pack(">BBBHQQII", 5, 0, 5, 1, 0, 0, 0, 0), 0),
            (MANIPULATOR, 3, 25, struct.pack(">H", 4711) + current, 0),
            (MANIPULATOR, 5, 1, struct.pack(">Hdd", event.id, numbers[-1], 0.25), 0),
        ]
        return success(packet) + reports

    return answer


def test_states_events_and_values_are_waited_for(crafts, dictionary):
    craft, _ = crafts(_reporting(dictionary))
    assert craft.state("MANIPULATOR") is None
    craft.send("MANIPULATOR.TARE")
    craft.wait_state("MANIPULATOR", "operational")
    assert craft.state("manipulator") == "OPERATIONAL"
    assert craft.wait_value("MANIPULATOR.DES_POSITION") == [0.0, 2.5]
    assert craft.wait_event("MANIPULATOR", "tare_done") == {"OFFSET": [0.0, 0.25]}
    craft.send("MANIPULATOR.TARE")
    assert craft.wait_value("MANIPULATOR.DES_POSITION", lambda value: value[0] == 1) == [1.0, 2.5]
    # This is the next event, and not the first one again.
    assert craft.wait_event("MANIPULATOR", "TARE_DONE") == {"OFFSET": [1.0, 0.25]}
    with pytest.raises(TimedOut, match="the last event was TARE_DONE of MANIPULATOR"):
        craft.wait_event("MANIPULATOR", "TARE_DONE", 0.05)
    with pytest.raises(TimedOut, match=r"the last value was \[1.0, 2.5\]"):
        craft.wait_value("MANIPULATOR.DES_POSITION", lambda value: value[0] == 9, 0.05)


def test_housekeeping_is_decoded_only_for_a_reader(dictionary, monkeypatch):
    decoded, decode = [], telemetry.decode
    monkeypatch.setattr(telemetry, "decode", lambda packet, *rest: decoded.append(packet.message) or decode(packet, *rest))
    session = Session(dictionary, 0)
    reports = [build_tm(MANIPULATOR, count, 3, 25, struct.pack(">H", 4711) + bytes(count), session.source) for count in range(2)]
    session.feed(b"".join(reports))
    assert decoded == []
    assert [packet.raw for packet, _ in session.housekeeping.values()] == reports[1:]  # The last report of a structure is kept.
    verification = session.send(Request(MANIPULATOR, 17, 1))
    session.feed(reports[0])
    assert decoded == [(3, 25)] and [packet.raw for packet, _ in verification.replies] == reports[:1]


def test_time_outs_in_stepped_time_do_not_depend_on_the_wall_clock(dictionary):
    session = Session(dictionary, 0)
    RealDriver(None, session, dictionary.epoch_ns)
    StepDriver(None, session, None)
    session.feed(build_tm(MANIPULATOR, 0, 17, 2, b"", session.source, dictionary.epoch_ns + 10**12))
    assert session.slipped_ns == 0


def test_a_jump_of_mission_time_is_no_time_out(crafts, dictionary):
    """The first packet has mission time 1000 s; the wait of 60 s continues in real time."""
    craft, _ = crafts(lambda packet: success(packet))
    craft.cmd("MANIPULATOR.TARE")
    craft.cmd("MANIPULATOR.TARE")
    assert craft.session.now_ns >= 1_000_000_000_000


def test_connecting_again_closes_the_earlier_connection(crafts):
    """The simulated spacecraft serves one connection at a time."""
    craft, simulated = crafts(lambda packet: success(packet))
    craft.cmd("MANIPULATOR.TARE")
    earlier = craft._stream
    assert craft.connect() is craft and earlier.fileno() == -1
    craft.cmd("MANIPULATOR.TARE")
    assert len(simulated.received) == 2


@pytest.mark.parametrize(("flown", "port", "is_told"), [("0x01", 0, True), (None, 0, False), ("known", 0, False), ("", 0, False), ("0x01", 1, False)])
def test_other_device_classes_are_reported_when_a_flight_is_joined(tmp_path, dictionary_path, flown, port, is_told):
    known = dictionary_module.Dictionary.load(dictionary_path).content["device_classes_hash"]
    (tmp_path / "ground.port").write_text("10020\n", encoding="ascii")
    if flown is not None:
        (tmp_path / "ground.classes").write_text((known if flown == "known" else flown) + "\n", encoding="ascii")
    craft = Spacecraft(tmp_path, port=port, dictionary=dictionary_path)
    reported = [f"the flight has device classes 0x01, the dictionary has those of {known}: run make"] if is_told else []
    assert list(craft.session.mismatches.values()) == reported


def test_calls_without_a_link_raise_an_error(crafts, dictionary_path):
    with pytest.raises(LinkLost, match="no link"):
        Spacecraft(port=1, dictionary=dictionary_path).connect()
    craft = Spacecraft(port=1, dictionary=dictionary_path)
    assert craft.plan("ping", "all").text.startswith("ping JOYSTICK")
    with pytest.raises(LinkLost, match="not connected"):
        craft.cmd("MANIPULATOR.TARE")
    lost, _ = crafts(lambda packet: None)
    with pytest.raises(LinkLost, match="closed the link"):
        lost.cmd("MANIPULATOR.TARE")


@pytest.fixture
def world(tmp_path):
    """The lines that a simulated live port has received. It refuses only `fault`; it is paused from the second query of the
    time to the third."""
    server, lines = socket.create_server(("127.0.0.1", 0)), []
    (tmp_path / "live.port").write_text(str(server.getsockname()[1]), encoding="ascii")

    def serve():
        stream, _ = server.accept()
        with stream, stream.makefile("r", encoding="utf-8") as given:
            for line in given:
                lines.append(line.strip())
                is_paused = lines.count("time") == 2
                answer = "refused live:1: no such device" if line.startswith("fault") else f"ok 2.5{' paused' if is_paused else ''}"
                stream.sendall(answer.encode() + b"\n")

    threading.Thread(target=serve, daemon=True).start()
    yield lines
    server.close()


def test_lines_for_the_live_port_are_sent_and_answered(crafts, world):
    craft, _ = crafts(success)
    assert craft.hand("aim", 0.1, 0, 0.5) == 2.5
    craft.pause()
    craft.step(0.25)
    craft.speed(0.5)
    craft.resume()
    with pytest.raises(LiveRefused, match="refused: no such device"):
        craft.fault("unplug", "robot", "JOINT9")
    assert world == ["name gse", "hand aim 0.1 0 0.5", "pause", "step 0.2500", "time", "time", "speed 0.5", "resume", "fault unplug robot JOINT9"]


def test_a_line_without_a_live_port_raises_an_error(crafts):
    craft, _ = crafts(success)
    with pytest.raises(LinkLost, match="TIME=real"):
        craft.pause()


def test_users_write_tests_with_the_fixture(pytester, dictionary_path):
    """The tests run in a separate directory with the plug-in and its option, and with a separate run directory."""
    simulated = Simulated(success)
    run = pytester.mkdir("run")
    (run / "ground.port").write_text(str(simulated.port), encoding="ascii")
    pytester.makepyfile(f"""
        import pytest
        from hirosco_gse import run_directory
        run_directory.default_dictionary = lambda run: {str(dictionary_path)!r}

        def test_one(spacecraft):
            spacecraft.cmd("MANIPULATOR.TARE")
    """)
    pytester.syspathinsert(ROOT / "gse")
    done = pytester.runpytest_inprocess("-p", "hirosco_gse.pytest_plugin", "--spacecraft-run", run, "-p", "no:xdist")
    simulated.close()
    done.assert_outcomes(passed=1)
    assert [packet.message for packet in simulated.received] == [(8, 1)]
