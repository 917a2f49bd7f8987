# SPDX-License-Identifier: Apache-2.0
"""Fly a mission that is commanded by random telecommands in each time step: `random_flight.py --seed N`.

The telecommands have correct checksums. Most are drawn from a pool, which this program makes from the dictionary of the
mission: the requests that bring subsystems up, and each request of the catalogue with several values. They are sent
as they are, or with changed fields; others are random octets. The program test/fuzz/flight checks invariants in each
cycle; this program compares the counts at the end: each telecommand with a valid header is accepted or refused, once.

A flight depends on its seed only. A violation prints the seed, the reason and the last telecommands, as pusdump reads
them, and is repeated by the same seed."""

import argparse
import contextlib
import json
import os
import pathlib
import random
import shutil
import struct
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "gse"), str(ROOT / "test/support")]

from hirosco_gse import commands, packets  # noqa: E402
from hirosco_gse.dictionary import Dictionary  # noqa: E402
from message_values import Values  # noqa: E402

MISSION = "rokviss"
INNER_SEQUENCE = 16001  # First sequence count of embedded requests, above those of all other requests.
DRAWS = 4  # Number of sets of values for each request of the catalogue.
SUPERVISOR, COMMUNICATION = 1, 2
OFFLINE, RESTS = 0, (3, 4, 5)
CONFIGURATION, LINKS = "TELEPRESENCE", ("HAND_POSITION", "ROBOT_STATE")
SHUTDOWN = (131, 5)
SIZES = {"u8": 1, "u16": 2, "u32": 4}
PROGRAM = ROOT / "build/random-flight/image"
TIMEOUT_S = 6 * 3600
LONGEST_S = 100000  # Limit of simulated time; the flight shuts itself down earlier.


class Drawn(Values):
    """Draws values, most of which exist in the mission."""

    def value(self, entry, field):
        kind = self.catalogue.kinds.get(field["kind"], {"coding": None})
        parameter = self.layouts.get(field.get("of"))
        if field["kind"] in ("value", "auxiliary") and hasattr(parameter, "size"):
            return [self.random.choice((0, 1, 2)) for one in (parameter.fields or (parameter,)) for _ in range(one.count)]
        known = {"u8": (0, 1, 2, 3), "u16": (1, 2, 3, 16, 17, 4711), "u32": (0, 1, 10, 1000)}
        if kind["coding"] == "id" and self.random.random() < 0.8:
            subsystem = self.random.choice([one for one in self.catalogue.dictionary.subsystems.values() if one.parameters])
            parameter = self.random.choice(list(subsystem.parameters.values()))
            self.layouts[field["name"]] = parameter
            return f"0x{parameter.parameter_id:08X}"
        if kind["coding"] == "packet":
            return packets.build_tc(self.random.choice((1, 2, 16, 17)), INNER_SEQUENCE, *self.random.choice(((17, 1), (3, 5), (129, 1), (20, 1)))).hex()
        if kind["coding"] in known and not self.catalogue.words(entry["service"], field["name"]) and self.random.random() < 0.8:
            return self.random.choice(known[kind["coding"]])
        return super().value(entry, field)


def entry_of(apid, service, subtype, data):
    return struct.pack(">HBBH", apid, service, subtype, len(data)) + data


def members(dictionary):
    return [subsystem for subsystem in dictionary.subsystems.values() if subsystem.apid not in (SUPERVISOR, COMMUNICATION)]


def state(subsystem, number):
    return entry_of(subsystem.apid, 129, 1, bytes([number]))


def open_link(dictionary, link):
    """Requests to negotiate and open a link."""
    request = commands.plan(["link", "open", link.name], dictionary).requests[0]
    return [entry_of(SUPERVISOR, 130, 3, request.data), entry_of(SUPERVISOR, 130, 6, struct.pack(">HI", link.number, 0))]


