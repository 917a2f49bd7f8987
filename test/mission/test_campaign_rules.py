# SPDX-License-Identifier: Apache-2.0
"""The invariants of the campaign see what is broken: of a flight that is made up, and of one that was flown."""

import dataclasses

import pytest

import campaign

JOYSTICK, MANIPULATOR, SUPERVISOR = 17, 16, 1
USER = 2
OPERATIONAL, ERROR_OPERATIONAL = 5, 6
DEATH_S = 4.0
DEATH = f"{DEATH_S:.6f} fault kill JOYSTICK"
ENDED = (1, 7)
PROGRESS = [(1, 1), (1, 3), (1, 5)]


@dataclasses.dataclass
class Story:
    """What violations() asks of a flight."""

    packets: list
    code: int = 1
    facts: dict = dataclasses.field(default_factory=lambda: {"simulated_s": campaign.END_S, "exit_reason": "", "reproducible": True})
    console: str = ""
    output: str = ""
    left: list = dataclasses.field(default_factory=list)
    numbers: list = None

    def read(self, name):
        """packets.ascii, as far as its numbers go."""
        assert name == "packets.ascii"
        return "".join(f"{number} -\n" for number in (self.numbers or range(1, len(self.packets) + 1)))

    def leftovers(self):
        """Whatever the test says."""
        return self.left


def _at(time_s):
    return round(time_s * campaign.NS_PER_S)


def _tc(time_s, apid, count, source=USER):
    raw = (0x1800 | apid).to_bytes(2, "big") + (0xC000 | count).to_bytes(2, "big") + bytes((0, 6, 0x2F, 17, 1)) + source.to_bytes(2, "big")
    return _at(time_s), "TC", raw + bytes(2)


def _tm(time_s, apid, message, data, destination=USER):
    raw = (0x0800 | apid).to_bytes(2, "big") + bytes((0xC0, 0, 0, 0, 0x20, *message, 0, 0)) + destination.to_bytes(2, "big") + bytes(8) + data
    return _at(time_s), "TM", raw + bytes(2)


def _told(time_s, request, message=ENDED, **how):
    return _tm(time_s, int.from_bytes(request[2][:2], "big") & 0x7FF, message, request[2][:4], **how)


def _became(time_s, apid, before, state):
    return _tm(time_s, apid, (129, 2), bytes((before, state, 0)))


def _up():
    return [_became(1.0, apid, 4, OPERATIONAL) for apid in (JOYSTICK, MANIPULATOR)]


def _story(*packets, **how):
    return Story(sorted([*_up(), *packets], key=lambda packet: packet[0]), **how)


PING = _tc(2.0, MANIPULATOR, 7)
REACTED = _became(DEATH_S + 0.004, MANIPULATOR, OPERATIONAL, ERROR_OPERATIONAL)


def test_a_flight_as_it_should_be():
    assert campaign.violations(_story(PING, _told(2.1, PING), REACTED), [DEATH]) == []


@pytest.mark.parametrize("ends", [[], [ENDED, ENDED], [ENDED, (1, 8)], [(1, 10), (1, 2)], PROGRESS])
def test_a_request_that_does_not_end_once(ends):
    found = campaign.violations(_story(PING, *(_told(2.1, PING, message) for message in ends)), [])
    assert len(found) == 1
    assert found[0].startswith("request (16, 7) of [2.0] s ended by")


@pytest.mark.parametrize("end", sorted(campaign.TERMINAL))
def test_each_kind_of_end_is_one(end):
    assert campaign.violations(_story(PING, _told(2.1, PING, (1, end))), []) == []


def test_an_end_for_another_is_none():
    """Neither that of another request, nor what goes to a user on board."""
    other = _tc(2.0, MANIPULATOR, 8)
    assert len(campaign.violations(_story(PING, _told(2.1, other)), [])) == 2
    assert len(campaign.violations(_story(PING, _told(2.1, PING, destination=campaign.ON_BOARD | 1)), [])) == 1
    assert campaign.violations(_story(_tc(2.0, MANIPULATOR, 8, source=campaign.ON_BOARD | 1)), []) == []


def test_only_what_is_asked_at_the_very_end_may_be_left():
    last = campaign.END_S - campaign.CUT_S
    assert campaign.violations(_story(_tc(last, MANIPULATOR, 8)), []) == []
    assert len(campaign.violations(_story(_tc(last - 0.001, MANIPULATOR, 8)), [])) == 1
    late = _tc(last, MANIPULATOR, 8)
    assert len(campaign.violations(_story(late, _told(last, late), _told(last, late)), [])) == 1


