# SPDX-License-Identifier: Apache-2.0
"""Write a run in one compact form for the page of the station: the contents of the page's store over the time of the flight.

The form is a gzip stream of: length of the head (u32, little-endian), head (JSON), columns. A column of a table contains one number of each
row. Multiplied by "per", the numbers are 32-bit integers. Their differences are stored in zigzag code: first the lowest octets of all rows,
then the next octets. A column without "per" contains 64-bit floating point numbers, little-endian, in the same order of octets. The smallest
32-bit integer stands for "not a number"."""

from . import interrupt

if __name__ == "__main__":
    interrupt.hold()

import gzip
import os
import struct
import sys

import numpy as np

from . import run as runs
from . import telemetry
from . import truth as truth_log
from .dictionary import STATES
from .failures import FINAL_SUBTYPES, name_of
from .files import next_step
from .run_directory import problem_of
from .sentences import told
from .station.about import hello
from .station.geometry import as_lists
from .station.led_to import LedTo, Reports
from .station.lights import lights_of
from .station.own_requests import is_own
from .values import json_of

TRUTH_HZ = 50  # Rows of the truth in a second of the recording.
GROUND_USERS = 0x8000  # Users with a smaller number are on the ground.
FINEST = 1_000_000  # Factor by which numbers that are not whole are multiplied.
WIDEST = 2**31 - 2  # Largest integer in a column.
NONE = -(2**31)



def _per(numbers):
    """Factor by which the numbers of a column are multiplied; None if 32-bit integers cannot represent them well."""
    known = numbers[np.isfinite(numbers)]
    most = float(np.abs(known).max(initial=0.0))
    if len(known) < len(numbers) and not np.isnan(numbers[~np.isfinite(numbers)]).all():
        return None
    if most <= WIDEST and not (known % 1).any():
        return 1
    return FINEST if most * FINEST <= WIDEST else None


def column(numbers):
    """(per, octets) of a column."""
    numbers = np.asarray(numbers, float)
    per = _per(numbers)
    if per is None:
        return None, numbers.astype("<f8").view(np.uint8).reshape(-1, 8).T.tobytes()
    whole = np.where(np.isnan(numbers), NONE, np.rint(np.nan_to_num(numbers) * per)).astype(np.int64)
    step = np.diff(whole, prepend=0).astype(np.int32)  # A difference may wrap; the sum of the reader wraps back.
    coded = (step.astype(np.uint32) << 1) ^ (step >> 31).astype(np.uint32)
    return per, coded.astype("<u4").view(np.uint8).reshape(-1, 4).T.tobytes()


class _Tables:
    """Tables of columns: their description, and their octets in the same order."""

    def __init__(self):
        self.described, self.parts = [], []

    def add(self, about, times, leaves):
        """Add a table that has a row for each of `times`. `leaves`: name -> array with the numbers of each row."""
        per, octets = column(times)
        self.parts.append(octets)
        described = []
        for name, rows in leaves.items():
            columns = [column(numbers) for numbers in np.asarray(rows, float).reshape(len(times), -1).T]
            described.append([name, [part for part, _ in columns]])
            self.parts += [part for _, part in columns]
        self.described.append({**about, "rows": len(times), "per": per, "leaves": described})