def script(dictionary):
    """Requests that lead all subsystems to operation with links, in their order."""
    subsystems = members(dictionary)
    requests = [state(one, OFFLINE) for one in subsystems]
    requests += [entry_of(SUPERVISOR, 131, 6, struct.pack(">H", one.apid)) for one in subsystems]
    requests += [state(one, RESTS[0]) for one in subsystems]
    requests += [entry_of(one.apid, 129, 3, struct.pack(">H", one.configuration(CONFIGURATION).id)) for one in subsystems]
    requests += sum((open_link(dictionary, link) for link in dictionary.links if link.name in LINKS), [])
    return requests + [state(one, rest) for rest in RESTS[1:] for one in subsystems]


def usual_requests(dictionary):
    """Requests that bring subsystems, links and functions up, and close links."""
    for subsystem in members(dictionary):
        yield from (state(subsystem, rest) for rest in RESTS)
        for configuration in subsystem.configurations.values():
            yield entry_of(subsystem.apid, 129, 3, struct.pack(">H", configuration.id))
        for function in subsystem.functions.values():
            yield entry_of(subsystem.apid, 8, 1, function.name.encode().ljust(8, b"\0") + b"\0")
        yield entry_of(SUPERVISOR, 131, 6, struct.pack(">H", subsystem.apid))
    yield from (entry_of(SUPERVISOR, 131, 1, bytes([mode["id"]])) for mode in dictionary.modes if mode["initial"])
    for link in dictionary.links:
        yield from open_link(dictionary, link)
        yield from (entry_of(apid, 130, 7, struct.pack(">HB", link.number, 0)) for apid in (SUPERVISOR, link.producer, link.consumer))


def private_data(kinds, fields, rng):
    """Data of a request of the mission's own services: small numbers, and any."""
    data = b""
    for field in fields:
        if "fields" in field:
            groups = rng.randrange(4)
            data += bytes([groups]) + b"".join(private_data(kinds, field["fields"], rng) for _ in range(groups))
        else:
            size = SIZES[kinds[field["kind"]]["coding"]]
            data += (rng.choice((0, 1, 2, 3, 16, 17)) if rng.random() < 0.7 else rng.getrandbits(8 * size)).to_bytes(size, "big")
    return data


def drawn_data(catalogue, message, seed):
    """Data of a request of the catalogue. Some drawn values do not fit their parameter: then others are drawn."""
    for attempt in range(10):
        made = (Drawn if attempt < 9 else Values)(catalogue, f"{seed}/{attempt}").group(message, message["fields"])
        try:
            return catalogue.encode("TC", message["service"], message["subtype"], made)
        except ValueError:
            continue
    raise AssertionError(f"no values for TC[{message['service']},{message['subtype']}]")


def all_requests(dictionary, content):
    """Each request of the catalogue and of the mission's own services, for each subsystem that may have it."""
    rng = random.Random(0)
    apids = sorted(subsystem.apid for subsystem in dictionary.subsystems.values())
    for message in dictionary.catalogue.all("TC"):
        kind = message["service"], message["subtype"]
        for seed in range(DRAWS):
            yield entry_of(rng.choice(apids), *kind, drawn_data(dictionary.catalogue, message, seed))
    private = content["catalogue"]["private"]
    for service in private["services"].values():
        for message in service["messages"]:
            kind = message["service"], message["subtype"]
            if message["direction"] == "TC" and kind != SHUTDOWN:
                for _ in range(DRAWS):
                    yield entry_of(rng.choice(apids), *kind, private_data(private["kinds"], message["fields"], rng))


def write_pool(path):
    """Write the pool of a mission. Returns the number of its entries."""
    source = ROOT / f"build/generated/{MISSION}.json"
    dictionary, content = Dictionary.load(source), json.loads(source.read_text())
    ordered = script(dictionary)
    usual = ordered + list(usual_requests(dictionary))
    entries = usual + list(all_requests(dictionary, content))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(struct.pack(">HH", len(ordered), len(usual)) + b"".join(entries))
    return len(entries)


