# SPDX-License-Identifier: Apache-2.0
"""SocketCAN as carrier of the buses: flights over vcan and over emulated controllers, recorded by can-utils;
and options that are refused. The arguments are the names of the cases to run."""

import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import time

import buses
import cases
import short_flights

OUT = pathlib.Path(os.environ["OUT"])
BIN = pathlib.Path("build/bin")
WORK = pathlib.Path("/dev/shm/flights")
BOUND_S = 900
# Room for 80 000 frames: the kernel doubles the number and needs about 800 octets for each frame.
BACKLOG = 1 << 25
CONTRACTS = ["contract/osal/test_can", "contract/osal/posix/test_can", "contract/osal/posix/test_can_socket",
             "contract/osal/posix/test_lockstep_scheduler_blocking", "unit/fsw/framework/dataflow/test_flow_can_socket"]
# Smallest number of tests that a program must run; 1 for the others.
TESTS_MIN = {"test_can_socket": 16, "test_flow_can_socket": 4}
KEPT = ("can-robot.log", "can-robot-b.log", "can-joystick.log", "packets.log", "operator.log", "console.log", "run.json",
        "truth.lcm")
FIRST, LAST = "7FE#EE", "7FF#FF"  # Probe and sentinel: identifiers that no node of the mission sends.


def ip(*words):
    return buses.command("ip", *words)


def links():
    return {link["ifname"] for link in json.loads(ip("-json", "link", "show"))}


def until(condition, what):
    """Poll until a condition holds; the time limit only ends a wait without end."""
    end = time.monotonic() + BOUND_S
    while not condition():
        assert time.monotonic() < end, f"not within {BOUND_S} s: {what}"
        time.sleep(0.1)


