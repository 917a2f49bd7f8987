# SPDX-License-Identifier: Apache-2.0
"""The micro-VM as users and tests use it: a single command, a shell on a terminal, and its failures."""

import concurrent.futures
import contextlib
import os
import pathlib
import pty
import select
import shutil
import signal
import subprocess
import sys
import termios
import time

import pytest

import environments
from vm import microvm, prepare

BOUND_S = 600  # much more than a boot takes on a busy machine
BUSES, CONTROLLERS = "test/hil/guest/buses.py", "test/hil/guest/controllers.py"
RUNNER = [sys.executable, str(environments.ROOT / "gse" / "vm" / "microvm.py")]


def until(condition, what):
    end = time.monotonic() + BOUND_S
    while not condition():
        assert time.monotonic() < end, f"waited too long for {what}"
        time.sleep(0.02)


def mentioning(text):
    """Processes with the text in their command line."""
    found = []
    for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            if str(text).encode() in path.read_bytes() and path.parent.name != str(os.getpid()):
                found.append(path.parent.name)
    return found


@pytest.fixture
def kernel_directory(tmp_path):
    """A boot directory for this test only, so that other micro-VMs are not in it."""
    directory = tmp_path / "boot"
    directory.mkdir()
    for name in ("vmlinux", "initramfs.cpio"):
        (directory / name).symlink_to(microvm.DIRECTORY / name)
    yield directory
    assert not list(directory.glob("control-*")), "the runner left a control directory behind"
    assert not mentioning(directory), "the runner left a process behind"


# --- one command ---------------------------------------------------------------------------------------------------

def test_command_streams_its_output_and_returns_its_exit_code_and_only_the_output_directory_stays(tmp_path):
    readme = environments.ROOT / "README.md"
    before, intruder = readme.read_bytes(), environments.ROOT / "build" / f"written-in-guest-{os.getpid()}"
    script = (f"echo first; while [ ! -e $OUT/go-on ]; do sleep 0.05; done; echo told >/dev/stderr; pwd; "
              f"echo changed >README.md && cat README.md && touch {intruder} && ls {intruder} && echo kept >$OUT/result; "
              "sleep 1000 & exit 7")
    process = subprocess.Popen([*RUNNER, "--out", tmp_path, script], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE)
    try:
        # The command still runs: it waits for the file that the next line creates.
        assert process.stdout.readline() == b"first\n"
        (tmp_path / "go-on").touch()
        stdout, stderr = process.communicate(timeout=BOUND_S)
    finally:
        process.kill()
    assert (process.returncode, stderr) == (7, b"told\n")
    assert stdout.decode().splitlines() == [str(environments.ROOT), "changed", str(intruder)]
    assert (tmp_path / "result").read_text() == "kept\n"
    assert readme.read_bytes() == before and not intruder.exists()
    assert not mentioning(tmp_path)


