# SPDX-License-Identifier: Apache-2.0
"""The test environment of the hardware-in-the-loop tests. If the kernel of this machine has vcan, vxcan and TIPC and permits this account to
use them, it is this kernel, in separate namespaces; otherwise it is the micro-VM. `python3 test/hil/environments.py` prints the test
environment and the reason."""

import ast
import contextlib
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "gse"))

from vm import microvm

PYTHON = "build/venv/bin/python"
PROBE = "test/hil/guest/probe.py"
PROBE_SECONDS = 300
SECONDS = 1200
SHOWN_LINES = 40
LIMIT_REACHED = microvm.LIMIT_REACHED
# The processor of the micro-VM has no fused multiply-add. With these instructions some functions of the C
# library round differently; therefore a flight that is compared with one in the micro-VM must not use them.
# Other libraries ignore this variable.
ARITHMETIC = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2"}
# Shell commands that precede each command on the running kernel, in its new namespaces: they make /run and
# /dev/shm empty and set the loopback interface up, as in the micro-VM.
SURROUNDINGS = "mount -t tmpfs run /run && mount -t tmpfs shm /dev/shm && ip link set lo up || exit 126; "


class Result:
    """Result of a command: `code` (124: the time limit has ended it), `stdout` and `stderr` as text, `directory`
    with the files that it left in $OUT."""

    def __init__(self, code, stdout, stderr, directory):
        self.code, self.directory = code, directory
        self.stdout, self.stderr = (text.decode(errors="replace") for text in (stdout, stderr))

    def end(self):
        """Exit code and last lines of the output, for the messages of failed tests."""
        lines = (self.stdout + self.stderr).splitlines()[-SHOWN_LINES:]
        limit = " (time limit)" if self.code == LIMIT_REACHED else ""
        return "\n".join([f"exit code {self.code}{limit}, results in {self.directory}, last lines:", *lines])


class Group(dict):
    """Cases that one process ran: name -> (passed, message)."""

    def __init__(self, name, result):
        super().__init__()
        self.name, self.result = name, result
        path = result.directory / "results.jsonl"
        for line in path.read_text().splitlines() if path.is_file() else []:
            case = json.loads(line)
            self[case["case"]] = (case["passed"], case["message"])

    def check(self, case):
        """Fail unless the case ran and passed."""
        passed, message = self.get(case, (False, f"no result: the group ended before this case\n{self.result.end()}"))
        if not passed:
            raise AssertionError(f"{self.name}, {case}: {message}")


class Environment:
    """Runs commands that use buses. `directory` has their results; `name` and `why` are the name of the test
    environment and the reason for its choice."""

    name = None

    def __init__(self, directory, why):
        self.directory, self.why = pathlib.Path(directory), why
        self.groups = {}

    def results_directory(self, out):
        if out is None:
            self.directory.mkdir(parents=True, exist_ok=True)
            return pathlib.Path(tempfile.mkdtemp(prefix="run-", dir=self.directory))
        pathlib.Path(out).mkdir(parents=True, exist_ok=True)
        return pathlib.Path(out).absolute()

    def run(self, command, seconds=SECONDS, cans=0, out=None, memory=microvm.MEMORY_MB):
        """Run a shell command as root of the test environment, in the project's directory; return a Result.

        `seconds`: time limit of the command.
        `out`: directory for the files that the command writes into $OUT; None: a new one in `directory`.
        `cans`: number of emulated CAN controllers (can0, can1 ...) on one bus; only the micro-VM has them, so the command
        runs there.
        `memory` [MB] is that of the micro-VM."""
        raise NotImplementedError

    def group(self, name, command, seconds=SECONDS, cans=0, memory=microvm.MEMORY_MB):
        """The cases that the command reports in $OUT/results.jsonl (see guest/cases.py); the command runs once for each name."""
        if name not in self.groups:
            self.groups[name] = Group(name, self.run(command, seconds, cans, memory=memory))
        return self.groups[name]


