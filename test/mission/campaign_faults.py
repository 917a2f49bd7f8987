# SPDX-License-Identifier: Apache-2.0
"""Flights of the fault campaign, drawn from seeds: the same seed gives the same flight.

Each kind of fault is a function of (rng, flight) that adds a fault to the flight: lines of the scenario,
writes that the disk refuses, damage to the initial record store, a connection between two nodes that is
cut."""

import errno
import random
from dataclasses import dataclass, field

import flying
from hirosco_gse import packets

MEMBERS = ("JOYSTICK", "MANIPULATOR")
DEVICES = (("robot", "JOINT1"), ("robot", "JOINT2"), ("joystick", "STICK"))
SHORTEST_S, LONGEST_S = 10.0, 60.0
SETTLE_S = 6.0  # From the last fault to the end of the flight: longer than every time-out of a request.
AGAIN_S = 2.5  # The operator brings up the mission again this long after the middle of the flight.
# Longest absence of the supervisor: a hang is detected after 31 ms, and the next life begins after its boot time and three time steps.
OUTAGE_S = 0.083
STORM = "for i = 1, {0} do event(16) end"  # PROCEDURE_WARNING.
DAMAGES = ("flip", "zero", "cut", "empty", "noise")
OPENED = 3  # Number of writes into a record store by which a component opens it.
STORED = ("SUPERVISOR.journal.0", "SUPERVISOR.journal.1", "MANIPULATOR.journal.0", "MANIPULATOR.journal.1", "JOYSTICK.journal.0", "SUPERVISOR.store.0")


@dataclass
class Drawn:
    """A drawn flight: its mission, form and faults."""

    seed: int
    count: int
    form: str = "image"  # image, processes, nodes (processes on two computers)
    end_s: float = SHORTEST_S
    lines: list = field(default_factory=list)
    kinds: list = field(default_factory=list)
    disk: str = ""  # CAMPAIGN_DISK of the probe: the writes that fail.
    # (file of the record store, kind of damage, place as a fraction of the length)
    damages: list = field(default_factory=list)
    cuts: list = field(default_factory=list)  # (from, until [s]) in which the connection between the nodes is cut
    is_split: bool = False  # The members are on different nodes.

    @property
    def is_determined(self):
        """True if every repetition, in every form, must give the same octets."""
        return not self.cuts

    def moment(self, rng):
        """An instant between the bring-up and the end; every grant of the scheduler is possible."""
        return rng.randrange(int(0.3e6), int((self.end_s - SETTLE_S) * 1e6), 500) / 1e6


def _kill(rng, flight):
    flight.lines.append(f"{flight.moment(rng):.6f} fault kill {rng.choice(MEMBERS)}")


def _hang(rng, flight):
    flight.lines.append(f"{flight.moment(rng):.6f} fault hang {rng.choice(MEMBERS)}")


def _short_hang(rng, flight):
    at, name = flight.moment(rng), rng.choice(MEMBERS)
    flight.lines += [f"{at:.6f} fault hang {name}", f"{at + rng.choice((0.0005, 0.004, 0.015, 0.05, 0.6)):.6f} fault resume {name}"]


def _stop(rng, flight):
    at, name = flight.moment(rng), rng.choice(MEMBERS)
    again = at + rng.choice((0.0, 0.001, 0.03, 0.5))
    flight.lines += [f"{at:.6f} operator try process stop {name}", f"{again:.6f} operator try process start {name}"]


def _supervisor(rng, flight):
    at, kind = flight.moment(rng), rng.choice(("kill", "kill", "hang", "short_hang"))
    flight.lines.append(f"{at:.6f} fault {'kill' if kind == 'kill' else 'hang'} SUPERVISOR")
    if kind == "short_hang":
        flight.lines.append(f"{at + rng.choice((0.0005, 0.004, 0.015)):.6f} fault resume SUPERVISOR")


def _communication(rng, flight):
    flight.lines.append(f"{flight.moment(rng):.6f} fault {rng.choice(('kill', 'hang'))} COMMUNICATION")


