# SPDX-License-Identifier: Apache-2.0
"""Invariants that every flight of the fault campaign must keep, whatever faults it has."""

import contextlib
import json
import re
import sqlite3
from dataclasses import dataclass, field

from campaign_faults import OUTAGE_S

NS_PER_S = 1_000_000_000
STEP_NS = 500_000
ROUNDING_NS = 1000  # Tolerance for the rounding of times in packets, whose unit is 2^-24 s.
APIDS = {"JOYSTICK": 17, "MANIPULATOR": 16, "SUPERVISOR": 1, "COMMUNICATION": 2}
PARTNER = {17: 16, 16: 17}
SERVICE_1 = 1
TERMINAL = {2, 4, 7, 8, 10}  # Subtypes of ST[01] after which a request has no further report.
ON_BOARD = 0x8000  # Lowest number of users on board.
CUT_S = 0.2  # Requests of the last 0.2 s may stay unanswered, because the mission may already shut down.
# A request that was sent less than this time before the loss of the connection may be lost, too.
UPLINK_NS = NS_PER_S
MOVING = (0x27, 0x07)  # Statuswords of CiA 402: operation enabled, quick stop active.
REACTION_NS = 2 * STEP_NS
SILENCE_NS = 10_000_000  # Longest reaction to a stale link: the age limit of the link, one cycle, and the time of the report.
OPERATIONAL, ERROR_OPERATIONAL = 5, 6
DEVICE_BUS = {"robot": 16, "joystick": 17}  # Owner of the drives.
# Emergency 0x8250: no RPDO has arrived.
EMERGENCY = re.compile(r"^\((\d+)\.(\d{6})\) (?:robot|joystick) 0(?:91|92|A1)#5082", re.MULTILINE)
PROBLEMS = re.compile(r"assertion|[0-9]+ missing|[1-9][0-9]* doubled|runtime error|Sanitizer", re.IGNORECASE)
# Descriptors that a program may have open at its end.
DESCRIPTORS = {"hirosco": 12, "packet-archive-sqlite": 4, "simulator": 4}
COMPONENT_DESCRIPTORS = 11  # Of a component; four of them are sockets of links.


