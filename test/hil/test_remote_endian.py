# SPDX-License-Identifier: Apache-2.0
"""A real difference in byte order: the program of one subsystem, built for a big-endian processor, flies
together with little-endian programs, and the buses are the same."""

import binascii
import concurrent.futures
import os
import random
import shutil
import signal
import subprocess
import sys

import environments
import pytest

sys.path.insert(0, str(environments.ROOT / "test" / "mission"))
sys.path.insert(0, str(environments.ROOT / "gse"))

import flying
import lives
from hirosco_gse import run as runs

S390X = environments.ROOT / "build" / "s390x"
MEMBERS = {"MANIPULATOR": 16, "JOYSTICK": 17}
RUNNER = "qemu-s390x"
BUS_LOGS = ("can-robot.log", "can-robot-b.log", "can-joystick.log", "can-joystick-b.log")
END_S = 60  # Much longer than the end of a process takes.
FLIGHT_S = 20
REPEATS = 20
BIG, LITTLE = 0, 1  # Byte orders in an agreement of service 130.


@pytest.fixture(scope="module")
def directory(hil_directory):
    path = hil_directory / "big-endian"
    path.mkdir()
    return path


@pytest.fixture(scope="module")
def native(directory):
    """The same flight with little-endian programs only."""
    flight = flying.fly(directory / "native", "--scenario", "hil", "--links", "udp")
    assert flight.code == 0, flight.transcript()
    return flight


@pytest.fixture(scope="module", params=MEMBERS)
def remote_endian(request, directory):
    """(subsystem, its flight)."""
    flight = flying.fly(directory / request.param, "--scenario", "hil", "--remote-endian", request.param)
    assert flight.code == 0, flight.transcript()
    return request.param, flight


def test_programs_are_big_endian_and_static():
    for name in MEMBERS:
        head = (S390X / "bin" / name.lower()).read_bytes()[:20]
        assert head[:4] == b"\x7fELF" and head[5] == 2, "expected ELF with the most significant octet first"
        assert int.from_bytes(head[18:20], "big") == 22, "expected a program for IBM S/390"


def test_flight_ends_without_error_over_udp(remote_endian):
    name, flight = remote_endian
    assert flight.facts["remote_endian"] == name
    assert flight.facts["links"] == "udp"
    assert flight.facts["reproducible"] is True
    flying.assert_clean(flight)


def test_records_lie_in_the_storage_directory(native, remote_endian):
    """The remote-endian program uses the same names of records as a native program."""
    name, flight = remote_endian
    records = sorted(path.name for path in (flight.directory / "storage").iterdir())
    assert records == sorted(path.name for path in (native.directory / "storage").iterdir())
    assert f"{name}.journal.0" in records


@pytest.mark.parametrize("log", BUS_LOGS)
def test_buses_carry_the_same_frames(native, remote_endian, log):
    _, flight = remote_endian
    assert flight.octets(log) == native.octets(log)


def test_truth_is_the_same(native, remote_endian):
    _, flight = remote_endian
    assert flight.octets("truth.lcm") == native.octets("truth.lcm")


def _differing(native, flight):
    """Number of packets that differ. They may differ only in the byte order of an agreement and in the
    checksum."""
    differing = 0
    assert len(flight.packets) == len(native.packets)
    for (time_ns, direction, here), (other_ns, other_direction, raw) in zip(native.packets, flight.packets):
        assert (time_ns, direction) == (other_ns, other_direction)
        if here == raw:
            continue
        differing += 1
        differing_octets = [i for i in range(len(here) - 2) if here[i] != raw[i]]
        assert len(here) == len(raw) and len(differing_octets) == 1, f"{here.hex()} {raw.hex()}"
        assert here[7] == 130 and here[8] in (3, 4, 9), "expected a difference only in a request, an agreement or a report of a link"
        assert (here[differing_octets[0]], raw[differing_octets[0]]) == (LITTLE, BIG)
        assert int.from_bytes(raw[-2:], "big") == binascii.crc_hqx(raw[:-2], 0xFFFF)
    return differing


