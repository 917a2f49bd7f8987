# SPDX-License-Identifier: Apache-2.0
"""Run a command, or a shell, in a micro-VM with vcan, vxcan and TIPC over this machine's own file system.

    python3 gse/vm/microvm.py [--seconds N] [--cans N] [--memory MB] [--out DIRECTORY] [-- COMMAND]

The guest has the tree at the same path and may write anywhere; only the output directory, whose path in the guest is $OUT, is kept.
Exit code: that of the command; 124 time limit, 125 the micro-VM did not start, 130 Ctrl-C. It always emulates the processor and
never opens /dev/kvm. It removes its temporary files when it ends; the next run removes those of a run that was killed."""

import argparse
import fcntl
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import termios
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
DIRECTORY = ROOT / "build" / "vm"
QEMU = "qemu-system-x86_64"
SECONDS, MEMORY_MB = 300, 1024
BOOT_SECONDS = 180  # Longest time for the boot.
FIRST_BOOT_SECONDS = 60  # Limit of the first attempt: in about one of a hundred boots the emulator hangs before the guest writes anything.
END_SECONDS = 10  # Longest wait for the end of the emulator.
POLL_S = 0.02
STALE_S = 60  # Age from which the control directory of a runner may be removed.
MEMORY_MIN_MB = 256
PROCESSORS_MAX = 2  # The guest has at most as many processors as this process may use: two on one would mostly wait for each other.
CANS_MAX = 8
OUTPUT_MAX = 1 << 28
CONSOLE_LINES = 40  # Lines of the console in an error message.
LIMIT_REACHED, NOT_STARTED, INTERRUPTED = 124, 125, 130
NEXT_STEP = "rm -rf build/vm && make build/setup/vm"
SYSTEM_PATHS = ["/usr/local/sbin", "/usr/sbin", "/sbin", "/usr/local/bin", "/usr/bin", "/bin"]
# Variables by which make controls its children must not reach make in the guest.
NOT_PASSED = {"MAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEOVERRIDES", "MAKE_TERMOUT", "MAKE_TERMERR", "CMD", "SECONDS", "CANS",
              "MEMORY", "VM_COMMAND", "PWD", "OLDPWD", "_", "TMPDIR"}
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
ESCAPES = re.compile(r"\x1b(\[[0-9;?=]*[A-Za-z]|c|[()].)|[\x00-\x08\x0b-\x1f\x7f]")


class NotStarted(Exception):
    """The command did not run, or its exit code is unknown; the text contains the reason, the end of the console and the next step."""


class NotBooted(NotStarted):
    """The micro-VM did not boot in time."""


class Outcome:
    """Outcome of a command: its exit code (124 with `limit` set after the time limit), and its output."""

    def __init__(self, code, stdout=b"", stderr=b"", limit=False):
        self.code, self.stdout, self.stderr, self.limit = code, stdout, stderr, limit


class Stream:
    """A file that grows in the guest; its new octets are passed to a sink."""

    def __init__(self, path, sink):
        self.file = open(path, "rb")
        self.sink = sink
        self.octets = bytearray()

    def pump(self):
        """Pass new octets on; returns whether there were any."""
        octets = self.file.read(1 << 20)
        if octets:
            self.octets += octets
            if self.sink:
                self.sink(octets)
        return bool(octets)


def console_end(path):
    """The last lines of the guest's console, without control sequences of a terminal."""
    text = path.read_bytes().decode(errors="replace") if path.is_file() else ""
    lines = [ESCAPES.sub("", line).rstrip() for line in re.split(r"[\r\n]+", text)]
    lines = [line for line in lines if line]
    return "\n".join(f"    {line}" for line in lines[-CONSOLE_LINES:]) or "    (nothing)"


def guest_script(command, out, environment):
    """The shell script that sets up the environment in the guest and executes the command, or an interactive shell."""
    values = {name: value for name, value in environment.items() if IDENTIFIER.fullmatch(name) and name not in NOT_PASSED}
    paths = values.get("PATH", "").split(":")
    values["PATH"] = ":".join(path for path in [*paths, *(one for one in SYSTEM_PATHS if one not in paths)] if path)
    values |= {"OUT": str(out), "PYTHONDONTWRITEBYTECODE": "1"}
    # Use the byte code of runs outside of the guest.
    values.setdefault("PYTHONPYCACHEPREFIX", str(ROOT / "build" / "pycache"))
    lines = [f"export {name}={shlex.quote(value)}" for name, value in sorted(values.items())]
    lines.append(f"cd {shlex.quote(str(ROOT))} || exit 126")
    if command is None:
        size = shutil.get_terminal_size()
        lines += [f"stty rows {size.lines} cols {size.columns} sane",
                  f"echo {shlex.quote(greeting(out))}",
                  "if command -v bash >/dev/null; then exec bash; else exec sh; fi"]
    else:
        lines.append(f"exec /bin/sh -c {shlex.quote(command)}")
    return "#!/bin/sh\n" + "\n".join(lines) + "\n"