def prepare_programs(program):
    """A directory with the launcher and all programs, in which the image is `program`."""
    directory, built = program.parent, ROOT / "build/bin"
    for path in built.iterdir():
        place = directory / path.name
        if path.name != "image" and place.resolve() != path:
            with contextlib.suppress(FileExistsError):  # Another flight may create it at the same time.
                place.unlink(missing_ok=True)  # A link of a tree that was moved.
                place.symlink_to(path)
    return directory / "hirosco"


def fly(seed, count, out, program=PROGRAM, fault="", keep=False, timeout_s=TIMEOUT_S):
    """Fly. Returns the counts of the flight. Raises AssertionError with the reason and the last telecommands. `fault` plants one of
    test/fuzz/flight/faults.c; `keep` keeps the directory of the flight; a flight that lasts longer than `timeout_s` is
    stopped."""
    pool, result, directory = out / "pool", out / f"{seed}.json", out / f"{seed}"
    shutil.rmtree(directory, ignore_errors=True)
    for path in (result, result.with_suffix(".json.failure")):
        path.unlink(missing_ok=True)
    write_pool(pool)
    environment = dict(os.environ, RANDOM_FLIGHT=f"{seed} {count} {pool} {result}", RANDOM_FLIGHT_FAULT=fault)
    words = [str(prepare_programs(program)), "run", "--mission", MISSION, "--form", "image", "--scenario", "none", "--report", "no", "--duration", str(LONGEST_S),
             "--seed", str(seed), "--out", str(directory)]
    again = f"to repeat it: python3 {pathlib.Path(__file__).relative_to(ROOT)} --seed {seed} --count {count}"
    try:
        done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=timeout_s)
    except subprocess.TimeoutExpired as stuck:
        output = b"".join(text[-2000:] for text in (stuck.stdout, stuck.stderr) if text).decode(errors="replace")
        raise AssertionError(f"seed {seed}: the flight did not end within {timeout_s:g} s of wall-clock time and was stopped; its files are in {directory}\n"
                             f"{output}{again}") from None
    failure = result.with_suffix(".json.failure")
    if failure.exists():
        raise AssertionError(f"{failure.read_text()}{again}")
    assert result.exists(), f"seed {seed}: the flight has no result\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
    counts = json.loads(result.read_text())
    judge(counts)
    if not keep:
        shutil.rmtree(directory)
    return counts


def judge(counts):
    """Check that each followed telecommand was accepted or refused once, and that the flight ended by its own shutdown."""
    seed = counts["seed"]
    assert counts["shut_down"] == 1, f"seed {seed}: the flight ended early: {counts}"
    answered = counts["accepted"] + counts["refused"] + counts["unrouted"]
    assert answered + counts["unanswered"] == counts["followed"], f"seed {seed}: counts differ: {counts}"
    assert counts["unanswered"] == 0, f"seed {seed}: telecommands without an answer: {counts}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1, help="seed of the first flight")
    parser.add_argument("--count", type=int, default=20000, help="number of telecommands of each flight")
    parser.add_argument("--flights", type=int, default=1, help="number of flights, with consecutive seeds")
    parser.add_argument("--program", type=pathlib.Path, default=PROGRAM)
    arguments = parser.parse_args()
    if not arguments.program.exists():
        parser.error(f"{arguments.program} is not there; run: make random-flight")
    total = 0
    for seed in range(arguments.seed, arguments.seed + arguments.flights):
        try:
            counts = fly(seed, arguments.count, arguments.program.parent / "out", arguments.program)
        except AssertionError as violation:
            print(violation)
            return 1
        total += counts["sent"]
        print(f"seed {seed}: {counts}; {total} telecommands in all", flush=True)
    print("check: no telecommand violates an invariant")
    return 0


if __name__ == "__main__":
    sys.exit(main())
