# SPDX-License-Identifier: Apache-2.0
"""Dictionary and decoding of telemetry, with the dictionary made from the real descriptors."""

import copy
import json
import re
import struct

import pytest
from hirosco_gse import packets, telemetry
from hirosco_gse.dictionary import SEVERITIES, Dictionary, DictionaryError
from hirosco_gse.failures import Failure
from hirosco_gse.station import about
from hirosco_gse.values import REALS, ValueProblem, Word, in_words, to_text
from tm_packets import build_tm

MANIPULATOR, SUPERVISOR = 16, 1
SUBTYPES = {severity: subtype for subtype, severity in SEVERITIES.items()}


def tm(apid, service, subtype, data, user=1):
    return packets.parse(build_tm(apid, 0, service, subtype, data, user, 10**18))


def test_items_are_found_by_name_and_number(dictionary):
    manipulator = dictionary.subsystem("manipulator")
    assert manipulator is dictionary.subsystem("16") is dictionary.subsystem_of_apid(16)
    assert dictionary.mode("nominal") == dictionary.mode("1") == 1
    assert [item.name for item in dictionary.members] == ["JOYSTICK", "MANIPULATOR"]
    position = manipulator.parameter("DES_POSITION")
    assert position.parameter_id >> 21 == 16
    assert position.size == 16


@pytest.mark.parametrize("path", ["subsystem", "link"])
def test_unknown_names_offer_the_known(dictionary, path):
    with pytest.raises(DictionaryError, match="there are: "):
        getattr(dictionary, path)("NOBODY")


def test_layout_hash_is_that_of_the_generator(dictionary):
    for subsystem in dictionary.content["subsystems"]:
        ours = dictionary.subsystem(subsystem["name"])
        for configuration in subsystem["configurations"]:
            for port in configuration["provides"] + configuration["requires"]:
                is_consumer = port in configuration["requires"]
                assert ours.port(port["id"], is_consumer).layout_hash == port["layout_hash"]
                assert ours.port(port["id"], is_consumer).octets == port["octets"]


def test_a_file_that_is_no_dictionary_is_refused(tmp_path):
    with pytest.raises(DictionaryError, match="run make"):
        Dictionary.load(tmp_path / "none.json")
    for text in ("{", "[]", '{"mission": "x"}', '{"mission": "x", "epoch": 0, "subsystems": [{}]}'):
        (tmp_path / "d.json").write_text(text)
        with pytest.raises(DictionaryError, match="not a mission dictionary"):
            Dictionary.load(tmp_path / "d.json")


def test_housekeeping_interleaves_sample_by_sample(dictionary_path):
    content = json.loads(dictionary_path.read_text())
    manipulator = next(s for s in content["subsystems"] if s["name"] == "MANIPULATOR")
    manipulator["configurations"][0]["housekeeping"] = [
        {"id": 7, "interval": 8, "once": ["LINK_AGE"], "repeated": [{"nrep": 2, "parameters": ["DES_POSITION", "TORQUE_LIMIT"]}]}
    ]
    dictionary = Dictionary(content)
    data = struct.pack(">HI8d", 7, 500, *range(8))
    decoded = telemetry.decode(tm(MANIPULATOR, 3, 25, data, 0), dictionary)
    assert decoded["values"] == {
        "LINK_AGE": [500],
        "DES_POSITION": [[0.0, 1.0], [4.0, 5.0]],
        "TORQUE_LIMIT": [[2.0, 3.0], [6.0, 7.0]],
    }
    for wrong in (data[:-1], data + b"\0"):
        assert "error" in telemetry.decode(tm(MANIPULATOR, 3, 25, wrong, 0), dictionary)