def greeting(out):
    return (f"micro-VM with vcan, vxcan and TIPC. Changes to files are lost, except in $OUT = {out}\n"
            "As a first step: ip link add vcan0 type vcan && ip link set vcan0 up. Ctrl-D or exit ends it.")


def arguments(directory, control, out, cans, memory, append, interactive):
    line = ["setpriv", "--pdeathsig", "KILL", "--", QEMU, "-M", "q35", "-accel", "tcg,thread=multi", "-cpu", "Nehalem,+rdrand",
            "-smp", str(min(PROCESSORS_MAX, len(os.sched_getaffinity(0)))), "-m", str(memory), "-nodefaults",
            "-display", "none", "-no-reboot", "-nic", "none",
            "-serial", f"file:{control / 'console'}",
            "-kernel", str(directory / "vmlinux"), "-initrd", str(directory / "initramfs.cpio"),
            # no_timer_check: on a loaded machine the ticks of the emulated timer arrive late, and the kernel panics after its check.
            "-append", f"console=ttyS0 quiet panic=-1 no_timer_check mitigations=off cryptomgr.notests random.trust_cpu=on {append}".strip()]
    for tag, path, options in (("root", "/", ",readonly=on,multidevs=remap"), ("control", control, ""), ("out", out, "")):
        path = str(path).replace(",", ",,")
        line += ["-fsdev", f"local,id={tag},path={path},security_model=none{options}",
                 "-device", f"virtio-9p-pci,fsdev={tag},mount_tag={tag}"]
    if cans:
        line += ["-object", "can-bus,id=canbus0", *["-device", "kvaser_pci,canbus=canbus0"] * cans]
    if interactive:
        line += ["-chardev", "stdio,id=shell,signal=off", "-device", "virtio-serial-pci", "-device", "virtconsole,chardev=shell"]
    return line


def check(directory, out, cans, memory):
    """Raise NotStarted if the arguments cannot work."""
    if not shutil.which(QEMU):
        raise NotStarted(f"{QEMU} is not installed; run: sh gse/setup/setup.sh hil")
    for name in ("vmlinux", "initramfs.cpio"):
        if not (directory / name).is_file():
            raise NotStarted(f"{directory / name} is not there; run: {NEXT_STEP}")
    if not 0 <= cans <= CANS_MAX:
        raise NotStarted(f"{cans} CAN controllers, expected 0 to {CANS_MAX}")
    if memory < MEMORY_MIN_MB:
        raise NotStarted(f"{memory} MB of memory, expected at least {MEMORY_MIN_MB}")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise NotStarted(f"the output directory {out} cannot be created ({error.strerror}); choose another by OUT=") from error


def failure(what, control):
    """Error text: output of the emulator, end of the console, next step."""
    output = (control / "emulator").read_text(errors="replace").strip()
    return (f"the micro-VM {what}" + (f"; {QEMU} printed: {output}" if output else "") + "\nEnd of its console:\n"
            + console_end(control / "console") + f"\nNext step: {NEXT_STEP}")


def start(line, control, interactive):
    """Start the emulator. Its output goes to the control directory, or to this terminal."""
    with open(control / "emulator", "wb") as output:
        return subprocess.Popen(line, stdin=None if interactive else subprocess.DEVNULL, stdout=None if interactive else output,
                                stderr=output, start_new_session=not interactive)


def wait_for_boot(process, control, boot_seconds):
    """Return when the command starts; raise NotBooted or NotStarted if it does not."""
    end_of_boot = time.monotonic() + boot_seconds
    while not (control / "booted").exists():
        if process.poll() is not None and not (control / "booted").exists():
            raise NotStarted(failure(f"did not boot (exit code {process.returncode} of {QEMU})", control))
        if time.monotonic() > end_of_boot:
            raise NotBooted(failure(f"did not boot within {boot_seconds:g} s", control))
        time.sleep(POLL_S)


def wait_for_code(process, control, streams, seconds):
    """Pass the output of the command on until its exit code exists or its time is over. Returns an Outcome without stdout and stderr."""
    limit = time.monotonic() + (float("inf") if seconds is None else seconds)
    while True:
        ended, finished = process.poll() is not None, (control / "code").is_file()
        if any([stream.pump() for stream in streams]):
            if any(len(stream.octets) > OUTPUT_MAX for stream in streams):
                raise NotStarted(f"the command wrote more than {OUTPUT_MAX >> 20} MB; let it write to a file in $OUT")
        elif finished:
            return Outcome(int((control / "code").read_text()))
        elif ended:
            raise NotStarted(failure("ended before the command did", control))
        else:
            time.sleep(POLL_S)
        if not finished and time.monotonic() > limit:
            return Outcome(LIMIT_REACHED, limit=True)


def end(process, timeout):
    """Wait for the end of the emulator for the given time, then kill it."""
    for act in (None, process.terminate, process.kill):
        if act:
            act()
        try:
            process.wait(timeout if act is None else END_SECONDS)
            return
        except subprocess.TimeoutExpired:
            continue