class _Commands:
    """Telecommands of users on the ground, with the states of their verification lights over time."""

    def __init__(self, run):
        self.rows, self._open = [], {}
        self._dictionary, self._led_to = run.dictionary, LedTo(run.dictionary)
        self._steps = {}  # (APID, sequence count) of a telecommand -> step of the operator's script
        for step in run.operator:
            for asked in step.get("asked") or []:
                self._steps.setdefault(tuple(asked), []).append(step)

    def send(self, seconds, packet):
        """Take a telecommand of the log. Telecommands of one step of the operator's script become one row."""
        if packet.user >= GROUND_USERS:
            return
        key = (packet.apid, packet.sequence)
        # Sequence counts repeat in a long flight, so the time must fit, too, within 0.1 s.
        step = next((item for item in self._steps.get(key, ()) if item["time"] - 0.1 <= seconds <= item["end"] + 0.1), None)
        row = next((item for item in self.rows[-8:] if step is not None and item["step"] is step), None)
        if row is None:
            text = " ".join([step["verb"], *step["words"]]) if step else _words(packet, self._dictionary)
            own = step is None and is_own(packet, self._dictionary) or None
            row = {"step": step, "time": seconds, "text": text, "requests": [], "lights": [], "words": None, "code": None, "own": own}
            row["reports"] = Reports()
            self.rows.append(row)
        self._led_to.sent(packet, packet.request_id, packet.user, row["reports"])
        request = _Sent()
        row["requests"].append(request)
        self._open[key] = (row, request)
        self._light(row, seconds)

    def take(self, seconds, packet, decoded):
        """Take a report of the log. A verification report changes the lights of its telecommand."""
        self._led_to.take(seconds, packet, decoded)
        if packet.service == 1 and "error" not in decoded:
            self._verify(seconds, packet, decoded)

    def _verify(self, seconds, packet, decoded):
        row, request = self._open.get((decoded["request_apid"], decoded["request_sequence"]), (None, None))
        if row is None:
            return
        request.stages.append(packet.subtype)
        request.is_finished = request.is_finished or packet.subtype in FINAL_SUBTYPES
        if "words" in decoded:
            row["words"], row["code"] = decoded["words"], decoded["code"]
        self._light(row, seconds)

    @staticmethod
    def _light(row, seconds):
        row["lights"].append([round(seconds, 4), "".join(cell[0] for cell in lights_of(row["requests"]))])

    def as_lists(self):
        kept = ("time", "text", "lights", "words", "code", "own")
        return [{key: row[key] for key in kept if row[key] is not None} | row["reports"].message() for row in self.rows]


class _Sent:
    """The verification of a telecommand, with the members that `lights_of` reads."""

    def __init__(self):
        self.stages, self.is_finished = [], False


def _words(packet, dictionary):
    """A telecommand as an operator would type it, or its name in the standard."""
    name = dictionary.name_of_apid(packet.apid)
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    data = packet.data
    if packet.message == (129, 1) and data:
        return f"state {name} {name_of(STATES, data[0])}"
    if packet.message == (129, 3) and len(data) >= 2 and subsystem:
        return f"config {name} {subsystem.configuration_name(int.from_bytes(data[:2], 'big'))}"
    if packet.message == (131, 1) and data:
        return f"mode {next((mode['name'] for mode in dictionary.modes if mode['id'] == data[0]), data[0])}"
    decoded = telemetry.decode(packet, dictionary)
    if "function_id" in decoded:
        return f"cmd {name}.{decoded['function_id']}"
    return f"{packet.title if 'error' in decoded else decoded['kind']}: {name}"


class _Telemetry:
    """The reports of a run, sorted by their content."""

    def __init__(self, run):
        self.dictionary = run.dictionary
        self.states, self.events, self.modes, self.links = [], [], [], []
        self.heard, self.tables = {}, {}
        self._present = {}
        for time_ns, packet, decoded in run.reports:
            taker = getattr(self, f"_{decoded['kind'].replace(' ', '_')}", None)
            if taker and "error" not in decoded:
                taker(round(time_ns / 1e9, 6), packet, decoded)

    def _state(self, seconds, packet, decoded):
        name = self.dictionary.name_of_apid(packet.apid)
        self.heard.setdefault(name, []).append(seconds)
        self._add_state(seconds, name, decoded, decoded.get("cause"))

    _transition = _status = _state

    def _subsystems(self, seconds, _packet, decoded):
        for row in decoded["rows"]:
            self._add_state(seconds, row["subsystem"], row, None)

    def _add_state(self, seconds, name, decoded, cause):
        present = (decoded["state"], decoded["phase"], decoded["configuration"])
        if self._present.get(name) != present:
            self._present[name] = present
            self.states.append([seconds, name, *present, cause])

    def _event(self, seconds, packet, decoded):
        subsystem = self.dictionary.subsystem_of_apid(packet.apid)
        said = told(subsystem.event(decoded["event"]), decoded["values"])
        self.events.append([seconds, subsystem.name, decoded["severity"], decoded["event"], *(said[key] for key in ("text", "device", "values"))])

    def _mode(self, seconds, _packet, decoded):
        self.modes.append([seconds, decoded["mode"]])

    def _link_transition(self, seconds, _packet, decoded):
        self._add_link(seconds, decoded["link"], {"state": decoded["state"]})

    def _links(self, seconds, packet, decoded):
        for row in decoded["rows"]:
            if row["consumer"] == packet.apid:
                self._add_link(seconds, row["link"], {name: row[name] for name in ("state", "received", "lost", "late")})

    def _add_link(self, seconds, number, facts):
        self.links += [[seconds, link.name, facts] for link in self.dictionary.links if link.number == number]

    def _housekeeping(self, seconds, packet, decoded):
        name = self.dictionary.name_of_apid(packet.apid)
        self.heard.setdefault(name, []).append(seconds)
        leaves = {leaf: value for leaf, value in telemetry.leaves(decoded["values"]).items() if all(isinstance(one, (int, float)) for one in value)}
        key = (name, decoded["structure"], tuple((leaf, len(value)) for leaf, value in leaves.items()))
        self.tables.setdefault(key, []).append((seconds, leaves))

    def put(self, tables):
        """Add the tables of housekeeping, and the times at which reports of each subsystem arrived."""
        for (name, structure, leaves), rows in self.tables.items():
            times = [seconds for seconds, _ in rows]
            columns = {leaf: np.array([values[leaf] for _, values in rows], float) for leaf, _ in leaves}
            tables.add({"kind": "housekeeping", "subsystem": name, "structure": structure}, times, columns)
        for name, times in self.heard.items():
            tables.add({"kind": "heard", "subsystem": name}, times, {})