def test_a_structure_is_decoded_as_in_its_configuration_or_by_its_size(dictionary):
    """Because of LINK_AGE, structure 4711 differs between the configurations. If the configuration is not known, the size decides."""
    manipulator = dictionary.subsystem("MANIPULATOR")
    for configuration in manipulator.configurations.values():
        structure = configuration.structures[4711]
        size = sum(p.size for p in structure.once) + sum(n * sum(p.size for p in sampled) for n, sampled in structure.repeated)
        packet = tm(MANIPULATOR, 3, 25, struct.pack(">H", 4711) + bytes(size), 0)
        for known in ({}, {MANIPULATOR: configuration.id}):
            decoded = telemetry.decode(packet, dictionary, known)
            assert ("LINK_AGE" in decoded["values"]) == (configuration.name.startswith("TELEPRESENCE"))


def test_an_event_is_decoded_with_its_values(dictionary):
    event = dictionary.subsystem("MANIPULATOR").event("TORQUE_LIMIT")
    data = struct.pack(">H", event.id) + b"".join(bytes(item.size) for item in event.parameters)
    decoded = telemetry.decode(tm(MANIPULATOR, 5, 3, data, 0), dictionary)
    assert (decoded["event"], decoded["severity"]) == ("TORQUE_LIMIT", "MEDIUM")
    assert "TORQUE_LIMIT" in telemetry.describe(tm(MANIPULATOR, 5, 3, data, 0), decoded, dictionary)
    assert "error" in telemetry.decode(tm(MANIPULATOR, 5, 3, data + b"\0", 0), dictionary)
    assert "error" in telemetry.decode(tm(MANIPULATOR, 5, 3, b"\0\xff", 0), dictionary)


# Event of a subsystem, its values, and how it is written.
IDENTIFIED = [
    (16, "DEVICE_LOST", struct.pack(">B", 0x11), "NODE=JOINT1 (0x11)"),
    (16, "DEVICE_LOST", struct.pack(">B", 0x7F), "NODE=127"),
    (16, "DEVICE_REFUSED", struct.pack(">BBII", 0x12, 4, 0x200102, 7), "NODE=JOINT2 (0x12)  REASON=VALUE  OBJECT=0x2001:02  DETAIL=7"),
    (17, "BUS_WARNING", struct.pack(">BH", 0x21, 0x8120), "NODE=STICK (0x21)  CODE=ERROR_PASSIVE"),
    (17, "BUS_WARNING", struct.pack(">BH", 0, 3), "NODE=CONTROLLER (0x00)  CODE=BUS_OFF"),
    (16, "VALUE_OUT_OF_LIMITS", struct.pack(">HIBBd", 7, 0x0202000C, 1, 4, 1.5), "MONITOR=7  PARAMETER=MANIPULATOR.LINK_AGE (0x0202000C)  CHECK=limit  STATUS=above high  VALUE=1.5"),
    (16, "JOURNAL_DAMAGED", struct.pack(">IIB", 40, 2, 1), "OCTETS=40 octets  RECORDS=2 records  KEPT=YES"),
    (1, "NETWORK_SHUT_DOWN", struct.pack(">HH", 16, 17), "NETWORK=MANIPULATOR  APID=JOYSTICK"),
    (1, "RECORD_REFUSED", struct.pack(">BIB", 12, 3, 10), "TABLE=on-board monitoring  KEY=3  REASON=CHECKSUM"),
    (1, "RECOMMISSION_STOPPED", struct.pack(">HHH", 16, 4, 0x0204), "APID=MANIPULATOR  STATE=SAFE_OPERATIONAL  CODE=not allowed in the present state"),
    (1, "PROCEDURE_FAILED", struct.pack(">8sBHI45s", b"LOOK", 3, 0, 2, b"it's gone"), "PROCEDURE='LOOK'  WHAT=FAILED  STEP=0  DETAIL=2  TEXT=\"it's gone\""),
    (1, "PLAN_STARTED", struct.pack(">HH", 17, 1), "APID=JOYSTICK  EVENT=DEVICE_LOST (1)"),
    (1, "PLAN_OVERRULED", struct.pack(">HHHH", 16, 3, 17, 1), "APID=MANIPULATOR  EVENT=TORQUE_LIMIT (3)  BY_APID=JOYSTICK  BY_EVENT=DEVICE_LOST (1)"),
]


