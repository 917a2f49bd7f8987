# SPDX-License-Identifier: Apache-2.0
"""The invariants of the campaign find violations: in a synthetic flight, and in a real one."""

import dataclasses
import pathlib

import pytest

import campaign
import campaign_faults as faults
import campaign_rules as rules
from hirosco_gse import run as runs

JOYSTICK, MANIPULATOR, SUPERVISOR = 17, 16, 1
USER = 2
OPERATIONAL, ERROR_OPERATIONAL = 5, 6
END_S = 10.0
STEP_S = 0.0005
DEATH_S = 4.0
DEATH = f"{DEATH_S:.6f} fault kill JOYSTICK"
# Emergency 0x8250 of the joystick, which has received no RPDO since the death of its subsystem.
EMERGENCY_ON_BUS = "(0000000004.002163) joystick 0A1#5082110000000000\n"
ENDED = (1, 7)
HIGH = (5, 4)
PROGRESS = [(1, 1), (1, 3), (1, 5)]


@dataclasses.dataclass
class SyntheticFlight:
    """The properties of a flight that the rules read in addition to its packets; a test sets them."""

    code: int = 1
    facts: dict = dataclasses.field(default_factory=lambda: {"simulated_s": END_S, "exit_reason": "", "reproducible": True})
    console: str = ""
    output: str = ""
    left: list = dataclasses.field(default_factory=list)
    bus: str = ""

    def read(self, name):
        """The frames of a bus."""
        assert name.startswith("can-")
        return self.bus

    def leftovers(self):
        """Processes and names that the flight has left, as the test sets them."""
        return self.left


def _at(time_s):
    return round(time_s * rules.NS_PER_S)


def _tc(time_s, apid, count, source=USER):
    raw = (0x1800 | apid).to_bytes(2, "big") + (0xC000 | count).to_bytes(2, "big") + bytes((0, 6, 0x2F, 17, 1)) + source.to_bytes(2, "big")
    return _at(time_s), "TC", raw + bytes(2)


def _tm(time_s, apid, message, data, destination=USER, logged_s=None):
    """A report with a time in its header; `logged_s` is the time in the log. Reports are numbered when the
    flight is built."""
    fraction = (_at(time_s) % rules.NS_PER_S) * (1 << 24) // rules.NS_PER_S
    stamp = bytes(5) + fraction.to_bytes(3, "big")
    raw = (0x0800 | apid).to_bytes(2, "big") + bytes((0xC0, 0, 0, 0, 0x20, *message, 0, 0)) + destination.to_bytes(2, "big") + stamp + data
    return _at(time_s if logged_s is None else logged_s), "TM", raw + bytes(2)


def _reported(time_s, request, message=ENDED, **how):
    return _tm(time_s, int.from_bytes(request[2][:2], "big") & 0x7FF, message, request[2][:4], **how)


def _became(time_s, apid, before, state):
    return _tm(time_s, apid, (129, 2), bytes((before, state, 0)))


def _event(time_s, apid, **how):
    return _tm(time_s, apid, HIGH, bytes((0, 9)), **how)


def _numbered(packets):
    counts = {}
    for time_ns, direction, raw in packets:
        if direction == "TM":
            apid = raw[:2]
            counts[apid] = counts.get(apid, -1) + 1
            raw = raw[:2] + (0xC000 | counts[apid]).to_bytes(2, "big") + raw[4:]
        yield time_ns, direction, raw


def _key(raw):
    return [int.from_bytes(raw[:2], "big") & 0x7FF, int.from_bytes(raw[2:4], "big") & 0x3FFF]


def _asked(time_s, *keys):
    """An entry of the operator's log about requests that it has sent."""
    return {"time": time_s, "end": time_s, "verb": "ping", "outcome": "", "asked": list(map(list, keys))}


def _link(time_s, outcome):
    """An entry of the operator's log about a change of the connection."""
    return {"time": time_s, "verb": "link", "outcome": outcome}


def _seen(packets, lines=(), numbers=None, drives=(), ends="", **how):
    """Build a synthetic flight: the properties of the draw go to Seen, all others to SyntheticFlight."""
    drawn = {name: how.pop(name) for name in ("is_determined", "has_cut") if name in how}
    sent = [(time_ns, _key(raw)) for time_ns, direction, raw in packets if direction == "TC" and not raw[9] & 0x80]
    memo = {"packets": packets, "numbers": list(range(1, len(packets) + 1)) if numbers is None else numbers}
    memo["operator"] = how.pop("operator", [_asked(time_ns / rules.NS_PER_S, key) for time_ns, key in sent])
    return rules.Seen(SyntheticFlight(**how), list(lines), END_S, drives, ends=ends, memo=memo, **drawn)