def held(control):
    """Descriptor of a lock on the control directory; None if its runner is alive."""
    lock = os.open(control, os.O_RDONLY)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return lock
    except BlockingIOError:
        os.close(lock)
        return None


def remove_stale(directory):
    """Remove control directories of runners that were killed; those of the last minute may be about to get their lock."""
    for control in directory.glob("control-*"):
        try:
            lock = held(control) if control.stat().st_mtime < time.time() - STALE_S else None
        except FileNotFoundError:
            continue  # The runner that owned this file has just ended.
        if lock is not None:
            shutil.rmtree(control, ignore_errors=True)
            os.close(lock)


def run(command, seconds=SECONDS, cans=0, memory=MEMORY_MB, out=None, sinks=(None, None), environment=None,
        directory=DIRECTORY, append="", boot_seconds=BOOT_SECONDS):
    """Run a shell command in a micro-VM of its own; None runs an interactive shell on this terminal.

    `seconds` limits the time of the command (None: no limit); `sinks` receive its two streams as they arrive; `out` is kept,
    by default build/vm/out; `append` is added to the kernel's command line. Returns an Outcome; raises NotStarted."""
    out = pathlib.Path(out or DIRECTORY / "out").absolute()
    check(directory, out, cans, memory)
    remove_stale(directory)
    control = pathlib.Path(tempfile.mkdtemp(prefix="control-", dir=directory))
    lock = held(control)
    interactive = command is None
    process, terminal = None, None
    try:
        (control / "guest.sh").write_text(guest_script(command, out, environment or dict(os.environ)))
        (control / "parameters").write_text(f"directory={shlex.quote(str(ROOT))}\nout={shlex.quote(str(out))}\ncans={cans}\n"
                                            f"interactive={'yes' if interactive else 'no'}\n")
        for name in ("stdout", "stderr"):
            (control / name).touch()
        streams = [Stream(control / name, sink) for name, sink in zip(("stdout", "stderr"), sinks)]
        terminal = termios.tcgetattr(0) if interactive else None
        line = arguments(directory, control, out, cans, memory, append, interactive)
        process = start(line, control, interactive)
        try:
            wait_for_boot(process, control, min(boot_seconds, FIRST_BOOT_SECONDS))
        except NotBooted:
            if boot_seconds <= FIRST_BOOT_SECONDS:
                raise
            end(process, 0)
            process = start(line, control, interactive)
            wait_for_boot(process, control, boot_seconds - FIRST_BOOT_SECONDS)
        outcome = wait_for_code(process, control, streams, seconds)
        end(process, 0 if outcome.limit else END_SECONDS)
        outcome.stdout, outcome.stderr = (bytes(stream.octets) for stream in streams)
        return outcome
    finally:
        if process:
            end(process, 0)
        if terminal:
            termios.tcsetattr(0, termios.TCSADRAIN, terminal)
        shutil.rmtree(control, ignore_errors=True)
        os.close(lock)


def parse(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, help=f"time limit of the command, {SECONDS} if not given; of a shell, none")
    parser.add_argument("--cans", type=int, default=0, help="emulated CAN controllers (kvaser_pci) on one bus: can0, can1 ...")
    parser.add_argument("--memory", type=int, default=MEMORY_MB, help="memory of the guest [MB], which also holds the changes to files")
    parser.add_argument("--out", help="output directory that stays; build/vm/out if not given")
    parser.add_argument("--append", default="", help="additional parameters of the kernel's command line")
    parser.add_argument("command", nargs="*", help="shell command; without it an interactive shell")
    options = parser.parse_args(words)
    if options.seconds is not None and not options.seconds > 0:
        parser.error(f"--seconds {options.seconds:g}: expected more than 0")
    return options


def sink_to(stream):
    def write(octets):
        stream.buffer.write(octets)
        stream.flush()
    return write


def main():
    options = parse(sys.argv[1:])
    command = " ".join(options.command).strip() or os.environ.get("VM_COMMAND", "").strip() or None
    if command is None and not (sys.stdin.isatty() and sys.stdout.isatty()):
        print("vm: a shell needs a terminal; to run one command: make vm CMD='...'", file=sys.stderr)
        return 2
    seconds = options.seconds or (SECONDS if command else None)
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, frame: sys.exit(128 + number))
    try:
        outcome = run(command, seconds, options.cans, options.memory, options.out, (sink_to(sys.stdout), sink_to(sys.stderr)),
                      append=options.append)
    except NotStarted as reason:
        print(f"vm: {reason}", file=sys.stderr)
        return NOT_STARTED
    except KeyboardInterrupt:
        print("vm: ended by Ctrl-C", file=sys.stderr)
        return INTERRUPTED
    if outcome.limit:
        print(f"vm: ended after its time limit of {seconds:g} s; SECONDS= sets a longer one", file=sys.stderr)
    return outcome.code


if __name__ == "__main__":
    sys.exit(main())
