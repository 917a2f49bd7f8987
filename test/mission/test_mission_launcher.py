# SPDX-License-Identifier: Apache-2.0
"""The launcher's command line: options, directories and scenarios that it refuses, and why; two runs at once; programs
started by hand."""

import re
import shutil
import socket
import subprocess

import flying
import pytest

USAGE = 2


@pytest.mark.parametrize(
    ("options", "reasons"),
    [
        (("--form", "image", "--time", "real"), ("image", "real-time")),
        (("--scenario", "none"), ("none", "stepped", "end")),
        (("--bus", "lin"), ("lin", "shm", "vcan", "can")),
        (("--bus", "can"), ("can", "--interface", "robot=can0")),
        (("--bus", "can", "--interface", "robot=can0", "--time", "stepped"), ("stepped", "--time real", "--sim-interface")),
        (("--transport", "tcp"), ("tcp", "udp", "tipc")),
        (("--form", "image", "--transport", "udp"), ("image", "memory", "processes")),
        (("--nodes", "3"), ("3", "1 or 2", "namespaces")),
        (("--nodes", "2", "--bus", "vcan"), ("vcan", "namespace", "shm")),
        (("--form", "image", "--nodes", "2"), ("image", "one program", "processes")),
        (("--links", "tcp"), ("tcp", "shm")),
        (("--form", "nodes"), ("nodes", "processes", "image")),
        (("--time", "soon"), ("soon", "stepped", "real")),
        (("--seed", "one"), ("one", "number")),
        (("--seed", "-1"), ("-1", "number")),
        (("--seed", "99999999999999999999999"), ("number",)),
        (("--port", "0"), ("port",)),
        (("--port", "65536"), ("port", "65535")),
        (("--port", "10015x"), ("port",)),
        (("--duration", "0"), ("seconds",)),
        (("--duration", "1.5"), ("seconds",)),
        (("--mission", "../../etc/passwd"), ("name",)),
        (("--mission", "rok viss"), ("name",)),
        (("--report", "maybe"), ("yes", "no")),
        (("--speed", "9"), ("--speed", "unknown")),
        (("--seed",), ("--seed: expected a known option with its value",)),
        (("telepresence",), ("telepresence",)),
        (("--out", "x" * 5000), ("long",)),
        (("--scenario", "/" + "x" * 5000 + ".scn"), ("long",)),
    ],
)
def test_wrong_options_are_refused_with_the_reason(options, reasons):
    refused = flying.refuse("run", *options)
    assert refused.returncode == USAGE, refused
    assert refused.stdout == ""
    assert len(refused.stderr.strip().splitlines()) == 1
    assert refused.stderr.startswith("hirosco: ")
    for reason in reasons:
        assert reason in refused.stderr


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--mission", "apollo"), "no such mission"),
        (("--scenario", "picnic"), "no such scenario: sim/scenarios/picnic.scn; choose another one with --scenario"),
        (("--scenario", "/nowhere/picnic.scn"), "no such scenario: /nowhere/picnic.scn"),
        (("--bus", "can", "--interface", "robot=none0", "--interface", "joystick=none1"), "none0"),
        (("--bus", "can", "--interface", "arm=none0"), "the mission has no such bus: arm=none0"),
    ],
)
def test_a_missing_mission_scenario_or_interface_is_named(directory, options, reason):
    refused = flying.refuse("run", *options, "--out", directory)
    assert refused.returncode in (1, USAGE), refused
    assert reason in refused.stderr
    assert not directory.exists(), "expected no directory of a run that never began"


@pytest.mark.parametrize("options", [("--scenario", ""), ("--seed", ""), ("--port", "", "--form", "")])
def test_empty_values_are_as_not_given(directory, options):
    """The Makefile passes every option, with an empty value if the user has not set it."""
    flight = flying.fly(directory, *options, "--scenario", "commissioning")
    assert flight.code == 0, flight.transcript()


@pytest.mark.parametrize("words", [(), ("--help",), ("run", "--help")])
def test_help_is_printed(words):
    shown = flying.refuse(*words)
    assert shown.returncode == 0
    assert shown.stdout.startswith("usage: hirosco run")
    for option in ("mission", "scenario", "seed", "form", "time", "bus", "transport", "links", "port", "out", "duration", "report"):
        assert f"--{option} " in shown.stdout
    assert max(map(len, shown.stdout.splitlines())) <= 110


@pytest.mark.parametrize("words", [("guard", "x"), ("guard", "hirosco-"), ("guard", "hirosco-0", "--seed", "1")])
def test_guard_without_a_launcher_is_refused(words):
    refused = flying.refuse(*words)
    assert refused.returncode == USAGE
    assert "guards are started by `hirosco run`" in refused.stderr


def test_unknown_command_is_refused():
    refused = flying.refuse("fly")
    assert refused.returncode == USAGE
    assert "hirosco --help" in refused.stderr


