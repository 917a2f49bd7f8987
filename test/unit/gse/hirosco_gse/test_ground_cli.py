# SPDX-License-Identifier: Apache-2.0
"""The command line with a simulated spacecraft: sent requests, printed texts, exit codes."""

import json
import pathlib
import re
import struct
import subprocess
import sys

import named_dictionary
import pytest
from hirosco_gse import commands, packets
from hirosco_gse.cli import main
from spacecraft import Spacecraft, failure, success
from tm_packets import build_tm

ROOT = pathlib.Path(__file__).resolve().parents[4]


def _consoles(path, capsys):
    """Yields run(answer, *words, timeout_s) -> (exit code, stdout, stderr, received telecommands), with the dictionary at `path`."""
    crafts = []

    def run(answer, *words, timeout_s=600):
        craft = Spacecraft(answer)
        crafts.append(craft)
        code = main(["--port", str(craft.port), "--dictionary", str(path), "--timeout", str(timeout_s), *words])
        out, err = capsys.readouterr()
        assert "Traceback" not in err
        return code, out, err, craft.received

    yield run
    for craft in crafts:
        craft.close()


@pytest.fixture
def console(dictionary_path, capsys):
    yield from _consoles(dictionary_path, capsys)


def test_ping_prints_that_a_subsystem_answers(console):
    code, out, _, received = console(lambda p: success(p, (17, 2, b"")), "ping", "MANIPULATOR")
    assert code == 0
    assert "MANIPULATOR is alive" in out
    assert [(p.apid, p.message, p.user, p.ack, p.data) for p in received] == [(16, (17, 1), 1, 15, b"")]


def test_ping_without_a_name_reaches_all_and_prints_json(console):
    code, out, _, received = console(lambda p: success(p, (17, 2, b"")), "ping", "--json")
    assert code == 0
    assert {json.loads(line)["subsystem"] for line in out.splitlines()} == {
        "JOYSTICK", "MANIPULATOR", "SUPERVISOR", "COMMUNICATION",
    }
    assert len(received) == 4


@pytest.fixture
def named(dictionary_path, tmp_path, capsys):
    """As console, with the names of named_dictionary."""
    content = named_dictionary.named(json.loads(dictionary_path.read_text(encoding="utf-8")))
    path = tmp_path / "named.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    yield from _consoles(path, capsys)


def test_numbers_are_written_by_their_names(named):
    assert named(success, "set", "MANIPULATOR.CHOICE", "quick,3")[3][0].data[5:] == struct.pack(">HH", 4, 3)
    move = named(success, "cmd", "MANIPULATOR.MOVE_TO", "position=0,0", "duration=SLOW")[3][0]
    assert move.data.endswith(struct.pack(">HH", 2, 3))
    request = named(success, "tc", "MANIPULATOR", "20,3", 'n=[{"parameter_id": "MANIPULATOR.CHOICE", "parameter_value": ["SLOW", "QUICK"]}]')[3][0]
    assert request.data[5:] == struct.pack(">HH", 3, 4)


def test_one_field_of_a_structure_is_set_and_read_by_its_name(named, dictionary):
    control = dictionary.subsystem("MANIPULATOR").parameter("CONTROL")
    item, offset = control.field("FADE_TIME")
    value = bytes(range(control.size % 256)) if control.size < 256 else bytes(number % 251 for number in range(control.size))
    report = struct.pack(">HI", 1, control.parameter_id) + value

    def answer(packet):
        return success(packet, (20, 2, report)) if packet.message == (20, 1) else success(packet)

    code, _, _, received = named(answer, "set", "manipulator.control.fade_time", "0.5")
    assert code == 0 and [packet.message for packet in received] == [(20, 1), (20, 3)]
    changed = received[1].data[5:]
    assert received[1].data[:5] == struct.pack(">BI", 1, control.parameter_id)
    assert changed[offset : offset + item.size] == struct.pack(">d", 0.5)
    assert changed[:offset] + changed[offset + 8 :] == value[:offset] + value[offset + 8 :]
    code, out, _, received = named(answer, "get", "MANIPULATOR.CONTROL.FADE_TIME", "--json")
    shown = json.loads(out.splitlines()[-1])["values"]["CONTROL.FADE_TIME"]
    assert code == 0 and struct.pack(">d", *shown) == value[offset : offset + 8]


