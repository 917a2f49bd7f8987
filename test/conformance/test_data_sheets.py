# SPDX-License-Identifier: Apache-2.0
"""The data sheets (EDS) of the devices, as PyPI canopen reads them, compared object by object with the
simulated devices."""

import configparser
import pathlib
import shutil
import sys
import xml.etree.ElementTree as ET

import canopen
import pytest
from canopen.objectdictionary import ODVariable
from simulated import CUBE, SHEETS, Simulator, pass_time, patient

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "gse"))
from generator import sheet as reader  # noqa: E402

# World, bus and node of the device that is simulated.
PLACES = {"joint-drive": ("rokviss", "robot", 0x11), "joystick": ("rokviss", "joystick", 0x21), "valve-box": ("actuators", "platform", 0x3A),
          "gyro": ("actuators", "platform", 0x2B)}
# Devices of the world cube.
OF_CUBE = {element.get("eds").removesuffix(".eds"): (None, element.get("bus"), int(element.get("node"), 0))
           for element in ET.parse(CUBE).getroot() if element.get("eds")}
# Any other sheet replaces the sheet of a device of PLACES. The first of these section names that the sheet contains selects the device.
MARKS = {"[6840]": "joystick", "[6200]": "valve-box", "[6040]": "joint-drive", "[6131]": "gyro"}
IN_PLACE_OF = {path.stem: next(name for mark, name in MARKS.items() if mark in path.read_text(encoding="utf-8"))
               for path in SHEETS.glob("*.eds") if path.stem not in OF_CUBE}
DEVICES = {**{name: PLACES[other] for name, other in sorted(IN_PLACE_OF.items())}, **OF_CUBE}
# Objects whose values change while the device runs: they are not compared with their defaults.
CHANGING = {0x1001, 0x6041, 0x6062, 0x6064, 0x606B, 0x606C, 0x6074, 0x6077, 0x6078, 0x60F4, 0x2220,
            0x6841, 0x6864, 0x686C, 0x6874, 0x6877, 0x6878, 0x60FD, 0x6130, 0x6150, 0x9130, 0x2100, 0x2102, 0x2103, 0x2104}
NO_OBJECT, NO_MEMBER, READ_ONLY, NOT_NOW = 0x06020000, 0x06090011, 0x06010002, 0x08000022
ACCESS = {"const", "ro", "rw", "rww", "rwr", "wo"}
VISIBLE_STRING = 9  # Data type of CiA 301.


def variables(dictionary):
    """Every variable: objects that are variables, and the members of other objects."""
    for entry in dictionary.values():
        yield from [entry] if isinstance(entry, ODVariable) else entry.values()


@pytest.fixture(scope="module", params=DEVICES)
def sheet(request):
    """Name, path and dictionary of a device."""
    path = SHEETS / f"{request.param}.eds"
    return request.param, path, canopen.import_od(str(path), DEVICES[request.param][2])


def test_the_lists_of_the_sheet_name_its_objects(sheet):
    """CiA 306: mandatory, optional and manufacturer objects are numbered, and each has its section."""
    _, path, dictionary = sheet
    reader = configparser.ConfigParser(interpolation=None, comment_prefixes=(";",))
    reader.read(path)
    listed = []
    for kind in ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects"):
        section = reader[kind]
        listed += [int(section[str(number)], 0) for number in range(1, int(section["SupportedObjects"]) + 1)]
        assert len(section) == int(section["SupportedObjects"]) + 1, kind
    assert sorted(listed) == sorted(dictionary) == sorted(set(listed))
    assert listed[:3] == [0x1000, 0x1001, 0x1018]
    for index in dictionary:
        area = "ManufacturerObjects" if 0x2000 <= index < 0x6000 else None
        assert area is None or f"0x{index:04x}" in {value.lower() for value in reader[area].values()}, f"{index:04X}"


def test_every_variable_is_described_in_full(sheet):
    _, _, dictionary = sheet
    for variable in variables(dictionary):
        name = f"{variable.index:04X}:{variable.subindex:02X}"
        assert variable.access_type in ACCESS, name
        assert variable.name and variable.data_type in canopen.objectdictionary.datatypes.NUMBER_TYPES + (VISIBLE_STRING,), name
        assert variable.default is not None, name
    for index, entry in dictionary.items():
        if not isinstance(entry, ODVariable) and index != 0x1003:  # In 0x1003 it is the number of errors.
            highest = max(entry)
            assert entry[0].default == highest or 0x1600 <= index < 0x1C00 and entry[0].default < highest, f"{index:04X}"


