# SPDX-License-Identifier: Apache-2.0
"""Change one place of the flight sources at a time and check whether a test detects it (`make mutants`).

Places are drawn by a seed over the functions of base/, pus/, fsw/, osal/ and launcher/, except those of LEFT_OUT: a comparison, a
bound, a sign, a logical operator, a condition, a returned value, or a statement that is left out. Each mutant is built in a copy
under build/mutants, and up to NEAREST test programs that link the changed file run, until one fails: first those named like it,
then those that call its functions, then those in the nearest directories. They run in namespaces of their own (processes, /tmp,
/dev/shm), since a mutant may kill or remove what it does not own. If all pass, and with --fly, the tests in FLIGHTS run with the
programs of the copy. A mutant that does not build, or that gives the same object code, is replaced by another one. Other sources
that no C test links have no mutants; they are listed at the end.

Prints the survivors and the score of each directory. equivalent.txt holds mutants that no test can distinguish from the original, each with
its reason; they do not count. --check: exit code 1 below 95 % in all or 90 % in a directory with ten mutants or more.

universalmutator (PyPI) is no alternative: its rules do not handle assertions, clang-format and which tests link a file."""

import argparse
import collections
import concurrent.futures
import hashlib
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
TREE = ROOT / "build" / "mutants"
EQUIVALENT = ROOT / "test" / "mutants" / "equivalent.txt"
DIRECTORIES = ("base", "pus", "fsw", "osal", "launcher")
# Not mutated and not listed: programs, the command line tool and the bindings of services to the supervisor. Only
# flights test them.
LEFT_OUT = re.compile(r"_main\.c$|_program\.c$|^pus/tool/|^fsw/supervisor/services/")
COPIED = ("Makefile", "base", "descriptors", "fsw", "gse", "launcher", "mk", "osal", "pus", "sim", "test")
BUILT = ("flags", "obj", "lib", "bin", "generated", "setup")
# Flights that take seconds: packet services, states and control, faults, restarts.
FLIGHTS = ("test/mission/test_mission_causes.py", "test/mission/test_mission_unplug.py", "test/mission/test_mission_packets.py",
           "test/mission/test_mission_can_faults.py", "test/mission/test_mission_plans.py", "test/mission/test_mission_restarts.py",
           "test/mission/test_mission_telepresence.py", "test/conformance/pus",
           "--ignore=test/conformance/pus/test_power_cuts.py", "--ignore=test/conformance/pus/test_z_coverage.py",
           "--deselect=test/conformance/pus/test_operations.py::test_every_example_works_as_it_stands")
# Tests of the messages of launcher/. They run for a mutant in launcher/, too.
LAUNCHER_FLIGHTS = ("test/mission/test_mission_launcher.py",)
NEAREST = 40  # Largest number of test programs tried for a mutant.
FEW = 10  # A directory with fewer mutants has no bound.
SECONDS = 60  # Limit for one test program.
FLIGHT_SECONDS = 300  # Limit for one test in flight.
# Time limit: this multiple of the time without a mutant, plus ten seconds; it ends a mutant that runs without
# end.
TIMEOUT_FACTOR = 20
TOTAL_PERCENT, DIRECTORY_PERCENT = 95.0, 90.0
SWAPS = [(" <= ", " < "), (" < ", " <= "), (" >= ", " > "), (" > ", " >= "), (" == ", " != "), (" != ", " == "),
         (" && ", " || "), (" || ", " && "), (" + ", " - "), (" - ", " + "), (" += ", " -= "), (" -= ", " += "),
         (" true;", " false;"), (" false;", " true;"), (" STATUS_OK;", " STATUS_IO;")]
STATEMENT = re.compile(r"^(\s+)((?:\(void\))?[a-z_][\w.>\[\]()*-]*(?:\(.*\)| [-+|&^]?= .*|\+\+|--);)(.*)$")
DECLARATION = re.compile(r"^\s+(?:const |static |struct |unsigned |(?:\w+_t|bool|int|char|double|float|size_t)\b(?!\)))")
BOUND = re.compile(r"(?<![\w.])(\d+)U?L*(?![\w.])")


class Mutant:
    """One change of one line."""

    def __init__(self, path, number, old, new):
        self.path, self.number, self.old, self.new = path, number, old, new
        self.directory = "/".join(path.split("/")[:2 if path.startswith("fsw/") else 1])

    def __str__(self):
        return f"{self.path}:{self.number}: {self.old.strip()}  ->  {self.new.strip() or '(nothing)'}"

    def row(self):
        """The mutant as a row of equivalent.txt."""
        return self.path, self.old.strip(), self.new.strip()