def _violations(packets, lines=(), **how):
    """Violations of a flight in which both members come up and these packets are logged."""
    up = [_became(1.0, apid, 4, OPERATIONAL) for apid in (JOYSTICK, MANIPULATOR)]
    return rules.violations(_seen(list(_numbered(sorted([*up, *packets], key=lambda packet: packet[0]))), lines, **how))


PING = _tc(2.0, MANIPULATOR, 7)
REACTED = _became(DEATH_S + 0.003, MANIPULATOR, OPERATIONAL, ERROR_OPERATIONAL)


def test_a_correct_flight_violates_no_rule():
    assert _violations([PING, _reported(2.1, PING), REACTED], [DEATH], bus=EMERGENCY_ON_BUS) == []


@pytest.mark.parametrize("ends", [[], [ENDED, ENDED], [ENDED, (1, 8)], [(1, 10), (1, 2)], PROGRESS])
def test_a_request_that_does_not_end_exactly_once_is_a_violation(ends):
    found = _violations([PING, *(_reported(2.1, PING, message) for message in ends)])
    assert len(found) == 1
    assert found[0].startswith("request (16, 7) of [2.0] s ended by")


@pytest.mark.parametrize("end", sorted(rules.TERMINAL))
def test_each_final_report_ends_a_request(end):
    assert _violations([PING, _reported(2.1, PING, (1, end))]) == []


def test_the_end_of_another_request_is_ignored():
    """A report about another request does not end a request, and neither does a report to a user on board. A request of a user on board needs
    no report."""
    other = _tc(2.0, MANIPULATOR, 8)
    assert len(_violations([PING, _reported(2.1, other)])) == 2
    assert len(_violations([PING, _reported(2.1, PING, destination=rules.ON_BOARD | 1)])) == 1
    assert _violations([_tc(2.0, MANIPULATOR, 8, source=rules.ON_BOARD | 1)]) == []


def test_only_a_request_at_the_very_end_may_stay_unanswered():
    last = END_S - rules.CUT_S
    assert _violations([_tc(last, MANIPULATOR, 8)]) == []
    assert len(_violations([_tc(last - 0.001, MANIPULATOR, 8)])) == 1
    late = _tc(last, MANIPULATOR, 8)
    assert len(_violations([late, _reported(last, late), _reported(last, late)])) == 1


# ---- Between the operator and the packet log ----

LOST, OPEN = "the link is lost; 1 request has no end of verification", "the link is open again"


@pytest.mark.parametrize(
    "operator, problems",
    [
        ([_asked(2.0, (16, 7))], 0),
        ([_asked(2.0, (16, 7), (17, 3))], 1),  # Sent, but never received on board.
        ([_asked(3.5, (16, 7))], 1),  # Another request was received on board.
        ([_asked(0.9, (16, 7))], 1),
        ([_asked(2.0, (16, 7)), _asked(END_S - 0.9, (17, 3))], 0),
        ([_asked(2.0, (16, 7)), _asked(3.0, (17, 3)), _link(3.9, LOST), _link(4.0, OPEN)], 0),  # Lost with the connection.
        ([_asked(2.0, (16, 7)), _asked(3.0, (17, 3)), _link(4.1, LOST), _link(4.2, OPEN)], 1),
        # The request waited for the next connection.
        ([_asked(2.0, (16, 7)), _link(4.1, LOST), _asked(4.15, (17, 3)), _link(4.2, OPEN)], 1),
        ([_asked(2.0, (16, 7)), _link(4.1, LOST), _asked(4.15, (17, 3)), _link(4.2, OPEN), _link(5.1, LOST)], 0),
        ([_asked(2.0, (16, 7)), _link(4.1, LOST), _asked(4.15, (17, 3))], 0),  # There was no next connection.
    ],
)
def test_a_request_is_followed_from_the_operator_to_the_packet_log(operator, problems):
    assert len(_violations([PING, _reported(2.1, PING)], operator=operator)) == problems


# ---- A member fails ----


