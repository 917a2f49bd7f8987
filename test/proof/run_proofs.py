# SPDX-License-Identifier: Apache-2.0
"""Proofs of the flight software by bounded model checking (CBMC): `make proofs`.

Each test/proof/<directory>/proof_*.c begins with its statement as lines `// Key: text`, continued by indented lines:

    Proves, Bounds, Replaced   texts for the reader; all required
    Sources    files that are compiled with it
    Options    options of CBMC
    Quick      `yes`: part of `make check`
    Fault      a source, then lines `- text` and `+ text`: a fault that the proof must find (at least one)
    Reduced    a header or source, then lines `- text` and `+ text`: what is smaller or simpler in the proof, such as a
               capacity; Bounds or Replaced state it

CBMC checks every access, every overflow of signed numbers, every shift and division, that each loop ends within its
bound, and the statements of the proof, for all values at once. Then it checks copies of the sources with each planted
fault: a proof that does not find its fault proves nothing. Last it searches for each statement a way to reach it with all
its conditions true: a statement that is never reached proves nothing, either. Prints a table; exit code 1 if a proof
fails, if a planted fault is not found, or if a statement is not reached."""

import argparse
import hashlib
import json
import pathlib
import re
import resource
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = ROOT / "test/proof"
OUT = ROOT / "build/proofs"
CBMC = ROOT / "build/third_party/cbmc"
PAGE = "docs/assurance.md"
COMMON = ["test/proof/assertion.c"]
FLAGS = ["--function", "proof", "--bounds-check", "--pointer-check", "--pointer-overflow-check", "--signed-overflow-check",
         "--div-by-zero-check", "--undefined-shift-check", "--unwinding-assertions", "--slice-formula", "-D_POSIX_C_SOURCE=200809L"]
COMPILER = ["gcc", "-D_POSIX_C_SOURCE=200809L"]
INCLUDES = ["-I.", "-Ibuild"]
# Options of the search for values that reach the statements; it makes no other checks.
REACHING = ["--function", "proof", "--no-standard-checks", "--slice-formula", "-DPROOF_REACHED", "-D_POSIX_C_SOURCE=200809L"]
MEMORY = 6_000_000 * 1024
REQUIRED = ("Proves", "Bounds", "Replaced", "Sources", "Options", "Fault")
OPTIONAL = ("Quick", "Reduced")
TIMEOUT_S = 900 # Limit of processor time for one run.
HOLDS, FAILS = 0, 10


class Change:
    """One change of one source: a planted fault, or a reduced capacity."""

    def __init__(self, path, old, new):
        self.path, self.old, self.new = path, old, new

    def copy_to(self, directory):
        place = directory / self.path
        text = (place if place.exists() else ROOT / self.path).read_text()
        if not self.old or text.count(self.old) != 1:
            raise SystemExit(f"{self.path}: the planted fault or reduction replaces a text that is there {text.count(self.old)} times, "
                             f"expected once: {self.old}")
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text.replace(self.old, self.new))


