# SPDX-License-Identifier: Apache-2.0
"""The Python package canopen as master of the simulated devices, in lock-step with the simulator.

CANOPEN_INTERFACES=vcan-: this program creates the interfaces vcan-robot and vcan-joystick, the simulator
publishes its buses there, and all frames pass through them; candump records vcan-robot into $OUT. Without the
variable the frames pass through the simulator's own port, which works on any kernel. The arguments select cases; without
arguments all run."""

import contextlib
import os
import pathlib
import subprocess
import sys
import threading

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "test/conformance"), str(ROOT / "test/hil/guest")]

import canopen
import cases
import lock_step
import simulated
from canopen.profiles.p402 import BaseNode402
from simulated import until

PREFIX = os.environ.get("CANOPEN_INTERFACES", "")
OUT = pathlib.Path(os.environ["OUT"])
BUSES = ("robot", "joystick")
SYNC, HEARTBEAT = 0x080, 0x700
STEPS_PER_CYCLE = 4  # 2 ms
SENTINEL = 0x7FF


class Master:
    """The master of one bus: the network, the bus in lock-step, and the functions that are called in each
    cycle."""

    def __init__(self, port, bus):
        interface = PREFIX + bus if PREFIX else None
        self.bus = lock_step.LockStepBus(port, bus, interface, STEPS_PER_CYCLE)
        self.network = canopen.Network(self.bus)
        self.cyclic = []  # Functions that are called in each cycle before SYNC is sent; empty: no SYNC.
        self.bus.on_step.append(self._step)
        self.network.connect()

    def _step(self, now):
        del now
        if self.cyclic:
            for function in list(self.cyclic):
                function()
            self.network.send_message(SYNC, [])

    def pass_steps(self, count):
        """Let simulated time pass in steps of 0.5 ms."""
        wanted = self.bus.steps + count
        until(lambda: self.bus.steps >= wanted, f"{count} steps")

    def drive(self, number, sheet="joint-drive"):
        """Add a CiA 402 node with long time-outs; it replaces an earlier node with this number."""
        node = simulated.patient(BaseNode402(number, str(simulated.SHEETS / f"{sheet}.eds")))
        self.network[number] = node
        return node

    @contextlib.contextmanager
    def cycles(self, *functions):
        """Within the block, call these functions and send SYNC in every cycle."""
        self.cyclic[:] = functions or (lambda: None,)
        try:
            yield
        finally:
            self.cyclic.clear()
            self.pass_steps(2 * STEPS_PER_CYCLE)


class World:
    """The simulator, the master of one bus at a time, and the recorder."""

    def __init__(self):
        self.recorder = None
        options = []
        for bus in BUSES if PREFIX else ():
            interface = PREFIX + bus
            subprocess.run(["ip", "link", "add", interface, "mtu", "72", "type", "vcan"], check=True)
            subprocess.run(["ip", "link", "set", interface, "up"], check=True)
            options += ["--publish", f"{bus}=can:{interface}"]
        if PREFIX:
            self._record()
        self.simulator = simulated.Simulator(OUT, *options)
        self.bus, self._master = None, None

    def master(self, bus):
        """The master of a bus. Only one exists at a time: the simulator waits for each master that is connected."""
        if self.bus != bus:
            self._leave()
            self.bus, self._master = bus, Master(self.simulator.port, bus)
        return self._master

    def _leave(self):
        if self._master:
            self._master.network.disconnect()

    def _record(self):
        self.log = OUT / "candump.log"
        with open(self.log, "w") as file:
            self.recorder = subprocess.Popen(
                ["candump", "-L", "-d", "-r", "33554432", f"{PREFIX}robot"], stdout=file, stdin=subprocess.DEVNULL)
        self._mark()

    def _mark(self):
        """Send a frame that no device uses until it is in the log: all earlier frames are then in the log."""
        marks = self.log.read_text().count(f" {SENTINEL:03X}#")

        def seen():
            subprocess.run(["cansend", f"{PREFIX}robot", f"{SENTINEL:03X}#FF"], check=True)
            return self.log.read_text().count(f" {SENTINEL:03X}#") > marks
        until(seen, "the sentinel in candump's log")

    def close(self):
        self._leave()
        self.simulator.close()
        if self.recorder:
            self._mark()
            self.recorder.terminate()
            self.recorder.wait()


def refusal(call, *arguments):
    """SDO abort code of an access; 0 if it succeeded."""
    try:
        call(*arguments)
    except canopen.SdoAbortedError as aborted:
        return aborted.code
    return 0