@pytest.mark.parametrize(
    "reaction",
    [
        [],
        [_became(DEATH_S + 0.0101, MANIPULATOR, OPERATIONAL, ERROR_OPERATIONAL)],
        [_became(DEATH_S + 0.004, JOYSTICK, OPERATIONAL, ERROR_OPERATIONAL)],
        [_became(DEATH_S + 0.004, MANIPULATOR, OPERATIONAL, 4)],
    ],
)
def test_a_partner_that_reacts_late_or_not_at_all(reaction):
    found = campaign.violations(_story(*reaction), [DEATH])
    assert len(found) == 1
    assert "did not reach ERROR_OPERATIONAL" in found[0]


def test_a_partner_is_judged_in_operation_and_by_one_fault():
    assert campaign.violations(Story(_up()[:1]), [DEATH]) == []
    assert campaign.violations(_story(_became(3.0, MANIPULATOR, OPERATIONAL, 4)), [DEATH]) == []
    assert campaign.violations(_story(), [DEATH, f"{DEATH_S + 0.9} fault hang MANIPULATOR"]) == []
    assert len(campaign.violations(_story(), [DEATH, f"{DEATH_S + 1.1} fault hang MANIPULATOR", f"{DEATH_S} operator try ping all"])) == 1


@pytest.mark.parametrize(
    "how",
    [
        {"code": None},
        {"code": -6},
        {"facts": {"simulated_s": campaign.END_S - 0.1, "exit_reason": "", "reproducible": True}},
        {"facts": {"simulated_s": campaign.END_S, "exit_reason": "", "reproducible": False}},
        {"console": "x.c:1: Assertion `y' failed"},
        {"output": "2 missing"},
        {"output": "1 doubled"},
        {"console": "x.c:1:2: runtime error: overflow"},
        {"left": ["/dev/shm/x"]},
        {"numbers": [1, 3]},
        {"numbers": [1, 1]},
        {"numbers": [1]},
        {"numbers": [1, 2, 3]},
    ],
)
def test_what_is_told_beside_the_packets(how):
    assert len(campaign.violations(_story(**how), [])) == 1


@pytest.mark.parametrize("status, brake, is_seen", [(0x0250, 0, 1), (0x0250, 1, 0), (0x0231, 0, 1), (0x0218, 0, 1), (0x0237, 0, 0), (0x0217, 0, 0)])
def test_a_joint_without_its_brake(status, brake, is_seen):
    drive = {"bus": "robot", "node": 17, "time_us": 1, "statusword": status, "brake_engaged": brake}
    assert len(campaign.violations(_story(), [], [drive])) == is_seen
    assert campaign.violations(_story(), [], [drive | {"bus": "joystick"}]) == []


def _seed_with_a_kill():
    """The first seed by which one member is killed in operation."""
    for seed in range(1000):
        lines = campaign.scenario(seed, 1)
        deaths = [line for line in lines if " fault kill " in line and float(line.split()[0]) > 2.0]
        if deaths:
            return seed, lines
    raise AssertionError("no seed kills anybody")


def test_each_end_and_the_reaction_of_a_real_flight_count(folder):
    """One packet fewer, one more, or one later, and a rule is broken."""
    seed, lines = _seed_with_a_kill()
    flight, found = campaign.fly(folder, seed, 1)
    assert found == []
    whole = flight.packets
    ends = [i for i, (_, direction, raw) in enumerate(whole) if direction == "TM" and raw[7] == 1 and raw[8] in campaign.TERMINAL and not raw[11] & 0x80]
    assert len(ends) > 10
    for i in ends:
        time_ns = next(time_ns for time_ns, direction, raw in whole if direction == "TC" and raw[:4] == whole[i][2][21:25])
        is_due = time_ns < _at(campaign.END_S - campaign.CUT_S)
        assert len(campaign.violations(Story(whole[:i] + whole[i + 1 :]), lines)) == is_due, whole[i]
        assert len(campaign.violations(Story(whole[:i] + [whole[i]] + whole[i:]), lines)) == 1, whole[i]

    def is_reaction(packet):
        return packet[1] == "TM" and packet[2][7:9] == b"\x81\x02" and packet[2][22] == ERROR_OPERATIONAL

    assert any(map(is_reaction, whole))
    silent = [packet for packet in whole if not is_reaction(packet)]
    late = [(packet[0] + campaign.REACTION_NS * is_reaction(packet), *packet[1:]) for packet in whole]
    for doctored in (silent, late):
        found = campaign.violations(Story(doctored), lines)
        assert len(found) == 1
        assert "did not reach ERROR_OPERATIONAL" in found[0]
