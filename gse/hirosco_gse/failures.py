# SPDX-License-Identifier: Apache-2.0
"""Failure notices of ST[01] in words."""

import struct
from dataclasses import dataclass

from .dictionary import STATES

# Subtypes of ST[01] that report a failure.
STAGES = {
    2: "refused at acceptance",
    4: "refused at start of execution",
    6: "failed in progress",
    8: "failed at completion",
    10: "could not be routed",
}
# Subtypes of ST[01] with which a verification ends.
FINAL_SUBTYPES = (2, 4, 7, 8, 10)
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


def _link(detail, dictionary):
    consumer = dictionary.subsystem_of_apid(detail >> 16)
    port = consumer.port_name(detail & 0xFFFF, requires=True) if consumer else str(detail & 0xFFFF)
    return f"{dictionary.name_of_apid(detail >> 16)} requires {port} (port {detail & 0xFFFF})"


def _parameter(detail, dictionary):
    if detail <= 0xFFFF:  # All parameter ids are greater.
        return f"event {detail}"
    subsystem = dictionary.subsystem_of_apid(detail >> 21)
    parameter = subsystem.parameter_of_id(detail) if subsystem else None
    return parameter.name if parameter else f"0x{detail:08X}"


def _identifier(detail, dictionary):
    """A parameter id as its name, the four characters of a packet store or procedure as text, another identifier as a number."""
    subsystem = dictionary.subsystem_of_apid(detail >> 21)
    parameter = subsystem.parameter_of_id(detail) if subsystem else None
    if parameter:
        return f"{subsystem.name}.{parameter.name}"
    text = detail.to_bytes(4, "big").rstrip(b"\0").decode("latin-1")
    return f"'{text}'" if detail >> 24 and text.isascii() and text.isprintable() else str(detail)


def _explain(code, detail, dictionary, apid):
    """Words for a failure code and its detail, from pus/catalogue/failures.txt or the sender's descriptor."""
    sender = dictionary.subsystem_of_apid(apid)
    if sender and code in sender.failures:
        name, of = sender.failures[code]
        return f"{name}, {of} {detail}" if of else name
    if code not in dictionary.catalogue.failures:
        return f"failure code not in the dictionary (detail {detail})"
    what, more = dictionary.catalogue.failures[code]
    high, low = detail >> 8 & 0xFF, detail & 0xFF
    modes = {mode["id"]: mode["name"] for mode in dictionary.modes}
    more = more.format(
        d=detail,
        x=f"0x{detail:04X}",
        address=f"0x{detail:08X}",
        high=high,
        low=low,
        apid=dictionary.name_of_apid(detail & 0x7FF),
        mode=modes.get(high, str(high)),
        state=name_of(STATES, low),
        reason=name_of(LINK_REASONS, detail >> 8),
        link=_link(detail, dictionary),
        parameter=_parameter(detail, dictionary),
        identifier=_identifier(detail, dictionary),
    )
    return f"{what}{'' if more.startswith(':') or not more else ' '}{more}"


@dataclass(frozen=True)
class Failure:
    """A failure notice with the stage of its report (subtype of ST[01])."""

    stage: int
    code: int
    instruction: int
    detail: int
    step: int = None
    apid: int = None  # APID of the sender, whose descriptor may define the code.

    @classmethod
    def decode(cls, subtype, octets, apid=None):
        """Decode the octets after the request id."""
        step = None
        if subtype == 6:
            step, octets = int.from_bytes(octets[:2], "big"), octets[2:]
        code, instruction, detail = struct.unpack(">HHI", octets)
        return cls(subtype, code, instruction, detail, step, apid)

    def words(self, dictionary):
        entry = f", instruction {self.instruction}" if self.instruction else ""
        step = f" at step {self.step}" if self.step is not None else ""
        return f"{STAGES[self.stage]}{step}: {_explain(self.code, self.detail, dictionary, self.apid)} [0x{self.code:04X}{entry}]"