@pytest.mark.parametrize(("apid", "name", "data", "text"), IDENTIFIED)
def test_an_event_names_the_device_and_the_event_that_it_is_about(dictionary, apid, name, data, text):
    """The names are those of the dictionary, with the number beside. A number without a name, and each number in JSON, stays a number."""
    event = dictionary.subsystem_of_apid(apid).event(name)
    packet = tm(apid, 5, SUBTYPES[event.severity], struct.pack(">H", event.id) + data, 0)
    decoded = telemetry.decode(packet, dictionary)
    assert telemetry.describe(packet, decoded, dictionary).endswith(f"{name}  {text}")
    nodes = in_words(decoded["values"]).get("NODE")
    assert nodes is None or nodes == [data[0]]
    assert decoded["values"].get("NODE") != [0x11] or decoded["values"]["NODE"] == ["JOINT1"]
    assert copy.deepcopy(decoded["values"]) == decoded["values"]


def test_devices_without_a_bus_are_named_by_their_number(dictionary_path_of):
    zoo = Dictionary.load(dictionary_path_of("zoo"))
    instruments = zoo.subsystem("INSTRUMENTS")
    event = instruments.event("DEVICE_LOST")
    packet = tm(instruments.apid, 5, 3, struct.pack(">HBB", event.id, 1, 2), 0)
    assert "DEVICE=SHUTTER (1)  CAUSE=SILENT" in telemetry.describe(packet, telemetry.decode(packet, zoo), zoo)


def test_reports_of_the_mission_services_are_decoded(dictionary):
    decoded = telemetry.decode(tm(16, 129, 2, struct.pack(">BBBHBHI", 4, 5, 0, 2, 1, 9, 77)), dictionary)
    assert (decoded["previous"], decoded["state"], decoded["configuration"], decoded["cause"], decoded["cycle"]) == (
        "SAFE_OPERATIONAL", "OPERATIONAL", "TELEPRESENCE", "own error", 77,
    )
    decoded = telemetry.decode(tm(16, 129, 5, struct.pack(">BBBHQQII", 3, 5, 3, 1, 0xAB, 0xCD, 2, 3)), dictionary)
    assert (decoded["phase"], decoded["interface_hash"]) == ("CONFIGURED", "0x00000000000000ab")
    decoded = telemetry.decode(tm(1, 131, 9, struct.pack(">HHBBBHB", 1, 17, 2, 5, 0, 2, 1)), dictionary)
    assert decoded["rows"][0]["subsystem"] == "JOYSTICK"
    decoded = telemetry.decode(tm(1, 131, 11, struct.pack(">HHHHHHH", 1, 1, 2, 16, 17, 1, 3)), dictionary)
    assert decoded["rows"] == [{"network": 1, "members": ["MANIPULATOR", "JOYSTICK"], "links": [3]}]
    row = struct.pack(">HBHHHH", 3, 3, 16, 1, 17, 2) + struct.pack(">IIBIHBBI", 1, 32, 1, 500, 0, 2, 1, 2000)
    decoded = telemetry.decode(tm(1, 130, 9, struct.pack(">H", 1) + row + struct.pack(">IIIII", 9, 8, 1, 0, 9)), dictionary)
    assert (decoded["rows"][0]["state"], decoded["rows"][0]["lost"], decoded["rows"][0]["properties"]["method"]) == (
        "open", 1, "UDP",
    )


def test_every_truncation_is_an_error_and_no_exception(dictionary):
    bodies = {
        (1, 2): bytes(12), (3, 10): bytes(11), (3, 35): b"\0\1" + bytes(7), (5, 8): b"\0\1\0\1",
        (20, 2): b"\0\1" + bytes(6),
        (129, 2): bytes(12), (129, 5): bytes(29), (130, 2): b"\0\1" + bytes(24), (130, 4): bytes(29),
        (130, 5): bytes(27), (130, 9): b"\0\1" + bytes(52), (130, 10): bytes(13), (131, 2): bytes(3),
        (131, 4): bytes(12), (131, 9): b"\0\1" + bytes(8), (131, 11): b"\0\1" + bytes(6),
    }
    for (service, subtype), body in bodies.items():
        for size in range(len(body)):
            decoded = telemetry.decode(tm(16, service, subtype, body[:size]), dictionary)
            assert "error" in decoded, (service, subtype, size)