def test_a_field_of_an_enumeration_is_set_and_read_by_name(named, dictionary):
    counters = dictionary.subsystem("MANIPULATOR").parameter("COUNTERS")
    report = struct.pack(">HI", 1, counters.parameter_id) + struct.pack(">I", 4) + bytes(counters.size - 4)

    def answer(packet):
        return success(packet, (20, 2, report)) if packet.message == (20, 1) else success(packet)

    assert "COUNTERS.CYCLES=QUICK" in named(answer, "get", "MANIPULATOR.COUNTERS.CYCLES")[1]
    assert named(answer, "set", "MANIPULATOR.COUNTERS.CYCLES", "SLOW")[3][1].data[5:9] == struct.pack(">I", 3)
    code, _, err, received = named(answer, "set", "MANIPULATOR.COUNTERS.CYCLES", "FAST")
    assert code == 2 and not received and "there are: SLOW, QUICK" in err


def test_unknown_fields_are_refused_with_the_right_ones(named):
    for verb in (("get", "MANIPULATOR.ENERGY.LOST"), ("set", "MANIPULATOR.ENERGY.LOST", "1")):
        code, _, err, received = named(success, *verb)
        assert code == 2 and not received and "no field of ENERGY 'LOST'; there are: TAKEN, GIVEN" in err
    assert "no field of DES_POSITION 'X'; there are: none" in named(success, "get", "MANIPULATOR.DES_POSITION.X")[2]


def test_unknown_names_are_refused_with_the_right_ones(named):
    for words in (("set", "MANIPULATOR.CHOICE", "SLOW,FAST"), ("set", "MANIPULATOR.CHOICE", "SLOW,5"),
                  ("cmd", "MANIPULATOR.MOVE_TO", "position=0,0", "duration=FAST")):
        code, _, err, received = named(success, *words)
        assert code == 2 and not received
        assert "there are: SLOW, QUICK" in err
    assert "DURATION=SLOW|QUICK[1]" in named(success, "cmd", "MANIPULATOR.MOVE_TO", "position=0,0")[2]


def test_numbers_are_shown_by_their_names(named):
    value = struct.pack(">HIHH", 1, named_dictionary.CHOICE_ID, 4, 7)
    code, out, _, _ = named(lambda p: success(p, (20, 2, value)), "get", "MANIPULATOR.CHOICE")
    assert code == 0 and "CHOICE=[QUICK, 7]" in out.replace(": ", "=")


@pytest.mark.parametrize(("number", "words"), [(0x8001, "TOO_FAR, JOINT 2 [0x8001]"), (0x8002, "TOO_FAST [0x8002]"), (0x8003, "failure code not in the dictionary")])
def test_failures_of_a_subsystem_are_shown_by_their_names(named, number, words):
    code, _, err, _ = named(lambda p: failure(p, 8, number, 2), "cmd", "MANIPULATOR.STOP")
    assert code == 1 and words in err


def test_a_function_is_called_with_its_arguments(console):
    words = ["cmd", "manipulator.move_to", "position=0.5,-0.25", "duration=2"]
    code, _, _, received = console(success, *words)
    assert code == 0
    expected = b"MOVE_TO\0" + struct.pack(">BHddHd", 2, 1, 0.5, -0.25, 2, 2.0)
    assert received[0].message == (8, 1)
    assert received[0].data == expected


