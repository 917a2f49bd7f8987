# SPDX-License-Identifier: Apache-2.0
"""Power cuts in flight at any change of the storage. The next flight has everything that was acknowledged,
nothing twice, and in addition at most the complete effect of the one request in progress.

A campaign is drawn from its seed: requests with persistent effects, one after the other, and the number of
changes of the storage after which the power is cut (power_cut.c, which also undoes what a disk would have
lost). Each flight gets the storage of the one before, reports its content, and continues."""

import collections
import random
import shutil
import signal
import subprocess
import types

import flying
import pytest
import station as stations
from hirosco_gse import packets

JOYSTICK, USER = 17, 2
FAR = 1_000_000.0  # Seconds of mission time that no flight of these tests reaches.
# Flights of a campaign; maximum number of changes up to a cut; maximum number of requests of a flight.
LIVES, CHANGES, REQUESTS = 4, 120, 200
SHORT_RUN_SEEDS, LONG_RUN_SEEDS = 3, 60  # Campaigns of a normal run, and of a run with LONG=1.
STORE_SIZES = (65536, 1 << 20)
MOST = {"activity": 200, "definition": 100, "sequence": 20, "store": 6, "procedure": 20, "file": 30, "directory": 10, "group": 5}


def _ping(sequence):
    return packets.build_tc(JOYSTICK, sequence, 17, 1, source=USER).hex()