@dataclass
class Seen:
    """A flight, the faults that were drawn for it, and what its logs contain."""

    flight: object
    lines: list
    end_s: float
    drives: tuple = ()  # Drives from the truth log of the flight.
    is_determined: bool = True  # Every repetition must give the same octets.
    has_cut: bool = False  # The connection between nodes was cut: datagrams are lost.
    ends: str = ""  # Lines `<program> <open descriptors>` that the probe has written at the end of each program.
    memo: dict = field(default_factory=dict)

    def of(self, name, make):
        """The value with this name; `make` computes it at the first call."""
        if name not in self.memo:
            self.memo[name] = make()
        return self.memo[name]

    @property
    def packets(self):
        """(time_ns, direction, octets) of packets.log."""
        return self.of("packets", lambda: self.flight.packets)

    @property
    def numbers(self):
        """Numbers of the records of packets.db, in order."""

        def found():
            with contextlib.closing(sqlite3.connect(f"file:{self.flight.directory}/packets.db?mode=ro", uri=True)) as database:
                return [number for (number,) in database.execute("SELECT number FROM packet ORDER BY number")]

        return self.of("numbers", found)

    @property
    def operator(self):
        """Entries of the operator's log."""
        return self.of("operator", lambda: [json.loads(line) for line in self.flight.read("operator.log").splitlines()])

    def shutdown_ns(self):
        """Time at which the operator commands the shutdown of the mission; members then leave OPERATIONAL on
        command."""
        times = [float(line.split()[0]) for line in self.lines if line.split()[-1] == "shutdown"]
        return round(min(times, default=self.end_s) * NS_PER_S)

    def faults(self):
        """(time_ns, words) of each line of the scenario that is a fault or that stops or starts a process."""
        for line in self.lines:
            words = line.split()
            if words[1] == "fault" or words[2:4] == ["try", "process"]:
                yield round(float(words[0]) * NS_PER_S), words

    def ends_of_lives(self):
        """(time_ns, APID) of each instant at which a process is killed, stopped or suspended."""
        for time_ns, words in self.faults():
            if words[2] in ("kill", "hang"):
                yield time_ns, APIDS[words[3]]
            elif words[3:5] == ["process", "stop"]:
                yield time_ns, APIDS[words[5]]

    def is_alone(self, at_ns):
        """True if a process is killed at an instant and no other fault occurs less than a second before or after."""
        near = [words for time_ns, words in self.faults() if abs(time_ns - at_ns) < NS_PER_S]
        return len(near) == 1 and near[0][2] == "kill"

    def transitions(self):
        """(time of the transition, APID, state before, state after) of every TM[129,2]; the time is by the
        member's clock."""

        def found():
            return [(_stamp(time_ns, raw), _apid(raw), raw[21], raw[22]) for time_ns, direction, raw in self.packets if direction == "TM" and raw[7:9] == b"\x81\x02"]

        return self.of("transitions", found)

    def reported_state(self, apid, at_ns):
        """(time, state) of a member's last report before a time; (-1, 0) if there is none."""
        found = [(time_ns, state) for time_ns, of, _, state in self.transitions() if of == apid and time_ns < at_ns]
        return found[-1] if found else (-1, 0)

    def state_at(self, apid, at_ns, until_ns):
        """Last state that a member reported before at_ns; 0 if it has reported none, or if its life ends
        between that report and until_ns."""
        last, state = self.reported_state(apid, at_ns)
        return 0 if any(of == apid and last <= time_ns <= until_ns for time_ns, of in self.ends_of_lives()) else state

    def is_secured(self, apid, from_ns, until_ns):
        """True if a member reaches ERROR_OPERATIONAL in time or, during a shutdown, any state other than
        OPERATIONAL."""
        return any(of == apid and from_ns <= time_ns <= until_ns + ROUNDING_NS and
                   (state == ERROR_OPERATIONAL or (state != OPERATIONAL and time_ns >= self.shutdown_ns()))
                   for time_ns, of, _, state in self.transitions())  # fmt: skip


def _apid(raw):
    return int.from_bytes(raw[:2], "big") & 0x7FF


def _stamp(log_ns, raw):
    """Time in the header of a report [ns of the flight]; the report must be in the packet log less than a second
    later."""
    fraction = int.from_bytes(raw[18:21], "big") * NS_PER_S // (1 << 24)
    second = log_ns // NS_PER_S
    while second * NS_PER_S + fraction > log_ns + ROUNDING_NS:
        second -= 1
    return second * NS_PER_S + fraction


def _requests(seen):
    """Requests of the ground: (APID, sequence count) -> times in order."""
    found = {}
    for time_ns, direction, raw in seen.packets:
        if direction == "TC" and int.from_bytes(raw[9:11], "big") < ON_BOARD:
            found.setdefault((_apid(raw), int.from_bytes(raw[2:4], "big") & 0x3FFF), []).append(time_ns)
    return found


def _endings(seen):
    """(APID, sequence count) of requests -> subtypes of ST[01] that ended them."""
    found = {}
    for _, direction, raw in seen.packets:
        if direction == "TM" and raw[7] == SERVICE_1 and raw[8] in TERMINAL and int.from_bytes(raw[11:13], "big") < ON_BOARD:
            found.setdefault((int.from_bytes(raw[21:23], "big") & 0x7FF, int.from_bytes(raw[23:25], "big") & 0x3FFF), []).append(raw[8])
    return found


def every_request_ends_once(seen):
    requests, endings, last_ns = _requests(seen), _endings(seen), int((seen.end_s - CUT_S) * NS_PER_S)
    for key in endings.keys() - requests.keys():
        yield f"request {key} ended by {endings[key]}, but the packet log has no such request"
    for key, times in requests.items():
        found = endings.get(key, [])
        due = sum(time_ns < last_ns for time_ns in times)
        if not due <= len(found) <= len(times):
            yield f"request {key} of {[time_ns / NS_PER_S for time_ns in times]} s ended by {found}"