@pytest.mark.parametrize(
    ("words", "apid", "message", "data"),
    [
        (["state", "MANIPULATOR", "SAFE_OPERATIONAL"], 16, (129, 1), b"\x04"),
        (["config", "JOYSTICK", "TELEPRESENCE"], 17, (129, 3), b"\0\2"),
        (["mode", "SAFE"], 1, (131, 1), b"\0"),
        (["log", "sqlite"], 1, (131, 3), b"\1"),
        (["shutdown"], 1, (131, 5), b""),
        (["hk", "enable", "MANIPULATOR", "4711"], 16, (3, 5), struct.pack(">BH", 1, 4711)),
        (["hk", "interval", "MANIPULATOR", "4711", "100"], 16, (3, 31), struct.pack(">BHI", 1, 4711, 100)),
        (["event", "disable", "JOYSTICK", "OPERATOR_NOTE"], 17, (5, 6), b"\1\0\x09"),
        (["process", "start", "JOYSTICK"], 1, (131, 6), b"\0\x11"),
    ],
)
def test_each_command_sends_its_request(console, words, apid, message, data):
    code, _, _, received = console(success, *words)
    assert code == 0
    assert (received[0].apid, received[0].message, received[0].data) == (apid, message, data)


def test_set_takes_negative_values(console, dictionary):
    code, _, _, received = console(success, "set", "MANIPULATOR.DES_POSITION", "-0.5,0.25")
    assert code == 0
    parameter = dictionary.subsystem("MANIPULATOR").parameter("DES_POSITION")
    assert received[0].data == struct.pack(">BIdd", 1, parameter.parameter_id, -0.5, 0.25)


def test_get_prints_the_value(console, dictionary):
    parameter = dictionary.subsystem("MANIPULATOR").parameter("TORQUE_LIMIT")
    report = (20, 2, struct.pack(">HIdd", 1, parameter.parameter_id, 12.0, 38.5))
    code, out, _, _ = console(lambda p: success(p, report), "get", "MANIPULATOR.TORQUE_LIMIT")
    assert code == 0
    assert "TORQUE_LIMIT=[12, 38.5]" in out


def test_a_structure_is_created_with_its_parameters(console, dictionary):
    words = ["hk", "create", "MANIPULATOR", "5000", "1000", "TORQUE_OFFSET", "4:DES_POSITION"]
    code, _, _, received = console(success, *words)
    assert code == 0
    ids = [dictionary.subsystem("MANIPULATOR").parameter(n).parameter_id for n in ("TORQUE_OFFSET", "DES_POSITION")]
    assert received[0].data == struct.pack(">HIBIBHBI", 5000, 1000, 1, ids[0], 1, 4, 1, ids[1])


def _link_spacecraft(packet):
    if packet.message == (130, 3):
        transaction = packet.data[:4]
        accept = transaction + struct.pack(">H", 9) + bytes(21) + b"\0\0"
        return success(packet, (130, 4, accept))
    return success(packet)


def test_link_is_requested_then_opened(console):
    code, out, _, received = console(_link_spacecraft, "link", "open", "HAND_POSITION")
    assert code == 0
    assert "id 9" in out
    assert [p.message for p in received] == [(130, 3), (130, 6)]
    assert received[0].data[4:14] == struct.pack(">HHHHH", 0, 17, 1, 16, 2)
    assert len(received[0].data) == 4 + 10 + 21
    assert received[1].data == struct.pack(">HI", 9, 0)


def test_a_refused_link_is_reported_in_words(console):
    code, _, err, _ = console(lambda p: failure(p, 8, 0x0409, 3 << 8 | 4), "link", "open", "HAND_POSITION")
    assert code == 1
    assert "sampling period" in err


@pytest.mark.parametrize(
    ("subtype", "code", "detail", "words"),
    [
        (2, 0x0110, 1 << 8 | 3, "not permitted in mode NOMINAL while in state PRE_OPERATIONAL"),
        (2, 0x0111, 16 << 16 | 2, "MANIPULATOR requires HAND_POSITION"),
        (2, 0x0113, 17, "JOYSTICK"),
        (4, 0x0204, 0, "not allowed in the present state"),
        (8, 0x0405, 0, "superseded"),
        (10, 0x0002, 16, "MANIPULATOR does not run"),
    ],
)
def test_rejections_are_reported_in_words(console, subtype, code, detail, words):
    exit_code, _, err, _ = console(lambda p: failure(p, subtype, code, detail), "state", "MANIPULATOR", "SAFE_OPERATIONAL")
    assert exit_code == 1
    assert words in err
    assert f"0x{code:04X}" in err