class Plan:
    """Requests that can be performed in a state, drawn at random. The state is a dictionary of everything
    persistent, by (kind, name or number); the value of a file is 1 if it is locked. Each request is (service,
    subtype, fields, new entries of the state: None for a removed one)."""

    def __init__(self, seed):
        self.rng = random.Random(seed)
        self.number = 0

    def draw(self, state):
        """The next request."""
        kinds = (self._activity, self._group, self._definition, self._sequence, self._store, self._procedure, self._file, self._directory)
        while not (request := self.rng.choice(kinds)(state)):
            pass
        return request

    def _new(self):
        self.number += 1
        return self.number

    def _grows(self, state, kind):
        """True if an entry should be added: the fuller the state, the less likely."""
        return self.rng.random() > len(_keys(state, kind)) / MOST[kind]

    def _some(self, state, kind, most=1, where=lambda value: True):
        keys = [key for key in _keys(state, kind) if where(state[key])]
        return self.rng.sample(keys, min(len(keys), self.rng.randint(1, most)))

    # ---- ST[11] ----

    def _group(self, state):
        if self._grows(state, "group"):
            group = next(n for n in range(1, 99) if ("group", n) not in state)
            entry = {"group_id": group, "group_status": self.rng.choice(("disabled", "enabled"))}
            return 11, 22, {"n": [entry]}, {("group", group): entry["group_status"]}
        used = {value[1] for key, value in state.items() if key[0] == "activity"}
        (key,) = self._some(state, "group")
        if key[1] not in used and self.rng.random() < 0.5:
            return 11, 23, {"n": [key[1]]}, {key: None}
        status = self.rng.choice(("disabled", "enabled"))
        return 11, (24 if status == "enabled" else 25), {"n": [key[1]]}, {key: status}

    def _activity(self, state):
        groups = self._some(state, "group")
        if groups and self._grows(state, "activity"):
            sub_schedule, group = self.rng.randint(1, 4), groups[0][1]
            changes = {("activity", n): (sub_schedule, group, FAR + n, _ping(n)) for n in (self._new() for _ in range(self.rng.randint(1, 3)))}
            entries = [{"group_id": group, "release_time": value[2], "request": value[3]} for value in changes.values()]
            changes[("sub-schedule", sub_schedule)] = state.get(("sub-schedule", sub_schedule), "disabled")
            return 11, 4, {"sub_schedule_id": sub_schedule, "n": entries}, changes
        if not (keys := self._some(state, "activity", 3)):
            return None
        identities = [{"source_id": USER, "apid": JOYSTICK, "sequence_count": key[1]} for key in keys]
        if self.rng.random() < 0.5:
            return 11, 5, {"n": identities}, dict.fromkeys(keys)
        later = {key: (*state[key][:2], state[key][2] + 64.0, state[key][3]) for key in keys}
        return 11, 7, {"time_offset": 64.0, "n": identities}, later

    # ---- ST[19] ----

    def _definition(self, state):
        if self._grows(state, "definition"):
            numbers = [self._new() for _ in range(self.rng.randint(1, 3))]
            entries = [{"apid": JOYSTICK, "event_definition_id": n, "request": _ping(n)} for n in numbers]
            return 19, 1, {"n": entries}, {("definition", n): ("disabled", _ping(n)) for n in numbers}
        status = self.rng.choice(("disabled", "enabled"))
        keys = self._some(state, "definition", 3, lambda value: value[0] == status)
        named = {"n": [{"apid": JOYSTICK, "event_definition_id": key[1]} for key in keys]}
        if not keys:
            return None
        if status == "enabled":
            return 19, 5, named, {key: ("disabled", state[key][1]) for key in keys}
        if self.rng.random() < 0.5:
            return 19, 4, named, {key: ("enabled", state[key][1]) for key in keys}
        return 19, 2, named, dict.fromkeys(keys)

    # ---- ST[21] and ST[18] ----

    def _sequence(self, state):
        if self._grows(state, "sequence"):
            name, entries = f"Q{self._new()}", [(_ping(n), n / 4) for n in range(self.rng.choice((1, 5, 200)))]
            fields = {"request_sequence_id": name, "n": [{"request": request, "delay": delay} for request, delay in entries]}
            return 21, 1, fields, {("sequence", name): entries}
        (key,) = self._some(state, "sequence")
        return 21, 3, {"request_sequence_id": key[1]}, {key: None}

    def _procedure(self, state):
        if self._grows(state, "procedure"):
            name = f"P{self._new()}"
            code = f"step(1) -- {name} ".encode() * self.rng.choice((1, 100))
            fields = {"obcp_id": name, "obcp_code": code.hex(), "checksum": packets.crc16(code)}
            return 18, 1, fields, {("procedure", name): fields["checksum"]}
        (key,) = self._some(state, "procedure")
        return 18, 2, {"obcp_id": key[1]}, {key: None}

    # ---- ST[15] ----

    def _store(self, state):
        if self._grows(state, "store"):
            name = f"S{self._new()}"
            value = (self.rng.choice(STORE_SIZES), self.rng.choice(("circular", "bounded")), self.rng.randint(0, 3), "disabled", ())
            fields = dict(zip(("packet_store_size", "packet_store_type", "virtual_channel"), value))
            return 15, 20, {"n": [{"packet_store_id": name, **fields}]}, {("store", name): value}
        (key,) = self._some(state, "store")
        size, kind, channel, status, selected = state[key]
        name, what = {"packet_store_id": key[1]}, self.rng.randrange(4)
        if what == 0:
            other = "enabled" if status == "disabled" else "disabled"
            return 15, (1 if other == "enabled" else 2), {"n": [name]}, {key: (size, kind, channel, other, selected)}
        if what == 1 and status == "disabled":
            return 15, 21, {"n": [name]}, {key: None}
        if what == 2:
            return 15, 28, {**name, "virtual_channel": channel ^ 1}, {key: (size, kind, channel ^ 1, status, selected)}
        # No subsystem sends reports of these service types: the selection changes, and the store stays empty.
        service = self.rng.choice([number for number in range(200, 256) if number not in selected])
        if len(selected) < 5:
            chosen = [{"apid": JOYSTICK, "n2": [{"service_type": service, "n3": []}]}]
            return 15, 3, {**name, "n1": chosen}, {key: (size, kind, channel, status, tuple(sorted((*selected, service))))}
        return 15, 4, {**name, "n1": []}, {key: (size, kind, channel, status, ())}

    # ---- ST[23] ----

    def _directory(self, state):
        if self._grows(state, "directory"):
            name = f"D{self._new()}"
            return 23, 9, {"repository_path": "/", "directory_name": name}, {("directory", f"/{name}"): True}
        (key,) = self._some(state, "directory")
        inside = [path for path in _keys(state, "file") if path[1].startswith(key[1] + "/")]
        if not inside:
            return 23, 10, {"repository_path": "/", "directory_name": key[1][1:]}, {key: None}
        if any(state[path] for path in inside):
            return None  # A locked file is not moved.
        name = f"D{self._new()}"
        moved = {("file", f"/{name}{path[1][len(key[1]):]}"): state[path] for path in inside}
        fields = {"repository_path": "/", "old_directory_name": key[1][1:], "new_directory_name": name}
        return 23, 11, fields, {key: None, ("directory", f"/{name}"): True, **dict.fromkeys(inside), **moved}

    def _file(self, state):
        if not (directories := _keys(state, "directory")):
            return None
        directory, name = self.rng.choice(directories)[1], f"F{self._new()}"
        if self._grows(state, "file"):
            locked = self.rng.randrange(2)
            fields = {"repository_path": directory, "file_name": name, "maximum_size": 4096, "file_locked_status": locked}
            return 23, 1, fields, {("file", f"{directory}/{name}"): locked}
        (key,) = self._some(state, "file")
        named = dict(zip(("repository_path", "file_name"), key[1].rsplit("/", 1)))
        what = self.rng.choice(("lock", "copy", "away"))
        if what == "lock":
            return 23, (6 if state[key] else 5), named, {key: 1 - state[key]}
        both = {"operation_id": self._new(), **{f"source_{word}": text for word, text in named.items()}}
        both.update({"target_repository_path": directory, "target_file_name": name})
        if what == "copy":
            return 23, 14, both, {("file", f"{directory}/{name}"): 0}
        if state[key]:
            return None  # A locked file is neither deleted nor moved.
        return (23, 2, named, {key: None}) if self.rng.random() < 0.5 else (23, 15, both, {key: None, ("file", f"{directory}/{name}"): 0})


