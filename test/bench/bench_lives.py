# SPDX-License-Identifier: Apache-2.0
"""Deaths and hangs in wall-clock time: how fast they are detected and repaired, and how long other components wait.

    hang_found_*          a stopped joystick, until the supervisor raises PROCESS_HUNG; baseline: 40 ms
    hang_others_wait_*    the longest round trip of a ping of the manipulator around the hang; baseline: 50 ms
    supervisor_back       a killed supervisor, until its successor reports that it has taken over; baseline: 200 ms
    restart_to_ready      a killed joystick, until its next life answers a ping; baseline: 200 ms

Baselines are the required values. Values are medians over the rounds. Each round is a flight of processes, with
TIME=real (rows `_real`) or TIME=free (rows `_free` and those of killed processes). With TIME=free the supervisor
allows each process 200 ms more, because of the machine's other work. The instant of the fault is on the machine's
clock; the fastest ping gives its offset to the run's clock."""

import os
import pathlib
import shutil
import signal
import statistics
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / directory) for directory in ("test/mission", "test/conformance/pus", "gse")]

import failures
import flying
import station as stations
from hirosco_gse import packets

ROUNDS = 5
DIRECTORY = ROOT / "runs" / "bench-lives"
JOYSTICK, MANIPULATOR, SUPERVISOR = 17, 16, 1
PROCESS_HUNG, SUPERVISOR_RESTARTED = 30, 20  # Ids of events, descriptors/subsystems/supervisor.xml.
PING_ANSWER = (17, 2)
MS = 1e6


class Round:
    """A flight with both members in PRE_OPERATIONAL. kind: TIME of the flight."""

    def __init__(self, kind):
        shutil.rmtree(DIRECTORY, ignore_errors=True)
        self.flight = flying.start(DIRECTORY, "--time", kind, "--scenario", "none")
        self.station = stations.Station(self.flight, stations.Notes())
        # Time on the machine's clock [ns] of each ping of the manipulator and of each answer.
        self.pings, self.sent, self.heard = [], [], []
        self.station.session.listeners.append(self._note)
        try:
            self.bring_up()
        except AssertionError:
            self.flight.abandon()
            raise

    def bring_up(self):
        """Bring both members to PRE_OPERATIONAL, with a configuration."""
        for name in ("JOYSTICK", "MANIPULATOR"):
            self.station.do(name, 17, 1)
            self.station.command("state", name, "PRE_OPERATIONAL")
            self.station.command("config", name, "TELEPRESENCE")

    def _note(self, packet, _):
        if packet.message == PING_ANSWER and packet.apid == MANIPULATOR:
            self.heard.append(time.monotonic_ns())

    def ping(self, count):
        """Send pings to the manipulator, 5 ms apart, without waiting for the answers."""
        for _ in range(count):
            self.sent.append(time.monotonic_ns())
            self.pings.append(self.station.send("MANIPULATOR", 17, 1))
            self.station.listen(0.005)

    def cause_fault(self, name, number):
        """Cause the fault between pings. Returns the instant [ns] on the machine's clock."""
        self.ping(40)
        at_ns = time.monotonic_ns()
        os.kill(self.flight.children()[name], number)
        self.ping(100)
        return at_ns

    def wait_for(self, name):
        """Ping a component until it answers."""
        while True:
            ping = self.station.send(name, 17, 1)
            self.station.listen(0.005)
            if 7 in ping.stages:
                return

    def end(self):
        """End the flight. Returns the packets with their times [ns of the run], the offset from the machine's
        clock to the clock of the run, and the longest wait for an answer [ns on the machine's clock]."""
        try:
            self.station.wait(lambda: all(ping.is_finished for ping in self.pings), "the end of each ping")
        except AssertionError:
            self.flight.abandon()
            raise
        self.station.close()
        self.flight.process.send_signal(signal.SIGINT)
        self.flight.wait()
        reports = [(at, packets.parse(raw)) for at, _, raw in self.flight.packets]
        shutil.rmtree(DIRECTORY, ignore_errors=True)
        arrived = [at for at, p in reports if p.direction == "TC" and p.apid == MANIPULATOR and p.message == (17, 1)][-len(self.sent) :]
        offset_ns = min(at - sent for at, sent in zip(arrived, self.sent, strict=True))
        return reports, offset_ns, max(heard - sent for sent, heard in zip(self.sent, self.heard, strict=False))


def first(reported, since_ns, apid, what):
    """Time of the first report of an application process after `since_ns` for which `what` is true."""
    return next(at for at, p in reported if at > since_ns and p.direction == "TM" and p.apid == apid and what(p))


def is_event(event_id, values=b""):
    """A condition that is true for packets that report this event with values that begin with these octets."""
    return lambda p: p.service == 5 and int.from_bytes(p.data[:2], "big") == event_id and p.data[2:].startswith(values)


def hang(kind):
    """(time until the hang is found, longest wait of other requests) [ms]."""
    flown = Round(kind)
    at_ns = flown.cause_fault("joystick", signal.SIGSTOP)
    reported, offset_ns, wait_ns = flown.end()
    since_ns = at_ns + offset_ns
    return (first(reported, since_ns, SUPERVISOR, is_event(PROCESS_HUNG, JOYSTICK.to_bytes(2, "big"))) - since_ns) / MS, wait_ns / MS


def death(name, apid, what):
    """Time from the kill to the first report for which `what` is true [ms]."""
    flown = Round("free")
    since_ns = flown.cause_fault(name, signal.SIGKILL)
    flown.wait_for(name.upper())
    reported, offset_ns, _ = flown.end()
    return (first(reported, since_ns + offset_ns, apid, what) - since_ns - offset_ns) / MS


def rounds(measure, *words):
    """Values of the rounds; a round that other work of the machine disturbs is reported and flown again, a
    few times."""
    values, spoilt = [], 0
    while len(values) < ROUNDS:
        try:
            values.append(measure(*words))
        except AssertionError as error:
            spoilt += 1
            print(f"  a round of {measure.__name__} {words[0]} was disturbed and is flown again: {str(error).splitlines()[0][:120]}", flush=True)
            if spoilt > ROUNDS:
                raise
    return values


def print_row(name, values, bound):
    """Print a row whose baseline is the bound."""
    ratios = [value / bound for value in values]
    print(f"BENCH {name} {statistics.median(values):.3f} ms {bound} {statistics.median(ratios):.3f} {min(ratios):.3f} {max(ratios):.3f}")


def main():
    """Fly the rounds and print the BENCH lines."""
    for kind in ("real", "free"):
        found = rounds(hang, kind)
        print_row(f"hang_found_{kind}", [value for value, _ in found], 40)
        print_row(f"hang_others_wait_{kind}", [value for _, value in found], 50)
    print_row("supervisor_back", rounds(death, "supervisor", SUPERVISOR, is_event(SUPERVISOR_RESTARTED)), 200)
    print_row("restart_to_ready", rounds(death, "joystick", JOYSTICK, lambda p: p.message == PING_ANSWER), 200)


if __name__ == "__main__":
    failures.run(main)