@pytest.mark.parametrize(
    "words",
    [
        [], ["frobnicate"], ["ping", "NOBODY"], ["state", "MANIPULATOR"], ["state", "MANIPULATOR", "HARDWARE_INIT"],
        ["cmd", "MANIPULATOR"], ["cmd", "MANIPULATOR.MOVE_TO"], ["cmd", "MANIPULATOR.TARE", "x=1"],
        ["cmd", "MANIPULATOR.MOVE_TO", "position=1", "duration=1"], ["set", "MANIPULATOR.TORQUE_LIMIT", "a,b"],
        ["link", "open", "NOWHERE"], ["log", "papyrus"], ["raw", "xyz"], ["raw", "00"], ["hk", "enable", "MANIPULATOR"],
        ["mode", "PARTY"], ["--port", "many", "ping"], ["hk", "create", "MANIPULATOR", "x", "1", "DES_POSITION"],
    ],
)
def test_wrong_usage_is_refused(dictionary_path, capsys, words):
    """Wrong usage is detected before a link is needed."""
    assert main(["--port", "1", "--dictionary", str(dictionary_path), *words]) == 2
    assert capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["at", "+5", "cmd", "MANIPULATOR.MOVE_TO", "POSITION=1"], "POSITION: '1' has 1 value, 2 expected"),
        (["at", "+5", "ping", "all"], "'ping all' sends 4 requests, expected a command that sends one"),
        (["action", "add", "MANIPULATOR", "TORQUE_LIMIT", "cmd", "MANIPULATOR.HALT"], "no function of MANIPULATOR 'HALT'"),
        (["monitor", "limit", "MANIPULATOR", "1", "LINK_AEG", "0", "1", "0", "0"], "no parameter of MANIPULATOR 'LINK_AEG'"),
        (["monitor", "limit", "MANIPULATOR", "1", "", "0", "1", "0", "0"], "no parameter of MANIPULATOR ''"),
        (["state", "all", "\u00b2"], "'\u00b2' is not a state that can be requested"),
        (["ping", "\u00b2"], "no subsystem '\u00b2'"),
        (["tc", "SUPERVISOR", "1,\u00b2"], "usage: tc"),
        (["at", "\u00b2", "ping", "SUPERVISOR"], "at: found '\u00b2', expected a time in seconds; usage: at"),
        (["monitor", "limit", "MANIPULATOR", "1", "LINK_AGE", "a", "1", "0", "0"], "low_limit: 'a' is not a UINT32 value"),
        (["store", "create", "A", "x"], "gse: packet_store_size: 'x' is not a number"),
        (["log", "postgre"], "no packet log 'postgre'; there are: ascii, sqlite, ring"),
        (["raw", "1"], "raw: found '1', expected octets, each as two hexadecimal digits"),
        (["dance"], "no command 'dance'; gse --help lists them"),
        (["file", "upload", "absent/file", "/x"], "cannot read 'absent/file': No such file or directory"),
        (["file", "upload", "/dev/zero", "/x"], "/dev/zero has more than 131072 octets"),
        (["procedure", "load", "P", "/dev/zero"], "/dev/zero has more than 16384 octets"),
        (["hk", "enable", "MANIPULATOR", "65536"], "structure id: found 65536, expected 0 to 65535"),
        (["hk", "create", "MANIPULATOR", "99", "-1", "LINK_AGE"], "number of cycles: found -1"),
        (["hk", "create", "MANIPULATOR", "99", "1", "65536:LINK_AGE"], "number of samples: found 65536"),
        (["hk", "create", "MANIPULATOR", "99", "1", *["LINK_AGE"] * 256], "at most 255 parameters"),
        (["--timeout", "nan", "ping"], "found 'nan', expected seconds"),
        (["--timeout", "1e400", "ping"], "found '1e400', expected seconds"),
        (["--port", "0", "ping"], "found '0', expected a port from 1 to 65535"),
        (["--run", "", "ping"], "found '', expected a word"),
        (["script", sys.executable], "expected text in UTF-8"),
        (["procedure", "load", "P", "a\0b"], "cannot read 'a\0b': embedded null byte"),
    ],
)
def test_wrong_words_within_a_command_are_named(dictionary_path, capsys, words, reason):
    assert main(["--port", "1", "--dictionary", str(dictionary_path), *words]) == 2
    assert reason in capsys.readouterr().err


