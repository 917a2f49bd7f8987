# SPDX-License-Identifier: Apache-2.0
"""The flight side's master against slaves that it does not know: PyPI canopen's LocalNode, in lock-step with the flight.

One flight of the manipulator with its own drives unplugged. In each case a drive is strange in one way; the outcome is an
event that names node and reason, and a state that is known. In between, and at the end, two good drives are flown."""

import pathlib
import re
import socket
import sys
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "test/mission"), str(ROOT / "test/conformance")]
import flying  # noqa: E402
import slaves  # noqa: E402
from hirosco_gse import link, session  # noqa: E402
from hirosco_gse.dictionary import STATES, Dictionary  # noqa: E402

MANIPULATOR, SUPERVISOR = 16, 1
STAND_ALONE = 1
NODES = (0x11, 0x12)
LIMIT_S = 60.0  # Wall-clock; simulated time stands still while a slave thinks.
NOT_BOOTED, TIMEOUT, ABORTED, VALUE, FORMAT, REBOOTED, SILENT = 1, 2, 3, 4, 5, 6, 7


def free_port():
    """A port that nobody listens on."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


class Ground:
    """A ground user who waits by the clock on the wall only to give up."""

    def __init__(self, port):
        self.session = session.Session(Dictionary.load(ROOT / "build/generated/rokviss.json"))
        self.stream = link.connect("127.0.0.1", port, 10.0)
        self.stream.settimeout(0.5)

    def pump(self):
        """Send what waits, take in what has come."""
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
        """Until the condition holds."""
        end = time.monotonic() + LIMIT_S
        while not condition():
            assert time.monotonic() < end, f"{what} within {LIMIT_S} s; {self.state}, {self.events(0)[-3:]}"
            self.pump()

    def command(self, apid, service, subtype, data):
        """Send a telecommand; its verification at the end."""
        verification = self.session.send(session.Request(apid, service, subtype, bytes(data), f"TC[{service},{subtype}]"))
        self.wait(lambda: verification.is_finished, "end of verification")
        return verification

    def request(self, state):
        """Request a state; whether it was reached."""
        return self.command(MANIPULATOR, 129, 1, [STATES.index(state)]).failure is None

    def configure(self):
        """Select the configuration for flying alone; whether it was applied."""
        return self.command(MANIPULATOR, 129, 3, [0, STAND_ALONE]).failure is None

    def await_state(self, state):
        """Until the manipulator reports a state."""
        self.wait(lambda: self.state == state, state)

    @property
    def state(self):
        """State of the manipulator as last reported."""
        return self.session.states.get(MANIPULATOR)

    def events(self, first):
        """(name, severity, values) of the manipulator's events from number `first` on."""
        return [(told["event"], {name: value[0] for name, value in told["values"].items()})
                for packet, told in self.session.events[first:] if packet.apid == MANIPULATOR]


class Stage:
    """The flight, the ground and the slaves."""

    def __init__(self, folder):
        scenario = flying.write_scenario(folder / "alone.scn", "0.0 hand rest", "0.0 fault unplug robot")
        tools = free_port()
        self.flight = flying.start(folder / "run", "--scenario", scenario, "--tools", tools, "--duration", 36000)
        self.slaves = None
        try:
            flying.wait_until(lambda: self._has_tools(tools), LIMIT_S, "no port for tools")
            self.slaves = slaves.Slaves(tools, "robot", NODES)
            self.ground = Ground(self.flight.port())
        except BaseException:
            self.flight.abandon()
            raise
        self.mark = 0

    def _has_tools(self, port):
        return re.search(rf"127\.0\.0\.1:{port}\b", self.flight.console) is not None

    def drive(self, number):
        """A slave."""
        return self.slaves.drives[number]

    def play(self, change=None):
        """New devices, changed in one way."""
        def begin():
            for number in NODES:
                self.drive(number).reset()
            if change:
                change(self.drive(0x12))
        self.slaves.call(begin)
        self.mark = len(self.ground.session.events)

    def events(self):
        """Events since the last play."""
        return self.ground.events(self.mark)

    def refusals(self):
        """(node, reason, object, detail) of devices that were not commissioned since the last play."""
        return [tuple(values.values()) for name, values in self.events() if name == "DEVICE_REFUSED"]

    def close(self):
        """Shut down and end."""
        self.ground.command(SUPERVISOR, 131, 5, [])
        self.ground.stream.close()
        self.flight.wait()
        self.slaves.close()


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    """The one flight of this file."""
    opened = Stage(tmp_path_factory.mktemp("strange"))
    yield opened
    try:
        opened.close()
    finally:
        opened.flight.abandon()
    assert opened.flight.code == 0, opened.flight.told()
    flying.assert_clean(opened.flight)


@pytest.fixture
def down(stage):
    """Ends each case as an operator would: everything off, and nothing stays behind."""
    yield
    if stage.ground.state != "OFFLINE":
        assert stage.ground.request("OFFLINE")
    stage.ground.await_state("OFFLINE")