@contextlib.contextmanager
def on_all_processors():
    """Within the block, this thread starts commands on any processor, also if a worker of the tests is bound to one
    (test/conftest.py): on a single one, the processors of a micro-VM would wait for each other."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, range(os.cpu_count()))
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


class MicroVm(Environment):
    """Starts a micro-VM for each command."""

    name = "micro-VM"

    def run(self, command, seconds=SECONDS, cans=0, out=None, memory=microvm.MEMORY_MB):
        directory = self.results_directory(out)
        with on_all_processors():
            outcome = microvm.run(command, seconds, cans=cans, memory=memory, out=directory)
        return Result(outcome.code, outcome.stdout, outcome.stderr, directory)


class RunningKernel(Environment):
    """The kernel of this machine, with network, process and mount namespaces for each command. Unlike in the
    micro-VM, the tree is not a copy: written files stay."""

    name = "running kernel"

    def run(self, command, seconds=SECONDS, cans=0, out=None, memory=microvm.MEMORY_MB):
        if cans:
            return MicroVm(self.directory, self.why).run(command, seconds, cans, out, memory)
        directory = self.results_directory(out)
        with on_all_processors():
            code, stdout, stderr = in_namespaces(command, seconds, os.environ | ARITHMETIC | {"OUT": str(directory)})
        return Result(code, stdout, stderr, directory)


def in_namespaces(command, seconds, environment):
    """Run a shell command in new namespaces. Returns (exit code, stdout, stderr); the code is 124 if the time
    limit has ended it. No process of it remains."""
    paths = environment.get("PATH", "").split(":")
    environment["PATH"] = ":".join([*paths, *(path for path in microvm.SYSTEM_PATHS if path not in paths)])
    line = ["unshare", *([] if os.geteuid() == 0 else ["--map-root-user"]), "--net", "--mount", "--pid", "--fork",
            "--kill-child", "--mount-proc", "--", "/bin/sh", "-c", SURROUNDINGS + command]
    # Files instead of pipes: reading a pipe would wait for processes that the command has left.
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen(line, cwd=ROOT, env=environment, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                   start_new_session=True)
        try:
            code = process.wait(seconds)
        except subprocess.TimeoutExpired:
            code = LIMIT_REACHED
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read())
    return code, *texts


def lacking():
    """Features that the running kernel lacks, as text; empty if it has all."""
    try:
        code, stdout, stderr = in_namespaces(f"exec /usr/bin/python3 {PROBE}", PROBE_SECONDS, dict(os.environ))
    except FileNotFoundError as missing:
        return f"there is no {missing.filename}"
    if code == 0:
        return ""
    return "; ".join((stdout or stderr).decode(errors="replace").split("\n")).strip("; ") or f"{PROBE} ended with exit code {code}"


def choose(directory, wanted=None):
    """The test environment for this machine; `wanted` (or the variable HIL_ENVIRONMENT), vm or kernel, overrides the probe."""
    wanted = wanted or os.environ.get("HIL_ENVIRONMENT")
    if wanted not in (None, "", "vm", "kernel"):
        raise ValueError(f"HIL_ENVIRONMENT={wanted}: expected vm or kernel")
    if wanted:
        return {"vm": MicroVm, "kernel": RunningKernel}[wanted](directory, f"HIL_ENVIRONMENT={wanted}")
    lack = lacking()
    if lack:
        return MicroVm(directory, lack)
    return RunningKernel(directory, "it has vcan, vxcan, TIPC and network namespaces")


def cases(program):
    """Names of the cases of a guest program, without running it."""
    names = [node.name for node in ast.parse((ROOT / program).read_text()).body if isinstance(node, ast.FunctionDef)]
    found = [name.removeprefix("case_") for name in names if re.match("case_", name)]
    assert found, f"{program} has no function case_..."
    return found


if __name__ == "__main__":
    chosen = choose(ROOT / "build" / "test" / "hil")
    print(f"{chosen.name}: {chosen.why}")