def _keys(state, kind):
    return sorted(key for key in state if key[0] == kind)


def _after(state, changes):
    changed = {**state, **changes}
    return {key: value for key, value in changed.items() if value is not None}


# ---- what a flight has ----


def _lasting(station):
    """The state according to the reports; no entry may occur twice."""
    entries = [*_schedule(station), *_functions(station), *_stores(station), *_files(station, "")]
    doubled = [key for key, count in collections.Counter(key for key, _ in entries).items() if count > 1]
    assert not doubled
    return dict(entries)


def _schedule(station):
    for entry in station.ask("SUPERVISOR", 11, 16)["n"]:
        sequence = int.from_bytes(bytes.fromhex(entry["request"])[2:4], "big") & 0x3FFF
        yield ("activity", sequence), (entry["sub_schedule_id"], entry["group_id"], entry["release_time"], entry["request"])
    for entry in station.ask("SUPERVISOR", 11, 18)["n"]:
        yield ("sub-schedule", entry["sub_schedule_id"]), entry["sub_schedule_status"]
    for entry in station.ask("SUPERVISOR", 11, 26)["n"]:
        yield ("group", entry["group_id"]), entry["group_status"]


def _functions(station):
    for entry in station.ask("SUPERVISOR", 19, 10, n=[])["n"]:
        yield ("definition", entry["event_definition_id"]), (entry["event_action_status"], entry["request"])
    for name in (entry["request_sequence_id"] for entry in station.ask("SUPERVISOR", 21, 6)["n"]):
        content = station.ask("SUPERVISOR", 21, 11, request_sequence_id=name)["n"]
        yield ("sequence", name), [(entry["request"], entry["delay"]) for entry in content]
    for entry in station.ask("SUPERVISOR", 18, 8)["n"]:
        yield ("procedure", entry["obcp_id"]), entry["obcp_checksum"]


def _stores(station):
    status = {entry["packet_store_id"]: entry["packet_store_status"] for entry in station.ask("SUPERVISOR", 15, 18)["n"]}
    for entry in station.ask("SUPERVISOR", 15, 22)["n"]:
        name = entry["packet_store_id"]
        processes = station.ask("SUPERVISOR", 15, 5, packet_store_id=name)["n1"]
        selected = tuple(sorted(service["service_type"] for process in processes for service in process["n2"]))
        yield ("store", name), (entry["packet_store_size"], entry["packet_store_type"], entry["virtual_channel"], status[name], selected)


def _files(station, directory):
    for entry in station.ask("SUPERVISOR", 23, 12, repository_path=directory or "/")["n"]:
        path = f"{directory}/{entry['object_name']}"
        if entry["object_type"] == "directory":
            yield ("directory", path), True
            yield from _files(station, path)
        else:
            about = station.ask("SUPERVISOR", 23, 3, repository_path=directory or "/", file_name=entry["object_name"])
            yield ("file", path), about["file_locked_status"]


