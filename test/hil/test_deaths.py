# SPDX-License-Identifier: Apache-2.0
"""200 kills and unplugged devices at instants drawn from their numbers: 180 on shared memory on this machine,
20 over vcan and TIPC on one or two nodes. Each ends as specified: by the raw logs the other subsystems are in
safe states in time, and the run has ended with a report and left nothing behind."""

import concurrent.futures
import json
import os
import pathlib
import shutil
import sqlite3
import types

import deaths
import flying
import pytest
from hirosco_gse import logs, packet_log
from hirosco_gse import run as runs
from environments import ARITHMETIC, PYTHON

ON_SHARED_MEMORY = range(180)
# For each carrier, these include the death of a member and an unplugged device in operation.
ON_REAL_BUSES = range(17660, 17680)
AT_ONCE = min(2, len(os.sched_getaffinity(0)))
REAL_BUSES_S = 6000  # Time limit of the flights in the micro-VM.
APIDS = {"joystick": 17, "manipulator": 16}
OWNER = {"robot": 16, "joystick": 17}
REACTION_US = 5_000
REPORTED_US = 10_000
SUPERVISOR_LOST_US = 3_000_000
ENABLED, ENABLED_MASK = 0x27, 0x6F
ERROR_OPERATIONAL, OFFLINE = 6, 0
DRIVES = 4


# --- logs ---------------------------------------------------------------------------------------------------------------

def drives_of(directory):
    """(entries of the faults, dictionary: drive -> its entries in order), from the truth log."""
    channels = logs.parse_lcm((directory / "truth.lcm").read_bytes())
    truth = runs.decode_truth({name: channels[name] for name in ("DRIVE", "FAULT") if name in channels})
    drives = {}
    for entry in truth["DRIVE"]:
        drives.setdefault((entry["bus"], int(entry["node"]), int(entry["axis"])), []).append(entry)
    return truth["FAULT"], drives


def is_enabled(entry):
    return entry["statusword"] & ENABLED_MASK == ENABLED


def enabled_at(drives, time_us):
    """Drives that were in operation-enabled just before this time."""
    return {drive for drive, history in drives.items()
            if any(is_enabled(e) for e in [e for e in history if e["time_us"] < time_us][-1:])}


def left_after(drives, drive, time_us):
    """Microseconds from this time until the drive first left operation; None if it never did."""
    return next((int(e["time_us"]) - time_us for e in drives[drive] if e["time_us"] >= time_us and not is_enabled(e)), None)


def lines_before(path, time_us):
    """Complete lines of a bus log before a time."""
    lines = path.read_bytes().split(b"\n")[:-1]
    return [line for line in lines if int(line[1:11]) * 1_000_000 + int(line[12:18]) < time_us]


