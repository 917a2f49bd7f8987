# SPDX-License-Identifier: Apache-2.0
"""A run's raw logs as arrays over simulated time, aligned by the cycles of the control loop.

Cycle k is the time step [k, k+1) x 500 us in which SYNC k was sent. A frame belongs to the cycle of the last SYNC
on its bus before it: TPDO(k) was sampled at SYNC k; RPDO(k) was sent after SYNC k (computed from samples of
cycle k or before) and is applied at SYNC k+1. Frame and SYNC leave the controller in one burst, RPDOs first.
"""

import functools
import json
import pathlib
from dataclasses import dataclass

import numpy as np
from generator import sheet

from . import logs, packet_log, process_data, run_directory, telemetry
from . import truth as truth_log
from . import world as worlds
from .dictionary import Dictionary, DictionaryError

ROOT = pathlib.Path(__file__).resolve().parents[2]
CYCLE_US = 500  # Cycle of the control loop.
SYNC = 0x080  # Identifier of SYNC.
NO_DEVICE = worlds.Device("", "", "", 0)
JOINT_TORQUE_NM = 0.01  # Units of the words in a Run, to which the units of the devices are converted.
STICK_TORQUE_NM = 1e-4
POSITION_RAD = 1e-6
STATE_MASK = 0x6F  # Bits of the state in a statusword.
OPERATION_ENABLED = 0x27
ENABLE_OPERATION = 0x0F  # Controlword.


def scene(truth):
    """The first contact and the first spring of the world, and the torques of all contacts and springs on the joints."""
    contact, spring, joints = (truth.get(name) for name in ("CONTACT", "SPRING", "JOINTS"))
    known = [table for table in (contact, spring, joints) if table is not None]
    if contact is None and spring is None:
        return None
    times = functools.reduce(np.union1d, [table["time_us"] for table in known])

    def held(table, column):
        return table[column][truth_log.held(table, times)]

    found = {"time_us": times, "external_torque_nm": held(joints, "external_torque_nm") if joints else np.zeros((len(times), 0))}
    found["tip_m"] = held(contact or spring, "place_m")[:, 0]
    for name, table, column in (
        ("contact_point_m", contact, "point_m"),
        ("contact_force_n", contact, "force_n"),
        ("spring_force_n", spring, "force_n"),
    ):
        found[name] = held(table, column)[:, 0] if table else np.zeros((len(times), 3))
    for name, table, column in (("in_contact", contact, "is_touching"), ("spring_hooked", spring, "is_hooked")):
        found[name] = held(table, column)[:, 0] if table else np.zeros(len(times), bool)
    return found


def decode_truth(channels):
    """Decode as truth.decode does. DRIVE and FAULT are present even if the log does not have them. The table CONTACT contains the first contact
    and the first spring of the world, CONTACTS all contacts."""
    decoded = {"DRIVE": [], "FAULT": [], **truth_log.decode(channels)}
    found = scene(decoded)
    if "CONTACT" in decoded:
        decoded["CONTACTS"] = decoded.pop("CONTACT")
    if found is not None:
        decoded["CONTACT"] = found
    return decoded


@dataclass
class Cycles:
    """Words of one PDO over all cycles; `seen` marks the cycles with a frame. The last frame of a cycle counts."""

    seen: np.ndarray
    words: dict

    def __getitem__(self, name):
        return self.words[name]


def _cycles_of(bus, rows, sync_us):
    """Cycle of each frame: that of the last SYNC before it; -1 before the first."""
    order = np.searchsorted(sync_us, bus.time_us[rows], side="right") - 1
    cycles = sync_us // CYCLE_US
    return np.where(order >= 0, cycles[np.maximum(order, 0)] if len(cycles) else -1, -1)


