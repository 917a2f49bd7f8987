# SPDX-License-Identifier: Apache-2.0
"""Two on-board computers, joined by a veth: `nodes.py udp` or `nodes.py tipc` selects the carrier of messages
and links."""

import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "test" / "hil" / "guest"), str(ROOT / "test" / "mission")]

import cases
import flying
import lives
import test_mission_fan_out as fan_out

METHOD = sys.argv[1] if len(sys.argv) > 1 else "udp"
OUT = pathlib.Path(os.environ.get("OUT", "."))
NUMBER = {"shm": 0, "tipc": 1, "udp": 2}
REPEATS = int(os.environ.get("LIVES_REPEATS", "0"))
LIMIT_S = 1200  # Ends a wait that would otherwise never end; no test depends on it.
NODES = ("--nodes", 2, "--transport", METHOD)
BOTH = ("JOYSTICK", "MANIPULATOR")
MANIPULATOR, JOYSTICK = 16, 17  # application process ids
OFFLINE, OPERATIONAL, ERROR_OPERATIONAL = 0, 5, 6
SAFELY = {4, 6, 7, 8, 9, OFFLINE}  # states in which drives hold, are secured, or are being shut down


def split_mission():
    """A copy of the tree in which the mission places the joystick on node 1, so that the links go between the
    nodes."""
    tree = OUT / "split"
    if not tree.exists():
        (tree / "descriptors").mkdir(parents=True)
        for name in ("build", "gse", "sim"):
            (tree / name).symlink_to(ROOT / name)
        shutil.copytree(ROOT / "descriptors", tree / "descriptors", dirs_exist_ok=True)
        path = tree / "descriptors" / "missions" / "rokviss.xml"
        text = path.read_text(encoding="utf-8")
        head, tail = text.split('<Subsystem name="JOYSTICK"')
        path.write_text(head + '<Subsystem name="JOYSTICK"' + tail.replace('node="2"', 'node="1"', 1), encoding="utf-8")
    return tree


def run(name):
    """A directory for a run. In the micro-VM it is in /tmp: $OUT does not support memory maps of logs there, and
    the length of the path is limited."""
    directory = pathlib.Path("/tmp" if pathlib.Path("/run/vm").is_dir() else OUT) / name
    shutil.rmtree(directory, ignore_errors=True)
    return directory


def fly(name, *options, **how):
    flight = flying.fly(run(name), *options, limit_s=LIMIT_S, **how)
    assert flight.code == 0, flight.transcript()
    return flight


def assert_equal(one, other):
    for name in flying.TRACED:
        assert one.octets(name) == other.octets(name), f"{name} of {one.directory} and {other.directory}"


def assert_gone(flight):
    """No process, name or namespace is left."""
    flying.assert_clean(flight)
    assert not [path for path in pathlib.Path("/run/netns").glob(f"{flight.identity}.*")]


@contextlib.contextmanager
def frozen(flight):
    """Within the block simulated time stands still, because the simulator is suspended."""
    simulator = flight.children()["simulator"]
    os.kill(simulator, signal.SIGSTOP)
    yield
    os.kill(simulator, signal.SIGCONT)


def begun(name, *options):
    """A flight whose simulated time stands still after the operator's first steps; a flight that ends before
    is repeated."""
    while True:
        flight = flying.start(run(name), *options)
        flying.wait_until(lambda: flight.steps() >= 1 or flight.process.poll() is not None, "the operator's first steps", LIMIT_S)
        simulator = flight.children().get("simulator")
        if simulator:
            os.kill(simulator, signal.SIGSTOP)
            if flight.process.poll() is None and {"joystick", "manipulator"} <= set(flight.children()):
                return flight
            os.kill(simulator, signal.SIGCONT)
        flight.wait(LIMIT_S)
        assert flight.code == 0, flight.transcript()


def wait_for(flight, text):
    """Wait until the operator's log contains the text."""
    path = flight.directory / "operator.log"

    def has():
        assert flight.process.poll() is None, flight.wait(1).transcript()
        return path.exists() and text in path.read_text(encoding="utf-8")

    flying.wait_until(has, f"{text} in the operator's log", LIMIT_S)


def network_of(pid):
    return os.stat(f"/proc/{pid}/ns/net").st_ino


def local_addresses(pid):
    """Local addresses of all sockets in the network namespace of a process."""
    found = set()
    for name in ("tcp", "udp"):
        for line in pathlib.Path(f"/proc/{pid}/net/{name}").read_text().splitlines()[1:]:
            octets = bytes.fromhex(line.split()[1].split(":")[0])
            found.add(".".join(str(octet) for octet in reversed(octets)))
    return found


def methods_accepted(flight):
    """Transfer methods that the reports TM[130,4] contain."""
    # Headers (21 octets), transaction and link (6), then the properties P of docs/services/st130.md, method at 15.
    return [raw[21 + 6 + 15] for _, direction, raw in flight.packets if direction == "TM" and raw[7:9] == b"\x82\x04"]


