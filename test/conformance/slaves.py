# SPDX-License-Identifier: Apache-2.0
"""Joint drives made from PyPI canopen's LocalNode, in simulated time; without deviations unless a test sets
some.

SDO server, object dictionary and PDO packing are those of canopen; the states of the drive, NMT, SYNC and
heartbeat are implemented here, because those of canopen run in wall-clock time."""

import contextlib
import pathlib
import threading

import canopen
import lock_step

SHEETS = pathlib.Path(__file__).resolve().parents[2] / "descriptors/devices"
SYNC, NMT, BOOT_UP, HEARTBEAT_S = 0x080, 0x000, 0x700, 0.020
OPERATIONAL, PRE_OPERATIONAL, STOPPED = 5, 127, 4
START, STOP, PREPARE, RESET_NODE, RESET_COMMUNICATION = 1, 2, 128, 129, 130
SWITCH_ON_DISABLED, READY, SWITCHED_ON, ENABLED = 0x250, 0x231, 0x233, 0x1237
SLOW_SYNCS = 20


class Slaves:
    """Drives on one bus of a simulator, in lock-step with it."""

    def __init__(self, port, bus, numbers, interface=None):
        self.bus = lock_step.LockStepBus(port, bus, interface)
        self.network = canopen.Network(self.bus)
        self.drives = {number: Drive(self.network, number) for number in numbers}
        self.calls = []  # (function, event): what the thread of the bus calls next.
        self.failure = None
        self.bus.on_step.append(self._step)
        self.network.connect()

    def _step(self, now):
        while self.calls:
            function, done = self.calls.pop(0)
            try:
                function()
            except Exception as failure:  # The caller gets the exception.
                self.failure = failure
            done.set()
        for drive in self.drives.values():
            drive.step(now)

    def call(self, function):
        """Call a function between two steps and wait until it has returned."""
        done = threading.Event()
        self.calls.append((function, done))
        assert done.wait(lock_step.TIMEOUT_S), "the simulation stands still"
        if self.failure:
            raise self.failure

    def close(self):
        """Leave the simulation; time continues without the drives."""
        self.network.disconnect()


class Drive:
    """A drive on a lock-step bus. The attributes below cause deviations; reset() removes them."""

    def __init__(self, network, number):
        self.network, self.number = network, number
        self.now = 0.0
        self.due = []  # (time, identifier, octets)
        network.subscribe(NMT, self._on_nmt)
        network.subscribe(SYNC, self._on_sync)
        self.node = None
        self.reset()

    def reset(self):
        """A new device without deviations."""
        self.answer_delay = 0.0  # [s]
        self.boots = True
        self.boot_again_every = None  # [s]
        self.beats = True
        self.publishes = True
        self.overrides = {}  # (index, subindex) -> octets read instead
        self.refusals = {}  # (index, subindex) -> abort code of reading and writing
        self.state, self.statusword, self.syncs = PRE_OPERATIONAL, SWITCH_ON_DISABLED, 0
        self.last_beat = self.last_boot = self.now
        self.due.clear()
        if self.node is not None:
            self._unmap()
            del self.network[self.number]
        dictionary = canopen.import_od(str(SHEETS / "joint-drive.eds"), self.number)
        dictionary[0x1017].value = dictionary[0x1017].default = 0  # canopen's heartbeat would run in wall-clock time.
        self.node = self.network.create_node(self.number, dictionary)
        self.node.sdo.send_response = self._answer
        self.node.add_read_callback(self._on_read)
        self.node.add_write_callback(self._on_write)
        self._map()

    def forget(self, index):
        """Remove an object, which this device then does not have."""
        del self.node.object_dictionary[index]

    def _unmap(self):
        for rpdo in self.node.rpdo.values():
            with contextlib.suppress(KeyError):
                self.network.unsubscribe(rpdo.cob_id)

    def _map(self):
        self._unmap()
        self.node.tpdo.read()
        self.node.rpdo.read()
        for rpdo in self.node.rpdo.values():
            rpdo.callbacks[:] = [self._on_command]

    # --- SDO

    def _on_read(self, index, subindex, od):
        del od
        if (index, subindex) in self.refusals:
            raise canopen.SdoAbortedError(self.refusals[index, subindex])
        return self.overrides.get((index, subindex))

    def _on_write(self, index, subindex, od, data):
        del od, data
        if (index, subindex) in self.refusals:
            raise canopen.SdoAbortedError(self.refusals[index, subindex])

    def _answer(self, octets):
        self.due.append((self.now + self.answer_delay, self.node.sdo.tx_cobid, bytes(octets)))

    # --- NMT

    def _on_nmt(self, identifier, octets, stamp):
        del identifier, stamp
        command, number = octets[0], octets[1]
        if number not in (0, self.number):
            return
        if command in (RESET_NODE, RESET_COMMUNICATION):
            self.state, self.statusword = PRE_OPERATIONAL, SWITCH_ON_DISABLED
            if self.boots:
                self._boot(0.001)
        elif command == START:
            self._map()
            self.state, self.syncs = OPERATIONAL, 0
        else:
            self.state = STOPPED if command == STOP else PRE_OPERATIONAL
            self.statusword = SWITCH_ON_DISABLED

    def _boot(self, later):
        self.due.append((self.now + later, BOOT_UP + self.number, b"\0"))
        self.last_boot = self.last_beat = self.now

    def step(self, now):
        """End a step of the simulation."""
        self.now = now
        if self.boot_again_every and now - self.last_boot >= self.boot_again_every:
            self._boot(0.0)
        if self.beats and now - self.last_beat >= HEARTBEAT_S:
            self.last_beat = now
            self.due.append((now, BOOT_UP + self.number, bytes([self.state])))
        ready = [entry for entry in self.due if entry[0] <= now]
        self.due = [entry for entry in self.due if entry[0] > now]
        for _, identifier, octets in ready:
            self.network.send_message(identifier, octets)

    # --- process data

    def _on_sync(self, identifier, octets, stamp):
        del identifier, octets, stamp
        if self.state != OPERATIONAL or not self.publishes:
            return
        tpdo = self.node.tpdo
        tpdo[1]["Statusword"].raw = self.statusword
        tpdo[1]["Torque actual value"].raw = 0
        tpdo[1].transmit()
        self.syncs += 1
        if self.syncs % SLOW_SYNCS == 0:
            tpdo[2]["Drive temperature"].raw = 250
            tpdo[2].transmit()

    def _on_command(self, rpdo):
        if self.state != OPERATIONAL:
            return
        word = rpdo["Controlword"].raw & 0x8F
        state = self.statusword
        if word & 0x02 == 0 or word & 0x04 == 0:
            state = SWITCH_ON_DISABLED  # Disable voltage; or quick stop, which ends at once because the drive does not move.
        elif word & 0x0F == 0x06:
            state = READY
        elif word & 0x0F == 0x07 and state != SWITCH_ON_DISABLED:
            state = SWITCHED_ON
        elif word & 0x0F == 0x0F and state in (SWITCHED_ON, ENABLED):
            state = ENABLED
        self.statusword = state
        if state == ENABLED and "Target position" in [variable.name for variable in rpdo]:
            self.node.tpdo[1]["Position actual value"].raw = rpdo["Target position"].raw