def _plug(rng, flight):
    at, (bus, node) = flight.moment(rng), rng.choice(DEVICES)
    verb, back = rng.choice((("unplug", "plug"), ("cut", "mend")))
    flight.lines += [f"{at:.6f} fault {verb} {bus} {node}", f"{at + rng.choice((0.001, 0.05, 0.9)):.6f} fault {back} {bus} {node}"]


def _wire(rng, flight):
    at, bus = flight.moment(rng), rng.choice(("robot", "joystick", "robot-b", "joystick-b"))
    kind = rng.choice(("loss", "corruption", "duplication", "stuck"))
    until = at + rng.choice((0.002, 0.05, 0.4))
    if kind == "stuck":
        flight.lines += [f"{at:.6f} fault stuck {bus} on", f"{until:.6f} fault stuck {bus} off"]
    else:
        flight.lines += [f"{at:.6f} fault {kind} {bus} {rng.choice((0.01, 0.2, 0.9))}", f"{until:.6f} fault {kind} {bus} 0"]


def _device(rng, flight):
    at, (bus, node) = flight.moment(rng), rng.choice(DEVICES)
    if rng.random() < 0.5:
        flight.lines.append(f"{at:.6f} fault reset {bus} {node}")
    else:
        flight.lines += [f"{at:.6f} fault error {bus} {node} 0x4310 on", f"{at + 0.3:.6f} fault error {bus} {node} 0x4310 off"]


def _requests(rng, flight):
    at, target = flight.moment(rng), rng.choice((*MEMBERS, "SUPERVISOR", "all"))
    flight.lines += [f"{at:.6f} operator try nowait ping {target}"] * rng.choice((20, 100, 400))


def _events(rng, flight):
    """Load: a member raises events as fast as it accepts requests, or a procedure or monitoring definitions raise
    events."""
    at, name, kind = flight.moment(rng), rng.choice(MEMBERS), rng.choice(("notes", "notes", "procedure", "procedure", "monitor", "high"))
    if kind == "notes":
        flight.lines += [f"{at:.6f} operator try nowait cmd {name}.RAISE EVENT=9"] * rng.choice((50, 300))
    elif kind == "procedure":
        code = STORM.format(rng.choice((100, 3000, 100000))).encode()
        checksum = packets.crc16(code)
        load = f"tc SUPERVISOR 18,1 obcp_id=STORM obcp_code={code.hex()} checksum={checksum}"
        run = "nowait tc SUPERVISOR 18,3 obcp_id=STORM observability_level=0 n=[]"
        flight.lines += [f"{at:.6f} operator try {step}" for step in (load, run)] + [f"{at + 3:.6f} operator try procedure abort STORM"]
    else:
        event, low, high = ("OPERATOR_NOTE", 1, 100) if kind == "monitor" else ("STATE_TIMEOUT", *rng.choice(((1, 600), (0, 600), (600, 1000))))
        limits = [f"monitor limit MANIPULATOR {number} LINK_AGE {low} {high} {event} {event}" for number in range(1, 9)]
        steps = [*limits, *(f"monitor enable MANIPULATOR {number}" for number in range(1, 9)), "monitor start MANIPULATOR"]
        flight.lines += [f"{at:.6f} operator try {step}" for step in steps]


def _disk(rng, flight):
    """Some writes of the packet log or of a record store fail, because the disk is full, read-only or damaged."""
    text = rng.choice(("/packets.ascii", "/packets.ascii", "/storage/SUPERVISOR.", "/storage/MANIPULATOR."))
    first = rng.choice((1, rng.randrange(1, 300), rng.randrange(1, 30)))
    # The launcher refuses a flight whose component cannot open its record store.
    if "storage" in text:
        first = OPENED + rng.randrange(1, 25)
    number = rng.choice((1, 2, 3, 6))
    flight.disk = f"{text}:{first}:{number}:{rng.choice((errno.ENOSPC, errno.EROFS, errno.EIO))}"


def _damage(rng, flight):
    flight.damages.append((rng.choice(STORED), rng.choice(DAMAGES), rng.random()))