def case_scan_finds_the_nodes_of_each_bus():
    for bus, numbers in (("robot", [0x11, 0x12]), ("joystick", [0x21])):
        master = WORLD.master(bus)
        master.pass_steps(20)
        master.network.scanner.reset()
        master.network.scanner.search()
        until(lambda: len(master.network.scanner.nodes) >= len(numbers), "all nodes answer")
        master.pass_steps(20)
        assert sorted(master.network.scanner.nodes) == numbers


def case_sdo_transfers_are_expedited_and_segmented_in_both_directions():
    drive = WORLD.master("robot").drive(0x11)
    assert drive.sdo[0x1000].raw == 0x00020192
    assert drive.sdo[0x1008].raw == "hirosco joint drive JD-40"
    for text in ("x", "seven77", "a tag longer than one segment of seven", "y" * 64):
        drive.sdo[0x2300].raw = text
        assert drive.sdo[0x2300].raw == text
    drive.sdo[0x2310].raw = 0x0123456789ABCDEF
    assert drive.sdo[0x2310].raw == 0x0123456789ABCDEF
    drive.sdo[0x1017].raw = 20
    assert drive.sdo[0x1017].raw == 20


def case_sdo_accesses_end_with_the_abort_codes_of_cia_301():
    drive = WORLD.master("robot").drive(0x11)
    for index, subindex, data, code in (
        (0x5000, 0, None, 0x06020000),
        (0x1018, 9, None, 0x06090011),
        (0x1000, 0, b"\0\0\0\0", 0x06010002),
        (0x6060, 0, b"\x01", 0x06090030),
        (0x1017, 0, b"\0", 0x06070013),
        (0x1017, 0, b"\0\0\0\0", 0x06070012),
        (0x2300, 0, b"z" * 65, 0x06070012),
        (0x1A00, 1, b"\x20\0\x64\x60", 0x08000022),
    ):
        call = (drive.sdo.upload, index, subindex) if data is None else (drive.sdo.download, index, subindex, data)
        assert refusal(*call) == code, f"{index:04X}:{subindex:02X}: {refusal(*call):08X}"
    assert drive.sdo[0x1017].raw == 20


def case_mappings_are_read_from_the_devices():
    drive = WORLD.master("robot").drive(0x12)
    drive.pdo.read()
    mapped = {pdo.cob_id: ([variable.index for variable in pdo], pdo.trans_type, pdo.enabled)
              for pdo in (*drive.rpdo.values(), *drive.tpdo.values())}
    assert mapped == {
        0x212: ([0x6040, 0x607A, 0x60B2], 1, True),
        0x312: ([0x6040, 0x6071, 0x60FF], 1, False),
        0x192: ([0x6041, 0x6064, 0x6077], 1, True),
        0x292: ([0x606C, 0x6078, 0x2210], 20, True),
    }, mapped
    stick = WORLD.master("joystick").drive(0x21, "joystick")
    stick.pdo.read()
    assert [variable.index for variable in stick.tpdo[1]] == [0x6064, 0x6864]
    assert [variable.index for variable in stick.rpdo[1]] == [0x6071, 0x6871, 0x6040, 0x6840]


def case_heartbeat_and_boot_up_are_received():
    master = WORLD.master("robot")
    drive = master.drive(0x12)
    seen, steps = [], []

    def hear(state):
        seen.append(state)
        steps.append(master.bus.steps)

    drive.nmt.add_heartbeat_callback(hear)
    for state, number in (("OPERATIONAL", 5), ("STOPPED", 4), ("PRE-OPERATIONAL", 127)):
        drive.nmt.state = state
        until(lambda: seen and seen[-1] == number, state)
    mark = len(seen)
    drive.nmt.state = "RESET"
    until(lambda: 0 in seen[mark:], "boot-up")
    boot = seen.index(0, mark)
    until(lambda: len(seen) > boot + 11, "heartbeats")
    assert set(seen[boot + 1 : boot + 12]) == {127}
    assert 390 <= steps[boot + 11] - steps[boot + 1] <= 410  # One in 20 ms of simulated time, which is 40 steps.


def case_a_drive_reports_that_its_master_falls_silent():
    master = WORLD.master("robot")
    drive = master.drive(0x12)
    drive.rpdo.read()
    drive.sdo[0x1400][5].raw = 5
    drive.nmt.state = "OPERATIONAL"
    drive.rpdo[1].transmit()
    until(lambda: drive.emcy.log, "an emergency")
    assert drive.emcy.log[-1].code == 0x8250  # No RPDO has arrived.
    assert drive.emcy.log[-1].register == 0x11
    assert drive.sdo[0x1003][1].raw & 0xFFFF == 0x8250
    drive.nmt.state = "RESET"
    master.pass_steps(20)


