# SPDX-License-Identifier: Apache-2.0
"""A run's raw logs as arrays over simulated time, aligned by the cycles of the control loop.

Cycle k is the slot [k, k+1) x 500 us in which SYNC k was sent. A frame belongs to the cycle of the last SYNC
on its bus before it: TPDO(k) was sampled at SYNC k; RPDO(k) was sent after SYNC k (computed from samples of
cycle k or before) and is applied at SYNC k+1. Frame and SYNC leave the controller in one burst, RPDOs first.
"""

import json
import pathlib
from dataclasses import dataclass

import numpy as np

from . import logs, telemetry
from .dictionary import Dictionary, DictionaryError

CYCLE_US = 500
SYNC = 0x080
JOINT_NODES = (0x11, 0x12)
STICK_NODE = 0x21
JOINT_TORQUE_NM = 0.01
STICK_TORQUE_NM = 1e-4
POSITION_RAD = 1e-6
COUNT_RAD = 2 * np.pi / 65536  # one count of the joystick's encoder
STATE_MASK = 0x6F
OPERATION_ENABLED = 0x27
ENABLE_OPERATION = 0x0F

_TRUTH = {
    "JOINTS": [
        ("position_rad", ">f8", 2),
        ("velocity_rad_s", ">f8", 2),
        ("motor_position_rad", ">f8", 2),
        ("motor_torque_nm", ">f8", 2),
        ("joint_torque_nm", ">f8", 2),
        ("friction_nm", ">f8", 2),
        ("brake_engaged", "u1", 2),
    ],
    "STICK": [
        ("position_rad", ">f8", 2),
        ("velocity_rad_s", ">f8", 2),
        ("motor_torque_nm", ">f8", 2),
        ("hand_torque_nm", ">f8", 2),
    ],
    "CONTACT": [
        ("tip_m", ">f8", 3),
        ("in_contact", "u1"),
        ("spring_hooked", "u1"),
        ("contact_point_m", ">f8", 3),
        ("contact_force_n", ">f8", 3),
        ("spring_force_n", ">f8", 3),
        ("external_torque_nm", ">f8", 2),
    ],
    "OPERATOR": [
        ("intent_rad", ">f8", 2),
        ("wanted_tip_m", ">f8", 2),
        ("expected_torque_nm", ">f8", 2),
        ("grip", ">f8"),
        ("verb", "string"),
    ],
    "DRIVE": [
        ("bus", "string"),
        ("node", ">i4"),
        ("axis", ">i4"),
        ("statusword", ">i4"),
        ("plugged", "u1"),
        ("brake_engaged", "u1"),
    ],
    "FAULT": [("kind", "string"), ("target", "string"), ("active", "u1")],
}
_HEADER = [("fingerprint", "V8"), ("time_ns", ">i8")]


def _item(field):
    name, kind, *shape = field
    return (name, kind, *((size,) for size in shape))


def _fixed(events, fields):
    """Structured array of messages without text members."""
    return np.frombuffer(b"".join(events), np.dtype(_HEADER + [_item(field) for field in fields]))


def _with_texts(event, fields):
    """Tuple of a message's members, texts as str."""
    members, offset = [], 16
    for name, kind, *shape in fields:
        if kind == "string":
            size = int.from_bytes(event[offset : offset + 4], "big")
            members.append(bytes(event[offset + 4 : offset + 4 + size - 1]).decode("ascii", "replace"))
            offset += 4 + size
        else:
            part = np.dtype([_item((name, kind, *shape))])
            members.append(np.frombuffer(event, part, 1, offset)[name][0])
            offset += part.itemsize
    return members


