# SPDX-License-Identifier: Apache-2.0
"""A python-can bus in lock-step with the simulator: simulated time stands still until the received frames
have been answered.

Frames pass through the simulator's own port (socketcand) or through an interface on which the simulator
publishes the bus; the steps of time always pass through the port. Listeners run in the notifier's thread,
which calls `on_step` at the end of each step."""

import re
import socket
import threading
import time

import can

MESSAGE = re.compile(rb"<\s*(.*?)\s*>")
TIMEOUT_S = 600.0  # Wall-clock time: an emulated machine starts a flight slowly.


class LockStepBus(can.BusABC):
    """One bus of a simulator that serves tools on a port."""

    def __init__(self, port, bus, interface=None, every=1):
        """interface: a SocketCAN interface for the frames; without one they pass through the port. every:
        number of steps after which simulated time waits."""
        self.channel_info = f"{bus} in lock-step"
        self.on_step = []  # Called with the simulated time [s].
        self.steps, self.every = 0, every  # Steps since this bus has joined.
        self.ended = threading.Event()  # The simulator has closed the port.
        self._frames = can.Bus(interface="socketcan", channel=interface, fd=True) if interface else None
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=TIMEOUT_S)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._input = b""
        self._reported = None  # Time of the step to be acknowledged.
        self._say_lock = threading.Lock()
        super().__init__(channel=bus)
        self._expect("hi")
        if not interface:
            for word in (f"open {bus}", "rawmode"):
                self._say(word)
                self._expect("ok")
        self._say(f"step {every}")
        self._socket.settimeout(0.2)

    def _say(self, text):
        with self._say_lock:
            self._socket.sendall(f"< {text} >".encode())

    def _expect(self, word):
        while not (match := MESSAGE.search(self._input)):
            self._read()
        self._input = self._input[match.end():]
        if match[1].decode() != word:
            raise ConnectionError(f"the simulator sent {match[1]!r}, expected {word}")

    def _read(self):
        octets = self._socket.recv(65536)
        if not octets:
            self.ended.set()
            raise can.CanOperationError("the simulator has ended")
        self._input += octets

    def _recv_internal(self, timeout):
        """The next frame. This function is called again when all frames of a step have been delivered; then
        the step ends."""
        while True:
            if self._reported is not None:
                frame = self._frames.recv(0) if self._frames else None
                if frame:
                    return frame, False
                for listener in self.on_step:
                    listener(self._reported)
                self.steps += self.every
                self._reported = None
                self._say(f"step {self.every}")
            match = MESSAGE.search(self._input)
            if match is None:
                try:
                    self._read()
                except TimeoutError:
                    return None, False
                except (OSError, can.CanOperationError):
                    self.ended.set()
                    time.sleep(0.05)  # The function is called again until the bus is shut down.
                    return None, False
                continue
            self._input = self._input[match.end():]
            words = match[1].decode().split(" ")
            if words[0] == "step":
                self._reported = float(words[1])
            elif words[0] == "frame":
                data = bytes.fromhex(words[3]) if len(words) > 3 else b""
                identifier = int(words[1], 16)
                return can.Message(timestamp=float(words[2]), arbitration_id=identifier, data=data,
                                   is_extended_id=len(words[1]) > 3), False

    def send(self, msg, timeout=None):
        """Send a frame, which is on the bus in the next step."""
        if self._frames:
            self._frames.send(msg, timeout)
        else:
            octets = " ".join(f"{octet:x}" for octet in msg.data)
            self._say(f"send {msg.arbitration_id:x} {msg.dlc} {octets}")

    def shutdown(self):
        """Leave the simulation; time continues without this bus."""
        super().shutdown()
        self._socket.close()
        if self._frames:
            self._frames.shutdown()