def prepared(master, mode):
    """Joint 1 in NMT OPERATIONAL and in this mode of operation, with the PDO configuration read from it."""
    drive = master.drive(0x11)
    drive.nmt.state = "PRE-OPERATIONAL"
    drive.sdo[0x1400][5].raw = 0  # RPDO deadline off: this master does not run in real time.
    drive.sdo[0x6060].raw = mode
    drive.setup_402_state_machine()
    drive.rpdo[1]["Controlword"].raw = 0
    drive.nmt.state = "OPERATIONAL"
    return drive


def case_a_drive_passes_the_states_of_cia_402_to_operation_enabled_and_back():
    master = WORLD.master("robot")
    drive = prepared(master, 8)
    states_seen = []
    drive.tpdo[1].add_callback(lambda tpdo: states_seen.append(drive.state))
    with master.cycles(drive.rpdo[1].transmit):
        until(lambda: states_seen, "TPDO1")
        assert drive.state == "SWITCH ON DISABLED"
        drive.state = "READY TO SWITCH ON"
        drive.state = "SWITCHED ON"
        drive.rpdo[1]["Target position"].raw = drive.tpdo[1]["Position actual value"].raw
        drive.rpdo[1]["Torque offset"].raw = 590
        drive.state = "OPERATION ENABLED"
        master.pass_steps(40)
        assert drive.state == "OPERATION ENABLED" and drive.sdo[0x2220].raw == 0  # The brake is open.
        drive.state = "SWITCHED ON"
        assert drive.sdo[0x2220].raw == 1
        drive.state = "SWITCH ON DISABLED"
        drive.rpdo[1]["Controlword"].raw = 0
        master.pass_steps(40)
    assert [state for number, state in enumerate(states_seen) if number == 0 or state != states_seen[number - 1]] == [
        "SWITCH ON DISABLED", "READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED", "SWITCHED ON", "SWITCH ON DISABLED"]


def case_joint_moves_in_cyclic_synchronous_position():
    master = WORLD.master("robot")
    drive = prepared(master, 8)
    ramp = threading.Event()
    targets = []

    def command():
        if ramp.is_set() and len(targets) < 100:
            targets.append(start + 200 * (len(targets) + 1))
            drive.rpdo[1]["Target position"].raw = targets[-1]
        drive.rpdo[1].transmit()

    with master.cycles(command):
        until(lambda: drive.tpdo[1].is_received, "TPDO1")
        drive.state = "SWITCHED ON"
        start = drive.tpdo[1]["Position actual value"].raw
        drive.rpdo[1]["Target position"].raw = start
        drive.rpdo[1]["Torque offset"].raw = 590
        drive.state = "OPERATION ENABLED"
        ramp.set()
        until(lambda: len(targets) == 100, "a ramp of 0.2 s")
        master.pass_steps(400)
        moved = drive.tpdo[1]["Position actual value"].raw - start
        drive.state = "SWITCH ON DISABLED"
        drive.rpdo[1]["Controlword"].raw = 0
        master.pass_steps(40)
    assert abs(moved - 20000) < 1500, f"{moved} urad instead of 20000"


def case_axes_of_the_joystick_are_commanded_separately():
    master = WORLD.master("joystick")
    stick = master.drive(0x21, "joystick")
    stick.pdo.read()
    stick.sdo[0x1400][5].raw = 0
    stick.nmt.state = "OPERATIONAL"
    for first, second in ((0x06, 0x06), (0x07, 0x07), (0x0F, 0x07)):
        stick.rpdo[1][0x6040].raw, stick.rpdo[1][0x6840].raw = first, second
        with master.cycles(stick.rpdo[1].transmit):
            master.pass_steps(6 * STEPS_PER_CYCLE)
    assert stick.tpdo[2][0x6041].raw & 0x6F == 0x27
    assert stick.tpdo[2][0x6841].raw & 0x6F == 0x23
    stick.nmt.state = "PRE-OPERATIONAL"


def case_simulator_and_recorder_end_without_error():
    WORLD.close()


if __name__ == "__main__":
    sys.setswitchinterval(0.0005)  # The default of 5 ms delays each switch between the threads.
    WORLD = World()
    cases.run({name: what for name, what in globals().items() if not sys.argv[1:] or name.removeprefix("case_") in sys.argv[1:]})
