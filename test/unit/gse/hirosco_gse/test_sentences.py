# SPDX-License-Identifier: Apache-2.0
"""Event reports as sentences."""

import struct

import pytest
from hirosco_gse import packets, telemetry
from hirosco_gse.sentences import told
from tm_packets import build_tm

SUBTYPES = {"INFORMATIVE": 1, "LOW": 2, "MEDIUM": 3, "HIGH": 4}
# Event of a subsystem, the octets of its values, the sentence, and the values for a program.
EVENTS = [
    (16, "DEVICE_LOST", struct.pack(">B", 0x11), "A device does not answer any more: node JOINT1 (0x11)", {"NODE": "JOINT1"}),
    (16, "DEVICE_LOST", struct.pack(">B", 0x7F), "A device does not answer any more: node 127", {"NODE": 127}),
    (16, "TORQUE_LIMIT", struct.pack(">Bdd", 1, 12.0123, 12), "A torque is beyond its limit: joint 1, torque 12.01 Nm, limit 12 Nm", {"JOINT": 1, "TORQUE": 12.0123, "LIMIT": 12.0}),
    (16, "TARE_DONE", struct.pack(">dd", -0.0560316, 0.25), "The torque sensors are tared: offset -0.05603, 0.25 Nm", {"OFFSET": [-0.0560316, 0.25]}),
    (16, "SYNC_CONFLICT", b"", "Another node sends SYNC on the bus", {}),
    (16, "JOURNAL_DAMAGED", struct.pack(">IIB", 40, 2, 1), "The journal is damaged: 40 octets, 2 records, kept YES", {"OCTETS": 40, "RECORDS": 2, "KEPT": "YES"}),
    (1, "PLAN_STARTED", struct.pack(">HH", 17, 1), "A recovery plan was started for an event: subsystem JOYSTICK, event DEVICE_LOST (1)", {"APID": "JOYSTICK", "EVENT": "DEVICE_LOST"}),
    (1, "PROCEDURE_FAILED", struct.pack(">8sBHI45s", b"LOOK", 3, 0, 2, b""), "A procedure has failed: procedure LOOK, what FAILED, step 0, detail 2",
     {"PROCEDURE": "LOOK", "WHAT": "FAILED", "STEP": 0, "DETAIL": 2, "TEXT": ""}),
]


def decoded_of(dictionary, apid, event, data):
    """The content of an event report of a subsystem."""
    packet = packets.parse(build_tm(apid, 0, 5, SUBTYPES[event.severity], struct.pack(">H", event.id) + data))
    return telemetry.decode(packet, dictionary)


@pytest.mark.parametrize(("apid", "name", "data", "sentence", "values"), EVENTS)
def test_an_event_is_a_sentence_of_its_description_and_its_values(dictionary, apid, name, data, sentence, values):
    event = dictionary.subsystem_of_apid(apid).event(name)
    found = told(event, decoded_of(dictionary, apid, event, data)["values"])
    assert (found["text"], found["values"]) == (sentence, values)
    assert found["device"] == ("JOINT1" if values.get("NODE") == "JOINT1" else None)


def test_the_members_of_a_parameter_in_an_event_are_named(dictionary):
    """The event contains a parameter of the subsystem, with its fields."""
    event = dictionary.subsystem("COMMUNICATION").event("GROUND_MISUSED")
    size = sum(item.size for item in event.parameters)
    text = told(event, decoded_of(dictionary, 2, event, bytes(size))["values"])["text"]
    assert text.startswith("A ground user sends octets that are not telecommands, or too many users connect: ") and "refused 0" in text