def test_mappings_are_of_objects_that_may_be_mapped(sheet):
    _, _, dictionary = sheet
    for index in dictionary:
        if 0x1600 <= index < 0x1800 or 0x1A00 <= index < 0x1C00:
            for number in range(1, dictionary[index][0].default + 1):
                entry = dictionary[index][number].default
                variable = dictionary.get_variable(entry >> 16, entry >> 8 & 0xFF)
                assert variable.pdo_mappable and len(variable) == entry & 0xFF
                assert "w" in variable.access_type or index >= 0x1A00


def test_a_sheet_that_is_written_again_has_the_same_objects(sheet, tmp_path):
    name, _, dictionary = sheet
    canopen.export_od(dictionary, str(tmp_path / "again.eds"))
    again = canopen.import_od(str(tmp_path / "again.eds"), DEVICES[name][2])
    assert [(one.index, one.subindex, one.name, one.data_type, one.access_type, one.default) for one in variables(again)] == [
        (one.index, one.subindex, one.name, one.data_type, one.access_type, one.default) for one in variables(dictionary)]


def test_the_reader_of_the_ground_finds_the_same_objects(sheet):
    """Names, types and defaults for one node id are those that canopen reads."""
    name, path, dictionary = sheet
    ours = reader.load(path)
    assert {key: (entry.name, entry.kind) for key, entry in ours.entries.items()} == {
        (one.index, one.subindex): (one.name.split(".")[-1], one.data_type) for one in variables(dictionary)}
    assert ours.defaults(DEVICES[name][2]) == {
        (one.index, one.subindex): one.default for one in variables(dictionary) if isinstance(one.default, int)}


@pytest.fixture(scope="module")
def device(sheet, tmp_path_factory):
    """The simulated device, which has booted, as a node of canopen."""
    name, path, _ = sheet
    place, bus, number = DEVICES[name]
    directory = tmp_path_factory.mktemp("sheet")
    shutil.copytree(SHEETS.parent, directory / "descriptors")
    world = CUBE
    if name in IN_PLACE_OF:
        world = directory / f"descriptors/worlds/{place}.xml"
        placed = world.read_text(encoding="utf-8").replace(f'eds="{IN_PLACE_OF[name]}.eds"', f'eds="{name}.eds"')
        world.write_text(placed, encoding="utf-8")
    simulator = Simulator(directory, "--in-step", "--quantum", "2000", world=world)
    network = simulator.connect(bus)
    node = patient(network.add_node(number, str(path)))
    pass_time(network, 10)
    yield node
    simulator.close()


def refusal(call, *arguments):
    """Abort code of an access; 0 if it succeeded."""
    try:
        call(*arguments)
    except canopen.SdoAbortedError as aborted:
        return aborted.code
    return 0


def test_every_object_of_the_sheet_is_served_with_its_size_and_default(device):
    served = 0
    for variable in variables(device.object_dictionary):
        raw = device.sdo.upload(variable.index, variable.subindex)
        name = f"{variable.index:04X}:{variable.subindex:02X}"
        served += 1
        if variable.data_type != VISIBLE_STRING:
            assert len(raw) == len(variable) // 8, name
        if variable.index not in CHANGING:
            assert variable.decode_raw(raw) == variable.default, name
    assert served == sum(1 for _ in variables(device.object_dictionary)) > 80


def test_nothing_is_served_that_is_not_in_the_sheet(device):
    """The neighbours of every object and the sub-index after the last one of each object do not exist."""
    dictionary = device.object_dictionary
    for index in dictionary:
        for neighbour in (index - 1, index + 1):
            if neighbour not in dictionary:
                assert refusal(device.sdo.upload, neighbour, 0) == NO_OBJECT, f"{neighbour:04X}"
        entry = dictionary[index]
        last = 0 if isinstance(entry, ODVariable) else max(entry)
        assert refusal(device.sdo.upload, index, last + 1) == NO_MEMBER, f"{index:04X}"


def test_access_types_are_those_of_the_sheet(device):
    """An object that can be written accepts its own value; any other object refuses it with the correct
    code."""
    counts = {"refused": 0, "taken": 0, "not now": 0}
    for variable in variables(device.object_dictionary):
        raw = device.sdo.upload(variable.index, variable.subindex)
        code = refusal(device.sdo.download, variable.index, variable.subindex, raw)
        name = f"{variable.index:04X}:{variable.subindex:02X}"
        if variable.access_type in ("ro", "const"):
            assert code == READ_ONLY, name
            counts["refused"] += 1
        elif code == 0:
            assert device.sdo.upload(variable.index, variable.subindex) == raw, name
            counts["taken"] += 1
        # CiA 301: PDO parameters cannot change while the PDO exists; the SYNC counter cannot change while
        # there is a period.
        else:
            assert code == NOT_NOW and (variable.index == 0x1019 or 0x1400 <= variable.index < 0x1C00), f"{name}: {code:08X}"
            counts["not now"] += 1
    assert min(counts.values()) > 10, counts