def fly_good_ones(stage):
    """Two good drives from OFFLINE to OPERATIONAL and back."""
    stage.play()
    assert stage.ground.request("PRE_OPERATIONAL")
    assert stage.ground.configure()
    assert stage.ground.request("SAFE_OPERATIONAL")
    assert {drive.statusword for drive in stage.slaves.drives.values()} == {slaves.SWITCHED_ON}
    assert stage.ground.request("OPERATIONAL")
    assert {drive.statusword for drive in stage.slaves.drives.values()} == {slaves.ENABLED}
    assert stage.ground.request("SAFE_OPERATIONAL")
    assert {drive.statusword for drive in stage.slaves.drives.values()} == {slaves.SWITCHED_ON}
    assert stage.ground.request("OFFLINE")
    assert stage.events() == []


def test_good_devices_are_commissioned_and_flown(stage, down):
    fly_good_ones(stage)


def late(drive):
    drive.answer_delay = 0.080


def mute(drive):
    drive.answer_delay = 1e9


def other_type(drive):
    drive.overrides[0x1000, 0] = (0x00010192).to_bytes(4, "little")


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


def restless(drive):
    drive.boot_again_every = 0.004


@pytest.mark.parametrize("strange, told", [
    (late, (0x12, TIMEOUT, 0x100000, 0)),
    (mute, (0x12, TIMEOUT, 0x100000, 0)),
    (other_type, (0x12, VALUE, 0x100000, 0x00010192)),
    (short_value, (0x12, FORMAT, 0x607600, 0)),
    (no_torque, (0x12, VALUE, 0x607600, 0)),
    (without_mapping, (0x12, ABORTED, 0x1A0100, 0x06020000)),
    (other_mapping, (0x12, VALUE, 0x1A0003, 0x60780010)),
    (closed, (0x12, ABORTED, 0x607200, 0x08000022)),
    (restless, (0x12, REBOOTED, 0, 0)),
])
def test_a_strange_device_is_not_brought_up(stage, down, strange, told):
    stage.play(strange)
    assert not stage.ground.request("PRE_OPERATIONAL")
    assert stage.refusals() == [told]
    stage.ground.await_state("OFFLINE")


def test_a_device_that_does_not_boot_is_named_and_given_up(stage, down):
    def dead(drive):
        drive.boots = drive.beats = False
    stage.play(dead)
    assert not stage.ground.request("PRE_OPERATIONAL")
    assert stage.refusals() == [(0x12, NOT_BOOTED, 0, 0)]
    stage.ground.await_state("OFFLINE")


@pytest.mark.parametrize("index, code", [(0x6060, 0x06090030), (0x1400, 0x08000022)])
def test_a_setting_that_is_refused_leaves_it_unconfigured(stage, down, index, code):
    stage.play()
    assert stage.ground.request("PRE_OPERATIONAL")
    subindex = 0 if index == 0x6060 else 1
    stage.slaves.call(lambda: stage.drive(0x11).refusals.update({(index, subindex): code}))
    assert not stage.ground.configure()
    assert stage.refusals() == [(0x11, ABORTED, index << 8 | subindex, code)]
    assert stage.ground.state == "PRE_OPERATIONAL"
    assert not stage.ground.request("SAFE_OPERATIONAL")


def test_silence_after_the_start_of_process_data(stage, down):
    def shy(drive):
        drive.publishes = False
    stage.play(shy)
    assert stage.ground.request("PRE_OPERATIONAL")
    assert not stage.ground.configure()
    assert stage.refusals() == [(0x12, SILENT, 0, 0)]
    assert stage.ground.state == "PRE_OPERATIONAL"
    stage.ground.wait(lambda: stage.drive(0x11).state == slaves.PRE_OPERATIONAL, "process data stopped at the good one")


def stop_publishing(drive):
    drive.publishes = False


def stop_beating(drive):
    drive.beats = False


def boot(drive):
    drive.boot_again_every = 0.004


@pytest.mark.parametrize("reached, change", [
    ("PRE_OPERATIONAL", stop_beating),
    ("PRE_OPERATIONAL", boot),
    ("SAFE_OPERATIONAL", stop_publishing),
    ("SAFE_OPERATIONAL", boot),
    ("OPERATIONAL", stop_publishing),
    ("OPERATIONAL", stop_beating),
])
def test_a_device_that_is_lost_later_is_named_and_all_becomes_safe(stage, down, reached, change):
    stage.play()
    assert stage.ground.request("PRE_OPERATIONAL")
    if reached != "PRE_OPERATIONAL":
        assert stage.ground.configure()
        assert stage.ground.request("SAFE_OPERATIONAL")
    if reached == "OPERATIONAL":
        assert stage.ground.request("OPERATIONAL")
    seen = []
    stage.ground.session.listeners.append(lambda packet, told: seen.append(stage.ground.state))
    stage.slaves.call(lambda: change(stage.drive(0x12)))
    stage.ground.await_state("OFFLINE")  # By the recovery plan.
    stage.ground.session.listeners.pop()
    assert "ERROR_OPERATIONAL" in seen
    assert [event for event in stage.events() if event[0] == "DEVICE_LOST"] == [("DEVICE_LOST", {"NODE": 0x12})]
    assert {drive.statusword for drive in stage.slaves.drives.values()} == {slaves.SWITCH_ON_DISABLED}


def test_a_better_device_is_taken_afterwards(stage, down):
    fly_good_ones(stage)