ENTRIES = {"joint": "joints", "base": "bases", "contact": "contacts", "spring": "springs"}  # Name in the channel WORLD -> name in the head.


def _truth_names(run):
    """Names of the entries of the truth: of joints, bases, contacts, springs, wheels and valves, in the order of its columns."""
    world = (run.truth.get("WORLD") or [{}])[0]
    names = {ours: world.get(theirs, []) for theirs, ours in ENTRIES.items()}
    named = {entry["channel"]: entry["name"] for entry in run.truth.get("NAMES", [])}
    return {**names, "wheels": named.get("WHEEL", []), "valves": sorted({entry["name"] for entry in run.truth.get("VALVE", [])})}


def _valves(run, names, wanted_us):
    """Whether each valve is open at these instants; all are closed before their first change."""
    found = np.zeros((len(wanted_us), len(names)))
    for column, name in enumerate(names):
        changes = [entry for entry in run.truth["VALVE"] if entry["name"] == name]
        index = np.searchsorted([entry["time_us"] for entry in changes], wanted_us, side="right")
        found[:, column] = np.array([False, *(entry["is_open"] for entry in changes)])[index]
    return found


# Leaf of the recording, and the channel and field of the truth log that it repeats.
TRUTH_LEAVES = (("POSITION", "JOINTS", "position_rad"), ("VELOCITY", "JOINTS", "velocity_rad_s"), ("TORQUE", "JOINTS", "joint_torque_nm"),
                ("EXTERNAL_TORQUE", "JOINTS", "external_torque_nm"), ("BRAKE", "JOINTS", "brake_engaged"), ("HOOKED", "SPRING", "is_hooked"),
                ("STICK", "STICK", "position_rad"), ("FELT", "STICK", "motor_torque_nm"), ("WHEEL", "WHEEL", "momentum_nms"))