@pytest.mark.parametrize(
    "reaction, bus",
    [
        ([], EMERGENCY_ON_BUS),
        ([], ""),
        # More than two cycles after the emergency, which is on the bus 2.163 ms after the death.
        ([_became(DEATH_S + 0.0032, MANIPULATOR, OPERATIONAL, ERROR_OPERATIONAL)], EMERGENCY_ON_BUS),
        # More than SILENCE_NS after the death.
        ([_became(DEATH_S + 0.0101, MANIPULATOR, OPERATIONAL, ERROR_OPERATIONAL)], ""),
        ([_became(DEATH_S + 0.003, JOYSTICK, OPERATIONAL, ERROR_OPERATIONAL)], EMERGENCY_ON_BUS),
        ([_became(DEATH_S + 0.003, MANIPULATOR, OPERATIONAL, 4)], EMERGENCY_ON_BUS),
    ],
)
def test_a_partner_that_reacts_late_or_not_at_all_is_a_violation(reaction, bus):
    found = _violations(reaction, [DEATH], bus=bus)
    assert len(found) == 1
    assert "APID 16 is not in ERROR_OPERATIONAL" in found[0]


def test_the_reaction_time_begins_with_the_emergency_on_the_bus():
    later = [_became(DEATH_S + 0.0032, MANIPULATOR, OPERATIONAL, ERROR_OPERATIONAL)]
    assert _violations(later, [DEATH]) == []
    assert _violations(later, [DEATH], bus=EMERGENCY_ON_BUS.replace("4.002163", "4.002200")) == []
    # The rule ignores other emergency codes.
    assert _violations(later, [DEATH], bus=EMERGENCY_ON_BUS.replace("0A1#50", "0A1#10")) == []
    # An emergency before the failure does not begin the reaction time.
    assert _violations(later, [DEATH], bus=EMERGENCY_ON_BUS.replace("4.002163", "3.999999")) == []


def test_only_a_partner_in_operation_has_to_react():
    assert rules.violations(_seen(list(_numbered([_became(1.0, JOYSTICK, 4, OPERATIONAL)])), [DEATH], bus=EMERGENCY_ON_BUS)) == []
    assert _violations([_became(3.0, MANIPULATOR, OPERATIONAL, 4)], [DEATH], bus=EMERGENCY_ON_BUS) == []
    assert _violations([_became(3.0, JOYSTICK, OPERATIONAL, 4)], [DEATH], bus=EMERGENCY_ON_BUS) == []
    # The partner is also dead.
    assert _violations([], [DEATH, f"{DEATH_S + 0.005} fault hang MANIPULATOR"], bus=EMERGENCY_ON_BUS) == []
    assert _violations([], [DEATH], bus=EMERGENCY_ON_BUS, has_cut=True) == []


def test_in_a_shutdown_a_partner_may_leave_operation_to_another_state():
    left, shutdown = [_became(DEATH_S + 0.001, MANIPULATOR, OPERATIONAL, 4)], "operator try shutdown"
    assert _violations(left, [DEATH, f"{DEATH_S:.6f} {shutdown}"], bus=EMERGENCY_ON_BUS) == []
    assert len(_violations(left, [DEATH, f"{DEATH_S + 0.01:.6f} {shutdown}"], bus=EMERGENCY_ON_BUS)) == 1
    assert len(_violations([], [DEATH, f"{DEATH_S:.6f} {shutdown}"], bus=EMERGENCY_ON_BUS)) == 1


def test_without_an_emergency_the_reaction_time_begins_with_the_death():
    # If another fault occurs within a second, the rule expects a reaction only if there is an emergency.
    assert _violations([], [DEATH, f"{DEATH_S + 0.9} fault cut robot JOINT1"]) == []
    assert len(_violations([], [DEATH, f"{DEATH_S + 1.1} fault cut robot JOINT1", f"{DEATH_S} operator try ping all"])) == 1
    # The process may continue until another component detects the hang.
    assert _violations([], [DEATH.replace("kill", "hang")]) == []
    assert len(_violations([], [DEATH.replace("kill", "hang")], bus=EMERGENCY_ON_BUS)) == 1


# ---- Events of severity HIGH ----

SECURED = [_became(5.0, JOYSTICK, OPERATIONAL, ERROR_OPERATIONAL), _became(5.0 + 2 * STEP_S, MANIPULATOR, OPERATIONAL, ERROR_OPERATIONAL)]