def pdo(bus, identifier, layout, count, octets=8):
    """Cycles of a PDO; layout is a list of (name, offset, dtype)."""
    sync_us = bus.time_us[bus.frames(SYNC)]
    rows = bus.frames(identifier)
    rows = rows[bus.length[rows] == octets]
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

    def __init__(self, directory, dictionary=None, has_buses=True):
        """has_buses False: do not read the frames of the buses, which takes the longest."""
        self.directory = pathlib.Path(directory)
        self.facts, problem = run_directory.facts_of(self.directory)
        self.problems = [problem] if problem else []
        self.buses = self._read_buses(dictionary) if has_buses else {}
        self.packets = self._read(packet_log.read_packets, "packets.log") or []
        if not (self.directory / "packets.log").exists() and (self.directory / "packets.ascii").exists():
            self.problems.append(f"packets.log: absent; build/bin/packet-archive-sqlite merge {self.directory} makes it from the parts of a flight that was killed")
        self._compare_packets()
        channels = self._read(logs.read_lcm, "truth.lcm") or {}
        if "CUT" in channels:
            self.problems.append(f"truth.lcm: cut at {channels['CUT'][0][0] / 1e6:.3f} s, where it reached its maximum size")
        try:
            truth_log.check(channels)
            self.truth = decode_truth(channels)
        except (ValueError, IndexError, OverflowError) as error:
            self.problems.append(f"truth.lcm: not the format of this version, or damaged ({error})")
            self.truth = decode_truth({})
        self.operator = self._operator_log()
        self.world_problem = None
        self.world = self._world()
        devices = self.world.devices if self.world else []
        self.joints = [device for device in devices if device.kind in ("Drive", "Gripper")]
        self.stick = next((device for device in devices if device.kind == "Joystick"), NO_DEVICE)
        self.dictionary = dictionary
        self._align()
        self._interpret()

    def _read(self, reader, name):
        try:
            return reader(self.directory / name)
        except (logs.LogError, OSError) as error:
            self.problems.append(str(error))
            return None if reader is not logs.read_bus else logs.parse_bus(b"")

    def _compare_packets(self):
        """Note a packet log that has fewer packets than an earlier report of the run has counted."""
        count, known = len(self.packets), self.facts.get("packets", 0)
        if count < known:
            last = f", the last at {self.packets[-1][0] / 1e9:.3f} s" if count else ""
            self.problems.append(f"packets.log: {count} of {known} packets are there{last}; the log was cut after the flight")

    def _read_buses(self, dictionary):
        names = {bus["name"] for bus in dictionary.buses} if dictionary else set()
        names |= {path.stem.removeprefix("can-") for path in self.directory.glob("can-*.log")}
        return {name: self._read(logs.read_bus, f"can-{name}.log") for name in sorted(names)}

    def _world(self):
        """The world of the flight; None if its file is gone."""
        name = str(self.facts.get("world") or mission_of(self.directory, self.facts))
        path = pathlib.Path(name) if name.endswith(".xml") else ROOT / "descriptors" / "worlds" / f"{name}.xml"
        beside = path.parent.parent / "devices"
        self.sheets = beside if beside.is_dir() else ROOT / "descriptors" / "devices"
        try:
            return worlds.read(path)
        except worlds.WorldError as problem:
            self.world_problem = str(problem)
            self.problems.append(self.world_problem)
            return None

    def _operator_log(self):
        try:
            lines = (self.directory / "operator.log").read_text(encoding="utf-8", errors="backslashreplace").splitlines()
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
        last = [bus.time_us[-1] for bus in self.buses.values() if len(bus)]
        ends = [table["time_us"][-1] for table in self.truth.values() if isinstance(table, dict) and len(table["time_us"])]
        self.truth_end_us = int(max(ends, default=0))
        last += ends
        self.count = int(max(last, default=0)) // CYCLE_US + 1
        self.joint_tpdo = [self._pdo(joint, JOINT_TORQUE_NM, status=0x6041, position=0x6064, torque=0x6077) for joint in self.joints]
        self.joint_csp = [self._pdo(joint, JOINT_TORQUE_NM, control=0x6040, position=0x607A, offset=0x60B2) for joint in self.joints]
        self.joint_cst = [self._pdo(joint, JOINT_TORQUE_NM, control=0x6040, torque=0x6071) for joint in self.joints]
        self.stick_tpdo = self._pdo(self.stick, STICK_TORQUE_NM, **{"0": 0x6064, "1": 0x6864})
        self.stick_status = self._pdo(self.stick, STICK_TORQUE_NM, **{"0": 0x6041, "1": 0x6841})
        self.stick_rpdo = self._pdo(self.stick, STICK_TORQUE_NM, **{"0": 0x6071, "1": 0x6871, "control0": 0x6040, "control1": 0x6840})

    def _pdo(self, device, torque_nm, **objects):
        """Words of the PDO that has these objects, by their names: positions in POSITION_RAD, torques in `torque_nm`."""
        found, factors = None, {}
        # Objects of a second axis are 0x800 higher.
        words = {"position": POSITION_RAD, "torque": torque_nm}
        kinds = {name: "position" if index % 0x800 in (0x64, 0x7A) else "torque" if index % 0x800 in (0x71, 0x77, 0xB2) else None
                 for name, index in objects.items()}
        if device.eds:
            try:
                loaded = sheet.load(self.sheets / device.eds)
                found = process_data.layout(loaded, *objects.values(), mapping=process_data.mapping_of(self.dictionary, device.bus, device.node))
                factors = {name: process_data.unit(loaded, kind) / words[kind] for name, kind in kinds.items() if found and kind}
            except sheet.SheetError as problem:
                self.problems.append(str(problem))
        base, octets, places = found or (0, 0, [(0, "u1")] * len(objects))
        bus = self.buses.get(device.bus, logs.parse_bus(b"")) if found else logs.parse_bus(b"")
        cycles = pdo(bus, base + device.node, [(name, *place) for name, place in zip(objects, places)], self.count, octets)
        for name, factor in factors.items():
            if abs(factor - 1.0) > 1e-9:
                cycles.words[name] = np.rint(cycles.words[name] * factor).astype(np.int64)
        return cycles

    def _interpret(self):
        """Set `reports`, those of the packet log: (time_ns, Packet, decoded)."""
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
        """Truth column at the cycles' SYNC instants, NaN after the end of the log."""
        table = self.truth.get(channel)
        if table is None or not len(table["time_us"]):
            return None
        return truth_log.at(table, name, np.arange(self.count) * CYCLE_US, self.truth_end_us)

    def segments(self):
        """Hand verbs in order: list of (verb, first cycle, end cycle)."""
        table = self.truth.get("OPERATOR")
        if table is None or not len(table["verb"]):
            return []
        verbs, cycles = table["verb"], table["time_us"] // CYCLE_US
        starts = np.flatnonzero(np.concatenate(([True], verbs[1:] != verbs[:-1])))
        ends = np.concatenate((starts[1:], [len(verbs)]))
        return [(str(verbs[a]), int(cycles[a]), int(cycles[b - 1]) + 1) for a, b in zip(starts, ends)]


def mission_of(directory, facts):
    """Name of the mission flown, from run.json or, while the run has not ended, from the launcher's file."""
    return str(facts.get("mission") or run_directory.mission_of(directory))


def load(directory, dictionary_path=None, has_buses=True):
    """Run of a directory, with the dictionary if there is one."""
    dictionary, problem = None, None
    facts, _ = run_directory.facts_of(directory)
    path = dictionary_path or ROOT / "build" / "generated" / f"{mission_of(pathlib.Path(directory), facts)}.json"
    try:
        dictionary = Dictionary.load(path)
    except DictionaryError as error:
        problem = str(error)
    run = Run(directory, dictionary, has_buses)
    if problem:
        run.problems.append(problem)
    return run