class Proof:
    """Statement of one harness."""

    def __init__(self, path):
        self.path = path.relative_to(ROOT)
        self.name = str(path.relative_to(HERE).with_suffix("")).replace("/proof_", "/")
        entries = self.entries(path.read_text())
        keys = [key for key, _ in entries]
        missing = [key for key in REQUIRED if key not in keys]
        unknown = [key for key in keys if key not in (*REQUIRED, *OPTIONAL)]
        if missing or unknown:
            raise SystemExit(f"{self.path}: the statement lacks {missing}, and has unknown {unknown}; expected {REQUIRED}")
        texts = {key: " ".join(lines) for key, lines in entries}
        self.proves, self.bounds, self.replaced = texts["Proves"], texts["Bounds"], texts["Replaced"]
        self.sources, self.options = texts["Sources"].split(), texts["Options"].split()
        self.is_quick = texts.get("Quick") == "yes"
        self.faults = [self.change(lines) for key, lines in entries if key == "Fault"]
        self.reduced = [self.change(lines) for key, lines in entries if key == "Reduced"]

    @staticmethod
    def entries(text):
        """[(key, lines)] of the comment at the beginning."""
        found = []
        for line in text.splitlines()[1:]:
            head = re.match(r"// ([A-Z][a-z]+): *(.*)", line)
            if head:
                found.append((head[1], [head[2].strip()]))
            elif line.startswith("//") and found:
                found[-1][1].append(line[2:].strip())
            else:
                break
        return found

    def change(self, lines):
        path, *changes = lines
        old = [line[1:].strip() for line in changes if line.startswith("-")]
        new = [line[1:].strip() for line in changes if line.startswith("+")]
        if len(old) != 1 or len(new) > 1:
            raise SystemExit(f"{self.path}: a fault or reduction is a path, one line `- text` and at most one line `+ text`")
        return Change(path, old[0], new[0] if new else "")

    def copies(self, directory, fault=None):
        """A new directory with the changed sources of one run."""
        shutil.rmtree(directory, ignore_errors=True)
        for change in [*self.reduced, *([fault] if fault else [])]:
            change.copy_to(directory)
        return directory

    def command(self, fault_directory=None, flags=FLAGS):
        faulty = [f"-I{fault_directory}"] if fault_directory else []
        def place(path):
            copy = fault_directory / path if fault_directory else None
            return str(copy) if copy and copy.exists() else path
        loader = next((CBMC / "lib").glob("ld-linux*"))
        return [str(loader), "--library-path", str(CBMC / "lib"), str(CBMC / "cbmc"), *flags, *self.options, *faulty, *INCLUDES,
                str(self.path), *COMMON, *(place(path) for path in self.sources)]

    def digest(self):
        """Digest of everything on which the result depends."""
        files = [str(self.path), *COMMON, *self.sources]
        listed = subprocess.run([*COMPILER, "-MM", *INCLUDES, *files], cwd=ROOT, capture_output=True, text=True, check=False)
        if listed.returncode != 0:
            raise SystemExit(f"{self.path}: does not compile:\n{listed.stderr}")
        names = sorted({name for name in re.sub(r"\\\n|\S+\.o:", " ", listed.stdout).split()})
        digest = hashlib.sha256(" ".join(map(str, self.command())).encode())
        for name in [*names, *(change.path for change in (*self.faults, *self.reduced)), "test/proof/run_proofs.py"]:
            digest.update((ROOT / name).read_bytes())
        return digest.hexdigest()

    def stale(self):
        """Reasons for which the proof no longer fits the sources; they are found without running it."""
        directory = OUT / self.name / "fits"
        for fault in self.faults:
            self.copies(directory, fault)
        command = [*COMPILER, "-w", "-fsyntax-only", f"-I{self.copies(directory)}", *INCLUDES, str(self.path)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        return [f"{self.path}: does not compile any more:\n{done.stderr}"] if done.returncode != 0 else []


class Result:
    """Output of one run of CBMC."""

    def __init__(self, code, text, seconds):
        self.code, self.text, self.seconds = code, text, seconds
        self.failed = re.findall(r"^\[\S+\] (?:line \d+ )?(.*): FAILURE$", text, re.MULTILINE)
        self.unreached = re.findall(r"^\[\S+\.assertion\.\d+\] (?:line \d+ )?(.*): SUCCESS$", text, re.MULTILINE)
        self.is_undefined = sorted(set(re.findall(r"no body for function '?(\w+)'?", text)))
        count = re.search(r"\*\* \d+ of (\d+) failed", text)
        self.checks = int(count[1]) if count else 0

    def finding(self):
        """First property that fails and is no loop bound; empty if there is none."""
        return next((what for what in self.failed if "unwinding assertion" not in what), "")


def set_limits():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (TIMEOUT_S, TIMEOUT_S))


