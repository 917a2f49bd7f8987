# SPDX-License-Identifier: Apache-2.0
"""Programs of subsystems on FreeRTOS, on an emulated board with a Cortex-M, in one mission with native programs: every log is that of a
flight with native programs only."""

import os
import re
import shutil
import signal
import subprocess
import sys

import environments
import pytest

sys.path[:0] = [str(environments.ROOT / "test" / part) for part in ("mission", "board", "conformance/pus")]

import eeprom
import flight as boards
import flying
import lives
import station as stations
from test_tutorial import copy_of_tree

M7, M3 = "mps2-an500", "mps2-an385"
LOGS = ("packets.log", "truth.lcm", "can-robot.log", "can-robot-b.log", "can-joystick.log", "can-joystick-b.log")
BUS_LOGS = LOGS[2:]
EMULATOR = "qemu-system-arm"[:15]  # The name of a process has at most 15 characters.
FLIGHT_S, END_S = 20, 60
LENGTH, TABLE_FULL = 0x0101, 0x0205  # Failure codes.
CYCLES = 108000
PROCESSORS = environments.ROOT / "test" / "hil" / "processors"  # A mission with three subsystems that drive devices.
FLOWN = ("manipulator", "joystick")  # Programs that the normal tests fly; those of LONG=1 build the others, too.
CONTROLLED = {"PRE_OPERATIONAL", "SAFE_OPERATIONAL", "OPERATIONAL", "ERROR_OPERATIONAL"}


@pytest.fixture(scope="module")
def directory(hil_directory):
    path = hil_directory / "rtos"
    path.mkdir()
    return path


def make(*words, root=environments.ROOT):
    subprocess.run(["make", "-s", *words], cwd=root, check=True)


def build(board, *programs, mission=""):
    make("rtos", f"BOARD={board}", f"ONLY={' '.join(programs)}", f"MISSION={mission}")


@pytest.fixture(scope="module")
def board():
    build(M7, *FLOWN)
    return M7


@pytest.fixture(scope="module")
def native(directory):
    """The flight of the scenario hil with native programs only."""
    flight = flying.fly(directory / "native", "--scenario", "hil", "--links", "udp")
    assert flight.code == 0, flight.transcript()
    return flight


def expect_same(native, flight, logs=LOGS):
    assert flight.code == 0, flight.transcript()
    flying.assert_clean(flight)
    for log in logs:
        assert flight.octets(log) == native.octets(log), log


@pytest.mark.parametrize("names", [FLOWN, pytest.param(("arm", "actuators", "instruments"), marks=pytest.mark.long)])
def test_programs_are_for_a_cortex_m_without_an_allocator(board, names):
    build(board, *names)
    for name in names:
        program = environments.ROOT / "build" / board / "bin" / name
        head = program.read_bytes()[:20]
        assert head[:6] == b"\x7fELF\x01\x01" and int.from_bytes(head[18:20], "little") == 40, "expected a 32-bit little-endian ELF for ARM"
        symbols = subprocess.run(["arm-none-eabi-nm", program], capture_output=True, text=True, check=True).stdout
        assert not re.findall(r" \w (pvPortMalloc|_malloc_r|_sbrk|_sbrk_r)$", symbols, re.MULTILINE)
        assert not re.findall(r" \w (XML_\w+|xml_\w+|descriptor_load_\w+)$", symbols, re.MULTILINE), "expected no XML reader"


@pytest.mark.parametrize("names", [pytest.param("MANIPULATOR", marks=pytest.mark.long), "MANIPULATOR,JOYSTICK"])
def test_logs_are_those_of_native_programs(directory, native, board, names):
    flight = flying.fly(directory / names, "--scenario", "hil", "--rtos", names)
    expect_same(native, flight)
    assert flight.facts["rtos"] == names and flight.facts["reproducible"] is True
    for name in names.split(","):
        records = eeprom.files(flight.directory / "storage" / f"{name}.eeprom")
        assert records == {path.name: path.read_bytes() for path in (native.directory / "storage").glob(f"{name}.*")}
        assert f"{name}.journal.0" in records