@pytest.mark.long
def test_make_passes_the_command_as_it_is_written(tmp_path):
    environment = {name: value for name, value in os.environ.items() if name not in microvm.NOT_PASSED}
    made = subprocess.run(["make", "--no-print-directory", "vm", f"OUT={tmp_path}", "SECONDS=200", "MEMORY=512",
                           "CMD=echo \"$((6 * 7))\" 'a  b' >$OUT/said; exit 9"],
                          cwd=environments.ROOT, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert made.returncode == 2 and "Error 9" in made.stderr, made.stderr  # make's own form of an exit code
    assert (tmp_path / "said").read_text() == "42 a  b\n"


def test_the_kernel_does_not_check_the_timer_of_the_emulator(tmp_path):
    """On a machine with much other work the check fails, and the kernel panics."""
    line = microvm.arguments(tmp_path, tmp_path, tmp_path, 0, 512, "debug", False)
    assert {"no_timer_check", "debug"} <= set(line[line.index("-append") + 1].split())


def test_time_limit_ends_a_command_that_hangs(kernel_directory, tmp_path):
    outcome = microvm.run("sleep 1000", seconds=1, out=tmp_path / "out", directory=kernel_directory)
    assert (outcome.code, outcome.limit) == (microvm.LIMIT_REACHED, True)


@pytest.mark.long
def test_a_command_that_writes_without_end_is_ended(kernel_directory, tmp_path, monkeypatch):
    monkeypatch.setattr(microvm, "OUTPUT_MAX", 1 << 20)
    with pytest.raises(microvm.NotStarted, match="wrote more than 1 MB; let it write to a file in"):
        microvm.run("yes", out=tmp_path / "out", directory=kernel_directory)


@pytest.mark.long
def test_ctrl_c_ends_the_vm(tmp_path):
    process = subprocess.Popen([*RUNNER, "--out", tmp_path, "echo begun; sleep 1000"], stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        assert process.stdout.readline() == b"begun\n"
        process.send_signal(signal.SIGINT)
        stderr = process.communicate(timeout=BOUND_S)[1]
    finally:
        process.kill()
    assert process.returncode == microvm.INTERRUPTED and b"Ctrl-C" in stderr
    assert not mentioning(tmp_path)


def test_emulator_ends_with_a_runner_that_is_killed(tmp_path):
    process = subprocess.Popen([*RUNNER, "--out", tmp_path, "echo begun; sleep 1000"], stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"begun\n"
    process.kill()
    process.communicate(timeout=BOUND_S)
    until(lambda: not mentioning(tmp_path), "the emulator's end")


def test_directories_of_a_killed_runner_are_removed_and_those_in_use_are_not(tmp_path):
    for name in ("control-left", "control-used", "control-new"):
        (tmp_path / name).mkdir()
    lock = microvm.held(tmp_path / "control-used")
    for name in ("control-left", "control-used"):
        os.utime(tmp_path / name, (0, 0))  # Old; a new directory may belong to a runner that has not locked it yet.
    microvm.remove_stale(tmp_path)
    os.close(lock)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["control-new", "control-used"]


@pytest.mark.long
def test_two_machines_run_at_the_same_time(tmp_path):
    """Each machine waits for a file that only the host can create: it shows that the other machine runs,
    too."""
    command = "touch $OUT/here; while [ ! -e $OUT/both ]; do sleep 0.05; done; echo $OUT"
    outs = [tmp_path / "a", tmp_path / "b"]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        runs = [pool.submit(microvm.run, command, BOUND_S, out=out) for out in outs]
        until(lambda: all((out / "here").exists() for out in outs) or any(run.done() for run in runs), "both micro-VMs")
        for out in outs:
            (out / "both").touch()
        outcomes = [run.result() for run in runs]
    assert [(outcome.code, outcome.stdout.decode()) for outcome in outcomes] == [(0, f"{out}\n") for out in outs]


# --- what does not boot ----------------------------------------------------------------------------------------------

def refusal(directory, tmp_path, **options):
    with pytest.raises(microvm.NotStarted) as raised:
        microvm.run("true", out=tmp_path / "out", directory=directory, **options)
    return str(raised.value)


def test_a_kernel_panic_shows_the_console(kernel_directory, tmp_path):
    text = refusal(kernel_directory, tmp_path, append="rdinit=/nothing root=/dev/nothing")
    assert "did not boot" in text and "Kernel panic" in text and microvm.NEXT_STEP in text
    assert "\x1b" not in text and "\r" not in text


@pytest.mark.long
def test_a_missing_module_is_named_on_the_console(kernel_directory, tmp_path):
    (kernel_directory / "initramfs.cpio").unlink()
    without_9p = [name for name in prepare.AT_BOOT if name not in ("9p", "9pnet_virtio")]
    prepare.make_initramfs(prepare.modules_of(microvm.DIRECTORY), kernel_directory / "initramfs.cpio", without_9p)
    text = refusal(kernel_directory, tmp_path)
    assert "did not boot" in text and "cannot be mounted (9p)" in text and microvm.NEXT_STEP in text


def test_a_guest_that_does_not_become_ready_is_ended(kernel_directory, tmp_path):
    text = refusal(kernel_directory, tmp_path, append="rdinit=/bin/cat", boot_seconds=3)
    assert "did not boot within 3 s" in text


def test_an_emulator_that_hangs_before_the_guest_begins_is_started_once_more(kernel_directory, tmp_path, monkeypatch):
    hangs_first = tmp_path / "bin" / microvm.QEMU
    hangs_first.parent.mkdir()
    hangs_first.write_text(f'#!/bin/sh\n[ ! -e {tmp_path}/hung ] || exec {shutil.which(microvm.QEMU)} "$@"\n'
                           f": >{tmp_path}/hung\nexec sleep 1000\n")
    hangs_first.chmod(0o755)
    monkeypatch.setenv("PATH", f"{hangs_first.parent}:{os.environ['PATH']}")
    monkeypatch.setattr(microvm, "FIRST_BOOT_SECONDS", 1)
    outcome = microvm.run("echo there", out=tmp_path / "out", directory=kernel_directory, boot_seconds=BOUND_S)
    assert (outcome.code, outcome.stdout) == (0, b"there\n")
    assert (tmp_path / "hung").exists()


@pytest.mark.parametrize("knows, message", [(False, "the package lists do not know linux-image-amd64"), (True, "cannot be fetched")])
def test_a_kernel_that_cannot_be_fetched_is_reported_with_the_next_step(tmp_path, monkeypatch, knows, message):
    """The machine has no package lists, or the lists name a server that does not exist."""
    (tmp_path / "lists" / "partial").mkdir(parents=True)
    sources = tmp_path / "sources.list"
    sources.write_text("")
    if knows:
        repository = tmp_path / "repository"
        repository.mkdir()
        (repository / "Packages").write_text("".join(
            f"Package: {name}\nVersion: 1\nArchitecture: amd64\n{more}Filename: ./{name}.deb\nSize: 1\nSHA256: {'0' * 64}\n\n"
            for name, more in (("linux-image-amd64", "Depends: linux-image-6.1.0-0-amd64\n"), ("linux-image-6.1.0-0-amd64", ""))))
        sources.write_text(f"deb [trusted=yes] file:{repository} ./\n")
    settings = tmp_path / "apt.conf"
    settings.write_text(f'Dir::Etc::sourcelist "{sources}"; Dir::Etc::sourceparts "/dev/null";\n'
                        f'Dir::State::lists "{tmp_path / "lists"}"; Dir::Cache "{tmp_path}"; Dir::State::status "/dev/null";\n'
                        'APT::Sandbox::User "root"; APT::Architecture "amd64";\n')
    monkeypatch.setenv("APT_CONFIG", str(settings))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with pytest.raises(prepare.Unavailable, match="make build/setup/vm") as raised:
        prepare.fetch(tmp_path)
    assert message in str(raised.value)


def test_a_kernel_is_fetched_once_for_all_clones(tmp_path, monkeypatch):
    client = tmp_path / "apt-get"
    client.write_text('#!/bin/sh\ncase "$*" in *download*) echo kernel >linux-image-6_1_amd64.deb ;; esac\n')
    client.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(prepare, "kernel_package", lambda: "linux-image-6")
    cached = tmp_path / "cache" / "hirosco" / "linux-image-6.deb"
    assert prepare.fetch(tmp_path) == cached and cached.read_text() == "kernel\n"
    client.write_text("#!/bin/sh\nexit 100\n")
    assert prepare.fetch(tmp_path) == cached
    package = tmp_path / "package.deb"
    package.write_text("kernel")
    assert prepare.keep(package, tmp_path / "apt-get" / "no directory" / "a.deb") == package
    monkeypatch.setattr(prepare, "kernel_package", lambda: None)  # No package lists either.
    assert prepare.fetch(tmp_path) == cached
    assert [path.name for path in cached.parent.iterdir()] == [cached.name]


def test_missing_parts_are_named(kernel_directory, tmp_path, monkeypatch):
    (kernel_directory / "initramfs.cpio").unlink()
    assert f"initramfs.cpio is not there; run: {microvm.NEXT_STEP}" in refusal(kernel_directory, tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "qemu-system-x86_64 is not installed; run: sh gse/setup/setup.sh hil" in refusal(kernel_directory, tmp_path)


@pytest.mark.parametrize("options, message", [({"cans": 9}, "9 CAN controllers, expected 0 to 8"),
                                              ({"memory": 1}, "1 MB of memory, expected at least 256")])
def test_numbers_out_of_range_are_refused(kernel_directory, tmp_path, options, message):
    assert message in refusal(kernel_directory, tmp_path, **options)


def test_output_directory_that_cannot_be_made_is_refused(kernel_directory, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(microvm.NotStarted, match="cannot be created"):
        microvm.run("true", out=tmp_path / "file" / "out", directory=kernel_directory)


def test_a_shell_without_a_terminal_is_refused():
    refused = subprocess.run(RUNNER, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert refused.returncode == 2 and "needs a terminal" in refused.stderr


# --- a shell on a terminal --------------------------------------------------------------------------------------------

class Terminal:
    """The runner on a pseudo terminal, and its output."""

    def __init__(self, *options):
        self.pid, self.master = pty.fork()
        if self.pid == 0:
            os.execv(RUNNER[0], [*RUNNER, *map(str, options)])
        self.shown = b""

    def expect(self, text):
        end = time.monotonic() + BOUND_S
        while text not in self.shown:
            assert time.monotonic() < end, f"waited too long for {text}; shown: {self.shown}"
            if select.select([self.master], [], [], 0.2)[0]:
                self.shown += os.read(self.master, 65536)
        self.shown = self.shown[self.shown.index(text) + len(text):]

    def type(self, text):
        os.write(self.master, text)

    def end(self):
        """The exit code of the runner."""
        with contextlib.suppress(OSError):
            while os.read(self.master, 65536):
                pass
        return os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])


@pytest.mark.long
def test_a_shell_on_a_terminal_gets_all_input_and_restores_the_terminal(tmp_path):
    terminal = Terminal("--out", tmp_path)
    before = termios.tcgetattr(terminal.master)
    try:
        terminal.expect(b"Ctrl-D or exit ends it")
        terminal.type(b"ip link add vcan0 type vcan && ip link set vcan0 up; echo made $((6 * 7))\n")
        terminal.expect(b"made 42")
        terminal.type(b"PS1='rea''dy '\n")
        terminal.expect(b"ready ")
        # When this shell prints `sleeps`, it is already the foreground process of the terminal, which Ctrl-C ends.
        terminal.type(b"sh -c 'echo slee\"\"ps; exec sleep 1000'\n")
        terminal.expect(b"sleeps")
        # Ctrl-C, like all input, goes to the shell in the VM and not to the emulator.
        terminal.type(b"\x03")
        terminal.expect(b"ready ")
        terminal.type(b"echo aft''er $?; tty; echo kept >$OUT/kept\n")
        terminal.expect(b"after 130")
        terminal.expect(b"/dev/hvc0")
        terminal.type(b"exit 5\n")
        assert terminal.end() == 5
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.kill(terminal.pid, signal.SIGKILL)
    assert termios.tcgetattr(terminal.master) == before
    os.close(terminal.master)
    assert (tmp_path / "kept").read_text() == "kept\n"
    assert not mentioning(tmp_path)


# --- the test environment, its buses and its controllers (test_buses.py uses them in every run) -----------------

@pytest.mark.long
@pytest.mark.parametrize("case", environments.cases(BUSES))
def test_the_buses_work(environment, case):
    environment.group("buses", f"{environments.PYTHON} {BUSES}").check(case)


@pytest.mark.long
@pytest.mark.parametrize("case", environments.cases(CONTROLLERS))
def test_the_controllers_work(environment, case):
    environment.group("controllers", f"{environments.PYTHON} {CONTROLLERS}", cans=2).check(case)


def test_a_group_that_ends_early_fails_the_cases_it_did_not_reach(tmp_path):
    report = environments.RunningKernel(tmp_path, "wanted")
    report.groups["cut"] = environments.Group("cut", environments.Result(1, b"why it ended\n", b"", tmp_path))
    with pytest.raises(AssertionError, match="(?s)no result.*exit code 1.*why it ended"):
        report.group("cut", "").check("any")


def test_an_unknown_test_environment_is_refused(tmp_path):
    with pytest.raises(ValueError, match="expected vm or kernel"):
        environments.choose(tmp_path, "moon")


@pytest.mark.skipif(not shutil.which("unshare"), reason="no unshare")
def test_features_that_the_kernel_lacks_are_reported(tmp_path):
    chosen = environments.choose(tmp_path)
    assert chosen.why and (chosen.name == "running kernel" or "no " in chosen.why)