def reports(packets, service, subtype):
    """(time_us, APID, octets) of all telemetry of one type."""
    return [(time_ns // 1000, int.from_bytes(raw[:2], "big") & 0x7FF, raw) for time_ns, direction, _, raw in packets
            if direction == "TM" and raw[7] == service and raw[8] == subtype]


# --- specified ends -----------------------------------------------------------------------------------------------------

def judge(case, end, directory, undisturbed):
    """Raise AssertionError unless the flight ended as specified. `undisturbed` are the logs of the same
    flight without the fault."""
    assert not end.left, end.left
    for log in ("can-robot.log", "can-joystick.log"):
        judge_before(case, directory / log, undisturbed / log)
    facts = json.loads((directory / "run.json").read_text())
    if case.victim == "launcher":
        judge_launcher(end, facts)
        judge_packets(directory)
        return
    assert end.code in (0, 1) and facts["exit_code"] == end.code, end.output
    judge_packets(directory)
    if case.victim in ("simulator", "image"):  # The devices end with the simulator.
        judge_death(case, end, facts)
        return
    faults, drives = drives_of(directory)
    assert [(int(f["time_us"]), f"{f['kind']} {f['target']}") for f in faults] == [(case.time_us, case.fault)]
    assert len(drives) == DRIVES
    assert not [drive for drive, history in drives.items() if is_enabled(history[-1])], "a drive is in operation at the end"
    packets = packet_log.read_packets(directory / "packets.log")
    if case.victim is None:
        judge_unplug(case, end, facts, drives, packets)
        if case.fault == "cut robot-b":
            assert (directory / "can-robot.log").read_bytes() == (undisturbed / "can-robot.log").read_bytes()
    else:
        judge_death(case, end, facts)
        judge_others(case, drives, packets, facts)


def judge_before(case, log, undisturbed):
    """Until the fault the flight must equal the undisturbed one; a simulator that dies has not written all
    its logs."""
    seen, expected = lines_before(log, case.time_us), lines_before(undisturbed, case.time_us)
    if case.victim in ("simulator", "image", "launcher"):
        expected = expected[: len(seen)]
    assert seen == expected, f"{log.name} differs from the undisturbed flight before the fault"


def judge_packets(directory):
    """The archive must have every packet of the log, in order and without a gap."""
    packets = packet_log.read_packets(directory / "packets.log")
    with sqlite3.connect(f"file:{directory}/packets.db?mode=ro", uri=True) as database:
        rows = database.execute("SELECT number, raw FROM packet ORDER BY number").fetchall()
    assert [number for number, _ in rows] == list(range(1, len(packets) + 1))
    assert [raw for _, raw in rows] == [raw for *_, raw in packets]


def judge_death(case, end, facts):
    """The run must fail and report the process that died and the cause."""
    assert end.code == 1, end.output
    assert facts["exit_reason"].startswith(f"{case.victim} was ended by signal 9"), facts["exit_reason"]
    assert f"failed: {case.victim} was ended by signal 9" in end.output
    # The ground link ends and opens in simulated time, except after a death before the operator has
    # connected.
    assert facts["reproducible"] is was_restarted(facts) or (facts["reproducible"] and case.victim == "communication")
    entry = next(entry for entry in facts["processes"] if entry["name"] == case.victim)
    assert entry.get("signal") == 9 or entry["starts"] == 2, entry


def was_restarted(facts):
    """True if the supervisor died and was started again at an instant of simulated time, and the operator completed
    its steps."""
    operator = next(entry for entry in facts["processes"] if entry["name"] == "operator")
    return "and was restarted" in facts["exit_reason"] and operator.get("exit_code") == 0


def judge_launcher(end, facts):
    """The guard must end the run and report this."""
    assert end.code in (-9, 137), "the launcher was not ended by SIGKILL"
    assert facts["exit_code"] == 1 and facts["exit_reason"].startswith("the launcher was killed"), facts
    assert "failed: the launcher was killed" in end.output
    assert facts["reproducible"] is False


def judge_others(case, drives, packets, facts):
    """After the death of a member all drives react as if a device were unplugged; after that of the supervisor,
    within the time-out of its members; after that of any other process, the shutdown is in order."""
    in_operation = enabled_at(drives, case.time_us)
    left = {drive: left_after(drives, drive, case.time_us) for drive in in_operation}
    if case.victim in APIDS and len(in_operation) == DRIVES:
        assert max(left.values()) <= REACTION_US, left
        other = next(apid for name, apid in APIDS.items() if name != case.victim)
        judge_reported(case, packets, [other])
    elif case.victim == "supervisor" and in_operation:
        assert max(left.values()) <= SUPERVISOR_LOST_US + REACTION_US, left
    elif case.victim in ("communication", "operator", "packet-archive-sqlite"):
        states = {apid: raw[22] for _, apid, raw in reports(packets, 129, 2)}
        assert all(states.get(apid, OFFLINE) == OFFLINE for apid in APIDS.values()), states
        others = [entry for entry in facts["processes"] if entry["name"] not in (case.victim, "operator")]
        assert all(entry.get("exit_code") == 0 for entry in others), others


def judge_reported(case, packets, apids):
    """Expect a TM[129,2] to ERROR_OPERATIONAL of each APID."""
    for apid in apids:
        reported = [(time_us - case.time_us, raw[22]) for time_us, source, raw in reports(packets, 129, 2)
                    if source == apid and time_us >= case.time_us and raw[21] != raw[22]]
        assert reported and reported[0][1] == ERROR_OPERATIONAL and reported[0][0] <= REPORTED_US, f"APID {apid}: {reported}"


def judge_unplug(case, end, facts, drives, packets):
    """All drives must leave operation, all members report, and the owner raise a HIGH event; no process may
    die."""
    assert not [entry for entry in facts["processes"] if "signal" in entry or entry.get("starts", 1) != 1], facts["processes"]
    if case.fault == "cut robot-b":  # This cuts the unused channel.
        assert end.code == 0 and facts["reproducible"], end.output
        return
    assert end.code == 0 or facts["exit_reason"].startswith("operator ended with exit code"), facts["exit_reason"]
    in_operation = enabled_at(drives, case.time_us)
    if len(in_operation) == DRIVES:
        left = {drive: left_after(drives, drive, case.time_us) for drive in in_operation}
        assert max(left.values()) <= REACTION_US, left
        judge_reported(case, packets, APIDS.values())
        high = [(time_us - case.time_us, apid) for time_us, apid, _ in reports(packets, 5, 4) if time_us >= case.time_us]
        assert high and high[0][1] == OWNER[case.fault.split()[1]] and high[0][0] <= REPORTED_US, high
        assert end.code == 1, "the run must fail, because the operator's next command is refused"


# --- flights ----------------------------------------------------------------------------------------------------------------

def is_in_operation(case):
    begin, end = deaths.ENABLED_US
    return begin <= case.time_us <= end


def first_of_each():
    """Numbers of ON_SHARED_MEMORY that fly without LONG=1: the first one of each fault in operation, and the first
    one of each fault at another time."""
    found = {}
    for number in ON_SHARED_MEMORY:
        case = deaths.drawn(number)
        found.setdefault((case.fault, is_in_operation(case)), number)
    return set(found.values())


def with_the_rest_long(numbers, quick):
    return [number if number in quick else pytest.param(number, marks=pytest.mark.long) for number in numbers]


def asked(request, test):
    """Numbers that this session will fly."""
    return [item.callspec.params["number"] for item in request.session.items if item.name.startswith(f"{test}[")]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The flight without a fault."""
    directory = tmp_path_factory.mktemp("undisturbed") / "run"
    flight = flying.fly(directory, "--scenario", "hil", "--form", "image", environment=ARITHMETIC)
    assert flight.code == 0, flight.transcript()
    return directory


@pytest.fixture(scope="module")
def ended(request, tmp_path_factory, undisturbed):
    """Dictionary: number -> future of its flight and its check. Two flights run at a time, ahead of the tests
    that use them."""
    parent = tmp_path_factory.mktemp("deaths")

    def flown(number):
        case, directory = deaths.drawn(number), parent / str(number)
        flight, left = deaths.fly(case, directory, parent)
        end = types.SimpleNamespace(code=flight.code, output=flight.output, left=left)
        judge(case, end, directory, undisturbed)
        shutil.rmtree(directory)

    with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        futures = {number: pool.submit(flown, number) for number in asked(request, "test_a_death_on_shared_memory_ends_as_specified")}
        yield futures
        pool.shutdown(cancel_futures=True)


@pytest.mark.parametrize("number", with_the_rest_long(ON_SHARED_MEMORY, first_of_each()), ids=lambda number: str(deaths.drawn(number)))
def test_a_death_on_shared_memory_ends_as_specified(ended, number):
    ended[number].result()


@pytest.mark.long  # The micro-VM needs half a minute of processor time and more for each.
@pytest.mark.timeout(REAL_BUSES_S + 300)
@pytest.mark.parametrize("number", ON_REAL_BUSES, ids=lambda number: str(deaths.drawn(number, True)))
def test_a_death_on_real_buses_ends_as_specified(request, environment, undisturbed, number):
    numbers = asked(request, "test_a_death_on_real_buses_ends_as_specified")
    group = environment.group("deaths", f"{PYTHON} {deaths.PROGRAM} {' '.join(map(str, numbers))}", seconds=REAL_BUSES_S)
    group.check(str(number))
    directory = pathlib.Path(group.result.directory) / str(number)
    end = types.SimpleNamespace(**json.loads((directory / "end.json").read_text()))
    judge(deaths.drawn(number, True), end, directory, undisturbed)


def test_every_process_is_killed_and_every_device_is_unplugged():
    """The numbers cover all kinds of faults, also while all drives are in operation."""
    cases = [deaths.drawn(number) for number in first_of_each()]
    expected = {f"kill {name}" for name in (*deaths.PROCESSES, *deaths.IN_IMAGE)} | set(deaths.UNPLUGS)
    assert {case.fault for case in cases} == expected
    assert {case.fault for case in cases if is_in_operation(case)} == expected
    for carrier in deaths.CARRIERS:
        met = [case for case in (deaths.drawn(number, True) for number in ON_REAL_BUSES)
               if case.options[2:] == carrier and is_in_operation(case)]
        assert [case for case in met if case.victim in APIDS] and [case for case in met if case.fault in deaths.UNPLUGS[:-1]]