def _operator(events):
    """The text of OPERATOR is its last member: everything before it has a fixed size; equal endings are decoded once."""
    fields = _TRUTH["OPERATOR"][:-1]
    part = np.dtype(_HEADER + [_item(field) for field in fields])
    heads = np.frombuffer(b"".join(event[: part.itemsize] for event in events), part)
    endings = {}
    verbs = [endings.setdefault(bytes(event[part.itemsize + 4 : -1]), len(endings)) for event in events]
    names = np.array([ending.decode("ascii", "replace") for ending in endings])
    columns = {name: heads[name].astype(float) for name, *_ in fields}
    return {"time_us": heads["time_ns"] // 1000, **columns, "verb": names[verbs] if len(names) else names}


def decode_truth(channels):
    """Dict channel -> dict of arrays (with "time_us"); DRIVE and FAULT are lists of dicts."""
    truth = {}
    for name in ("JOINTS", "STICK", "CONTACT"):
        if name in channels:
            table = _fixed(channels[name][1], _TRUTH[name])
            columns = {
                field: np.ascontiguousarray(table[field]).astype(bool if kind == "u1" else float)
                for field, kind, *_ in _TRUTH[name]
            }
            truth[name] = {"time_us": table["time_ns"] // 1000, **columns}
    if "OPERATOR" in channels:
        truth["OPERATOR"] = _operator(channels["OPERATOR"][1])
    for name in ("DRIVE", "FAULT"):
        names = [field[0] for field in _TRUTH[name]]
        truth[name] = [
            {"time_us": int.from_bytes(event[8:16], "big") // 1000, **dict(zip(names, _with_texts(event, _TRUTH[name])))}
            for event in channels.get(name, ((), ()))[1]
        ]
    return truth


@dataclass
class Cycles:
    """Words of one PDO over all cycles; `seen` marks the cycles with a frame. The last frame of a cycle counts."""

    seen: np.ndarray
    words: dict

    def __getitem__(self, name):
        return self.words[name]


def _cycles_of(bus, rows, sync_us):
    """Cycle of each frame: slot of the last SYNC before it; -1 before the first."""
    order = np.searchsorted(sync_us, bus.time_us[rows], side="right") - 1
    slots = sync_us // CYCLE_US
    return np.where(order >= 0, slots[np.maximum(order, 0)] if len(slots) else -1, -1)


def pdo(bus, identifier, layout, count):
    """Cycles of a PDO; layout is a list of (name, offset, dtype)."""
    sync_us = bus.time_us[bus.frames(SYNC)]
    rows = bus.frames(identifier)
    rows = rows[bus.length[rows] == 8]
    cycle = _cycles_of(bus, rows, sync_us)
    keep = (cycle >= 0) & (cycle < count)
    rows, cycle = rows[keep], cycle[keep]
    seen = np.zeros(count, bool)
    seen[cycle] = True
    words = {}
    for name, offset, dtype in layout:
        words[name] = np.zeros(count, np.int64)
        words[name][cycle] = bus.field(rows, offset, dtype)
    return Cycles(seen, words)


class Run:
    """The logs of a run; a missing log is empty."""

    def __init__(self, folder, dictionary=None):
        self.folder = pathlib.Path(folder)
        self.problems = []
        self.facts = self._json("run.json") or {}
        self.robot = self._read(logs.read_bus, "can-robot.log")
        self.joystick = self._read(logs.read_bus, "can-joystick.log")
        self.packets = self._read(logs.read_packets, "packets.log") or []
        channels = self._read(logs.read_lcm, "truth.lcm") or {}
        try:
            self.truth = decode_truth(channels)
        except ValueError as error:
            self.problems.append(f"truth.lcm: {error}")
            self.truth = decode_truth({})
        self.operator = self._operator_log()
        self.dictionary = dictionary
        self._align()
        self._interpret()

    def _read(self, reader, name):
        try:
            return reader(self.folder / name)
        except (logs.LogError, OSError) as error:
            self.problems.append(str(error))
            return None if reader is not logs.read_bus else logs.parse_bus(b"")

    def _json(self, name):
        try:
            return json.loads((self.folder / name).read_text(encoding="utf-8"))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            self.problems.append(f"{name}: {error}")
            return None

    def _operator_log(self):
        try:
            lines = (self.folder / "operator.log").read_text(encoding="utf-8").splitlines()
        except OSError:
            return []
        entries = []
        for line in lines:
            try:
                entries.append(json.loads(line))
            except ValueError:
                break  # the run ended while this line was written
        return entries

    def _align(self):
        last = [bus.time_us[-1] for bus in (self.robot, self.joystick) if len(bus)]
        last += [table["time_us"][-1] for table in self.truth.values() if isinstance(table, dict) and len(table["time_us"])]
        self.count = int(max(last, default=0)) // CYCLE_US + 1
        status = [("status", 0, "u2"), ("position", 2, "i4"), ("torque", 6, "i2")]
        csp = [("control", 0, "u2"), ("position", 2, "i4"), ("offset", 6, "i2")]
        cst = [("control", 0, "u2"), ("torque", 2, "i2"), ("velocity", 4, "i4")]
        self.joint_tpdo = [pdo(self.robot, 0x180 + node, status, self.count) for node in JOINT_NODES]
        self.joint_csp = [pdo(self.robot, 0x200 + node, csp, self.count) for node in JOINT_NODES]
        self.joint_cst = [pdo(self.robot, 0x300 + node, cst, self.count) for node in JOINT_NODES]
        self.stick_tpdo = pdo(self.joystick, 0x180 + STICK_NODE, [("0", 0, "i4"), ("1", 4, "i4")], self.count)
        self.stick_status = pdo(self.joystick, 0x280 + STICK_NODE, [("0", 0, "u2"), ("1", 2, "u2")], self.count)
        torque = [("0", 0, "i2"), ("1", 2, "i2"), ("control0", 4, "u2"), ("control1", 6, "u2")]
        self.stick_rpdo = pdo(self.joystick, 0x200 + STICK_NODE, torque, self.count)

    def _interpret(self):
        """Reports of the packet log: (time_ns, Packet, decoded)."""
        self.reports = []
        if self.dictionary is None:
            return
        configurations = {}
        for time_ns, direction, packet, _ in self.packets:
            if packet is None or direction != "TM":
                continue
            decoded = telemetry.decode(packet, self.dictionary, configurations)
            if "configuration_id" in decoded:
                configurations[packet.apid] = decoded["configuration_id"]
            self.reports.append((time_ns, packet, decoded))

    def reports_of(self, kind):
        """Decoded reports of one kind as (time_ns, Packet, decoded)."""
        return [report for report in self.reports if report[2]["kind"] == kind and "error" not in report[2]]

    def states(self):
        """Dict subsystem name -> list of (time_s, state name) at each change."""
        found = {}
        for time_ns, packet, decoded in self.reports:
            if decoded["kind"] in ("transition", "status") and "error" not in decoded:
                history = found.setdefault(self.dictionary.name_of_apid(packet.apid), [])
                if not history or history[-1][1] != decoded["state"]:
                    history.append((time_ns / 1e9, decoded["state"]))
        return found

    def at_cycles(self, channel, name):
        """Truth column resampled to the cycles' SYNC instants (nearest step), NaN outside the log."""
        table = self.truth.get(channel)
        if table is None or not len(table["time_us"]):
            return None
        want = np.arange(self.count) * CYCLE_US
        index = np.searchsorted(table["time_us"], want)
        column = table[name].astype(float)
        inside = index < len(column)
        column = column[np.minimum(index, len(column) - 1)]
        column[~inside] = np.nan
        return column

    def segments(self):
        """Hand verbs in order: list of (verb, first cycle, end cycle)."""
        table = self.truth.get("OPERATOR")
        if table is None or not len(table["verb"]):
            return []
        verbs, cycles = table["verb"], table["time_us"] // CYCLE_US
        starts = np.flatnonzero(np.concatenate(([True], verbs[1:] != verbs[:-1])))
        ends = np.concatenate((starts[1:], [len(verbs)]))
        return [(str(verbs[a]), int(cycles[a]), int(cycles[b - 1]) + 1) for a, b in zip(starts, ends)]


def load(folder, dictionary_path=None):
    """Run of a folder, with the dictionary if there is one."""
    dictionary, problem = None, None
    root = pathlib.Path(__file__).resolve().parents[2]
    try:
        facts = json.loads((pathlib.Path(folder) / "run.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        facts = {}
    path = dictionary_path or root / "build" / "generated" / f"{facts.get('mission', 'rokviss')}.json"
    try:
        dictionary = Dictionary.load(path)
    except DictionaryError as error:
        problem = str(error)
    run = Run(folder, dictionary)
    if problem:
        run.problems.append(problem)
    return run