def _connections(seen):
    """(begin, end) of each interval in which the operator was connected, from its log."""
    begin_ns, found = 0, []
    for entry in seen.operator:
        if entry["verb"] == "link":
            at_ns = round(entry["time"] * NS_PER_S)
            if "is open" in entry["outcome"]:
                begin_ns = at_ns
            elif begin_ns is not None:
                found.append((begin_ns, at_ns))
                begin_ns = None
    return found + ([(begin_ns, round(seen.end_s * NS_PER_S))] if begin_ns is not None else [])


def every_request_arrives(seen):
    """Requests of the operator must be in the packet log soon after they are sent, unless the connection is
    lost by then. Requests that are released on board have the source of the operator, too, but other sequence
    counts."""
    logged, connections = _requests(seen), _connections(seen)
    for entry in seen.operator:
        asked_ns = round(entry["time"] * NS_PER_S)
        # Between two connections a request waits on the ground for the next connection.
        begin_ns, end_ns = next(((begin, end) for begin, end in connections if asked_ns < end), (0, 0))
        sent_ns = max(begin_ns, asked_ns)
        if sent_ns + UPLINK_NS >= end_ns:
            continue
        for key in map(tuple, entry.get("asked", ())):
            # The log has the start of the time step; an entry of the operator's script may send its last request when it ends.
            until_ns = max(sent_ns, round(entry["end"] * NS_PER_S)) + UPLINK_NS
            if not any(asked_ns - STEP_NS <= time_ns <= until_ns for time_ns in logged.get(key, ())):
                yield f"request {key}, sent at {sent_ns / NS_PER_S} s, is not in the packet log"


def _log_is_whole(seen):
    """The packet log must have each record number once, and packets.log must have all records."""
    numbers = seen.numbers
    if numbers != list(range(1, len(numbers) + 1)):
        yield "the numbers of packets.db are not 1, 2, 3 ... without a gap"
    if len(seen.packets) != len(numbers):
        yield f"packets.log has {len(seen.packets)} records of {len(numbers)}"


def _reports_are_whole(seen):
    """The reports of an application process must have consecutive numbers; each new life starts a new
    sequence."""
    counts = {}
    for time_ns, direction, raw in seen.packets:
        if direction == "TM" and not seen.has_cut:
            apid, count = _apid(raw), int.from_bytes(raw[2:4], "big") & 0x3FFF
            if count not in (0, (counts.get(apid, -1) + 1) & 0x3FFF):
                yield f"APID {apid}: report {count} at {time_ns / NS_PER_S} s follows {counts.get(apid)}"
            counts[apid] = count


def _brakes_hold(seen):
    """A joint that is neither in operation nor in a controlled stop must be braked."""
    for entry in seen.drives:
        if entry["bus"] == "robot" and entry["statusword"] & 0x6F not in MOVING and not entry["brake_engaged"]:
            yield f"joint {entry['node']} at {entry['time_us'] / 1e6} s has statusword {entry['statusword']:#06x} and a released brake"


def _is_supervisor_away(seen, at_ns):
    return any(apid == APIDS["SUPERVISOR"] and time_ns <= at_ns + STEP_NS and at_ns <= time_ns + OUTAGE_S * NS_PER_S for time_ns, apid in seen.ends_of_lives())