def code_of(line):
    """The line with string and character constants and comments blanked."""
    line = re.sub(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'', lambda found: "_" * len(found[0]), line)
    return re.sub(r"//.*", lambda found: " " * len(found[0]), line)


def mutants_of_line(path, number, line):
    """All changes of a line."""
    code = code_of(line)
    if not code.startswith("    ") or "FSW_ASSERT" in code or "/*" in code:
        return
    for old, new in SWAPS:
        for found in re.finditer(re.escape(old), code):
            yield Mutant(path, number, line, line[: found.start()] + new + line[found.end():])
    for found in BOUND.finditer(code):
        yield Mutant(path, number, line, line[: found.start(1)] + str(int(found[1]) + 1) + line[found.end(1):])
    condition = re.match(r"(\s+(?:\} else )?(?:if|while) )(\(.*\))( \{.*)$", code)
    if condition:
        start, end = condition.span(2)
        yield Mutant(path, number, line, f"{line[:start]}(!{line[start:end]}){line[end:]}")
    statement = STATEMENT.match(code)
    if statement and not DECLARATION.match(code) and not re.match(r"\s+(return|break|continue|goto)\b", code):
        yield Mutant(path, number, line, statement[1] + "{}")


def mutants_of(path):
    """All mutants of a file."""
    lines = (ROOT / path).read_text(encoding="utf-8").splitlines()
    body = False  # Statements count only within a function; outside there are tables.
    for number, line in enumerate(lines, 1):
        body = line == "{" or (body and line != "}")
        if body:
            yield from mutants_of_line(path, number, line)


def drawn(only, seed):
    """All mutants in the order of the draw. A mutant keeps its place when other lines change."""
    sources = [path.relative_to(ROOT).as_posix() for directory in DIRECTORIES for path in (ROOT / directory).rglob("*.c")]
    found = [mutant for path in sorted(sources) if not LEFT_OUT.search(path) and only.split(":")[0] in path
             for mutant in mutants_of(path) if only in f"{path}:{mutant.number}:"]
    same = collections.Counter()

    def place(mutant):
        same[mutant.row()] += 1
        return hashlib.sha256(repr((seed, same[mutant.row()], *mutant.row())).encode()).digest()

    return sorted(found, key=place)


def symbols(paths, kinds="TDBR"):
    """Functions and objects that each program or object file exports; with kind U those that it uses from others. One call for all
    files: a call for each takes minutes on a busy machine."""
    found = {str(path): set() for path in paths}
    output = subprocess.run(["nm", "-gA", *map(str, paths)], capture_output=True, text=True, check=True).stdout if paths else ""
    for line in output.splitlines():
        path, _, rest = line.partition(":")
        kind, name = rest.split()[-2:]
        if kind in kinds:
            found[path].add(name)
    return found


def code(path):
    """The object file without debug information."""
    bare = TREE / "bare.o"
    subprocess.run(["objcopy", "--strip-debug", path, bare], check=True)
    return bare.read_bytes()


class Tests:
    """The test programs that link a source."""

    def __init__(self):
        names = [path.relative_to(ROOT).with_suffix("").as_posix() for directory in ("test/unit", "test/contract")
                 for path in sorted((ROOT / directory).rglob("test_*.c"))]
        names = [name for name in names if (ROOT / "build" / name).exists()]
        built = {name: ROOT / "build" / name for name in names}
        objects = {name: ROOT / "build" / "obj" / f"{name}.o" for name in names}
        sources = [path for directory in DIRECTORIES for path in (ROOT / "build" / "obj" / directory).rglob("*.o")]
        exported = symbols([*built.values(), *sources])
        used = symbols(objects.values(), "U")
        self.symbols = {name: exported[str(path)] for name, path in built.items()}
        self.called = {name: used[str(path)] for name, path in objects.items()}
        self.own = {path: exported[str(path)] for path in sources}

    def of(self, source):
        """Names of at most NEAREST test programs that link a source, in the order in which they are tried."""
        built = ROOT / "build" / "obj" / pathlib.Path(source).with_suffix(".o")
        if not built.exists():  # Built for the emulated board only (osal/freertos/), whose tests `make test` runs.
            return []
        own = self.own[built]
        place, stem = pathlib.Path(source).parent.parts, pathlib.Path(source).stem

        def distance(name):
            there = pathlib.Path(name).parent.parts[2:]
            shared = len(os.path.commonprefix([place, there]))
            return stem not in name, not own & self.called[name], len(place) + len(there) - 2 * shared, name

        return sorted((name for name, has in self.symbols.items() if own and own <= has), key=distance)[:NEAREST]