def _node_lost(rng, flight):
    """The members, on the second computer, die or are suspended for a while, all at the same time."""
    at = flight.moment(rng)
    flight.form = "nodes"
    if rng.random() < 0.5:
        flight.lines += [f"{at:.6f} fault kill {name}" for name in MEMBERS]
    else:
        until = at + rng.choice((0.004, 0.015, 0.6))
        flight.lines += [f"{at:.6f} fault hang {name}" for name in MEMBERS] + [f"{until:.6f} fault resume {name}" for name in MEMBERS]


def _connection_cut(rng, flight):
    """The connection between the computers is interrupted for a while."""
    at = rng.uniform(1.5, 3.0)
    flight.form = "nodes"
    flight.is_split = rng.random() < 0.5
    flight.end_s = max(flight.end_s, 15.0)
    flight.cuts.append((at, at + rng.uniform(0.5, 3.0)))


KINDS = {
    _kill: 14, _hang: 8, _short_hang: 8, _stop: 8, _supervisor: 12, _communication: 6, _plug: 10, _wire: 10, _device: 6,
    _requests: 6, _events: 10, _disk: 10, _damage: 10, _node_lost: 3, _connection_cut: 1,
}  # fmt: skip


BEGIN = (
    "mode NOMINAL",  # A mission whose records are damaged begins in mode SAFE.
    "tc SUPERVISOR 11,22 'n=[{\"group_id\":1,\"group_status\":\"enabled\"}]'",
    "at 100 ping MANIPULATOR",  # This request creates the sub-schedule.
    "tc SUPERVISOR 11,20 n=[1]",
    "schedule enable",
)


def _routine(rng, until_s):
    """Ordinary requests of an operator that change persistent records."""
    steps = [f"ping {name}" for name in (*MEMBERS, "SUPERVISOR")] * 2
    steps += ["at +0.7 ping MANIPULATOR", "at +1.3 ping JOYSTICK", "hk once MANIPULATOR 4711", "get MANIPULATOR.TORQUE_OFFSET", "status", "link list",
              "networks", "schedule list", "event disable MANIPULATOR OPERATOR_NOTE", "event enable MANIPULATOR OPERATOR_NOTE",
              "action add JOYSTICK OPERATOR_NOTE ping MANIPULATOR", "action delete JOYSTICK OPERATOR_NOTE",
              "monitor limit MANIPULATOR 20 LINK_AGE 0 100000 0 OPERATOR_NOTE", "monitor delete MANIPULATOR 20",
              "monitor limit MANIPULATOR 21 LINK_AGE 0 100000 0 OPERATOR_NOTE", "monitor delete MANIPULATOR 21"]  # fmt: skip
    at = 1.5
    while at < until_s:
        step = rng.choice(steps)
        yield f"{at:.1f} operator try {step}"
        at += 0.5 if until_s < 15 else 1.0


def draw(seed, count, form=None):
    """Draw the flight of a seed with this number of faults."""
    rng = random.Random(f"{seed}/{count}")
    longest = LONGEST_S if rng.random() < 0.1 else 1.5 * SHORTEST_S
    flight = Drawn(seed, count, rng.choice(("image",) * 5 + ("processes",)), round(rng.uniform(SHORTEST_S, longest), 1))
    for _ in range(count):
        kind = rng.choices(list(KINDS), list(KINDS.values()))[0]
        kind(rng, flight)
        flight.kinds.append(kind.__name__[1:])
    lines = ["0.0 hand rest", "2.0 hand circle 0.1 0.5 1 4 1", *(f"0.1 operator try {step}" for step in BEGIN)]
    bring_up = [flying.bring_up(0.2)] + ([flying.bring_up(flight.end_s / 2 + AGAIN_S)] if rng.random() < 0.4 else [])
    lines += [line.replace("operator ", "operator try ", 1) for part in bring_up for line in part if "wait-event" not in line]
    lines += _routine(rng, flight.end_s)
    lines += [*flight.lines, f"{flight.end_s} operator try shutdown"]
    flight.lines = sorted(lines, key=lambda line: float(line.split()[0]))
    if form is not None and flight.form != "nodes":
        flight.form = form
    return flight