def _truth(run, tables):
    """Add the truth of bodies, joysticks, wheels and valves, TRUTH_HZ times a second. Returns the names of the entries."""
    known = {name: table for name, table in run.truth.items() if isinstance(table, dict) and len(table["time_us"])}
    starts = [known[name]["time_us"][0] for name in ("JOINTS", "BASE", "STICK", "WHEEL", "CONTACT") if name in known]
    if not starts:
        return {}
    wanted = np.arange(min(starts), run.truth_end_us + 1, 1_000_000 // TRUTH_HZ)

    def at(channel, name):
        return truth_log.at(known[channel], name, wanted, run.truth_end_us).reshape(len(wanted), -1)

    def entries(channel, *columns):
        """These columns of the truth log, side by side for each entry of the channel."""
        parts = [truth_log.at(known[channel], name, wanted, run.truth_end_us) for name in columns]
        return np.concatenate(parts, axis=2).reshape(len(wanted), -1)

    leaves = {leaf: at(channel, name) for leaf, channel, name in TRUTH_LEAVES if channel in known}
    if "CONTACT" in known:
        leaves["FORCE"] = at("CONTACT", "contact_force_n") + at("CONTACT", "spring_force_n")
    for channel in ("CONTACTS", "SPRING"):
        if channel in known and known[channel]["place_m"].shape[1] > 1:  # FORCE already contains the only contact or spring.
            leaves[channel] = entries(channel, "place_m", "force_n")
    if "BASE" in known:
        leaves["BASE"] = entries("BASE", "position_m", "rotation")
    names = _truth_names(run)
    leaves |= {"VALVE": _valves(run, names["valves"], wanted)} if names["valves"] else {}
    tables.add({"kind": "truth"}, wanted / 1e6, leaves)
    return names


def _phases(run):
    """Phases of the run: [from, to, words]. Each action of the scenario's hand begins a phase, and so does each fault during the action."""
    parts = [[first * runs.CYCLE_US / 1e6, end * runs.CYCLE_US / 1e6, verb] for verb, first, end in run.segments()]
    faults = [(fault["time_us"] / 1e6, f"{fault['kind']} {fault['target']}") for fault in run.truth["FAULT"] if fault["active"]]
    found = []
    for start, end, verb in parts:
        for at, words in [(start, verb), *((at, words) for at, words in faults if start < at < end)]:
            if found and found[-1][0] >= start:
                found[-1][1] = at
            found.append([at, end, words])
    return found


def head_of(run, about=None, tables=None):
    """Head of the recording of a run: all but the columns of its tables, which go to `tables`."""
    head = {"hello": None, "about": about, "end": run.count * runs.CYCLE_US / 1e6, "phases": _phases(run)}
    if run.dictionary is not None:
        reports, commands = _Telemetry(run), _Commands(run)
        decoded_of = {id(packet): decoded for _, packet, decoded in run.reports}
        for time_ns, direction, packet, _ in run.packets:
            if packet is not None and direction == "TC":
                commands.send(time_ns / 1e9, packet)
            elif packet is not None:
                commands.take(time_ns / 1e9, packet, decoded_of[id(packet)])
        if tables:
            reports.put(tables)
        last = max((time_ns for time_ns, *_ in run.packets), default=0) / 1e9
        world = as_lists(run.world) if run.world else None
        head.update(hello=hello(run.dictionary, str(run.directory), world, run.world_problem), end=max(head["end"], last),
                    states=reports.states, events=reports.events, modes=reports.modes, links=reports.links, commands=commands.as_lists())
    return head


def make(run, about=None):
    """Octets of the recording of a run (hirosco_gse.run.Run); `about` is passed on to the page."""
    tables = _Tables()
    head = head_of(run, about, tables)
    head["truth"] = _truth(run, tables)
    text = json_of({**head, "tables": tables.described}, default=float, separators=(",", ":")).encode()
    return gzip.compress(b"".join([struct.pack("<I", len(text)), text, *tables.parts]), 6, mtime=0)


def _made_of(directory):
    """Octets of the recording of a run directory."""
    if problem := problem_of(directory):
        raise SystemExit(f"recording: {problem}")
    run = runs.load(directory, has_buses=False)
    return make(run, {"facts": run.facts, "problems": run.problems})


def main(argv=None):
    """Write the recording of a run directory to the standard output."""
    words = sys.argv[1:] if argv is None else argv
    if len(words) != 1:
        print("usage: python3 -m hirosco_gse.recording RUN_DIR", file=sys.stderr)
        raise SystemExit(2)
    directory = words[0]
    try:
        interrupt.release()
        octets = _made_of(directory)
    except KeyboardInterrupt as end:
        raise SystemExit("recording: ended by Ctrl-C") from end
    except OSError as problem:
        raise SystemExit(f"recording: {problem.filename or directory}: {problem.strerror}{next_step(problem)}") from problem
    try:
        sys.stdout.buffer.write(octets)
        sys.stdout.flush()
    except OSError as problem:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # Otherwise Python would try to write the rest again at exit.
        raise SystemExit(f"recording: cannot write the output: {problem.strerror}") from problem


if __name__ == "__main__":
    main()
