# SPDX-License-Identifier: Apache-2.0
"""Export a run as an MCAP file for PlotJuggler and Lichtblick: truth, frames of the buses, housekeeping, states and events.

Truth and frames are ROS 2 messages (CDR), whose schemas are in the file, with one named field for each joint, axis or signal. Contents of
packets are JSON. Times are mission time. Frames whose signals the CAN database of the mission does not define are raw octets."""

import json
import pathlib
import re

import numpy as np
from mcap.writer import Writer

from . import frames, logs
from . import run as runs
from . import truth as truth_log
from .dictionary import STATES
from .files import write_whole
from .run_directory import problem_of
from .values import Word, json_of

ROS = {"f": "float64", "u1": "uint8", "b": "bool", "u4": "uint32"}
ENTRIES = {"JOINTS": "joint", "STICK": "axis", "CONTACT": "contact", "SPRING": "spring", "BASE": "base"}  # Names in WORLD.
LEVELS = {"INFORMATIVE": 2, "LOW": 3, "MEDIUM": 4, "HIGH": 5}  # Levels of foxglove.Log: information, warning, error, fatal.
LOG_SCHEMA = {"type": "object", "properties": {
    "timestamp": {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
    "level": {"type": "integer"}, "message": {"type": "string"}, "name": {"type": "string"}}}
HEAD = b"\0\1\0\0"  # First octets of a CDR message in little-endian order.


class ExportError(ValueError):
    """A run that cannot be exported."""


def _name(text):
    """A field name of ROS."""
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")


def _names(texts):
    """Field names, with numbers where some are equal."""
    names = [_name(text) for text in texts]
    return [f"{name}_{names[: at + 1].count(name)}" if names.count(name) > 1 else name for at, name in enumerate(names)]


class _Cdr:
    """Messages that contain only numbers. They are built from columns: (field, array with a row for each message)."""

    def __init__(self):
        self.parts, self.size = [("head", "V4", None)], 0

    def add(self, column):
        """Add a column, aligned to the size of its numbers; bool is an octet."""
        column = np.ascontiguousarray(column, np.uint8 if column.dtype == bool else np.float64)
        gap = -self.size % column.itemsize
        if gap:
            self.parts.append((f"gap{len(self.parts)}", f"V{gap}", None))
        shape = column.shape[1:]
        self.parts.append((f"c{len(self.parts)}", np.dtype((column.dtype, shape)), column))
        self.size += gap + column.itemsize * int(np.prod(shape))

    def messages(self, count):
        """Octets of each message."""
        table = np.zeros(count, np.dtype([(name, kind) for name, kind, _ in self.parts]))
        table["head"] = np.void(HEAD)
        for name, _, column in self.parts:
            if column is not None:
                table[name] = column
        octets, step = table.tobytes(), table.dtype.itemsize
        return [octets[at : at + step] for at in range(0, len(octets), step)]


def _field(name, column):
    """Line of a ROS message definition."""
    kind = ROS["b"] if column.dtype == bool else ROS["f"]
    return f"{kind}{f'[{column.shape[1]}]' if column.ndim > 1 else ''} {name}\n"


class _File:
    """Messages of all channels, written in order of time."""

    def __init__(self):
        self.channels, self.rows = [], []

    def channel(self, topic, encoding, schema, metadata=None):
        """Number of a new channel; schema: name, encoding, text."""
        self.channels.append((topic, encoding, schema, metadata or {}))
        return len(self.channels) - 1

    def ros(self, topic, kind, text, times_ns, messages, metadata=None):
        channel = self.channel(topic, "cdr", (f"hirosco/msg/{kind}", "ros2msg", text), metadata)
        self.rows += [(int(time), channel, octets) for time, octets in zip(times_ns, messages)]

    def json(self, topic, rows, name=None, schema=None):
        """Add a channel of JSON objects from (time, object); the schema is that of the first object."""
        schema = schema or _schema(rows[0][1])
        channel = self.channel(topic, "json", (name or f"hirosco.{_name(topic)}", "jsonschema", json.dumps(schema)))
        self.rows += [(int(time), channel, json_of(entry, default=_plain).encode()) for time, entry in rows]

    def write(self, path, metadata):
        self.rows.sort(key=lambda row: row[:2])
        write_whole(path, lambda stream: self._write(stream, metadata))
        return len(self.rows)

    def _write(self, stream, metadata):
        writer = Writer(stream)
        writer.start(profile="", library="hirosco")
        writer.add_metadata("run", {name: str(value) for name, value in metadata.items()})
        numbers = []
        for topic, encoding, (name, kind, text), about in self.channels:
            schema = writer.register_schema(name, kind, text.encode())
            numbers.append(writer.register_channel(topic, encoding, schema, about))
        for sequence, (time_ns, channel, octets) in enumerate(self.rows):
            writer.add_message(numbers[channel], time_ns, octets, time_ns, sequence)
        writer.finish()


def _plain(value):
    """A number of numpy for JSON."""
    return value.item() if hasattr(value, "item") and value.ndim == 0 else value.tolist()


def _schema(value, items=()):
    """JSON schema of a value. items: the parameters or fields of its members, whose units the schema contains."""
    if isinstance(value, dict):
        known = {item.name: item for item in items}
        members = {name: _schema(member, getattr(known.get(name), "fields", ())) for name, member in value.items()}
        for name in members.keys() & known.keys():
            members[name] |= {"description": known[name].unit} if known[name].unit else {}
        return {"type": "object", "properties": members}
    if isinstance(value, list):
        return {"type": "array", "items": _schema(value[0]) if value else {}}
    return {"type": "boolean" if isinstance(value, bool) else "string" if isinstance(value, str) else "number"}


def _flat(value):
    """Values of a report for viewers that plot numbers: a list with one element becomes the element, and a number with a word is given with the word."""
    if isinstance(value, dict):
        flat = {name: _flat(item) for name, item in value.items()}
        return flat | {f"{name}_WORD": str(one) for name, one in flat.items() if isinstance(one, Word)}
    if isinstance(value, list):
        return _flat(value[0]) if len(value) == 1 else [_flat(item) for item in value]
    return value


# ---- truth ----


def _truth(file, channels):
    """Add a ROS channel for each truth channel with columns, and a JSON channel for each with records."""
    decoded = truth_log.decode(channels)
    names = {name: decoded["WORLD"][0][key] for name, key in ENTRIES.items()} if decoded.get("WORLD") else {}
    names |= {entry["channel"]: entry["name"] for entry in decoded.get("NAMES", [])}
    for channel, table in decoded.items():
        topic = f"/truth/{channel.lower()}"
        if isinstance(table, dict):
            _columns(file, topic, channel, table, names.get(channel))
        elif channel not in ("WORLD", "NAMES"):
            file.json(topic, [(entry["time_us"] * 1000, entry) for entry in table])


def _columns(file, topic, channel, table, entries):
    """Columns of a truth channel; those of named entries become one sub-message for each entry."""
    cdr, kind = _Cdr(), channel.capitalize()
    columns = {name: column for name, column in table.items() if name != "time_us" and column.dtype.kind != "U"}
    if entries:
        one = "".join(_field(name, column[:, 0]) for name, column in columns.items())
        text = "".join(f"hirosco/{kind}Entry {name}\n" for name in _names(entries)) + f"{'=' * 80}\nMSG: hirosco/{kind}Entry\n{one}"
        for number in range(len(entries)):
            for column in columns.values():
                cdr.add(column[:, number])
    else:
        text = "".join(_field(name, column) for name, column in columns.items())
        for column in columns.values():
            cdr.add(column)
    file.ros(topic, kind, text, table["time_us"] * 1000, cdr.messages(len(table["time_us"])))


# ---- buses ----


def _database(path, facts):
    """{identifier: (name, octets, signals)} of the messages with fixed signals in a generated CAN database. Raises DatabaseError."""
    database = frames.Database(path)
    if problem := database.problem_with(facts, "those that flew"):
        raise frames.DatabaseError(f"{problem}; its frames are raw")
    return {identifier: (name, database.octets[identifier], list(database.signals[identifier].values()))
            for identifier, name in database.names.items()
            if database.octets[identifier] <= 8 and database.signals[identifier]
            and not any(signal.is_multiplexor or signal.when for signal in database.signals[identifier].values())}


def _values(words, signal):
    """Physical values of a signal in the little-endian words of its frames."""
    shift = np.uint64(64 - signal.bits)
    values = words << np.uint64(64 - signal.bits - signal.start)  # Shift out the bits above the signal.
    if signal.is_real:
        whole = (values >> shift).astype("<u8" if signal.bits == 64 else "<u4")
        return whole.view("<f8" if signal.bits == 64 else "<f4").astype(float)
    values = values.view(np.int64) >> np.int64(shift) if signal.is_signed else values >> shift
    return values * signal.factor + signal.offset


def _bus(file, name, log, database):
    known = np.zeros(len(log), bool)
    words = np.ascontiguousarray(log.data[:, :8]).view("<u8").ravel()
    for identifier, (message, octets, signals) in sorted(database.items()):
        rows = log.frames(identifier)
        rows = rows[log.length[rows] == octets]
        if not len(rows):
            continue
        known[rows] = True
        cdr, text = _Cdr(), ""
        for signal in signals:
            column = _values(words[rows], signal)
            text += _field(_name(re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", signal.name)), column)
            cdr.add(column)
        file.ros(f"/can/{name}/{message.lower()}", f"Can{message.title().replace('_', '')}", text, log.time_us[rows] * 1000,
                 cdr.messages(len(rows)), {"identifier": f"0x{identifier:03X}"})
    rest = np.flatnonzero(~known)
    if not len(rest):
        return
    raw = [HEAD + int(log.id[row]).to_bytes(4, "little") + bytes([bool(log.is_fd[row]), 0, 0, 0]) + int(log.length[row]).to_bytes(4, "little")
           + bytes(log.data[row, : log.length[row]]) for row in rest]
    file.ros(f"/can/{name}/frames", "CanFrame", "uint32 id\nbool is_fd\nuint8[] data\n", log.time_us[rest] * 1000, raw)


# ---- packets ----


def _packets(file, run):
    """Housekeeping by structure, states, and all events in one log."""
    tables, events, schemas = {}, [], {}
    for time_ns, packet, decoded in run.reports:
        owner = run.dictionary.name_of_apid(packet.apid)
        if "error" in decoded:
            continue
        if decoded["kind"] == "housekeeping":
            topic, flat = f"/{owner.lower()}/housekeeping_{decoded['structure']}", _flat(decoded["values"])
            tables.setdefault(topic, []).append((time_ns, flat))
            schemas.setdefault(topic, _schema(flat, run.dictionary.subsystem(owner).parameters.values()))
        elif decoded["kind"] == "transition":
            entry = {name: decoded[name] for name in ("previous", "state", "phase", "configuration", "cause")}
            tables.setdefault(f"/{owner.lower()}/state", []).append((time_ns, {**entry, "number": STATES.index(decoded["state"])}))
        elif decoded["kind"] == "event":
            worded = "".join(f" {name}={value}" for name, value in _flat(decoded["values"]).items())
            seconds, rest = divmod(time_ns, 1_000_000_000)
            events.append((time_ns, {"timestamp": {"sec": seconds, "nsec": rest}, "level": LEVELS[decoded["severity"]],
                                     "message": decoded["event"] + worded, "name": owner, "file": "", "line": 0}))
    for topic, rows in sorted(tables.items()):
        file.json(topic, rows, schema=schemas.get(topic))
    if events:
        file.json("/events", events, "foxglove.Log", LOG_SCHEMA)


def write(directory):
    """Write run.mcap of a run. Returns (path, count of messages, problems of the run's logs). Raises ExportError, OSError."""
    if problem := problem_of(directory):
        raise ExportError(problem)
    run = runs.load(directory)
    if run.dictionary is None:
        raise ExportError("; ".join(run.problems))
    file = _File()
    try:
        channels = logs.read_lcm(run.directory / "truth.lcm")
        truth_log.check(channels)
        _truth(file, channels)
    except (logs.LogError, ValueError) as error:
        run.problems.append(f"truth.lcm: left out ({error})")
    for name, log in run.buses.items():
        if len(log):
            database = runs.ROOT / "build" / "generated" / f"{run.dictionary.mission}-{name}.dbc"
            try:
                messages = _database(database, run.facts)
            except frames.DatabaseError as problem:
                messages = {}
                run.problems.append(str(problem))
            _bus(file, name, log, messages)
    _packets(file, run)
    path = pathlib.Path(directory) / "run.mcap"
    return path, file.write(path, run.facts), run.problems