def test_packets_differ_in_the_byte_order_of_its_link_only(native, remote_endian):
    """The producer of a link states its byte order in the negotiation: accepted by the producer, requested of
    the consumer, accepted by it and to the ground."""
    _, flight = remote_endian
    assert _differing(native, flight) == 4
    output = subprocess.run([flying.PUSDUMP, flight.directory / "packets.log"], capture_output=True, text=True, check=True).stdout
    agreed = [line for line in output.splitlines() if " TM 1 " in line and "[130,4]" in line]
    assert [f"byte_order={BIG}" in line for line in agreed].count(True) == 1, agreed


@pytest.mark.long
def test_whole_telepresence_gives_the_same_logs(directory):
    """The logs of a flight with contact, spring, unplugged devices and the return to operation are the same."""
    one = flying.fly(directory / "telepresence-native", "--scenario", "telepresence", "--links", "udp")
    other = flying.fly(directory / "telepresence", "--scenario", "telepresence", "--remote-endian", "MANIPULATOR")
    assert (one.code, other.code) == (0, 0), other.transcript()
    for log in (*BUS_LOGS, "truth.lcm"):
        assert one.octets(log) == other.octets(log), log
    assert _differing(one, other) > 4, "expected further differing packets, because the links are opened again"
    flying.assert_clean(other)


# ---- Deaths ----

@pytest.fixture(scope="module")
def scenario(directory):
    lines = ["0.0 hand rest", f"2 hand circle 0.1 0.5 1 {FLIGHT_S} 1", *flying.bring_up(0.1)]
    lines += [f"{second} operator ping all" for second in range(3, FLIGHT_S)]
    return flying.write_scenario(directory / "death.scn", *lines, f"{END_S} operator shutdown")


@pytest.mark.parametrize("victim", [RUNNER, pytest.param("proxy", marks=pytest.mark.long)])
def test_kill_in_operation_ends_in_the_safe_state(directory, scenario, victim):
    """The program or its proxy dies: the subsystem is lost like any other one, its drives leave operation,
    and its partner follows."""
    flight = _die(directory / f"death-{victim}", scenario, victim, len(flying.bring_up(0.1)) + 2)
    states = [raw[22] for _, direction, raw in flight.packets if direction == "TM" and raw[7:9] == b"\x81\x02"
              and int.from_bytes(raw[:2], "big") & 0x7FF == MEMBERS["JOYSTICK"]]
    assert 6 in states, "expected ERROR_OPERATIONAL of the partner"
    _assert_safe(flight)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(8))
def test_a_kill_at_any_step_leaves_no_drive_in_operation(directory, scenario, seed):
    """Some steps are before the program has joined the run."""
    draw = random.Random(seed)
    victim, step = draw.choice([RUNNER, "proxy"]), draw.randint(0, FLIGHT_S)
    _assert_safe(_die(directory / f"death-{seed}", scenario, victim, step))


def _die(path, scenario, victim, step):
    """kill -9 of the manipulator's program or its proxy after a step of the operator."""
    flight = flying.start(path, "--scenario", scenario, "--remote-endian", "MANIPULATOR")
    try:
        flying.wait_until(lambda: flight.process.poll() is not None or flight.steps() >= step and victim in flying.descendants(flight.process.pid),
                          f"step {step}")
        assert flight.process.poll() is None, flight.transcript()
        os.kill(flying.descendants(flight.process.pid)[victim], signal.SIGKILL)
        flight.wait()
    finally:
        flight.abandon()
    assert flight.code == 1, flight.transcript()
    assert "manipulator" in flight.facts["exit_reason"]
    if victim == RUNNER:
        assert "was ended by signal 9" in flight.console, "expected a message of the proxy about the loss of its program"
    return flight


def _assert_safe(flight):
    """Expect that no drive is in operation at the end and that nothing is left."""
    drives = {}
    for entry in runs.load(flight.directory).truth["DRIVE"]:
        drives[entry["bus"], int(entry["node"]), int(entry["axis"])] = entry
    assert len(drives) == 4
    assert not [drive for drive, entry in drives.items() if entry["statusword"] & 0x6F == 0x27]
    flying.assert_clean(flight)