def _high_event_arrives_in_its_cycle(seen):
    """HIGH events must reach the supervisor; by then, or a cycle later, the member and its partner in
    operation must be in ERROR_OPERATIONAL."""
    for time_ns, direction, raw in seen.packets:
        if direction != "TM" or raw[7:9] != b"\x05\x04":
            continue
        apid, at_ns = _apid(raw), _stamp(time_ns, raw)
        what = f"HIGH event {int.from_bytes(raw[21:23], 'big')} of APID {apid} at {at_ns / NS_PER_S} s"
        if time_ns > at_ns + STEP_NS + ROUNDING_NS and not seen.has_cut and not _is_supervisor_away(seen, at_ns):
            yield f"{what} reported at {time_ns / NS_PER_S} s"
        if apid not in PARTNER or seen.has_cut:
            continue
        before_ns, until_ns = at_ns - ROUNDING_NS, at_ns + REACTION_NS
        if seen.state_at(apid, before_ns, at_ns + STEP_NS) != OPERATIONAL:
            continue
        if not seen.is_secured(apid, before_ns, at_ns + STEP_NS):
            yield f"{what}: the member itself is not in ERROR_OPERATIONAL in its cycle"
        if seen.state_at(PARTNER[apid], before_ns, until_ns) == OPERATIONAL and not seen.is_secured(PARTNER[apid], before_ns, until_ns):
            yield f"{what}: APID {PARTNER[apid]} is not in ERROR_OPERATIONAL two cycles later"


def failure_on_the_bus_is_seen(seen):
    """The drives of a dead member must stop and report this on the bus; two cycles later its partner in
    operation must be in ERROR_OPERATIONAL."""
    for time_ns, apid in seen.ends_of_lives():
        if apid not in PARTNER or seen.has_cut:
            continue
        is_operating = seen.reported_state(apid, time_ns)[1] == seen.state_at(PARTNER[apid], time_ns, time_ns + SILENCE_NS) == OPERATIONAL
        if not is_operating:
            continue
        bus = next(name for name, of in DEVICE_BUS.items() if of == apid)
        emergencies_ns = [int(second) * NS_PER_S + int(rest) * 1000 for second, rest in EMERGENCY.findall(seen.flight.read(f"can-{bus}.log"))]
        first = next((at_ns for at_ns in emergencies_ns if time_ns < at_ns < time_ns + SILENCE_NS), None)
        if first is None and not seen.is_alone(time_ns):
            continue
        if not seen.is_secured(PARTNER[apid], time_ns, first + REACTION_NS if first else time_ns + SILENCE_NS):
            where = f"seen on the bus at {first / NS_PER_S} s" if first else "not seen on the bus"
            yield f"APID {apid} fails at {time_ns / NS_PER_S} s, {where}: APID {PARTNER[apid]} is not in ERROR_OPERATIONAL in time"


def _nothing_is_left(seen):
    """The run must leave no process and no name, and its programs must not end with more open descriptors than usual."""
    yield from (f"left: {entry}" for entry in seen.flight.leftovers())
    for line in seen.ends.splitlines():
        name, number = line.rsplit(" ", 1)
        if not name.startswith("python") and int(number) > DESCRIPTORS.get(name, COMPONENT_DESCRIPTORS):
            yield f"{name} ended with {number} descriptors"


def _ends_as_it_should(seen):
    flight, facts = seen.flight, seen.flight.facts
    if flight.code is None or flight.code < 0:
        yield f"the launcher ended with {flight.code}"
    if facts["simulated_s"] < seen.end_s:
        yield f"the flight ended at {facts['simulated_s']} s: {facts['exit_reason']}"
    if seen.is_determined and not facts["reproducible"]:
        yield "the flight is not reproducible"
    # Lines of the console that begin with "[" come from the operator; the reports in them may contain words of PROBLEMS.
    messages = "\n".join(line for line in flight.console.splitlines() if not line.startswith("[")) + flight.output
    yield from (f"the output contains '{found[0]}'" for found in PROBLEMS.finditer(messages))


RULES = (
    _ends_as_it_should,
    every_request_ends_once,
    every_request_arrives,
    _log_is_whole,
    _reports_are_whole,
    _brakes_hold,
    _high_event_arrives_in_its_cycle,
    failure_on_the_bus_is_seen,
    _nothing_is_left,
)


def violations(seen):
    """Descriptions of the violated invariants."""
    return [what for rule in RULES for what in rule(seen)]