@pytest.mark.long
def test_a_processor_without_doubles_in_hardware_flies_the_same(directory, native):
    build(M3, "manipulator")
    expect_same(native, flying.fly(directory / "m3", "--scenario", "hil", "--rtos", f"MANIPULATOR:{M3}"))


@pytest.mark.long
def test_whole_telepresence_gives_the_same_logs(directory, board):
    one = flying.fly(directory / "telepresence-native", "--links", "udp")
    assert one.code == 0, one.transcript()
    expect_same(one, flying.fly(directory / "telepresence", "--rtos", "MANIPULATOR"))


@pytest.mark.long
@pytest.mark.parametrize("program, mission, scenario", [("actuators", "actuators", "actuators"), ("arm", "ur5e", "ur5e-poses")])
def test_wheels_and_valves_and_an_arm_of_six_joints_fly_the_same(directory, program, mission, scenario):
    """Each program that drives devices on CAN flies on the board, not only that of the manipulator."""
    build(M7, program)
    options = ("--mission", mission, "--scenario", scenario)
    one = flying.fly(directory / f"{mission}-native", *options, "--links", "udp")
    assert one.code == 0, one.transcript()
    buses = sorted(path.name for path in one.directory.glob("can-*.log"))
    assert sum(len(one.read(bus).splitlines()) for bus in buses) > 1000, buses
    flight = flying.fly(directory / mission, *options, "--rtos", mission.upper())
    expect_same(one, flight, ("packets.log", "truth.lcm", *buses))
    assert flight.facts["rtos"] == mission.upper()


@pytest.mark.long
def test_three_processors_fly_one_mission(directory, native, board):
    """A native supervisor, a manipulator on the board, and a joystick that is big-endian: the buses are the same."""
    make("remote-endian")
    flight = flying.fly(directory / "three", "--scenario", "hil", "--rtos", "MANIPULATOR", "--remote-endian", "JOYSTICK")
    expect_same(native, flight, (*BUS_LOGS, "truth.lcm"))


@pytest.fixture(scope="module")
def root(directory):
    """A copy of the tree with the mission of three subsystems, as docs/porting.md describes, and with all programs for it."""
    make("remote-endian")
    boards_built = [f"{board}/flight" for board in (M7, M3)]
    root = copy_of_tree(directory / "tree", ("bin", "lib", "obj", "generated", "setup", "third_party", "flags", "s390x/bin", *boards_built))
    for kind in ("mission", "world"):
        shutil.copy(PROCESSORS / f"{kind}.xml", root / f"descriptors/{kind}s/processors.xml")
    for target in ("generated", f"rtos-{M7}", f"rtos-{M3}"):
        make(target, root=root)
    yield root
    shutil.rmtree(root, ignore_errors=True)


@pytest.mark.long
def test_four_processors_fly_one_mission(root):
    """Cortex-M7, Cortex-M3, a big-endian processor of 64 bits, and this one: every log is that of native programs."""
    options = ("--mission", "processors", "--scenario", PROCESSORS / "flight.scn")
    one = flying.fly(root / "out-native", *options, "--links", "udp", root=root)
    flight = flying.fly(root / "out", *options, "--rtos", f"MANIPULATOR:{M7},JOYSTICK:{M3}", "--remote-endian", "ACTUATORS", root=root)
    assert one.code == 0, one.transcript()
    expect_same(one, flight, (*LOGS, "can-platform.log"))
    for log in ("can-robot.log", "can-joystick.log", "can-platform.log"):
        assert len(flight.read(log).splitlines()) > 1000, log
    assert (flight.facts["rtos"], flight.facts["remote_endian"]) == (f"MANIPULATOR:{M7},JOYSTICK:{M3}", "ACTUATORS")