def test_a_high_event_that_both_members_react_to_in_time_is_no_violation():
    assert _violations([_event(5.0, JOYSTICK), *SECURED]) == []
    assert _violations([_event(5.0, JOYSTICK, logged_s=5.0 + STEP_S), *SECURED]) == []
    assert _violations([_event(5.0, SUPERVISOR)]) == []  # The event does not name the subsystem concerned.


@pytest.mark.parametrize(
    "reaction, word",
    [
        ([], "the member itself"),
        (SECURED[:1], "two cycles later"),
        (SECURED[1:], "the member itself"),
        ([SECURED[0], _became(5.0 + 3 * STEP_S, MANIPULATOR, OPERATIONAL, ERROR_OPERATIONAL)], "two cycles later"),
        ([_became(5.0 + 2 * STEP_S, JOYSTICK, OPERATIONAL, ERROR_OPERATIONAL), SECURED[1]], "the member itself"),
    ],
)
def test_a_high_event_without_reaction_in_time_is_a_violation(reaction, word):
    found = _violations([_event(5.0, JOYSTICK), *reaction])
    assert any(word in what for what in found)
    assert _violations([_event(5.0, JOYSTICK), *reaction], has_cut=True) == []


def test_a_high_event_that_is_logged_late_is_a_violation():
    late = [_event(5.0, SUPERVISOR, logged_s=5.0 + 2 * STEP_S)]
    assert len(_violations(late)) == 1
    assert _violations(late, has_cut=True) == []
    # Killed 30 ms before the event, the supervisor could not receive it. If it is killed 90 ms before, the restarted supervisor
    # receives it (OUTAGE_S); if it is killed 10 ms after, it was alive at the event.
    assert _violations(late, ["4.970000 fault kill SUPERVISOR"]) == []
    assert len(_violations(late, ["4.910000 fault kill SUPERVISOR"])) == 1
    assert len(_violations(late, ["5.010000 fault kill SUPERVISOR"])) == 1


def test_a_high_event_outside_of_operation_needs_no_reaction():
    assert _violations([_became(3.0, JOYSTICK, OPERATIONAL, 4), _event(5.0, JOYSTICK)]) == []
    assert _violations([_event(5.0, MANIPULATOR), _became(5.0, MANIPULATOR, OPERATIONAL, ERROR_OPERATIONAL)], ["4.998 fault hang JOYSTICK"]) == []


# ---- Logs, processes, names, descriptors ----


@pytest.mark.parametrize(
    "how",
    [
        {"code": None},
        {"code": -6},
        {"facts": {"simulated_s": END_S - 0.1, "exit_reason": "", "reproducible": True}},
        {"facts": {"simulated_s": END_S, "exit_reason": "", "reproducible": False}},
        {"console": "x.c:1: Assertion `y' failed"},
        {"output": "2 missing, 0 doubled: 3-4"},
        {"output": "0 gone, 1 doubled"},
        {"console": "x.c:1:2: runtime error: overflow"},
        {"left": ["/dev/shm/x"]},
        {"numbers": [1, 3]},
        {"numbers": [1, 1]},
        {"numbers": [1]},
        {"numbers": [1, 2, 3]},
        {"ends": "supervisor 12"},
        {"ends": "hirosco 13"},
        {"ends": "simulator 5"},
    ],
)
def test_violations_outside_the_packets_are_found(how):
    assert len(_violations([], **how)) == 1


@pytest.mark.parametrize(
    "how",
    [
        {"ends": "supervisor 11\nhirosco 12\nsimulator 4\npython3.11 99\n"},
        {"console": "[ 1.0 s] try state X: not carried out: required real-time link missing"},
        {"facts": {"simulated_s": END_S, "exit_reason": "", "reproducible": False}, "is_determined": False},
    ],
)
def test_permitted_observations_are_no_violation(how):
    assert _violations([], **how) == []


def test_a_gap_in_the_numbers_of_reports_is_a_violation():
    """Each application process has a sequence of numbers, which starts again in its next life."""
    up = list(_numbered([_became(1.0 + i, JOYSTICK, 0, 0) for i in range(5)]))
    assert rules.violations(_seen(up)) == []
    for first, after in ((1, 2), (2, 4)):
        assert len(rules.violations(_seen(up[:first] + up[after:]))) == 1
    assert len(rules.violations(_seen([*up[:2], up[1], *up[2:]]))) == 1
    assert rules.violations(_seen([*up[:3], *up])) == []
    assert rules.violations(_seen(up[:1] + up[2:], has_cut=True)) == []