# --- one mission on two computers ----------------------------------------------------------------------------------

def case_two_nodes_fly_as_one_image():
    """The two-node flight has the same octets; each process is on its node; sockets are bound only to the
    ends of the veth."""
    flight = begun("two", "--scenario", "hil", *NODES, "--links", METHOD)
    pids = flight.children()
    places = {name: network_of(pids[name]) for name in ("supervisor", "communication", "joystick", "manipulator")}
    bound = {name: local_addresses(pids[name]) for name in ("supervisor", "manipulator")}
    listening = local_addresses(flight.process.pid)
    os.kill(pids["simulator"], signal.SIGCONT)
    flight.wait(LIMIT_S)
    assert flight.code == 0, flight.transcript()
    assert places["supervisor"] == places["communication"] != places["joystick"] == places["manipulator"], places
    assert network_of(os.getpid()) not in places.values()
    own = {"supervisor": {"10.0.0.1"}, "manipulator": {"10.0.0.2"}}
    assert bound == ({"supervisor": set(), "manipulator": set()} if METHOD == "tipc" else own), bound
    assert "127.0.0.1" in listening
    assert flight.facts["reproducible"] is True, flight.transcript()
    assert flight.facts["nodes"] == 2
    assert set(methods_accepted(flight)) == {NUMBER[METHOD]}
    assert_gone(flight)
    assert_equal(flight, fly("image", "--scenario", "hil", "--form", "image", "--links", METHOD))


def case_one_node_gives_the_same_octets():
    one = fly("one", "--scenario", "hil", "--transport", METHOD)
    assert_equal(one, fly("shm", "--scenario", "hil", "--form", "image"))
    assert one.facts["transport"] == METHOD


def case_lives_are_those_of_the_image():
    """Stops, kills, hangs and restarts give the same octets as an image, on one computer, and twice on two."""
    path = lives.scenario(OUT / "lives.scn")
    forms = {"image": ("--form", "image"), "one": ("--transport", METHOD), "two": NODES, "again": NODES}
    flights = [lives.fly(run(f"lives-{name}"), path, *options, "--links", METHOD, limit_s=LIMIT_S) for name, options in forms.items()]
    for flight in flights[1:]:
        for name in ("packets.log", *lives.BUS_LOGS):
            assert flight.octets(name) == flights[0].octets(name), f"{name} of {flight.directory}"
        assert_gone(flight)


def case_repetitions_give_the_same_checksum():
    """Stops, kills, hangs and restarts, repeated LIVES_REPEATS times on one computer and on two: each log has the same checksum every time."""
    path, sums = lives.scenario(OUT / "repeats.scn"), set()
    for options in (("--transport", METHOD), NODES):
        for _ in range(REPEATS):
            flight = lives.fly(run("repeat"), path, *options, "--links", METHOD, limit_s=LIMIT_S)
            sums.add(tuple(lives.digest(flight, ("packets.log", *lives.BUS_LOGS)).values()))
            assert len(sums) == 1, options


def case_one_port_feeds_readers_on_both_computers():
    """One reader closes its link, dies and restarts; the other reader loses no sample."""
    judged = fan_out.fly(pathlib.Path(os.environ["SECOND_READER"]), run("shadowed"), *NODES, "--links", METHOD)
    fan_out.judge(judged)
    assert judged.facts["transport"] == METHOD


# --- links between nodes -------------------------------------------------------------------------------------------

def case_shared_memory_is_not_offered_between_nodes():
    """Without the option --links, links use shared memory within a node and the carrier of the messages
    between nodes."""
    within = fly("within", "--scenario", "hil", *NODES)
    assert set(methods_accepted(within)) == {NUMBER["shm"]}
    between = fly("between", "--scenario", "hil", *NODES, root=split_mission())
    assert set(methods_accepted(between)) == {NUMBER[METHOD]}
    assert between.facts["reproducible"] is True, between.transcript()


def case_shared_memory_between_nodes_is_refused():
    lines = [f"0.{step} operator {words}" for step in (1, 2) for words in
             [f"{'state' if step == 1 else 'config'} {name} {'PRE_OPERATIONAL' if step == 1 else 'TELEPRESENCE'}" for name in BOTH]]
    # PUS_FAILURE_LINK_REFUSED.
    lines += ["0.3 operator expect-refusal 0x0409 link open HAND_POSITION", "0.4 operator shutdown"]
    path = flying.write_scenario(OUT / "refused.scn", "0.0 hand rest", *lines)
    flight = fly("refused", "--scenario", path, *NODES, "--links", "shm", root=split_mission())
    assert "transfer method" in flight.console, flight.transcript()