@pytest.mark.parametrize(
    ("code", "detail", "words"),
    [
        (0x0111, 16 << 16 | 2, "MANIPULATOR requires HAND_POSITION"),
        (0x0110, 1 << 8 | 3, "mode NOMINAL while in state PRE_OPERATIONAL"),
        (0x0113, 16, "MANIPULATOR"),
        (0x0115, 16, "silent and has not reported its state"),
        (0x0106, 3 << 8 | 99, r"\[3,99\]"),
        (0x0408, 17, "JOYSTICK"),
        (0x0409, 1 << 8 | 1, "layout"),
        (0x0201, 35192839, r"unknown: MANIPULATOR\.TORQUE_LIMIT \["),
        (0x0201, 0x41424344, r"unknown: 'ABCD' \["),
        (0x0201, 0x31000000, r"unknown: '1' \["),
        (0x0202, 4720, r"already: 4720 \["),
        (0x0201, 0x010A0000, r"unknown: 17432576 \["),
        (0x7777, 5, "not in the dictionary"),
    ],
)
def test_a_failure_is_written_in_words(dictionary, code, detail, words):
    failure = Failure.decode(2, struct.pack(">HHI", code, 0, detail))
    text = failure.words(dictionary)
    assert re.search(words, text)
    assert f"0x{code:04X}" in text
    assert "refused at acceptance" in text


def test_every_failure_has_words_and_its_detail(dictionary):
    assert len(dictionary.catalogue.failures) == 46
    for code, (what, detail) in dictionary.catalogue.failures.items():
        text = Failure.decode(4, struct.pack(">HHI", code, 0, 0x12345678)).words(dictionary)
        assert text.startswith(f"refused at start of execution: {what}")
        assert "{" not in text and "not in the dictionary" not in text
        assert not detail or not text.startswith(f"refused at start of execution: {what} [0x")


def test_the_report_of_a_failed_step_has_the_number_of_the_step(dictionary):
    failure = Failure.decode(6, struct.pack(">HHHI", 2, 0x0402, 2, 7))
    assert failure.words(dictionary).startswith("failed in progress at step 2: ")


@pytest.mark.parametrize(("apid", "step"), [(MANIPULATOR, "HARDWARE_INIT"), (1, "2")])
def test_the_step_of_a_progress_report_is_a_state_of_a_subsystem_or_a_number_of_the_supervisor(dictionary, apid, step):
    packet = tm(apid, 1, 5, struct.pack(">HHH", 0x1800 | apid, 0xC000, 2), 0)
    assert telemetry.describe(packet, telemetry.decode(packet, dictionary), dictionary).endswith(f" {step}")


def test_a_structure_is_encoded_from_the_text_of_all_its_values(dictionary):
    control = dictionary.subsystem("JOYSTICK").parameter("CONTROL")
    text = ",".join(str(n) for n in range(sum(item.count for item in control.fields)))
    assert len(control.encode_text(text)) == control.size
    with pytest.raises(ValueProblem, match="CONTROL"):
        control.encode_text(text + ",1")