def started(name, *options):
    shutil.rmtree(WORK / name, ignore_errors=True)
    return subprocess.Popen([BIN / "hirosco", "run", "--report", "no", "--out", WORK / name, *options],
                            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def facts(name):
    return json.loads((WORK / name / "run.json").read_text())


def kept(name):
    """Copy the files of a flight that the tests on the host compare into the output share."""
    (OUT / name).mkdir()
    for file in KEPT:
        if (WORK / name / file).exists():
            shutil.copy(WORK / name / file, OUT / name / file)


def flown(name, *options, seconds=BOUND_S):
    process = started(name, *options)
    output = process.communicate(timeout=seconds)[0]
    kept(name)
    assert process.returncode == 0, output + (WORK / name / "console.log").read_text()
    return output


def last_of(path):
    """The last lines of a growing file, which may be long."""
    with open(path, "rb") as file:
        file.seek(-min(path.stat().st_size, 65536), os.SEEK_END)
        return file.read().decode()


@contextlib.contextmanager
def recorder(path, sender, *interfaces, backlog=BACKLOG):
    """Record these interfaces, or all of them, with candump on the processor that the flight does not use. It
    records every frame from the probe to the sentinel, both sent on the interface `sender`, unless the
    backlog [octets of each interface] is full."""
    filters = [f"{interface},0:0,#FFFFFFFF" for interface in interfaces or ("any",)]
    with open(path, "w") as file:
        process = subprocess.Popen(["taskset", hex(1 << max(os.sched_getaffinity(0))), "candump", "-L", "-d", "-r", str(backlog), *filters],
                                   stdin=subprocess.DEVNULL, stdout=file)
        try:
            def listens():
                ip("link", "show", sender)
                buses.command("cansend", sender, FIRST)
                return FIRST in last_of(path)
            until(listens, "candump to listen")
            yield
            buses.command("cansend", sender, LAST)
            until(lambda: LAST in last_of(path), "the sentinel")
        finally:
            process.terminate()
            process.wait()


def command_names(parent):
    """(process id, name) of the children of a process."""
    children = pathlib.Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    return [(int(child), pathlib.Path(f"/proc/{child}/comm").read_text().strip()) for child in children]


def has_line(name, frame):
    """True if the log of bus robot of a running flight contains the frame."""
    log = WORK / name / "can-robot.log"
    return log.exists() and f" {frame}" in log.read_text()


def shut_down(process):
    """Shut the launcher down as Ctrl-C does. Returns its output."""
    process.send_signal(signal.SIGINT)
    output = process.communicate(timeout=BOUND_S)[0]
    assert process.returncode == 0, output
    return output


def refused(*options, runner=()):
    """Output of the launcher, which must refuse these options; `runner` are words before its command."""
    ended = subprocess.run([*runner, BIN / "hirosco", "run", "--report", "no", "--out", WORK / "refused", *options],
                           stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=BOUND_S)
    assert ended.returncode in (1, 2), ended.stdout + ended.stderr
    return ended.stdout + ended.stderr


# --- the operating system layer -----------------------------------------------------------------------------------

def case_contract_holds_on_this_kernel():
    for variant in ("build/test", "build/sanitize/test") if os.environ.get("LONG") else ("build/test",):
        for contract in CONTRACTS:
            program = pathlib.Path(variant, contract)
            ended = subprocess.run([program], capture_output=True, text=True, timeout=BOUND_S)
            counts = re.search(r"(\d+) Tests (\d+) Failures (\d+) Ignored", ended.stdout)
            assert ended.returncode == 0 and counts, ended.stdout + ended.stderr
            tests, failures, ignored = map(int, counts.groups())
            assert (failures, ignored) == (0, 0) and tests >= TESTS_MIN.get(program.name, 1), ended.stdout


# --- what is refused ------------------------------------------------------------------------------------------------

def run_printed_command(output):
    """Run the command that a refusal prints for the user to type as root."""
    subprocess.run(["sh", "-ec", output.rpartition("as root: ")[2]], check=True, timeout=BOUND_S)


def case_bad_interfaces_are_refused_with_the_next_step():
    """The order of the refusals matters: vcan-robot is down for the first one, and is set up before that of bus joystick."""
    before = links()
    ip("link", "set", "can0", "up", "type", "can", "bitrate", "500000")
    ip("link", "add", "vcan-robot", "type", "vcan")
    refusals = {
        "is down; as root: ip link set vcan-robot up": ["--bus", "vcan"],
        "there is no interface can9": ["--mission", "classic", "--bus", "can", "--interface", "robot=can9", "--time", "real"],
        "more than 15 characters": ["--mission", "classic", "--bus", "can", "--interface", "robot=a-name-of-17-long",
                                    "--time", "real"],
        "lo is an interface, but not for CAN": ["--mission", "classic", "--bus", "can", "--interface", "robot=lo",
                                                "--time", "real"],
        "can0 runs at 500000 bit/s, bus robot of the mission at 1000000;": [
            "--mission", "classic", "--bus", "can", "--interface", "robot=can0", "--time", "real"],
        "can1 is down": ["--mission", "classic", "--bus", "can", "--interface", "robot=can1", "--time", "real"],
        "can0 carries classic frames only (mtu 16)": ["--bus", "can", "--interface", "robot=can0", "--interface",
                                                      "joystick=can1", "--time", "real"],
        "no interface is named for bus joystick": ["--bus", "can", "--interface", "robot=vcan-robot", "--time", "real"],
        "the mission has no such bus: arm=can0": ["--mission", "classic", "--bus", "can", "--interface", "arm=can0",
                                                  "--time", "real"],
        "flight and simulator need separate controllers": ["--mission", "classic", "--bus", "can", "--interface", "robot=can0",
                                                           "--sim-interface", "robot=can0"],
    }
    ip("link", "set", "can1", "type", "can", "bitrate", "1000000")
    wrong_rate = ""
    for fragment, options in refusals.items():
        if "bus joystick" in fragment:
            ip("link", "set", "vcan-robot", "mtu", "72", "up")
        output = refused(*options)
        assert fragment in output, f"expected: {fragment}\noutput: {output}"
        wrong_rate = output if "500000" in fragment else wrong_rate
    ip("link", "set", "vcan-robot", "down")
    ip("link", "set", "vcan-robot", "mtu", "16", "up")
    output = refused("--bus", "vcan")
    assert "carries classic frames only (mtu 16), and the mission's bus is CAN FD" in output, output
    for options, output in ((["--bus", "vcan"], output), (["--mission", "classic", "--bus", "can", "--interface", "robot=can0"], wrong_rate)):
        run_printed_command(output)
        again = refused(*options, "--out", "/dev/null/none")  # This directory is refused only after the interfaces are accepted.
        assert "cannot create the output directory" in again, f"the interface is still refused after the printed command: {again}"
    ip("link", "delete", "vcan-robot")
    ip("link", "set", "can0", "down")
    assert links() == before


def case_two_runs_at_once_are_refused():
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as other:
        other.bind("\0hirosco.can.vcan-robot")  # As if another launcher had claimed the interface.
        assert "another run flies on vcan-robot" in refused("--bus", "vcan")


def case_without_permission_the_launcher_prints_the_command_for_root():
    WORK.mkdir(exist_ok=True)
    WORK.chmod(0o777)
    output = refused("--bus", "vcan", runner=["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"])
    assert "as root, once: ip link add vcan-robot mtu 72 type vcan; ip link set vcan-robot up;" in output, output
    shutil.rmtree(WORK)


def bring_up_controllers():
    for name in ("can0", "can1"):
        ip("link", "set", name, "down")
        ip("link", "set", name, "up", "type", "can", "bitrate", "1000000")


# --- flights ----------------------------------------------------------------------------------------------------------

def case_vcan_flight_is_seen_by_candump():
    """The run uses the interfaces of bus robot, which exist before, and makes the others. Frames to flight software (fsw-robot) arrive
    with a delay, because receive packet steering (RPS) hands them to processor 1."""
    WORK.mkdir(exist_ok=True)
    ip("link", "add", "fsw-robot", "mtu", "72", "type", "vcan")
    ip("link", "set", "fsw-robot", "up")
    ip("link", "add", "vcan-robot", "mtu", "72", "type", "vcan")
    ip("link", "set", "vcan-robot", "up")
    pathlib.Path("/sys/class/net/fsw-robot/queues/rx-0/rps_cpus").write_text("2")
    dump = WORK / "candump.log"
    with recorder(dump, "vcan-robot"):
        flown("vcan", "--bus", "vcan", "--scenario", short_flights.write_scenario(WORK, "reports"))
    lines = dump.read_text().splitlines()
    assert not [line for line in lines if "DROPCOUNT" in line]
    with open(OUT / "vcan" / "candump.log", "w") as file:
        file.writelines(f"{line}\n" for line in lines if " vcan-" in line)
    assert links() >= {"fsw-robot", "vcan-robot"}, "the interface that existed before was removed"
    assert not links() & {"vcan-joystick", "fsw-joystick"}, "interfaces made by the run still exist"
    ip("link", "delete", "fsw-robot")
    ip("link", "delete", "vcan-robot")
    summary = facts("vcan")
    assert summary["reproducible"] and summary["bus"] == "vcan", summary


def case_frames_of_tools_enter_the_bus():
    process = started("tools", "--bus", "vcan", "--scenario", "none", "--duration", "100000")
    played = WORK / "played.log"
    played.write_text("(0.000000) vcan-robot 7A2##10304\n(0.001000) vcan-robot 7A3#05\n")

    def seen_on_the_bus():
        assert process.poll() is None, process.communicate()[0]
        for frame in ("7A1#0102", "20000040#0000000000000000"):
            subprocess.run(["cansend", "vcan-robot", frame], capture_output=True)
        subprocess.run(["canplayer", "-I", played], capture_output=True)
        return all(has_line("tools", frame) for frame in ("7A1#0102", "20000040#", "7A2##10304", "7A3#05"))

    until(seen_on_the_bus, "frames of tools")
    shut_down(process)
    kept("tools")
    summary = facts("tools")
    assert summary["bus_frames_external"] >= 2 and not summary["reproducible"], summary


COUNTERS = "hk once MANIPULATOR 4712"
ARM_UP = [f"0.0 operator {words}" for words in (
    "state MANIPULATOR PRE_OPERATIONAL", "config MANIPULATOR STAND_ALONE", "state MANIPULATOR SAFE_OPERATIONAL",
    "state MANIPULATOR OPERATIONAL")]


def case_interfaces_that_are_lost_and_made_again_are_used_again():
    """Both interfaces of bus robot are deleted and made again while the simulator is stopped. The manipulator
    detects this when time continues, goes to OFFLINE, and comes up again by command."""
    script = WORK / "again.scn"
    script.write_text("\n".join(["0.0 hand rest", *ARM_UP, "0.0 operator wait-event MANIPULATOR DEVICE_LOST 100000",
                                 "0.0 operator wait-state MANIPULATOR OFFLINE 1", *ARM_UP,
                                 f"0.0 operator {COUNTERS}", "0.0 operator shutdown", ""]))
    process = started("again", "--bus", "vcan", "--scenario", script)
    log = WORK / "again" / "operator.log"
    until(lambda: process.poll() is not None or log.exists() and "MANIPULATOR OPERATIONAL: completed" in log.read_text(), "the arm")
    simulator = next(child for child in command_names(process.pid) if child[1] == "simulator")[0]
    os.kill(simulator, signal.SIGSTOP)
    with socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as tool:
        for name in ("fsw-robot", "vcan-robot"):
            ip("link", "delete", name)
            ip("link", "add", name, "mtu", "72", "type", "vcan")
            ip("link", "set", name, "up")
        tool.bind(("vcan-robot",))
        tool.settimeout(BOUND_S)
        os.kill(simulator, signal.SIGCONT)
        assert tool.recv(16), "the simulator does not publish the bus on the new interface"
        output = process.communicate(timeout=BOUND_S)[0]
    kept("again")
    assert process.returncode == 0, output + (WORK / "again" / "console.log").read_text()
    assert "BUS_LOST: 1 times," in log.read_text(), log.read_text()
    summary = facts("again")
    assert summary["bus_interfaces_lost"] == 2 and not summary["reproducible"], output
    assert "2 calls failed: interface down or removed" in output, output


def case_emulated_controllers_carry_the_classic_mission():
    """Channel B is on a virtual interface, because all controllers are on one bus."""
    ip("link", "add", "spare", "type", "vcan")
    ip("link", "set", "spare", "up")
    bring_up_controllers()
    flown("controllers", "--mission", "classic", "--bus", "can", "--interface", "robot=can0", "--sim-interface", "robot=can1",
          "--interface", "robot-b=spare", "--sim-interface", "robot-b=spare", "--scenario", short_flights.write_scenario(WORK, "classic"))
    summary = facts("controllers")
    assert summary["bus_frames_lost"] == 0 and summary["bus_frames_external"] == 0, summary


def case_a_mission_with_real_devices_flies_without_a_simulator():
    """No device answers on the bus: the mission comes up in wall-clock time, waits, and shuts down."""
    bring_up_controllers()
    output = flown("devices", "--mission", "classic", "--bus", "can", "--interface", "robot=can0", "--scenario", "none",
                 "--duration", "3")
    summary = facts("devices")
    assert summary["time"] == "real", summary
    assert "simulator" not in {process["name"] for process in summary["processes"]}, summary
    assert not summary["reproducible"] and summary["simulated_s"] >= 3, output


def case_a_burst_on_a_controller_is_counted():
    """An emulated controller sends at once, so its queue never fills; netem delays its frames as a real bus would."""
    program = "build/test/unit/fsw/framework/dataflow/test_flow_can_socket"
    bring_up_controllers()
    subprocess.run(["tc", "qdisc", "replace", "dev", "can0", "root", "netem", "limit", "5", "delay", "20ms"], check=True,
                   timeout=BOUND_S)
    try:
        ended = subprocess.run([program], env=dict(os.environ, CAN_CONTROLLERS="can0 can1"), capture_output=True, text=True,
                               timeout=BOUND_S)
    finally:
        subprocess.run(["tc", "qdisc", "del", "dev", "can0", "root"], check=True, timeout=BOUND_S)
    assert ended.returncode == 0 and "a_burst_on_a_controller_is_refused_and_counted:PASS" in ended.stdout, ended.stdout


def case_a_flood_on_the_wire_ends_in_a_safe_state():
    """Another program sends as fast as it can on the controller of the flight software while the arm is in
    operation: the arm goes to its safe state."""
    script = WORK / "up.scn"
    bring_up_controllers()
    script.write_text("".join(f"0.0 operator {words}\n" for words in (
        "state MANIPULATOR PRE_OPERATIONAL", "config MANIPULATOR CLASSIC", "state MANIPULATOR SAFE_OPERATIONAL",
        "state MANIPULATOR OPERATIONAL", COUNTERS, "wait-state MANIPULATOR ERROR_OPERATIONAL 100000", COUNTERS)))
    process = started("flood", "--mission", "classic", "--bus", "can", "--interface", "robot=can0",
                      "--sim-interface", "robot=can1", "--scenario", "none", "--duration", "100000")
    port = WORK / "flood" / "ground.port"
    until(lambda: process.poll() is not None or port.exists() and port.read_text().strip(), "the ground port")
    ground = subprocess.Popen([sys.executable, "-u", "gse/gse", "--port", port.read_text().strip(), "script", script],
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
    assert any(COUNTERS in line for line in ground.stdout), "not in operation"
    flood = subprocess.Popen(["cangen", "can0", "-g", "0", "-i", "-I", "7F0", "-L", "8"], stdout=subprocess.DEVNULL,
                             stderr=subprocess.DEVNULL)
    try:
        until(lambda: process.poll() is not None or has_line("flood", "7F0#"), "the flood")
        until(lambda: process.poll() is not None or ground.poll() is not None, "the arm to secure itself")
        assert ground.returncode == 0, ground.stdout.read()
        output = shut_down(process)
    finally:
        for child in (flood, ground):
            child.kill()
            child.wait()
    kept("flood")
    summary = facts("flood")
    assert summary["bus_frames_external"] > 0 and not summary["reproducible"], output


if __name__ == "__main__":
    cases.run({name: what for name, what in globals().items() if name.removeprefix("case_") in sys.argv[1:]}, BOUND_S)