@pytest.mark.parametrize("name", [name if name == "MANIPULATOR" else pytest.param(name, marks=pytest.mark.long) for name in MEMBERS])
def test_lives_are_those_of_a_native_program(directory, name):
    """Stops, kills, hangs and restarts of the program of the other byte order and of its partner: the buses
    are the same, and so are the packets except for the byte order in reports of its link."""
    path = lives.scenario(directory / f"lives-{name}.scn")
    native = lives.fly(directory / f"lives-native-{name}", path, "--links", "udp")
    flights = [lives.fly(directory / f"lives-{name}-{number}", path, "--remote-endian", name) for number in range(2)]
    assert lives.digest(flights[0]) == lives.digest(native)
    assert flights[0].octets("packets.log") == flights[1].octets("packets.log")
    assert _differing(native, flights[0]) == 4


@pytest.mark.long
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("name", MEMBERS)
def test_repetitions_give_the_same_checksum(directory, name):
    """Stops, kills, hangs and restarts, twenty times: each log has the same checksum every time."""
    path, sums = lives.scenario(directory / f"repeats-{name}.scn"), set()
    for number in range(REPEATS):
        flight = lives.fly(directory / f"repeat-{name}-{number}", path, "--remote-endian", name)
        sums.add(tuple(lives.digest(flight, ("packets.log", *BUS_LOGS)).values()))
        shutil.rmtree(flight.directory)
        assert len(sums) == 1, number


# ---- What is refused ----

@pytest.mark.parametrize("name, message", [("GRIPPER", "no such subsystem"), ("SUPERVISOR", "shared memory"), ("COMMUNICATION", "shared memory")])
def test_a_subsystem_that_cannot_be_remote_endian_is_refused(directory, name, message):
    refused = flying.refuse("run", "--remote-endian", name, "--out", directory / "refused")
    assert refused.returncode == 1
    assert message in refused.stderr + refused.stdout


def test_a_program_that_is_not_built_is_refused_with_the_next_step(directory):
    """The launcher looks for programs in its working directory, which has none in this test."""
    root = directory / "bare"
    root.mkdir()
    shutil.copytree(environments.ROOT / "descriptors", root / "descriptors")
    refused = subprocess.run([flying.BIN / "hirosco", "run", "--remote-endian", "MANIPULATOR"], cwd=root, stdin=subprocess.DEVNULL,
                             capture_output=True, text=True, timeout=flying.MOMENT_S)
    assert refused.returncode == 1
    assert "make remote-endian" in refused.stderr + refused.stdout


def test_a_proxy_and_a_program_that_are_started_by_hand_end_with_a_message():
    """Started by hand, each program says which program starts it."""
    alone = subprocess.run([flying.BIN / "proxy"], capture_output=True, text=True, timeout=flying.MOMENT_S)
    assert alone.returncode == 2 and "hirosco run --remote-endian" in alone.stderr
    no_run = subprocess.run([flying.BIN / "proxy", "--run", "/hirosco-0.run", "--component", "2", "--program", "x", "--runner", "y"],
                            capture_output=True, text=True, timeout=flying.MOMENT_S)
    assert no_run.returncode == 1 and "no such run" in no_run.stderr
    program = subprocess.run([RUNNER, S390X / "bin" / "manipulator", "--run", "x", "--proxy", "0"], stdin=subprocess.DEVNULL,
                             capture_output=True, text=True, timeout=flying.MOMENT_S, cwd=environments.ROOT)
    assert program.returncode == 1 and "the proxy has sent no run" in program.stderr


# ---- Units ----

def _units():
    return sorted(str(path.relative_to(S390X)) for path in (S390X / "test" / "unit").rglob("test_*")
                  if path.suffix == "" and path.is_file()) if S390X.exists() else []


@pytest.mark.long
def test_units_pass_on_a_big_endian_processor():
    """Tests of conversions between numbers and octets: packets, services, parameters, links, CANopen."""
    subprocess.run(["make", "-s", "S390X=1", "ONLY=", "remote-endian-tests"], cwd=environments.ROOT, check=True)
    programs = _units()
    assert len(programs) >= 70

    def run(program):
        return program, subprocess.run([RUNNER, S390X / program], cwd=environments.ROOT, stdin=subprocess.DEVNULL,
                                       capture_output=True, text=True, timeout=flying.FLIGHT_LIMIT_S)

    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        failed = [f"{program}:\n{ended.stdout[-2000:]}{ended.stderr[-2000:]}"
                  for program, ended in pool.map(run, programs) if ended.returncode != 0]
    assert not failed, "\n".join(failed)
