# SPDX-License-Identifier: Apache-2.0
"""Failure notices of ST[01] in words."""

import struct
from dataclasses import dataclass

from .dictionary import STATES

STAGES = {
    2: "refused at acceptance",
    4: "refused at start of execution",
    6: "failed in progress",
    8: "failed at completion",
    10: "could not be routed",
}
LINK_REASONS = (
    "request",
    "layout",
    "byte order",
    "sampling period",
    "transfer method",
    "resource",
    "state",
    "port",
    "deadline",
    "stale",
    "peer",
)


def name_of(table, number):
    """Name of a number in a tuple, or the number."""
    return table[number] if 0 <= number < len(table) else str(number)


def _apid(detail, dictionary):
    return dictionary.name_of_apid(detail & 0x7FF)


def _link_missing(detail, dictionary):
    consumer = dictionary.subsystem_of_apid(detail >> 16)
    port = consumer.port_name(detail & 0xFFFF, requires=True) if consumer else str(detail & 0xFFFF)
    name = dictionary.name_of_apid(detail >> 16)
    return f"required real-time link missing: {name} requires {port} (port {detail & 0xFFFF}), open it first"


def _permission(detail, dictionary):
    modes = {mode["id"]: mode["name"] for mode in dictionary.modes}
    mode = modes.get(detail >> 8 & 0xFF, str(detail >> 8 & 0xFF))
    return f"not permitted in mode {mode} while in state {name_of(STATES, detail & 0xFF)}"


def _parameter(detail, dictionary):
    if detail <= 0xFFFF:  # No parameter has so low an id.
        return f"event {detail} has auxiliary data that this service cannot fill"
    subsystem = dictionary.subsystem_of_apid(detail >> 21)
    parameter = subsystem.parameter_of_id(detail) if subsystem else None
    return f"parameter not readable or not settable: {parameter.name if parameter else f'0x{detail:08X}'}"


_WORDS = {
    0x0001: lambda d, y: f"no route to {_apid(d, y)}",
    0x0002: lambda d, y: f"destination not available: {_apid(d, y)} does not run or its mailbox is full",
    0x0101: lambda d, y: f"length field and received size differ ({d} octets received)",
    0x0102: lambda d, y: f"checksum wrong (computed 0x{d:04X})",
    0x0103: lambda d, y: f"PUS version not supported ({d})",
    0x0104: lambda d, y: f"APID unknown ({d})",
    0x0105: lambda d, y: f"service {d} not supported",
    0x0106: lambda d, y: f"message [{d >> 8 & 0xFF},{d & 0xFF}] not supported",
    0x0107: lambda d, y: f"source {d} not authorised",
    0x0108: lambda d, y: f"application data too short, too long or inconsistent at octet {d}",
    0x0109: lambda d, y: "queue full",
    0x010A: lambda d, y: f"packet version {d} not supported",
    0x010B: lambda d, y: "not a telecommand",
    0x010C: lambda d, y: "no secondary header",
    0x010D: lambda d, y: f"sequence flags {d}: segmented packets are not supported",
    0x0110: _permission,
    0x0111: _link_missing,
    0x0112: lambda d, y: f"resources not sufficient (detail {d})",
    0x0113: lambda d, y: f"another member of the real-time network is operational: {_apid(d, y)}",
    0x0114: lambda d, y: f"{_apid(d, y)} runs with another interface than the supervisor knows; see INTERFACE_DIFFERS, run make",
    0x0115: lambda d, y: f"{_apid(d, y)} has not reported its state since nothing was received from it: try again",
    0x0201: lambda d, y: f"identifier {d} unknown",
    0x0202: lambda d, y: f"identifier {d} exists already",
    0x0203: lambda d, y: f"value out of range (at octet {d})",
    0x0204: lambda d, y: f"not allowed in the present state (detail {d})",
    0x0205: lambda d, y: f"table full (at most {d})",
    0x0206: _parameter,
    0x0207: lambda d, y: f"address or length outside the memory (0x{d:08X})",
    0x0208: lambda d, y: f"memory {d} is write protected",
    0x0209: lambda d, y: "time or position in the past",
    0x020A: lambda d, y: f"embedded request malformed at octet {d}",
    0x020B: lambda d, y: f"identifier {d} twice in one request",
    0x020C: lambda d, y: f"forbidden in this mode ({d})",
    0x020D: lambda d, y: f"checksum of the data is 0x{d:04X}",
    0x0301: lambda d, y: f"step {d} failed",
    0x0401: lambda d, y: f"checksum mismatch after load (computed 0x{d:04X})",
    0x0402: lambda d, y: f"device {d} did not answer",
    0x0403: lambda d, y: f"device returned error {d}",
    0x0404: lambda d, y: f"input/output error {d}",
    0x0405: lambda d, y: "aborted, or superseded by another request",
    0x0406: lambda d, y: f"time-out after {d} ms",
    0x0407: lambda d, y: f"{d} instructions failed",
    0x0409: lambda d, y: f"link refused: {name_of(LINK_REASONS, d >> 8)} does not fit",
    0x0408: lambda d, y: f"addressee lost: {_apid(d, y)} ended before it completed the request",
    0x040B: lambda d, y: f"the supervisor has restarted (life {d}) and has not kept this request",
    0x040A: lambda d, y: f"the procedure failed at line {d}; see PROCEDURE_FAILED",
}


@dataclass(frozen=True)
class Failure:
    """A failure notice with the stage of its report (subtype of ST[01])."""

    stage: int
    code: int
    instruction: int
    detail: int
    step: int = None

    @classmethod
    def decode(cls, subtype, octets):
        """Decode the octets behind the request id."""
        step = None
        if subtype == 6:
            step, octets = int.from_bytes(octets[:2], "big"), octets[2:]
        code, instruction, detail = struct.unpack(">HHI", octets)
        return cls(subtype, code, instruction, detail, step)

    def words(self, dictionary):
        """The failure in words."""
        explain = _WORDS.get(self.code, lambda d, y: f"reason not known to this ground (detail {d})")
        entry = f", instruction {self.instruction}" if self.instruction else ""
        step = f" at step {name_of(STATES, self.step)}" if self.step is not None else ""
        return f"{STAGES[self.stage]}{step}: {explain(self.detail, dictionary)} [0x{self.code:04X}{entry}]"
