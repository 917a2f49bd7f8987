# SPDX-License-Identifier: Apache-2.0
"""The joystick on the node of the ground, the arm on the other, and between them a network with delay, jitter and loss
(netem). The network is as fast as the wall clock, so the flight is paced by it."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "mission"))

import cases
import flying
import nodes

ROUND_TRIP_MS = int(os.environ.get("ROUND_TRIP_MS", "20"))
UP_S = 0.4 if ROUND_TRIP_MS <= 20 else 0.4 + 4e-3 * ROUND_TRIP_MS  # When both subsystems become OPERATIONAL: the links have samples by then.
LIMIT_S = 1200  # Ends a wait that would otherwise never end; no test depends on it.
FRAMES = 1000
LOOK_S = 1
NODES = {"link1": "node1", "link2": "node2"}
OPTIONS = ("--nodes", 2, "--delay", ROUND_TRIP_MS, "--time", "real")
LINKS = {"HAND_MOTION", "ROBOT_CONTACT"}


def slow_mission():
    """A copy of the tree with the joystick on node 1 and a mission whose time limits are long enough for the
    slow processes of an emulated machine."""
    tree = nodes.split_mission()
    path = tree / "descriptors" / "missions" / "rokviss.xml"
    text = path.read_text(encoding="utf-8").replace(' hangAfter="10s"', "")
    path.write_text(text.replace("<Subsystem ", '<Subsystem hangAfter="10s" '), encoding="utf-8")
    return tree


def scenario(name, hand, end_s):
    """Write a scenario that brings both subsystems into operation over links with delay, moves the hand, and
    lists the links at the end."""
    # The first sample of a link arrives only after the delay.
    lines = flying.bring_up(0.2, "TELEPRESENCE_REMOTE")[:4] + [f"0.2 operator link open {link}" for link in sorted(LINKS)]
    lines += flying.bring_up(UP_S, "TELEPRESENCE_REMOTE")[4:]
    end = [f"{end_s} operator expect-state {member} OPERATIONAL" for member in nodes.BOTH]
    end += [f"{end_s} operator link list", f"{end_s} operator shutdown"]
    return flying.write_scenario(nodes.OUT / f"{name}.scn", "0.0 hand rest", *hand, *lines, *end)


def netem(flight):
    """Settings and counters of the netem queue at each end of the network with delay; empty before the launcher
    has made the network."""
    found = {}
    for interface, node in NODES.items():
        line = ["ip", "netns", "exec", f"{flight.identity}.{node}", "tc", "-j", "-s", "qdisc", "show", "dev", interface, "root"]
        done = subprocess.run(line, capture_output=True, text=True)
        shown = json.loads(done.stdout) if done.returncode == 0 else []
        if shown and shown[0]["kind"] == "netem":
            found[interface] = shown[0]
    return found


def start(name, path, tree):
    """Start a flight and wait until its network is made."""
    flight = flying.start(nodes.run(name), "--scenario", path, *OPTIONS, root=tree)
    flying.wait_until(lambda: len(netem(flight)) == 2 or flight.process.poll() is not None, "the network with delay", LIMIT_S)
    assert flight.process.poll() is None, flight.wait(1).transcript()
    return flight


def links_listed(flight):
    """Counters of the open links in the operator's last `link list`: link -> counter -> number."""
    steps = [json.loads(line) for line in flight.read("operator.log").splitlines()]
    text = [step["outcome"] for step in steps if step["words"] == ["list"]][-1]
    return {line.split(":")[0]: {name: int(number) for name, number in re.findall(r"(\w+)=(\d+)", line)}
            for line in text.splitlines() if ": open" in line}


def assert_delays(end):
    """Expect that each queue delays by half of the round trip and has passed some frames on and lost
    others."""
    options = end["options"]
    assert [round(1e3 * options["delay"][name], 3) for name in ("delay", "jitter")] == [ROUND_TRIP_MS / 2, ROUND_TRIP_MS / 20], end
    assert options["loss-random"]["loss"] == 0.05, end
    assert end["packets"] > FRAMES and 0.02 < end["drops"] / (end["packets"] + end["drops"]) < 0.1, end


def end_of(flight):
    """Wait for the end of the flight. Returns the last counters of its network that were read before."""
    counters = {}
    while flight.process.poll() is None:
        shown = netem(flight)
        counters = shown if len(shown) == 2 else counters
        time.sleep(LOOK_S)
    flight.wait(LIMIT_S)
    return counters


def judge(flight, counters):
    """Expect that both links had delay and loss, that the readers counted the lost samples, that no error
    ended the operation, and that nothing is left."""
    assert flight.code == 0, flight.transcript()
    nodes.assert_gone(flight)
    assert set(counters) == set(NODES), flight.transcript()
    for end in counters.values():
        assert_delays(end)
    assert flight.facts["relay"] == {"round_trip_ms": ROUND_TRIP_MS, "network": True}
    assert flight.facts["reproducible"] is False
    links = links_listed(flight)
    assert set(links) == LINKS, links
    for counted in links.values():
        assert 0.02 < counted["lost"] / counted["sent"] < 0.1 and counted["received"] > 0.9 * counted["sent"], links
    for apid in (nodes.JOYSTICK, nodes.MANIPULATOR):
        states = [state for _, state in nodes.states_reported(flight, apid)]
        assert nodes.OPERATIONAL in states and nodes.ERROR_OPERATIONAL not in states, states


def case_frames_between_nodes_pass_netem():
    flight = start("delay", scenario("delay", [], 1.4), slow_mission())
    try:
        counters = end_of(flight)
    finally:
        flight.abandon()
    judge(flight, counters)


def case_the_arm_presses_through_netem():
    """A second flight on the same machine has its own network; when the launcher of the second flight is
    killed, only that network disappears. The caller checks the contact."""
    hand = ["2.0 hand move 0.28 -0.020 1.6", "3.6 hand press 15 0.02", "5.0 hand hold"]
    tree, path = slow_mission(), scenario("delay-press", hand, 5.6)
    killed = start("delay-killed", path, tree)
    flight = start("delay-press", path, tree)
    try:
        killed.process.kill()
        killed.wait(LIMIT_S)
        nodes.assert_gone(killed)
        assert len(netem(flight)) == 2, flight.transcript()
        counters = end_of(flight)
    finally:
        flight.abandon()
        killed.abandon()
    judge(flight, counters)
    shutil.copytree(flight.directory, nodes.OUT / "judged")


def case_the_arm_holds_contact_through_netem():
    """The hand presses with 15 N and then holds for 5 s. The caller compares the hold with the bounds of this delay."""
    times = [UP_S + offset for offset in (1.6, 3.2, 5.2, 10.2)]
    hand = [f"{times[0]} hand move 0.28 -0.020 1.6", f"{times[1]} hand press 15 0.02", f"{times[2]} hand hold"]
    flight = start("delay-hold", scenario("delay-hold", hand, times[3]), slow_mission())
    try:
        counters = end_of(flight)
    finally:
        flight.abandon()
    shutil.copytree(flight.directory, nodes.OUT / "judged")
    judge(flight, counters)


if __name__ == "__main__":
    wanted = [f"case_{name}" for name in sys.argv[1:]]
    cases.run({name: what for name, what in globals().items() if name in wanted}, 2 * LIMIT_S)