PROGRAMS = sorted(path.name for path in flying.BIN.glob("*")) or ["hirosco"]


@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.parametrize("words", [(), ("--help",), ("--no-such-option",), ("--run",), ("--run", "/hirosco-0.run", "--component", "0")])
def test_program_called_by_hand_prints_something_and_ends(name, words):
    """No program of the project crashes or waits without end, whatever its arguments are."""
    done = subprocess.run([flying.BIN / name, *words], check=False, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=flying.MOMENT_S, cwd="/tmp")
    assert done.returncode in (0, 1, USAGE), f"{name} {words} ended with {done.returncode}"
    output = done.stdout + done.stderr
    if not (name == "pusdump" and words == ()):  # an empty packet log is well-formed
        assert output.strip(), f"{name} {words} prints nothing"


@pytest.mark.parametrize("name", PROGRAMS)
def test_program_prints_its_version_and_its_usage(name):
    """Both are on standard output, with exit code 0; the version is that of base/version.h."""
    version = re.search(r'HIROSCO_VERSION "([^"]+)"', (flying.ROOT / "base" / "version.h").read_text(encoding="utf-8"))[1]
    for word in ("--version", "--help"):
        done = subprocess.run([flying.BIN / name, word], check=False, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=flying.MOMENT_S, cwd="/tmp")
        assert (done.returncode, done.stderr) == (0, ""), f"{name} {word}"
        if word == "--version":
            assert done.stdout == f"{name} {version}\n"
        else:
            assert done.stdout.startswith("usage: ")


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [
        ("socketcand", "99999", "a whole number from 0 to 65535"),
        ("seed", "18446744073709551616", "a whole number from 0 to 18446744073709551615"),
        ("seed", " -1", "a whole number from 0"),
        ("quantum", "1s", "a whole number from 0 to 1000000000"),
        ("free-run", "long", "a time in seconds"),
        ("time", "soon", "stepped or real"),
        ("bus", "robot", "NAME=ADDRESS"),
        ("bus", "sixteen-letters-=shm:x", "a name of a bus with at most 15 characters"),
    ],
)
def test_simulator_names_the_expected_value(option, value, expected):
    done = subprocess.run([flying.BIN / "simulator", f"--{option}", value], check=False, capture_output=True, text=True, timeout=flying.MOMENT_S)
    assert done.returncode == USAGE
    assert f"--{option} '{value.partition('=')[0]}': expected {expected}" in done.stderr


@pytest.mark.parametrize("words", [("--no-such-option",), ("robot",), ("--world",)])
def test_simulator_names_the_word_that_it_does_not_know(words):
    done = subprocess.run([flying.BIN / "simulator", *words], check=False, capture_output=True, text=True, timeout=flying.MOMENT_S)
    assert done.returncode == USAGE
    assert f"simulator: found '{words[0]}', expected " in done.stderr


def test_a_port_in_use_is_refused_and_named(directory):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        refused = flying.refuse("run", "--scenario", "commissioning", "--port", port, "--out", directory)
    assert refused.returncode in (1, USAGE)
    assert f"in use on 127.0.0.1:{port}" in refused.stderr


def test_the_requested_port_is_used(directory):
    port = flying.free_port()
    flight = flying.fly(directory, "--scenario", "commissioning", "--port", port)
    assert flight.code == 0, flight.transcript()
    assert f"127.0.0.1:{port}" in flight.output
    assert int(flight.read("ground.port")) == port


def test_directory_of_another_run_is_refused(directory):
    assert flying.fly(directory, "--scenario", "commissioning").code == 0
    before = flying.Flight(directory, None).octets("packets.log")
    refused = flying.refuse("run", "--scenario", "commissioning", "--out", directory)
    assert refused.returncode in (1, USAGE)
    assert "a run in this directory already" in refused.stderr
    assert str(directory) in refused.stderr
    assert flying.Flight(directory, None).octets("packets.log") == before


def _fly_with_storage(directory, storage, mission="rokviss"):
    scenario = flying.write_scenario(directory.with_suffix(".scn"), "0.1 operator ping SUPERVISOR", "0.2 operator shutdown")
    return flying.fly(directory, "--mission", mission, "--scenario", scenario, "--form", "image", "--storage", storage)


def test_storage_of_another_mission_is_refused_and_left_as_it_is(directory, tmp_path):
    """The records identify subsystems by numbers that mean other subsystems in this mission."""
    directory.mkdir()
    storage = tmp_path / "storage"
    assert _fly_with_storage(directory / "1", storage).code == 0
    before = {path.name: path.read_bytes() for path in storage.iterdir() if path.is_file()}
    assert before["mission"] == b"rokviss" and "SUPERVISOR.journal.0" in before
    refused = _fly_with_storage(directory / "2", storage, "classic")
    assert refused.code == 1
    for words in (f"{storage}/mission", "contains 'rokviss'", "expected 'classic'", "--storage", "--mission"):
        assert words in refused.output, refused.output
    assert {path.name: path.read_bytes() for path in storage.iterdir() if path.is_file()} == before
    assert _fly_with_storage(directory / "3", storage).code == 0
    (storage / "mission").write_bytes(b"")  # A power cut may leave this file empty.
    assert _fly_with_storage(directory / "4", storage).code == 0
    assert (storage / "mission").read_bytes() == b"rokviss"