@pytest.mark.parametrize(("files", "reason"), [
    ({}, "found no file ground.port, expected the directory of a flight under way"),
    ({"run.json": "[]\n"}, "has ended; run.json: found '[]', expected an object with the facts of the flight; name a flight under way with --run or --port"),
    ({"run.json": '{"exit_code": 0, "exit_reason": "", "simulated_s": 93.62}'}, "flight ended at 93.62 s, code 0; name a flight under way with --run or --port"),
])
def test_a_run_without_a_flight_commands_no_other_flight(console, dictionary_path, tmp_path, capsys, files, reason):
    """Another flight may have the port of a flight that has ended, or the default port."""
    craft = Spacecraft(lambda p: success(p, (17, 2, b"")))
    for name, text in files.items():
        (tmp_path / name).write_text(text)
        (tmp_path / "ground.port").write_text(f"{craft.port}\n")
    assert main(["--run", str(tmp_path), "--dictionary", str(dictionary_path), "ping"]) == 3
    assert reason in capsys.readouterr().err and not craft.received
    craft.close()


def test_a_scheduled_command_keeps_quotes_of_its_words(dictionary):
    """JSON without blanks, and names with an apostrophe."""
    for words in (["tc", "SUPERVISOR", "11,22", 'n=[{"group_id":1,"group_status":"enabled"}]'], ["file", "delete", "/it's here"]):
        inner, = commands.plan(words, dictionary).requests
        outer, = commands.plan(["at", "5", *words], dictionary).requests
        assert inner.data in outer.data


def test_a_command_that_ctrl_c_ends_has_not_succeeded(dictionary_path, capsys, monkeypatch):
    def interrupted(craft, *words):
        raise KeyboardInterrupt

    monkeypatch.setattr("hirosco_gse.spacecraft.Spacecraft.do", interrupted)
    craft = Spacecraft(success)
    assert main(["--port", str(craft.port), "--dictionary", str(dictionary_path), "ping"]) == 130
    assert "the spacecraft may still perform the command" in capsys.readouterr().err
    craft.close()


def test_octets_that_are_no_text_do_not_end_the_shell(dictionary_path):
    craft = Spacecraft(lambda p: success(p, (17, 2, b"")))
    words = [sys.executable, "gse/gse", "--port", str(craft.port), "--dictionary", dictionary_path, "shell"]
    done = subprocess.run(words, cwd=ROOT, input=b"\xff\xfe\nping SUPERVISOR\n", capture_output=True, env={"PYTHONIOENCODING": "utf-8:strict"})
    craft.close()
    assert done.returncode == 0 and b"no command 'xffxfe'" in done.stdout and b"SUPERVISOR is alive" in done.stdout


def test_a_download_that_cannot_be_stored_fails_with_the_reason(console, tmp_path):
    attributes = struct.pack(">H1sH1sIB", 1, b"/", 1, b"h", 0, 0)
    target = tmp_path / "absent" / "file"
    code, _, err, _ = console(lambda p: success(p, (23, 4, attributes)), "file", "download", "/h", str(target))
    assert code == 1 and f"cannot write '{target}': No such file or directory" in err


def test_without_a_spacecraft_the_exit_code_is_3(dictionary_path, capsys):
    assert main(["--port", "1", "--dictionary", str(dictionary_path), "ping"]) == 3
    assert "no link" in capsys.readouterr().err


def test_a_lost_link_is_reported(console):
    code, _, err, _ = console(lambda p: None, "ping", "MANIPULATOR")
    assert code == 3
    assert "closed the link" in err


def test_time_out_names_the_missing_report(console):
    code, _, err, _ = console(lambda p: [(16, 1, 1, p.request_id, p.user)], "ping", "MANIPULATOR", timeout_s=5)
    assert code == 4
    assert "end of verification" in err