def _differences(one, other):
    return {key: (one.get(key), other.get(key)) for key in one.keys() | other.keys() if one.get(key) != other.get(key)}


# ---- campaigns ----


@pytest.fixture(scope="module")
def cutter(tmp_path_factory):
    """power_cut.c as a library that is loaded before the C library."""
    path = tmp_path_factory.mktemp("cut") / "power_cut.so"
    options = "-std=c99 -O1 -Wall -Wextra -Werror -shared -fPIC".split()
    subprocess.run(["gcc", *options, "-o", path, flying.ROOT / "test/conformance/pus/power_cut.c", "-ldl"], check=True)
    return path


def _fly(directory, storage, environment=None):
    """A flight and its station; no station if the power was cut before it could connect."""
    flight = stations.launch(directory, "--storage", storage, environment=environment)
    port = directory / "ground.port"
    flying.wait_until(lambda: flight.process.poll() is not None or (port.exists() and port.read_text()), "a ground port")
    try:
        station = stations.Station(flight, stations.Notes())
        if flight.process.poll() is None:
            return flight, station
        station.close()  # The power was cut meanwhile; another flight may have got the port.
        return flight, None
    except (ConnectionError, AssertionError):
        assert flight.process.poll() is not None or environment is not None, flight.transcript()
        return flight, None


def _compare(found, possible, last_action):
    assert found in possible, "\n".join([f"{last_action}, (found, expected):", *(str(_differences(found, each)) for each in possible)])


def _until_the_cut(ground, plan, possible, last_action):
    """Compare the state, then send requests one by one until the cut. Returns the states that the storage may
    have then."""
    try:
        state = _lasting(ground)
        _compare(state, possible, last_action)
        for _ in range(REQUESTS):
            service, subtype, fields, changes = plan.draw(state)
            possible, last_action = [state, _after(state, changes)], f"after TC[{service},{subtype}] {fields}"
            verification = ground.send("SUPERVISOR", service, subtype, **fields)
            try:
                outcome = ground.settle(verification)
                assert outcome.is_completed, f"{last_action}: {outcome.failure.words(ground.dictionary)}"
            finally:
                if 7 in verification.stages:
                    state = possible[1]
                    possible = [state]
    except stations.LinkClosed:
        pass
    return possible, last_action


def _campaign(cutter, directory, seed, lives):
    plan, storage = Plan(seed), directory / "storage"
    possible, last_action = [{}], "nothing"
    for life in range(lives):
        cut = {"LD_PRELOAD": str(cutter), "POWER_CUT_STORAGE": str(storage), "POWER_CUT_SEED": str(seed * 1000 + life)}
        cut["POWER_CUT_AFTER"] = str(plan.rng.randint(1, CHANGES))
        flight, ground = _fly(directory / str(life), storage, cut)
        try:
            if ground is not None:
                possible, last_action = _until_the_cut(ground, plan, possible, f"seed {seed}, life {life}, {last_action}")
                ground.close()
            flight.process.send_signal(signal.SIGINT)
            flight.wait()
        finally:
            flight.abandon()
    flight, ground = _fly(directory / "last", storage)
    _compare(_lasting(ground), possible, f"seed {seed}, the last life, {last_action}")
    ground.close()
    flight.process.send_signal(signal.SIGINT)
    assert flight.wait().code == 0, flight.transcript()
    flying.assert_clean(flight)


SEEDS = [pytest.param(seed, marks=() if seed < SHORT_RUN_SEEDS else pytest.mark.long) for seed in range(LONG_RUN_SEEDS)]


@pytest.mark.parametrize("seed", SEEDS)
def test_acknowledged_changes_survive_power_cuts(cutter, tmp_path, seed):
    _campaign(cutter, tmp_path, seed, LIVES)
    shutil.rmtree(tmp_path)


def test_a_flight_that_ends_before_its_station_connects_has_no_station(tmp_path):
    ended = types.SimpleNamespace(directory=tmp_path, port=flying.free_port, process=types.SimpleNamespace(poll=lambda: 1))
    with pytest.raises(stations.LinkClosed):
        stations.Station(ended, stations.Notes())
