# SPDX-License-Identifier: Apache-2.0
"""Frames of a bus from the simulator's listen-only tap: load, the decoded newest frame of each identifier with its rate, and error frames.

A bus has thousands of frames a second. A line is therefore only counted when it arrives; frames are decoded a few times a second, for display."""

import collections

from ..frame_length import classic_us, fd_us
from ..values import bits_for

ERRORS_KEPT = 20  # Newest error frames that a page shows.
_CONTROLLER = {0x01: "receive buffer overflow", 0x02: "transmit buffer overflow", 0x04: "receive errors: error warning", 0x08: "transmit errors: error warning",
               0x10: "receive errors: error passive", 0x20: "transmit errors: error passive", 0x40: "error active again"}
_CLASSES = ((0x001, "TX_TIMEOUT", "caution", "a frame was not sent in time"), (0x002, "ARBITRATION", "informative", "arbitration lost"),
            (0x008, "PROTOCOL", "caution", "a bit on the bus was wrong"), (0x010, "TRANSCEIVER", "serious", "fault of a line"),
            (0x020, "NO_ACK", "critical", "no node acknowledges"), (0x040, "BUS_OFF", "critical", "the controller is off the bus"),
            (0x080, "BUS", "caution", "error on the bus"), (0x100, "RESTARTED", "informative", "the controller is on the bus again"))


def error_of(identifier, octets):
    """(name, symbol, words) of an error frame of SocketCAN."""
    found = [entry[1:] for entry in _CLASSES if identifier & entry[0]]
    if identifier & 0x004 and len(octets) > 1:
        found += [("CONTROLLER", "informative" if bit == 0x40 else "caution", words) for bit, words in _CONTROLLER.items() if octets[1] & bit]
    name, symbol, _ = found[0] if found else ("ERROR", "caution", "")
    words = "; ".join(entry[2] for entry in found) or "error"
    if identifier & 0x200 and len(octets) > 7:
        words += f"; tx errors {octets[6]}, rx errors {octets[7]}"
    return name, symbol, words


class BusTap:
    """Statistics and newest frames of one bus. Rates in bit/s; database: hirosco_gse.frames.Database, or None; warning: why names and values may be
    wrong; bits: those of values.bits_of."""

    def __init__(self, name, rate, data_rate, database, warning=None, bits=None):
        self.name, self._rate, self._data_rate, self._database, self.warning = name, rate, data_rate, database, warning
        self._bits = bits or {}
        self.errors = collections.deque(maxlen=ERRORS_KEPT)
        self.dropped = self.error_count = 0
        self.transmit_errors = None
        self._newest, self._counts = {}, collections.Counter()
        self._rest, self._since = b"", None

    def feed(self, octets):
        """Process octets that the live port has sent."""
        *lines, self._rest = (self._rest + octets).split(b"\n")
        for line in lines:
            if not line.startswith(b"frame "):
                self.dropped += int(line.split()[1]) if line.startswith(b"dropped ") else 0
                continue
            identifier, _, data = line[line.rfind(b" ") + 1 :].partition(b"#")
            if len(identifier) == 8 and identifier[:1] in b"2367":  # Error frame of SocketCAN: bit 0x20000000 is set.
                self._take_error(line, int(identifier, 16), bytes.fromhex(data.decode()))
            else:
                self._newest[identifier] = line, data
                self._counts[identifier, len(data), data[:1] == b"#"] += 1

    def _take_error(self, line, identifier, octets):
        self.error_count += 1
        name, symbol, words = error_of(identifier, octets)
        if identifier & 0x200 and len(octets) > 7:
            self.transmit_errors = octets[6]
        self.errors.append({"time": _time(line), "name": name, "symbol": symbol, "words": words})

    def message(self):
        """Message for the pages about the time since the last call."""
        times = [_time(line) for line, _ in self._newest.values()]
        now = max(times, default=0.0)
        span = now - self._since if self._since is not None else 0.0
        self._since = now
        busy_us, rates = 0.0, collections.Counter()
        for (identifier, size, is_fd), count in self._counts.items():
            rates[identifier] += count
            length = max(0, size - 2) // 2 if is_fd else size // 2
            busy_us += count * (fd_us(length, self._rate, self._data_rate) if is_fd else classic_us(length, self._rate))
        self._counts.clear()
        frames = [self._frame(identifier, line, data, rates[identifier] / span if span > 0 else 0.0) for identifier, (line, data) in sorted(self._newest.items())]
        return {"kind": "bus", "bus": self.name, "warning": self.warning, "time": now, "load": busy_us / span / 1e6 if span > 0 else None, "frames": frames,
                "errors": list(self.errors), "error_count": self.error_count, "transmit_errors": self.transmit_errors, "dropped": self.dropped}

    def _frame(self, identifier, line, data, rate):
        octets = bytes.fromhex(data[2:].decode() if data[:1] == b"#" else data.decode() if data[:1] != b"R" else "")
        name, signals = self._database.decode(int(identifier, 16), octets, len(identifier) == 8) if self._database else (None, [])
        words = ", ".join(f"{signal} {self._word(signal, value)} {unit}".rstrip() for signal, value, unit in signals)
        return {"id": identifier.decode(), "name": name or "", "time": _time(line), "rate": rate, "octets": octets.hex().upper(), "words": words}

    def _word(self, signal, value):
        """Text of a value. If its bits have names, the text is the name of the state, as in the other tabs of the page."""
        bits = bits_for(signal, self._bits)
        if bits and isinstance(value, int):
            return bits.state(value)
        return f"{value:.6g}" if isinstance(value, float) else value


def _time(line):
    return float(line[7 : line.index(b")")])