def test_reports_of_other_clients_do_not_end_a_request(console):
    """The verification of another client's request with another sequence count does not end our request."""

    def answer(packet):
        other = bytes([packet.raw[0], packet.raw[1], 0xC0 | (packet.raw[2] ^ 1) & 0x3F, packet.raw[3]])
        return [(16, 1, 7, other, packet.user)]

    assert console(answer, "state", "MANIPULATOR", "OFFLINE", timeout_s=0.5)[0] == 4


def test_raw_sends_octets_as_they_are(console):
    raw = packets.build_tc(16, 77, 17, 1, b"", source=1)
    code, _, _, received = console(success, "raw", raw.hex())
    assert code == 0
    assert received[0].raw == raw


def test_stop_commands_the_subsystems_but_not_supervisor_and_communication(console):
    def answer(packet):
        if packet.message == (131, 8):
            rows = [(17, 2, 5), (16, 2, 4), (1, 2, 5), (2, 2, 5)]
            table = struct.pack(">H", 4) + b"".join(struct.pack(">HBBBHB", a, p, s, 0, 2, 0) for a, p, s in rows)
            return success(packet, (131, 9, table))
        return success(packet)

    code, _, _, received = console(answer, "stop")
    assert code == 0
    assert [(p.apid, p.message, p.data) for p in received[1:]] == [(17, (129, 1), b"\6"), (16, (129, 1), b"\6")]


def test_json_has_null_for_a_number_that_is_not_finite(console, dictionary):
    parameter = dictionary.subsystem("MANIPULATOR").parameter("TORQUE_LIMIT")
    report = (20, 2, struct.pack(">HIdd", 1, parameter.parameter_id, float("nan"), float("-inf")))
    code, out, _, _ = console(lambda p: success(p, report), "get", "MANIPULATOR.TORQUE_LIMIT", "--json")
    assert code == 0 and json.loads(out.splitlines()[-1], parse_constant=pytest.fail)["values"]["TORQUE_LIMIT"] == [None, None]


def test_events_are_shown(dictionary, dictionary_path, capsys, monkeypatch):
    monkeypatch.setattr("hirosco_gse.cli.LISTEN_S", 0.3)
    event = dictionary.subsystem("JOYSTICK").event("OPERATOR_NOTE")

    class Talker(Spacecraft):
        def _talk(self, stream):
            data = struct.pack(">H", event.id)
            stream.sendall(build_tm(17, 0, 5, 2, data, 0, dictionary.epoch_ns + 1_500_000_000))
            stream.recv(1)

    craft = Talker(None)
    try:
        code = main(["--port", str(craft.port), "--dictionary", str(dictionary_path), "events"])
    finally:
        craft.close()
    assert code == 0
    out = capsys.readouterr().out
    assert "JOYSTICK: LOW OPERATOR_NOTE" in out
    assert "1.500000" in out


def test_permissions_need_no_link(dictionary_path, capsys):
    assert main(["--dictionary", str(dictionary_path), "permissions"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any("MOVE_TO" in line for line in lines) and len({re.search(r"  to ", line).start() for line in lines}) == 1  # One column.
    assert main(["--dictionary", str(dictionary_path), "permissions", "MANIPULATOR"]) == 2
    assert capsys.readouterr().err == "gse: usage: permissions\n"


@pytest.mark.parametrize("program", [[sys.executable, "gse/gse"], [sys.executable, "-m", "gse"], ["gse/gse"]])
def test_the_command_runs_with_plain_python(program, dictionary_path):
    done = subprocess.run([*program, "--help"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert "exit codes" in done.stdout
    done = subprocess.run(
        [*program, "--port", "1", "--dictionary", dictionary_path, "ping"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 3
    assert "Traceback" not in done.stderr


def test_the_command_line_needs_no_package():
    """The command may import neither numpy nor matplotlib."""
    code = "import sys; sys.path.insert(0, 'gse'); import hirosco_gse.cli; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-S", "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert not {"numpy", "matplotlib"} & set(done.stdout.split())