def used_s():
    """Processor time that ended child processes have used."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(command, log):
    begin = used_s()
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                          preexec_fn=set_limits)
    log.parent.mkdir(parents=True, exist_ok=True)
    log.write_text(done.stdout)
    return Result(done.returncode, done.stdout, used_s() - begin)


def prove(proof):
    """Findings as texts, and the row of the table."""
    directory = OUT / proof.name
    held = run(proof.command(proof.copies(directory / "copies")), directory / "proof.txt")
    findings, found, seconds = [], [], 0.0
    if held.code != HOLDS or held.checks == 0:
        findings.append(f"{proof.path}: does not hold (code {held.code}): {'; '.join(held.failed[:5])}: "
                        f"see {(directory / 'proof.txt').relative_to(ROOT)}")
    if held.is_undefined:
        findings.append(f"{proof.path}: without a body, so without effect: {' '.join(held.is_undefined)}")
    for number, fault in enumerate(proof.faults):
        copies = proof.copies(directory / f"fault{number}", fault)
        result = run([*proof.command(copies), "--stop-on-fail"], directory / f"fault{number}.txt")
        seconds += result.seconds
        finding = result.finding() or next(iter(re.findall(r"^  (?!file|line|unwinding assertion)(.+)$", tail(result.text), re.MULTILINE)), "")
        if result.code != FAILS or not finding:
            findings.append(f"{proof.path}: the fault planted in {fault.path} is not found (code {result.code}): {fault.new}: "
                            f"see {(directory / f'fault{number}.txt').relative_to(ROOT)}")
        found.append(finding)
    reached = run(proof.command(proof.copies(directory / "reached"), REACHING), directory / "reached.txt")
    if reached.code != FAILS or reached.unreached:
        findings.append(f"{proof.path}: never reached with all conditions true (code {reached.code}): {'; '.join(reached.unreached)}: "
                        f"see {(directory / 'reached.txt').relative_to(ROOT)}")
    return findings, {"checks": held.checks, "seconds": held.seconds, "fault_seconds": seconds, "reach_seconds": reached.seconds, "found": found}


def tail(text):
    return text.rpartition("Violated property:")[2]


def kept(proof, digest):
    """Row of an earlier run with the same digest, or None."""
    stamp = OUT / proof.name / "passed.json"
    if not stamp.exists():
        return None
    row = json.loads(stamp.read_text())
    return row if row.pop("digest") == digest else None


def unlisted(proofs):
    """Proofs that docs/assurance.md does not list with property, bound and run time."""
    page = (ROOT / PAGE).read_text()
    return [f"{PAGE}: no row with `{proof.name}` in the table of proofs" for proof in proofs if f"`{proof.name}` |" not in page]


def print_row(proof, row, is_kept, is_passed):
    found = "; ".join(text or "NOT FOUND" for text in row["found"])
    print(f"{proof.name:<43} {row['checks']:>6} {row['seconds']:>7.1f} {row['fault_seconds']:>7.1f} {row['reach_seconds']:>7.1f}  "
          f"{'holds' if is_passed else 'FAILS'}{' (kept)' if is_kept else ''}; finds: {found}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="only proofs with this in their path")
    parser.add_argument("--quick", action="store_true", help="only the quick ones; what has passed is not repeated")
    parser.add_argument("--list", action="store_true", help="print each statement")
    arguments = parser.parse_args()
    proofs = [Proof(path) for path in sorted(HERE.rglob("proof_*.c"))]
    chosen = [proof for proof in proofs if arguments.only in str(proof.path) and (proof.is_quick or not arguments.quick)]
    if not chosen:
        raise SystemExit(f"ONLY={arguments.only}: no proof has this in its path; there are: {' '.join(p.name for p in proofs)}")
    if arguments.list:
        for proof in chosen:
            print(f"{proof.name}\n    {proof.proves}\n    Bounds: {proof.bounds}\n    Replaced: {proof.replaced}")
        return 0
    print(f"{'proof':<43} {'checks':>6} {'s':>7} {'fault s':>7} {'reach s':>7}  result")
    failures = unlisted(proofs) + [text for proof in proofs if arguments.quick and proof not in chosen for text in proof.stale()]
    for proof in chosen:
        digest = proof.digest()
        row = kept(proof, digest) if arguments.quick else None
        findings, is_kept = [], row is not None
        if row is None:
            findings, row = prove(proof)
            if not findings:
                (OUT / proof.name / "passed.json").write_text(json.dumps({"digest": digest, **row}))
        print_row(proof, row, is_kept, not findings)
        failures += findings
    print(f"{len(chosen)} proofs in {used_s():.0f} s of the processor")
    print("\n".join(failures) if failures else "check: every proof holds, reaches its statements and finds the fault planted for it")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