def case_unplugs_between_nodes_give_the_octets_of_an_image():
    """Devices are unplugged while the links go between the nodes; the caller checks the drives."""
    lines = ["0.0 hand rest", "0.2 hand circle 0.1 0.5 1 5 1"]
    for start, bus, device in ((0.3, "joystick", "STICK"), (2.6, "robot", "JOINT1")):
        cut = start + 0.9 + 0.000137
        lines += flying.bring_up(start, tare=False)
        lines += [f"{cut:.6f} fault unplug {bus} {device}"]
        lines += [f"{cut:.6f} operator wait-state {name} OFFLINE 1" for name in BOTH]
        lines += [f"{cut + 0.8:.6f} fault plug {bus} {device}"]
    path = flying.write_scenario(OUT / "unplug.scn", *lines, "4.8 operator shutdown")
    two = fly("unplug", "--scenario", path, *NODES, "--links", METHOD, root=split_mission())
    assert two.facts["reproducible"] is True, two.transcript()
    assert_equal(two, fly("unplug-image", "--scenario", path, "--form", "image", "--links", METHOD))
    shutil.copytree(two.directory, OUT / f"judged-{METHOD}")


# --- a connection that is cut --------------------------------------------------------------------------------------

def set_veth(flight, state):
    subprocess.run(["ip", "-n", f"{flight.identity}.node1", "link", "set", "node1", state], check=True)


def states_reported(flight, apid):
    """(time [ns], state) of each report of its own state by a subsystem: TM[129,2] and TM[129,5]."""
    found = []
    for time_ns, direction, raw in flight.packets:
        if direction == "TM" and int.from_bytes(raw[:2], "big") & 0x7FF == apid and raw[7] == 129:
            found.append((time_ns, raw[22] if raw[8] == 2 else raw[21]))
    return found


def cut_and_mend(name, root):
    """Cut the veth in operation, restore it when the supervisor has reported that a subsystem on the other
    computer is silent, and bring the mission up again by command."""
    directory = run(name)
    lines = flying.bring_up(0.1, tare=False)
    lines += ["1.2 operator wait-event SUPERVISOR SUBSYSTEM_SILENT 1000",
              "1.2 operator wait-event MANIPULATOR OPERATOR_NOTE 100000", "1.2 operator shutdown"]
    path = flying.write_scenario(OUT / f"{name}.scn", "0.0 hand rest", *lines)
    again = [f"0.0 operator state {member} OFFLINE" for member in BOTH] + flying.bring_up(0.0, tare=False)
    again += [f"0.0 operator expect-state {member} OPERATIONAL" for member in BOTH]
    again = flying.write_scenario(OUT / f"{name}-again.scn", *again, "0.0 operator cmd MANIPULATOR.RAISE EVENT=9")
    flight = flying.start(directory, "--scenario", path, *NODES, "--links", METHOD, root=root)
    try:
        wait_for(flight, "state MANIPULATOR OPERATIONAL: completed")
        with frozen(flight):
            set_veth(flight, "down")
        wait_for(flight, "SUBSYSTEM_SILENT")
        with frozen(flight):
            set_veth(flight, "up")
        # Until the computers reach each other again, commands get no answer; then the sequence is repeated.
        end = time.monotonic() + LIMIT_S
        while True:
            done = flying.gse(flight, "script", again, timeout=LIMIT_S)
            if done.returncode == 0 or flight.process.poll() is not None or time.monotonic() > end:
                break
        assert done.returncode == 0, done.stdout + done.stderr + flight.transcript()
        flight.wait(LIMIT_S)
    finally:
        flight.abandon()
    assert flight.code == 0, flight.transcript()
    assert flight.facts["reproducible"] is False
    assert_gone(flight)
    return flight


def after_operation(flight, apid):
    """The reported states from the first OPERATIONAL on, without repeated ones."""
    states = [state for _, state in states_reported(flight, apid)]
    after = states[states.index(OPERATIONAL):]
    return [state for index, state in enumerate(after) if index == 0 or after[index - 1] != state]


def assert_safe_and_again(states, safely):
    """Expect that the first state reported after OPERATIONAL is one of `safely`, that OPERATIONAL was reached
    again, and that the last state is OFFLINE. Reports sent during the cut may be lost."""
    assert states[0] == OPERATIONAL and states[1] in safely, states
    assert OPERATIONAL in states[2:] and states[-1] == OFFLINE, states


def case_members_cut_from_the_supervisor_hold_safely_and_are_brought_up_again():
    flight = cut_and_mend("cut-above", ROOT)
    for apid in (JOYSTICK, MANIPULATOR):
        assert_safe_and_again(after_operation(flight, apid), SAFELY)


def case_members_cut_from_each_other_secure_themselves_and_are_brought_up_again():
    flight = cut_and_mend("cut-between", split_mission())
    # The link becomes stale: the subsystem reacts in that cycle, with or without a supervisor.
    assert_safe_and_again(after_operation(flight, JOYSTICK), {ERROR_OPERATIONAL})
    assert_safe_and_again(after_operation(flight, MANIPULATOR), SAFELY)


if __name__ == "__main__":
    wanted = {f"case_{name}" for name in sys.argv[2:]}  # Without names, all cases are run.
    cases.run({name: what for name, what in globals().items() if not wanted or name in wanted}, 4 * LIMIT_S)
