# SPDX-License-Identifier: Apache-2.0
"""A flight of the manipulator with drives simulated by the package canopen, in lock-step, and the deviations
that a drive may have."""

import pathlib
import re
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "test/mission"), str(ROOT / "test/conformance")]
import flying  # noqa: E402
import slaves  # noqa: E402
from hirosco_gse import link, session  # noqa: E402
from hirosco_gse.dictionary import STATES, Dictionary  # noqa: E402

MANIPULATOR, SUPERVISOR = 16, 1
STAND_ALONE = 1
NODES = (0x11, 0x12)
LIMIT_S = 600.0  # Wall-clock time; simulated time stands still while a slave computes.
# Reasons of DEVICE_REFUSED.
NOT_BOOTED, TIMEOUT, ABORTED, VALUE, FORMAT, REBOOTED, SILENT = 1, 2, 3, 4, 5, 6, 7


class Ground:
    """A ground user; its wall-clock limits only end waits."""

    def __init__(self, port):
        self.session = session.Session(Dictionary.load(ROOT / "build/generated/rokviss.json"))
        self.stream = link.connect("127.0.0.1", port, LIMIT_S)
        self.stream.settimeout(0.5)

    def pump(self):
        """Send the waiting octets, and read those that have arrived."""
        if self.session.outbox:
            self.stream.sendall(bytes(self.session.outbox))
            self.session.outbox.clear()
        try:
            octets = self.stream.recv(65536)
        except TimeoutError:
            return
        assert octets, "the spacecraft has closed the link"
        self.session.feed(octets)

    def wait(self, condition, what):
        """Wait until the condition holds."""
        end = time.monotonic() + LIMIT_S
        while not condition():
            assert time.monotonic() < end, f"not within {LIMIT_S} s: {what}; state {self.state}, last events {self.events(0)[-3:]}"
            self.pump()

    def command(self, apid, service, subtype, data):
        """Send a telecommand and wait for the end of its verification. Returns the verification."""
        verification = self.session.send(session.Request(apid, service, subtype, bytes(data), f"TC[{service},{subtype}]"))
        self.wait(lambda: verification.is_finished, "end of verification")
        return verification

    def request(self, state):
        """Request a state; returns whether it was reached."""
        return self.command(MANIPULATOR, 129, 1, [STATES.index(state)]).failure is None

    def configure(self):
        """Select the configuration for flying alone; returns whether it was applied."""
        return self.command(MANIPULATOR, 129, 3, [0, STAND_ALONE]).failure is None

    def await_state(self, state):
        """Wait until the manipulator reports a state."""
        self.wait(lambda: self.state == state, state)

    @property
    def state(self):
        """State of the manipulator as last reported."""
        return self.session.states.get(MANIPULATOR)

    def events(self, first):
        """(name, values) of the manipulator's events from number `first` on."""
        return [(report["event"], {name: value[0] for name, value in report["values"].items()})
                for packet, report in self.session.events[first:] if packet.apid == MANIPULATOR]


class SlaveFlight:
    """A flight whose drives are slaves of the package canopen, and its ground user."""

    def __init__(self, directory, interface=None, options=()):
        """interface: SocketCAN interface of the slaves, if the run has one; options: additional options of
        the launcher."""
        scenario = flying.write_scenario(directory / "alone.scn", "0.0 hand rest", "0.0 fault unplug robot")
        tools = flying.free_port()
        self.flight = flying.start(directory / "run", "--scenario", scenario, "--tools", tools, "--duration", 36000, *options)
        self.slaves = None
        try:
            flying.wait_until(lambda: self._has_tools(tools), "a port for tools", LIMIT_S)
            self.slaves = slaves.Slaves(tools, "robot", NODES, interface)
            self.ground = Ground(self.flight.port(LIMIT_S))
        except BaseException:
            self.flight.abandon()
            raise
        self.mark = 0

    def _has_tools(self, port):
        return re.search(rf"127\.0\.0\.1:{port}\b", self.flight.console) is not None

    def drive(self, number):
        """The slave with this node id."""
        return self.slaves.drives[number]

    def replace_drives(self, change=None):
        """Replace the devices by new ones, one of them with a deviation."""
        def begin():
            for number in NODES:
                self.drive(number).reset()
            if change:
                change(self.drive(0x12))
        self.slaves.call(begin)
        self.mark = len(self.ground.session.events)

    def events(self):
        """Events since the last call of replace_drives()."""
        return self.ground.events(self.mark)

    def refusals(self):
        """(node, reason, object, detail) of devices that were not commissioned since the last call of replace_drives()."""
        return [tuple(values.values()) for name, values in self.events() if name == "DEVICE_REFUSED"]

    def close(self):
        """Shut the mission down and end the flight."""
        self.ground.command(SUPERVISOR, 131, 5, [])
        self.ground.stream.close()
        self.flight.wait()
        self.slaves.close()


def fly_without_deviations(flight):
    """Bring two drives without deviations from OFFLINE to OPERATIONAL and back."""
    flight.replace_drives()
    assert flight.ground.request("PRE_OPERATIONAL")
    assert flight.ground.configure()
    assert flight.ground.request("SAFE_OPERATIONAL")
    assert {drive.statusword for drive in flight.slaves.drives.values()} == {slaves.SWITCHED_ON}
    assert flight.ground.request("OPERATIONAL")
    assert {drive.statusword for drive in flight.slaves.drives.values()} == {slaves.ENABLED}
    assert flight.ground.request("SAFE_OPERATIONAL")
    assert {drive.statusword for drive in flight.slaves.drives.values()} == {slaves.SWITCHED_ON}
    assert flight.ground.request("OFFLINE")
    assert flight.events() == []


# --- one deviation each


def late(drive):
    drive.answer_delay = 0.080


def mute(drive):
    drive.answer_delay = 1e9


def other_type(drive):
    drive.overrides[0x1000, 0] = (0x00010192).to_bytes(4, "little")


def other_maker(drive):
    drive.overrides[0x1018, 1] = (0x29C).to_bytes(4, "little")


def other_product(drive):
    drive.overrides[0x1018, 2] = (0x2015).to_bytes(4, "little")


def short_value(drive):
    drive.overrides[0x6076, 0] = (10000).to_bytes(2, "little")


def no_torque(drive):
    drive.overrides[0x6076, 0] = bytes(4)


def without_mapping(drive):
    drive.forget(0x1A01)


def other_mapping(drive):
    drive.overrides[0x1A00, 3] = (0x60780010).to_bytes(4, "little")


def closed(drive):
    drive.refusals[0x6072, 0] = 0x08000022


def reboots_repeatedly(drive):
    drive.boot_again_every = 0.004


def stop_publishing(drive):
    drive.publishes = False


def stop_beating(drive):
    drive.beats = False