# Statuswords: 0x0250 switch on disabled, 0x0231 ready to switch on, 0x0218 fault; 0x0237 operation enabled, 0x0217 quick stop active.
@pytest.mark.parametrize("status, brake, violations", [(0x0250, 0, 1), (0x0250, 1, 0), (0x0231, 0, 1), (0x0218, 0, 1), (0x0237, 0, 0), (0x0217, 0, 0)])
def test_a_joint_that_is_neither_controlled_nor_braked_is_a_violation(status, brake, violations):
    drive = {"bus": "robot", "node": 17, "time_us": 1, "statusword": status, "brake_engaged": brake}
    assert len(_violations([], drives=[drive])) == violations
    assert _violations([], drives=[drive | {"bus": "joystick"}]) == []


def test_logs_that_differ_between_two_flights_are_named(tmp_path):
    @dataclasses.dataclass
    class Logs:
        directory: pathlib.Path

        def octets(self, name):
            return (self.directory / name).read_bytes()

    one, other = Logs(tmp_path / "1"), Logs(tmp_path / "2")
    for logs in (one, other):
        logs.directory.mkdir()
        for name in campaign.TRACED:
            (logs.directory / name).write_bytes(b"same")
    assert campaign.differences(one, other) == []
    (other.directory / "can-robot-b.log").write_bytes(b"another")
    assert campaign.differences(one, other) == ["can-robot-b.log is not the same in another form"]


# ---- A flight that was flown ----


def _drawn_with_a_kill():
    """The first seed that kills one member while both operate."""
    for seed in range(1000):
        drawn = faults.draw(seed, 1, "image")
        if drawn.kinds == ["kill"] and any(" fault kill " in line and 2.0 < float(line.split()[0]) < 5.0 for line in drawn.lines):
            return drawn
    raise AssertionError("no seed kills a process")


def test_a_removed_end_or_reaction_of_a_real_flight_is_a_violation(directory):
    """A rule is violated if a final report of a real flight is removed or doubled, if a request is removed, or if the reaction of the partner is
    removed. Only a request at the very end may stay without its final report."""
    drawn = _drawn_with_a_kill()
    flight, found = campaign.fly(campaign.Ground(directory / "ground"), directory / "flight", drawn)
    assert found == []
    assert campaign.drives(flight.directory / "truth.lcm") == runs.load(flight.directory).truth["DRIVE"]
    whole = flight.packets

    def broken(packets):
        """Apply the rules of this test; another test checks the numbers of reports."""
        seen = rules.Seen(flight, drawn.lines, drawn.end_s, memo={"packets": packets})
        return [what for rule in (rules.every_request_ends_once, rules.failure_on_the_bus_is_seen) for what in rule(seen)]

    ends = [i for i, (_, direction, raw) in enumerate(whole) if direction == "TM" and raw[7] == 1 and raw[8] in rules.TERMINAL and not raw[11] & 0x80]
    assert len(ends) > 10
    for i in ends:
        time_ns = next(time_ns for time_ns, direction, raw in whole if direction == "TC" and raw[:4] == whole[i][2][21:25])
        is_due = time_ns < _at(drawn.end_s - rules.CUT_S)
        assert len(broken(whole[:i] + whole[i + 1 :])) == is_due, whole[i]
        assert len(broken(whole[:i] + [whole[i]] + whole[i:])) == 1, whole[i]

    def is_of(packet, key):
        return packet[1] == "TC" and _key(packet[2]) == key and not packet[2][9] & 0x80

    sent = [key for entry in rules.Seen(flight, drawn.lines, drawn.end_s).operator if entry["time"] < drawn.end_s - 1 for key in entry["asked"]]
    assert len(sent) > 10
    for key in sent:
        seen = rules.Seen(flight, drawn.lines, drawn.end_s, memo={"packets": [packet for packet in whole if not is_of(packet, key)]})
        assert len(list(rules.every_request_arrives(seen))) == 1, key

    def is_reaction(packet):
        return packet[1] == "TM" and packet[2][7:9] == b"\x81\x02" and packet[2][22] == ERROR_OPERATIONAL

    assert any(map(is_reaction, whole))
    found = broken([packet for packet in whole if not is_reaction(packet)])
    assert len(found) == 1
    assert "is not in ERROR_OPERATIONAL" in found[0]