def test_directories_that_cannot_be_written_are_distinguished(directory, tmp_path):
    """A directory with the name of the first file that is written has the effect of a read-only disk."""
    storage = tmp_path / "storage"
    (storage / "mission").mkdir(parents=True)
    refused = flying.refuse("run", "--scenario", "commissioning", "--storage", storage, "--out", directory / "1")
    assert refused.returncode == 1
    assert f"cannot write the storage: {storage}/mission; " in refused.stderr and "--storage" in refused.stderr
    (directory / "2" / "ground.mission").mkdir(parents=True)
    refused = flying.refuse("run", "--scenario", "commissioning", "--storage", tmp_path / "other", "--out", directory / "2")
    assert refused.returncode == 1
    assert f"cannot write the output directory: {directory}/2/ground.mission; " in refused.stderr and "--out" in refused.stderr


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("0.1 operator dance", ("dance",)),
        ("0.1 hand wave", ("wave",)),
        ("0.1 fault burn robot", ("burn",)),
        ("0.1 fault unplug moon STICK", ("moon",)),
        ("soon operator ping all", ("soon",)),
        ("0.1 fault kill nosuch", ("nosuch", "a process of this run:", "MANIPULATOR")),
    ],
)
@pytest.mark.parametrize("form", ["processes", "image"])
def test_error_in_a_scenario_is_reported_with_its_line(directory, form, line, words):
    directory.mkdir()
    path = flying.write_scenario(directory / "wrong.scn", "0.0 hand rest", line, "0.2 operator shutdown")
    flight = flying.fly(directory / "run", "--scenario", path, "--form", form)
    assert flight.code != 0
    assert re.search(r"wrong\.scn:3\b", flight.console), flight.transcript()
    for word in words:
        assert word in flight.console
    flying.assert_clean(flight)


def test_two_runs_at_once_do_not_affect_each_other(session_directory):
    """The runs take different ports, and each has the same octets as alone."""
    options = ("--scenario", "hil", "--form", "processes")
    pair = [flying.start(session_directory / f"pair-{seed}", *options, "--seed", seed) for seed in (1, 2)]
    for flight in pair:
        flight.wait()
        assert flight.code == 0, flight.transcript()
    assert pair[0].port() != pair[1].port()
    for seed, flight in zip((1, 2), pair):
        alone = flying.fly(session_directory / f"alone-{seed}", *options, "--seed", seed)
        for name in (*flying.TRACED, "truth.lcm"):
            assert flight.octets(name) == alone.octets(name), f"{name} of seed {seed}"
        flying.assert_clean(flight)


def test_latest_points_to_a_run_under_runs():
    """Without --out a run creates its directory under runs/."""
    words = ("run", "--scenario", "commissioning", "--report", "no", "--seed", "77")
    done = flying.refuse(*words)
    assert done.returncode == 0, done
    name = re.search(r"directory (runs/\S+)", done.stdout)[1]
    assert re.fullmatch(r"runs/commissioning-processes-77-\d{3}", name)
    assert (flying.ROOT / name / "run.json").exists()
    latest = flying.ROOT / "runs" / "latest"
    assert latest.is_symlink()
    shutil.rmtree(flying.ROOT / name)


@pytest.mark.parametrize("form", ["processes", "image"])
def test_a_duration_shorter_than_the_scenario_is_no_failure(session_directory, directory, form):
    scenario = session_directory / f"endless-{form}.scn"
    scenario.write_text("0 operator ping all\n900000 operator ping all\n", encoding="utf-8")
    flight = flying.fly(directory, "--scenario", scenario, "--duration", "7", "--form", form, "--report", "no")
    assert flight.code == 0, flight.transcript()
    assert flight.facts["cut_short"] is True
    assert 7.0 <= flight.facts["simulated_s"] < 900000


@pytest.mark.parametrize("form", ["processes", "image"])
@pytest.mark.parametrize("words", [(), ("--duration", "7")])
def test_a_failed_step_fails_the_run_however_the_mission_ends(session_directory, directory, form, words):
    scenario = session_directory / f"failing-{form}-{len(words)}.scn"
    scenario.write_text("0 operator ping all\n1 operator expect-state JOYSTICK OPERATIONAL\n", encoding="utf-8")
    flight = flying.fly(directory, "--scenario", scenario, "--form", form, "--report", "no", *words)
    assert flight.code == 1, flight.transcript()
    assert flight.facts["exit_reason"].startswith("operator ended with exit code 1"), flight.transcript()