def test_steps_and_stacks_on_the_board_keep_a_margin(directory):
    """Each step in which drives are controlled takes at most half of the 108000 cycles that 216 MHz have in 0.5 ms. The emulator counts
    instructions, so the speed of this machine has no effect. Every state occurs, and an eighth of each stack stays free."""
    path = directory / "steps"
    path.mkdir()
    rows, stacks = boards.steps(path)
    assert {row.before for row in rows} >= {"OFFLINE", "HARDWARE_INIT", *CONTROLLED, "HARDWARE_DEINIT", "SOFTWARE_DEINIT"}
    assert all(row.longest <= CYCLES // 2 for row in rows if {row.before, row.after} <= CONTROLLED), rows
    assert sum(row.count for row in rows if row.before == "OPERATIONAL") > 5000
    assert {stack.task for stack in stacks} == {"main", "IDLE", "interrupts"}
    assert all(0 < stack.used <= stack.octets * 7 // 8 for stack in stacks), stacks


def test_the_loop_of_a_program_keeps_its_period_in_real_time(directory):
    """2 s of OPERATIONAL at 2 kHz, by the timer of the board: no step is missed, early, or more than 50 us late; and an eighth of
    each stack stays free, also of the tasks of the loops of services."""
    path = directory / "real-time"
    path.mkdir()
    waits, stacks = boards.loop_in_real_time(path)
    for state in ("PRE_OPERATIONAL", "SAFE_OPERATIONAL", "OPERATIONAL"):
        row = waits[state]
        assert (row.missed, row.early) == (0, 0) and row.latest <= 1250, row
    assert waits["OPERATIONAL"].steps >= 4000
    assert waits["OPERATIONAL"].lasted_us == (waits["OPERATIONAL"].steps - 1) * 500, "expected one step in each period of 500 us"
    assert {stack.task for stack in stacks} == {"main", "task", "IDLE", "interrupts"}
    assert all(0 < stack.used <= stack.octets * 7 // 8 for stack in stacks), stacks


@pytest.mark.parametrize("hang", ["hang", "hang-service"])
def test_a_program_that_hangs_in_real_time_is_reset_by_the_watchdog_of_the_board(directory, hang):
    """A step of the main loop, or a turn of the loop of services, never ends."""
    path = directory / f"real-time-{hang}"
    path.mkdir()
    _, text = boards.real_time(path, hang)
    assert "the watchdog was not fed within its period: the board is reset" in text and "LOOP" not in text, text


def test_stops_kills_hangs_and_restarts_are_those_of_a_native_program(directory, board):
    path = lives.scenario(directory / "lives.scn")
    native = lives.fly(directory / "lives-native", path, "--links", "udp")
    flight = lives.fly(directory / "lives-rtos", path, "--rtos", "MANIPULATOR")
    assert lives.digest(flight) == lives.digest(native)
    assert flight.octets("packets.log") == native.octets("packets.log")


def test_a_program_that_hangs_is_reset_by_the_watchdog_of_the_board(directory, board):
    """A step never ends: the watchdog resets the board, and the others see a death between two steps, as of a native program."""
    path = directory / "hang"
    path.mkdir()
    lines = ["0.0 hand rest", *flying.bring_up(0.1), "2 hand circle 0.1 0.5 1 2 1", "3.2 operator ping MANIPULATOR", "3.3 operator shutdown"]
    native = flying.fly(path / "native", "--links", "udp", "--scenario",
                        flying.write_scenario(path / "native.scn", *lines[:-2], "2.9995 fault kill manipulator", *lines[-2:]))
    flight = boards.start(path, "hang", "--scenario", flying.write_scenario(path / "hang.scn", *lines)).wait()
    assert flight.code == native.code == 1, flight.transcript()
    assert "the watchdog was not fed" in flight.console, flight.transcript()
    assert "ping MANIPULATOR: MANIPULATOR is alive" in flight.console, flight.transcript()
    assert flight.facts["reproducible"] is True
    flying.assert_clean(flight)
    for log in ("packets.log", *BUS_LOGS):
        assert flight.octets(log) == native.octets(log), log


@pytest.mark.long
def test_a_program_that_hangs_before_its_loop_is_reset_by_the_watchdog_of_the_board(directory, board):
    path = directory / "hang-start"
    path.mkdir()
    scenario = flying.write_scenario(path / "hang.scn", "0.0 hand rest", "0.5 operator ping all", "1 operator shutdown")
    flight = boards.start(path, "hang_start", "--scenario", scenario).wait()
    assert flight.code == 1, flight.transcript()
    assert "the watchdog was not fed" in flight.console, flight.transcript()
    assert "manipulator" in flight.facts["exit_reason"]
    flying.assert_clean(flight)


def _send_largest_requests(flight):
    """Dump as many areas as a board accepts; then more, which fails with TM[1,4]; then so many that the telecommand is longer than
    1024 octets, which is refused with TM[1,2]. The board performs the next request."""
    station = stations.Station(flight, stations.Notes())
    try:
        for areas, stage, code, detail in ((99, 7, None, None), (100, 4, TABLE_FULL, 99), (126, 4, TABLE_FULL, 99), (127, 2, LENGTH, None),
                                           (255, 2, LENGTH, None), (1, 7, None, None)):
            places = [{"start_address": place, "length": 1} for place in range(areas)]
            sent = station.send("MANIPULATOR", 6, 5, memory_id=2, n=places)
            outcome = station.settle(sent)
            assert outcome.stages[-1] == stage and len(outcome.failures) == (code is not None), (areas, outcome.stages, outcome.failures)
            assert code is None or (outcome.failure.code, outcome.failure.detail) == (code, detail or outcome.failure.detail), areas
    finally:
        station.close()


def _define(station, number):
    """Send a definition of ST[12], which is one record."""
    definition = {"pmon_id": number, "monitored_parameter_id": "MANIPULATOR.LINK_AGE", "validity_parameter_id": 0, "validity_mask": 0,
                  "validity_expected_value": 0, "monitoring_interval": 1, "repetition_number": 1, "check_type": "limit", "low_limit": 0,
                  "low_limit_event_definition_id": 0, "high_limit": 10, "high_limit_event_definition_id": 0}
    return station.send("MANIPULATOR", 12, 5, n=[definition])


def _kill_at_a_write(flight):
    """Kill the emulator when a third record begins to change the EEPROM, after two were acknowledged."""
    emulator = flying.descendants(flight.process.pid)[EMULATOR]
    image = flight.directory / "storage/MANIPULATOR.eeprom"
    station = stations.Station(flight, stations.Notes())
    try:
        for number in (1, 2):
            assert station.settle(_define(station, number)).is_completed
        before = image.stat().st_mtime_ns
        _define(station, 3)
        station.wait(lambda: image.stat().st_mtime_ns != before, "a write to the EEPROM")
        os.kill(emulator, signal.SIGKILL)
    finally:
        station.close()


def _expect_records(directory, storage):
    """Expect that the independent reader eeprom.py accepts the EEPROM, and that the next flight finds both acknowledged records;
    it may also find the third one."""
    records = eeprom.files(storage / "MANIPULATOR.eeprom")
    assert sorted(records) == ["MANIPULATOR.journal.0", "MANIPULATOR.journal.1"]
    assert records["MANIPULATOR.journal.0"].startswith(b"HJRN")
    flight = flying.start(directory, "--scenario", "none", "--duration", stations.ENDLESS_S, "--rtos", "MANIPULATOR", "--storage", storage)
    station = stations.Station(flight, stations.Notes())
    try:
        assert [entry["pmon_id"] for entry in station.ask("MANIPULATOR", 12, 8, n=[])["n"]] in ([1, 2], [1, 2, 3])
        station.command("state", "MANIPULATOR", "PRE_OPERATIONAL")
        assert station.settle(_define(station, 4)).is_completed
    finally:
        station.close()
        os.killpg(flight.process.pid, signal.SIGINT)  # As by Ctrl-C, which does not reach the emulator.
        flight.wait()
    assert flight.code == 0, flight.transcript()
    assert "damaged" not in flight.console


def test_an_emulated_computer_that_is_killed_is_a_lost_process(directory, board):
    """kill -9 of the emulator in operation, at a write to its EEPROM: drives leave operation, nothing is left of the run, and the next
    flight finds the records. Before, requests that are too long for the board are rejected."""
    lines = ["0.0 hand rest", f"2 hand circle 0.1 0.5 1 {FLIGHT_S} 1", *flying.bring_up(0.1)]
    lines += [f"{second} operator ping all" for second in range(3, FLIGHT_S)]
    scenario = flying.write_scenario(directory / "death.scn", *lines, f"{END_S} operator shutdown")
    step = len(flying.bring_up(0.1)) + 2
    flight = flying.start(directory / "death", "--scenario", scenario, "--rtos", "MANIPULATOR")
    try:
        flying.wait_until(lambda: flight.process.poll() is not None or flight.steps() >= step and EMULATOR in flying.descendants(flight.process.pid),
                          f"step {step}")
        assert flight.process.poll() is None, flight.transcript()
        _send_largest_requests(flight)
        _kill_at_a_write(flight)
        flight.wait()
    finally:
        flight.abandon()
    assert flight.code == 1, flight.transcript()
    assert "manipulator" in flight.facts["exit_reason"]
    assert "was ended by signal 9" in flight.console
    flying.assert_clean(flight)
    _expect_records(directory / "next", flight.directory / "storage")


def test_a_mission_that_was_not_compiled_in_is_refused(directory, board):
    """One number of the mission differs from the compiled one: the program ends with both hashes and the next step."""
    root = directory / "changed"
    shutil.copytree(environments.ROOT / "descriptors", root / "descriptors")
    for name in ("build", "sim"):
        (root / name).symlink_to(environments.ROOT / name)
    mission = root / "descriptors/missions/rokviss.xml"
    text, count = re.subn(r'(<Mission [^>]*power=")200"', r'\g<1>201"', mission.read_text())
    assert count == 1
    mission.write_text(text)
    refused = subprocess.run([flying.BIN / "hirosco", "run", "--scenario", "hil", "--rtos", "MANIPULATOR", "--out", "flight"], cwd=root,
                             stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=flying.MOMENT_S)
    assert refused.returncode != 0
    output = (root / "flight/console.log").read_text()
    assert re.search(r"hash 0x[0-9A-F]{16}: run `make rtos` .*, which was compiled for .*rokviss 0x[0-9A-F]{16}", output), output


@pytest.mark.long
def test_a_program_of_one_mission_contains_this_one_alone(directory, board):
    try:
        build(board, "manipulator", mission="classic")
        refused = flying.fly(directory / "other", "--scenario", "hil", "--rtos", "MANIPULATOR")
    finally:
        build(board, "manipulator")
    assert refused.code != 0
    assert re.search(r"run `make rtos` .*, which was compiled for classic 0x[0-9A-F]{16}\n", refused.console), refused.console
    flying.assert_clean(refused)
    program = (environments.ROOT / "build" / board / "bin/manipulator").read_bytes()
    assert b"\0classic\0" in program and b"\0rokviss\0" in program, "expected all missions in a program that was built without MISSION"


def test_an_unknown_mission_is_refused_with_the_names_of_all():
    done = subprocess.run(["make", "-s", f"rtos-{M7}", "MISSION=classical"], cwd=environments.ROOT, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "MISSION=classical: expected one of: actuators classic" in done.stderr


@pytest.mark.parametrize("name, message", [("GRIPPER", "no such subsystem"), ("SUPERVISOR", "shared memory"),
                                           ("MANIPULATOR:mps2", "mps2-an500"), ("MANIPULATOR,MANIPULATOR", "twice")])
def test_names_that_cannot_run_on_a_board_are_refused(directory, board, name, message):
    refused = flying.refuse("run", "--rtos", name, "--out", directory / "refused")
    assert refused.returncode != 0
    assert message in refused.stderr + refused.stdout


def test_a_program_that_is_not_built_is_named_with_the_next_step(directory):
    root = directory / "bare"
    root.mkdir()
    shutil.copytree(environments.ROOT / "descriptors", root / "descriptors")
    refused = subprocess.run([flying.BIN / "hirosco", "run", "--rtos", "MANIPULATOR"], cwd=root, stdin=subprocess.DEVNULL,
                             capture_output=True, text=True, timeout=flying.MOMENT_S)
    assert refused.returncode != 0
    assert "make rtos" in refused.stderr + refused.stdout