def make(targets, jobs):
    """Build targets in the copy. Returns true if all exist."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("MAKE", "MFLAGS"))}
    run = subprocess.run(["make", "-s", "-k", f"-j{jobs}", *targets], cwd=TREE, env=environment, capture_output=True)
    return run.returncode == 0


# The tree stays at its path if it is below /tmp.
ENTER = """exec 3<"$0" && mount -t tmpfs none /tmp && mount -t tmpfs none /dev/shm || exit
case "$0" in /tmp/*) mkdir -p "$0" && mount --no-canonicalize --rbind /proc/self/fd/3 "$0" && cd "$1" || exit ;; esac
exec 3<&- && shift && exec "$@" """


def alone(root, directory):
    """Command prefix that runs a program in that directory of a tree, in separate namespaces."""
    enter = ["unshare", "--pid", "--ipc", "--fork", "--kill-child", "--mount", "--mount-proc"]
    if os.getuid() != 0:
        enter[1:1] = ["--user", "--map-root-user"]
    return [*enter, "sh", "-c", ENTER, root, directory]


def passes(command, seconds, processor_seconds=SECONDS, output=subprocess.DEVNULL):
    """True if a command in the copy ends with success in that time. It has a process group of its own: kill(0) in a mutant
    ends its whole group, also outside its namespace."""
    limits = {resource.RLIMIT_CPU: processor_seconds, resource.RLIMIT_FSIZE: 1 << 30, resource.RLIMIT_CORE: 0}

    def limit():
        for which, most in limits.items():
            resource.setrlimit(which, (most, most))

    try:
        run = subprocess.run([*alone(ROOT, TREE), *command], cwd=TREE, stdin=subprocess.DEVNULL, stdout=output,
                             stderr=subprocess.STDOUT, timeout=seconds, preexec_fn=limit, start_new_session=True,
                             check=False)
        return run.returncode == 0
    except subprocess.TimeoutExpired:
        return False


def program_passes(name, seconds):
    """True if a test program passes in that time."""
    return passes([f"build/{name}"], seconds)


def flight_passes(directory):
    """True if the flights with the programs of the copy pass, for a mutant in that directory. Their output is in
    build/flights.txt of the copy."""
    tests = (*LAUNCHER_FLIGHTS, *FLIGHTS) if directory == "launcher" else FLIGHTS
    with open(TREE / "build" / "flights.txt", "wb") as output:
        return passes(["build/venv/bin/python", "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider",
                       f"--timeout={FLIGHT_SECONDS}", "--rootdir=.", *tests], 10 * FLIGHT_SECONDS, 10 * FLIGHT_SECONDS, output)


class Run:
    """The copy, and the results of its tests."""

    def __init__(self, jobs, flies):
        self.jobs, self.flies, self.tests, self.seconds = jobs, flies, Tests(), {}
        shutil.rmtree(TREE, ignore_errors=True)
        (TREE / "build").mkdir(parents=True)
        for name in COPIED:
            subprocess.run(["cp", "-a", ROOT / name, TREE / name], check=True)
        for name in BUILT:
            subprocess.run(["cp", "-a", ROOT / "build" / name, TREE / "build" / name], check=True)
        for name in ("third_party", "venv"):
            (TREE / "build" / name).symlink_to(ROOT / "build" / name)
        if flies and not make(["all"], jobs):
            sys.exit(f"mutants: `make all` fails without a mutant. Run it in {TREE} to see the error")
        if flies and not flight_passes("launcher"):
            sys.exit(f"mutants: flights fail without a mutant, mend them first: {TREE / 'build' / 'flights.txt'}")

    def try_all(self, names):
        """The first program that fails, with `jobs` of them built at a time; None if all pass."""
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            for begin in range(0, len(names), 2 * self.jobs):
                some = [name for name in names[begin:begin + 2 * self.jobs] if self.seconds_of(name)]
                make([f"build/{name}" for name in some], self.jobs)
                for name, good in zip(some, pool.map(program_passes, some, map(self.seconds_of, some))):
                    if not good:
                        return name
        return None

    def seconds_of(self, name):
        """Time limit of a program, from its time without a mutant; None if it fails without a mutant."""
        if name not in self.seconds:
            copy = TREE / "build" / name
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / "build" / name, copy)
            began = time.monotonic()
            is_sound = program_passes(name, SECONDS)
            if not is_sound:
                print(f"  {name} fails without a mutant: it is left out", flush=True)
            self.seconds[name] = min(SECONDS, 10 + TIMEOUT_FACTOR * (time.monotonic() - began)) if is_sound else None
            copy.unlink()
        return self.seconds[name]

    def verdict(self, mutant):
        """The program that detects the mutant; None if none does; False if the mutant does not build or has
        the same code."""
        source, target = TREE / mutant.path, f"build/obj/{mutant.path[:-2]}.o"
        lines = (ROOT / mutant.path).read_text(encoding="utf-8").splitlines(keepends=True)
        lines[mutant.number - 1] = mutant.new + "\n"
        source.write_text("".join(lines), encoding="utf-8")
        try:
            if not make([target], self.jobs) or code(TREE / target) == code(ROOT / target):
                return False
            killer = self.try_all(self.tests.of(mutant.path))
            if killer is None and self.flies and not (make(["all"], self.jobs) and flight_passes(mutant.directory)):
                killer = "a flight"
            return killer
        finally:
            shutil.copy(ROOT / mutant.path, source)
            shutil.copy(ROOT / target, TREE / target)


def read_equivalent():
    """Rows of equivalent.txt."""
    rows = set()
    for number, line in enumerate(EQUIVALENT.read_text(encoding="utf-8").splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        parts = [part.strip() for part in line.split(" | ")]
        if len(parts) != 4 or not all(parts):
            sys.exit(f"mutants: {EQUIVALENT}:{number}: found {line!r}, expected path | line | mutated line | reason")
        rows.add(tuple(parts[:3]))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", metavar="TEXT", help='mutate only lines for which "path:line:" contains this text')
    parser.add_argument("--count", type=int, default=20, help="number of mutants to try (%(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the draw: the same seed draws in the same order (%(default)s)")
    parser.add_argument("--jobs", type=int, default=2, help="number of programs that are built, or run, at the same time (%(default)s)")
    parser.add_argument("--fly", action="store_true", help="try mutants that pass the C tests in flight, too: two minutes for each")
    parser.add_argument("--check", action="store_true", help="exit code 1 if too many mutants survive (see above)")
    arguments = parser.parse_args()
    equivalent = read_equivalent()
    run = Run(arguments.jobs, arguments.fly)
    killed, tried, survivors = collections.Counter(), collections.Counter(), []
    mutants = drawn(arguments.only, arguments.seed)
    flown = sorted(path for path in {mutant.path for mutant in mutants} if not run.tests.of(path))
    for mutant in mutants:
        if sum(tried.values()) == arguments.count:
            break
        if mutant.path in flown:
            continue
        began = time.monotonic()
        verdict = False if mutant.row() in equivalent else run.verdict(mutant)
        if verdict is False:
            continue
        tried[mutant.directory] += 1
        killed[mutant.directory] += verdict is not None
        survivors += [mutant] if verdict is None else []
        print(f"{sum(tried.values()):4} {'survives' if verdict is None else 'killed  '} {mutant}"
              f"{f'  by {verdict}' if verdict else ''}  {time.monotonic() - began:.0f} s", flush=True)
    shutil.rmtree(TREE, ignore_errors=True)
    print("\n".join(["", "survivors:", *map(str, survivors)]) if survivors else "\nno survivor")
    if flown:
        print("not drawn, tried only in flight or on the board: " + " ".join(flown))
    scores = {name: 100.0 * killed[name] / tried[name] for name in sorted(tried)}
    for name, score in scores.items():
        print(f"{name:<14} {killed[name]:4} of {tried[name]:4} killed  {score:5.1f} %")
    total = 100.0 * sum(killed.values()) / max(1, sum(tried.values()))
    print(f"mutants: {sum(killed.values())} of {sum(tried.values())} killed, {total:.1f} %")
    is_low = total < TOTAL_PERCENT or any(score < DIRECTORY_PERCENT for name, score in scores.items() if tried[name] >= FEW)
    return 1 if arguments.check and is_low else 0


if __name__ == "__main__":
    sys.exit(main())
