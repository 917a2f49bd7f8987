# SPDX-License-Identifier: Apache-2.0
"""The files that the generator makes from the descriptors: they have the same octets each time, every file
contains the interface for which it is made, and the tables of a dissector are as expected."""

import json
import os
import pathlib
import re
import struct
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
GENERATOR = ROOT / "gse" / "generator"
MISSIONS = [ROOT / "descriptors" / "missions" / f"{name}.xml" for name in ("rokviss", "ur5e")]

sys.path[:0] = [str(path) for path in (GENERATOR, ROOT / "gse" / "yamcs", ROOT / "gse", ROOT / "test" / "support")]
import dissection  # noqa: E402
import dissector  # noqa: E402
import identifiers  # noqa: E402
import run as yamcs_run  # noqa: E402
from hirosco_gse import packets  # noqa: E402
from tm_packets import build_tm  # noqa: E402


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Two directories that were generated with different hash orders of sets and dictionaries and in different
    working directories."""
    directories = []
    for seed in ("1", "2"):
        out = tmp_path_factory.mktemp(f"made-{seed}")
        command = [sys.executable, GENERATOR / "generate.py", "--mission", *MISSIONS, "--out", out]
        subprocess.run(command, check=True, cwd=out, env={**os.environ, "PYTHONHASHSEED": seed})
        directories.append({path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()})
    return directories


def test_the_same_descriptors_give_the_same_octets(made):
    assert made[0] == made[1]
    assert {path.suffix for path in made[0]} == {".h", ".json", ".xml", ".lua", ".dbc", ".par", ".ycs"}


def test_every_file_of_a_mission_has_the_interface_that_it_is_made_for(made):
    for mission in MISSIONS:
        content = json.loads(made[0][pathlib.Path(f"{mission.stem}.json")])
        files = [path for path in made[0] if path.name.startswith((f"{mission.stem}.", f"{mission.stem}-")) or mission.stem in path.parts]
        assert {path.suffix for path in files} == {".json", ".xml", ".lua", ".dbc", ".par", ".ycs"}
        for path in files:
            assert content["interface_hash"].encode() in made[0][path], path
        for subsystem in content["subsystems"]:
            header = made[0][pathlib.Path(f"{subsystem['name'].lower()}_descriptor.h")].decode()
            assert subsystem["interface_hash"][2:].lower() in header.lower()


def test_the_generator_runs_before_every_source_that_includes_its_files():
    """SEES_GENERATED of mk/generated.mk covers every source that includes a file of build/generated, by the
    dependency files of the plain build. Otherwise a clean build would compile the source before the generator
    has run."""
    environment = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MAKELEVEL", "MFLAGS")}
    listed = subprocess.run(["make", "-s", "--eval=sees-generated: ; @echo $(SEES_GENERATED)", "sees-generated"], cwd=ROOT, env=environment,
                            check=True, capture_output=True, text=True).stdout.split()
    objects = ROOT / "build" / "obj"
    including = [path.relative_to(objects).with_suffix(".c") for path in objects.rglob("*.d") if "build/generated/" in path.read_text()]
    including = [path for path in including if (ROOT / path).exists()]
    assert pathlib.Path("fsw/equipment/equipment.c") in including and len(including) > 50
    assert [path for path in including if not path.as_posix().startswith(tuple(pattern.removesuffix("%") for pattern in listed))] == []


def test_yamcs_is_not_started_silently_with_a_file_of_another_interface(made, monkeypatch, tmp_path):
    for path, octets in made[0].items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_bytes(octets)
    monkeypatch.setattr(yamcs_run, "GENERATED", tmp_path)
    wanted = json.loads(made[0][pathlib.Path("rokviss.json")])["interface_hash"]
    assert yamcs_run.compare_files("rokviss", wanted) == []
    older = ("rokviss.xtce.xml", "rokviss.events.json", "yamcs/rokviss/displays/JOYSTICK.par", "yamcs/rokviss/stacks/ALL-OFFLINE.ycs")
    for name in older:
        path = tmp_path / name
        path.write_text(path.read_text(encoding="utf-8").replace(wanted, "0x00000000000000AA"), encoding="utf-8")
    assert yamcs_run.compare_files("rokviss", wanted) == [f"{name} was not made for the interface of the dictionary, {wanted}: run make" for name in older]


SMALL = {
    "mission": "small", "interface_hash": "0x0123456789ABCDEF", "configuration_hash": "0x02", "epoch": 100, "ground": {"port": 10015},
    "types": {"UINT8": {"code": 0}, "FLOAT": {"code": 8}}, "modes": [{"id": 1, "name": "NOMINAL"}], "users": [{"id": 1, "name": "CLI"}],
    "links": [], "subsystems": [{
        "name": "LAMP", "apid": 16, "interface_hash": "0xFE", "enumerations": {"LIGHT": {"DARK": 0, "BRIGHT": 1}},
        "failures": [{"name": "BURNT", "code": 0x8001, "detail": ""}],
        "parameters": [
            {"name": "LIGHT", "parameter_id": 0x02000001, "type": "UINT8", "count": 1, "unit": "", "enumeration": "LIGHT"},
            {"name": "HEAT", "parameter_id": 0x02180002, "type": "STRUCT", "fields": [{"name": "CORE", "type": "FLOAT", "count": 2, "unit": "K"}]},
        ],
        "events": [{"name": "HOT", "id": 3, "parameters": ["HEAT.CORE", {"name": "PART", "type": "UINT8", "count": 1, "unit": "", "kind": "device"}]}],
        "identifiers": {"CANopen node": {}, "device": {"2": "BULB"}},
        "functions": [{"name": "DIM", "arguments": [{"name": "TO", "id": 1, "type": "UINT8", "count": 1, "unit": "", "enumeration": "LIGHT"}]}],
        "configurations": [{"id": 7, "name": "ON", "devices": [], "housekeeping": [{"id": 5, "once": ["LIGHT"], "repeated": [{"nrep": 4, "parameters": ["HEAT"]}]}]}],
    }],
    "catalogue": {
        "kinds": {"id": {"coding": "u16", "meaning": ""}, "part": {"coding": "rest", "meaning": ""}},
        "failures": {"1": ["no route", ""]},
        "services": {"17": {"enumerations": {"of": {"2": "two"}}, "messages": [
            {"direction": "TC", "subtype": 1, "name": "say \"hello\"", "fields": [{"repeat": "n", "fields": [{"name": "of", "kind": "id"}]}]}]}},
    },
}
TABLES = '''local MISSION = {
  ["name"] = "small",
  ["epoch"] = 100,
  ["port"] = 10015,
  ["apids"] = {[16] = "LAMP"},
}
local INTERFACES = {
  [16] = "00000000000000FE",
}
local LAYOUTS = {
  [0] = "UINT8",
  [8] = "FLOAT",
}
local WORDS = {
  ["LAMP.LIGHT"] = {[0] = "DARK", [1] = "BRIGHT"},
  ["apid"] = {[16] = "LAMP"},
  ["device_LAMP"] = {[2] = "BULB"},
  ["failure_code"] = {[1] = "no route", [32769] = "LAMP.BURNT"},
  ["layout"] = {[0] = "UINT8", [8] = "FLOAT"},
  ["link_id"] = {},
  ["mode8"] = {[1] = "NOMINAL"},
  ["st17.of"] = {[2] = "two"},
  ["type"] = {[0] = "TM", [1] = "TC"},
  ["user"] = {[0] = "all", [1] = "CLI"},
}
'''
FIELDS = '''  ["lamp.dim.to"] = {"UINT8", "TO", "LAMP.LIGHT"},
  ["lamp.heat.core"] = {"FLOAT", "CORE [K]", false},
  ["lamp.hot.part"] = {"UINT8", "PART", "device_LAMP"},
  ["lamp.light"] = {"UINT8", "LIGHT", "LAMP.LIGHT"},
'''
LAYOUTS = '''local NAMES = {
  ["configuration"] = {[16] = {[7] = "ON"}},
  ["device"] = {},
  ["failure"] = {},
}
local PARAMETERS = {
  [33554433] = {["name"] = "LAMP.LIGHT", ["items"] = {{"lamp.light", "UINT8", 1}}},
  [35127298] = {["name"] = "LAMP.HEAT", ["items"] = {{"lamp.heat.core", "FLOAT", 2}}},
}
local STRUCTURES = {
  [16] = {[5] = {{["configuration"] = 7, ["items"] = {{"lamp.light", "UINT8", 1}, {4, {{"lamp.heat.core", "FLOAT", 2}}}}}}},
}
local EVENTS = {
  [16] = {[3] = {["name"] = "HOT", ["items"] = {{"lamp.heat.core", "FLOAT", 2}, {"lamp.hot.part", "UINT8", 1}}}},
}
local FUNCTIONS = {
  [16] = {["DIM"] = {[1] = {"lamp.dim.to", "UINT8", 1}}},
}
local CATALOGUE = {
  ["kinds"] = {["id"] = {["coding"] = "u16"}, ["part"] = {["coding"] = "rest"}},
  ["messages"] = {["TC[17,1]"] = {["name"] = "say \\034hello\\034", ["fields"] = {{["repeat"] = "n", ["fields"] = {{["name"] = "of", ["kind"] = "id"}}}}}},
}
'''


def test_the_tables_of_a_dissector_are_as_expected():
    text = dissector.script(SMALL)
    assert text.splitlines()[1] == (
        "-- Wireshark dissector of PUS packets, mission small; interface 0x0123456789ABCDEF, configuration 0x02. Made by gse/generator; "
        "do not edit.")
    for part in (TABLES, FIELDS, LAYOUTS):
        assert part in text, text[:6000]


def shown_by_wireshark(script, path, raws):
    """The lines of tshark about the fields of packets, without the filter of their names."""
    return [line.strip() for line in dissection.tshark(script, dissection.capture(path, raws), "-V").splitlines()]


def test_wireshark_names_an_event_by_the_subsystem_that_it_is_about(made, tmp_path):
    """Event 3 is TORQUE_LIMIT of MANIPULATOR and NETWORK_SHUT_DOWN of SUPERVISOR; the APID is in the event, in a group, or in the header."""
    script = tmp_path / "rokviss.lua"
    script.write_bytes(made[0][pathlib.Path("rokviss.lua")])
    supervisor = next(one for one in json.loads(made[0][pathlib.Path("rokviss.json")])["subsystems"] if one["name"] == "SUPERVISOR")
    ids = {event["name"]: event["id"] for event in supervisor["events"]}
    told = struct.pack(">HHBHBH", ids["ADOPTION_DIFFERS"], 16, 5, 3, 5, 1)
    seen = [shown_by_wireshark(script, tmp_path / "one.pcap", [raw]) for raw in (
        build_tm(1, 0, 5, 1, struct.pack(">HHH", ids["PLAN_STARTED"], 16, 3)), build_tm(1, 0, 5, 1, struct.pack(">HHHHH", ids["PLAN_OVERRULED"], 1, 3, 16, 3)),
        build_tm(1, 0, 5, 2, told), packets.build_tc(16, 0, 5, 5, b"\1\0\3"), build_tm(1, 0, 19, 7, struct.pack(">HHHBHHB", 2, 16, 3, 1, 1, 3, 0)),
        build_tm(16, 0, 129, 5, struct.pack(">BBBHQQII", 3, 0, 3, 3, 0, 0, 0, 0)), build_tm(1, 0, 5, 1, struct.pack(">HHH", ids["PLAN_STARTED"], 99, 3)))]
    wanted = [["EVENT: 3 (TORQUE_LIMIT)"], ["EVENT: 3 (NETWORK_SHUT_DOWN)", "BY_EVENT: 3 (TORQUE_LIMIT)"], ["CONFIGURATION: 3 (CLASSIC)", "TOLD_CONFIGURATION: 1 (STAND_ALONE)"],
              ["event definition id: 3 (TORQUE_LIMIT)"], ["event definition id: 3 (TORQUE_LIMIT)", "event definition id: 3 (NETWORK_SHUT_DOWN)"], ["configuration: 3 (CLASSIC)"], ["EVENT: 3"]]
    for lines, names in zip(seen, wanted):
        assert [line for line in lines if line in names] == names, (names, lines)
        assert [line for line in lines if re.search("[A-Z_]{3,} or [A-Z_]{3,}|pus.malformed|Differs from", line)] == []


def test_wireshark_names_a_device_by_its_configuration_and_a_failure_by_its_subsystem(tmp_path):
    """Two configurations use a node for different devices, and two subsystems a code for different failures. Until a subsystem reports its
    configuration, the dissector shows no name of such a device."""
    lamp = json.loads(json.dumps(SMALL["subsystems"][0]))
    ends = [{"endnodes": [{"node": "0x11"}], "name": name} for name in ("BULB", "TUBE")]
    lamp["configurations"] = [{**lamp["configurations"][0], "id": number, "name": name, "devices": [end]} for number, name, end in ((7, "ON", ends[0]), (8, "DIM", ends[1]))]
    lamp["events"] = [{"name": "HOT", "id": 3, "parameters": [{"name": "NODE", "type": "UINT8", "count": 1, "unit": "", "kind": "CANopen node"}]}]
    lamp["identifiers"] = identifiers.devices(lamp["configurations"])
    other = {**lamp, "name": "FAN", "apid": 17, "failures": [{"name": "STUCK", "code": 0x8001, "detail": ""}]}
    content = json.loads((ROOT / "build" / "generated" / "rokviss.json").read_text(encoding="utf-8"))["catalogue"]
    script = tmp_path / "small.lua"
    script.write_text(dissector.script({**SMALL, "subsystems": [lamp, other], "catalogue": content, "types": {**SMALL["types"]}}), encoding="utf-8")
    state = [build_tm(16, 0, 129, 5, struct.pack(">BBBHQQII", 3, 0, 3, number, 0, 0, 0, 0)) for number in (7, 8)]
    event = build_tm(16, 0, 5, 4, b"\0\3\x11")
    refused = [build_tm(apid, 0, 1, 2, struct.pack(">HHHHI", 0x1800 | apid, 0xC000, 0x8001, 0, 0)) for apid in (16, 17)]
    lines = shown_by_wireshark(script, tmp_path / "all.pcap", [event, state[0], event, state[1], event, *refused])
    assert [line for line in lines if line.startswith("NODE")] == ["NODE: 17", "NODE: 17 (BULB)", "NODE: 17 (TUBE)"]
    assert [line for line in lines if line.startswith("failure code")] == ["failure code: of the subsystem (32769) (BURNT)", "failure code: of the subsystem (32769) (STUCK)"]