def test_every_number_is_shown_with_its_unit_what_it_counts_or_its_word(dictionary):
    """Housekeeping reports, the page and requests by name use the words and quantities of descriptions.txt
    like enumerations and units."""
    manipulator = dictionary.subsystem("MANIPULATOR")
    shown = [leaf for item in dictionary.content["subsystems"] for leaf in about.about(item)["parameters"]]
    bare = {leaf["name"] for leaf in shown if not leaf["unit"] and not leaf["words"] and not leaf["bits"] and leaf["type"] not in ("BOOL", *REALS)}
    assert len(shown) > 200 and bare == {"COUNTERS.CHANNEL"}, "it counts nothing"
    structure = next(iter(manipulator.configurations["STAND_ALONE"].structures.values()))
    values = {item.name: item.decode(bytes(item.size), 0)[0] for item in structure.once}
    values["CUR_VALUES"]["STATE"] = manipulator.parameter("CUR_VALUES").field("STATE")[0].decode(b"\0\0\0\5", 0)[0]
    text = telemetry.measured(values, manipulator.parameters)
    assert "STATE: OPERATIONAL" in text and "POSITION: [0, 0] rad" in text
    supervisor = dictionary.subsystem("SUPERVISOR")
    counters = supervisor.parameter("COUNTERS")
    assert "TC_ROUTED: 0 packets" in telemetry.measured({"COUNTERS": counters.decode(bytes(counters.size), 0)[0]}, supervisor.parameters)
    mode, _ = dictionary.subsystem("SUPERVISOR").parameter("STATUS").field("MODE")
    assert mode.encode_text("SAFE") == mode.encode_text("0") and mode.decode(b"\x09", 0) == ([9], 1)


def test_a_statusword_is_written_with_its_state_and_flags(dictionary):
    """The states are those of CiA 402; bits 4 and 5 do not matter in four of them. Arithmetic uses the number."""
    statusword, _ = dictionary.subsystem("MANIPULATOR").parameter("CUR_VALUES").field("STATUSWORD")
    numbers = [0x0637, 0x0250, 0x0040, 0x0231, 0x0233, 0x0207, 0x021F, 0x0218, 0x0000, 0xFFFF, 0x0001]
    found = [statusword.decode(struct.pack(">2H", number, 0), 0)[0][0] for number in numbers]
    assert found == numbers
    assert [str(word) for word in found] == [
        "OPERATION_ENABLED+VOLTAGE_ENABLED+REMOTE+TARGET_REACHED", "SWITCH_ON_DISABLED+VOLTAGE_ENABLED+REMOTE", "SWITCH_ON_DISABLED",
        "READY_TO_SWITCH_ON+VOLTAGE_ENABLED+REMOTE", "SWITCHED_ON+VOLTAGE_ENABLED+REMOTE", "QUICK_STOP_ACTIVE+REMOTE",
        "FAULT_REACTION_ACTIVE+VOLTAGE_ENABLED+REMOTE", "FAULT+VOLTAGE_ENABLED+REMOTE", "NOT_READY_TO_SWITCH_ON",
        "UNKNOWN+VOLTAGE_ENABLED+WARNING+MANUFACTURER_BIT_8+REMOTE+TARGET_REACHED+INTERNAL_LIMIT_ACTIVE+MODE_BIT_12+MODE_BIT_13+MANUFACTURER_BIT_14+MANUFACTURER_BIT_15",
        "UNKNOWN"]
    assert found[0].members["STATE"] == "OPERATION_ENABLED" and [name for name, is_set in found[0].members.items() if is_set == 1] == ["TARGET_REACHED", "REMOTE"]
    values = {"CUR_VALUES": {"STATUSWORD": found[4:6]}}
    assert "STATUSWORD: [SWITCHED_ON+VOLTAGE_ENABLED+REMOTE, QUICK_STOP_ACTIVE+REMOTE]" in telemetry.measured(values, dictionary.subsystem("MANIPULATOR").parameters)
    assert json.dumps(found[0]) == str(0x0637) and copy.deepcopy(found)[0].members == found[0].members


def test_a_number_with_a_word_computes_as_the_number_and_is_written_as_the_word():
    word = Word(5, "OPERATIONAL")
    assert word == 5 and word == "OPERATIONAL" and word != "OFFLINE" and word != 4 and word + 1 == 6
    assert f"{word} {word:>12}" == "OPERATIONAL  OPERATIONAL" and to_text([word]) == "OPERATIONAL"
    assert json.dumps(word) == "5" and json.dumps(in_words({"a": [word], "b": 1.5})) == '{"a": ["OPERATIONAL"], "b": 1.5}'
    again = copy.deepcopy([word])[0]
    assert again == "OPERATIONAL" and {5: "x"}[again] == "x"
