# SPDX-License-Identifier: Apache-2.0
"""Drives of another manufacturer for the arm (another vendor, product, unit, rated torque, mapping), or
drives on two buses. Only world and descriptor change; no C code changes and nothing is built."""

import re
import struct

import flying
import pytest
from hirosco_gse import figures
from hirosco_gse import run as runs

DESCRIPTOR = "descriptors/subsystems/manipulator.xml"
WORLD = "descriptors/worlds/rokviss.xml"
INCREMENT = "2.9960562e-7"  # 2 pi / (131072 x 160) rad.
VENDOR = 0x101801  # Object 0x1018:01, as in DEVICE_REFUSED: index * 256 + subindex.


@pytest.fixture
def root(directory):
    """A copy of the descriptors in a directory that otherwise refers to the project."""
    return flying.descriptors_copied(directory)


def _swap_in_world(root, joints):
    text = (root / WORLD).read_text(encoding="utf-8")
    for joint in joints:
        text, count = re.subn(rf'(<Drive name="{joint}"[^>]*eds=")joint-drive', r"\1servo-drive", text)
        assert count == 1
    (root / WORLD).write_text(text, encoding="utf-8")


def _swap_in_descriptor(root, joints):
    text = (root / DESCRIPTOR).read_text(encoding="utf-8")
    swapped = re.sub(r'      <Device name="(\w+)".*?</Device>\n', lambda found: _device(found[0]) if found[1] in joints else found[0],
                     text, flags=re.DOTALL)
    assert swapped.count('type="servo-drive"') == 4 * len(joints)
    (root / DESCRIPTOR).write_text(swapped, encoding="utf-8")


def _device(text):
    """A servo drive receives torques in its first RPDO and positions in its second; it reports neither
    temperature nor brake state."""
    text = text.replace('type="joint-drive"', 'type="servo-drive"').replace('scale="1e-6"', f'scale="{INCREMENT}"')
    text = re.sub(r"0x140([01]):", lambda found: f"0x140{1 - int(found[1])}:", text)
    # The COB-IDs 0x200 + node and 0x300 + node change places; bit 31 (0x8...: PDO is not valid) stays.
    text = re.sub(r'"0x([08])0000([23])(1[12])"', lambda found: f'"0x{found[1]}0000{5 - int(found[2])}{found[3]}"', text)
    return re.sub(r' *<Quantity name="(?:TEMPERATURE|BRAKE)".*\n', "", text)


def _fly(root, scenario, form="image"):
    return flying.fly(root / "out", "--scenario", scenario, "--form", form, "--world", root / WORLD, root=root)


@pytest.mark.parametrize(("joints", "form"), [
    pytest.param(("JOINT1", "JOINT2"), "image", id="both"),
    pytest.param(("JOINT1", "JOINT2"), "processes", id="both-in-processes", marks=pytest.mark.long),
    pytest.param(("JOINT2",), "image", id="one", marks=pytest.mark.long)])
def test_drives_of_another_maker_fly_the_mission(root, joints, form):
    """All figures are within their bounds; the frames on the bus have the other layout."""
    _swap_in_world(root, joints)
    _swap_in_descriptor(root, joints)
    flight = _fly(root, "telepresence", form)
    assert flight.code == 0, flight.transcript()
    found, reasons = figures.compute(runs.load(flight.directory))
    assert not reasons
    assert [name for name in figures.BOUNDS if not figures.holds(name, found[name])] == []
    log = (flight.directory / "can-robot.log").read_text(encoding="utf-8")
    lengths = {node: {len(words) // 2 for words in re.findall(rf" 2{node:02X}##1([0-9A-F]+)", log)} for node in (0x11, 0x12)}
    assert lengths[0x12] == {4}, "expected torque and controlword"
    assert (lengths[0x11] == {4}) == ("JOINT1" in joints)
    flying.assert_clean(flight)


def _refusals(flight):
    """(node, reason, object, value found) of each event DEVICE_REFUSED of the manipulator with the reason 4: another value than expected."""
    return [struct.unpack(">BBII", raw[23:33]) for _, direction, raw in flight.packets
            if direction == "TM" and raw[7] == 5 and raw[1] == 16 and raw[24] == 4]


@pytest.mark.parametrize("swap", [_swap_in_world, _swap_in_descriptor])
def test_a_drive_whose_vendor_differs_from_the_descriptor_is_refused(root, swap):
    """Commissioning reads the vendor before any motion."""
    swap(root, ("JOINT1",))
    flight = _fly(root, "commissioning")
    assert flight.code != 0
    assert _refusals(flight)[0] == (0x11, 4, VENDOR, 0xFFFFFF01 if swap is _swap_in_world else 0), flight.transcript()


@pytest.mark.parametrize(("eds", "old", "new", "object_", "found"), [
    ("joint-drive", "DefaultValue=0x4010", "DefaultValue=0x4012", 0x101802, 0x4012),
    ("joint-drive", "DefaultValue=0xFA100000", "DefaultValue=0xFD410000", 0x60A800, 0xFD410000),
], ids=["product", "unit"])
def test_a_device_that_is_not_of_its_class_is_refused(root, eds, old, new, object_, found):
    """The simulated device has another product code or another unit of positions; its data sheet has another
    name."""
    text = (root / f"descriptors/devices/{eds}.eds").read_text(encoding="utf-8")
    assert text.count(old) == 1
    (root / "descriptors/devices/other.eds").write_text(text.replace(old, new), encoding="utf-8")
    flying.replace(root / WORLD, ('node="0x12" eds="joint-drive.eds"', 'node="0x12" eds="other.eds"'))
    flight = _fly(root, "commissioning")
    assert flight.code != 0
    assert _refusals(flight)[0] == (0x12, 4, object_, found), flight.transcript()


def test_a_sheet_that_changed_after_the_build_is_reported_with_both_hashes(root):
    """The change is reported before any process starts: the programs contain the classes of another data
    sheet."""
    sheet = root / "descriptors/devices/gyro.eds"
    built = re.search(r'"gyro", .sheet_hash = 0x(\w+)ULL', (flying.ROOT / "build/generated/device_classes.h").read_text(encoding="utf-8"))[1]
    sheet.write_text(sheet.read_text(encoding="utf-8") + "; changed\n", encoding="utf-8")
    flight = _fly(root, "commissioning")
    assert flight.code == 1
    message = re.search(r"descriptors/devices/gyro.eds: expected hash 0x(\w+), from which the programs were built, found 0x(\w+): run make", flight.output)
    assert message and message[1].lower() == built and message[2].lower() != built, flight.transcript()


ELBOW = '    <Bus name="elbow" bitRate="1000000" dataBitRate="5000000"/>\n'


def test_the_arm_flies_with_its_joints_on_two_buses(root):
    """All figures are within their bounds; SYNC is sent on both buses at the same instants, since each bus has the commands of one drive."""
    flying.replace(root / "descriptors/missions/rokviss.xml", ('    <Bus name="robot-b"', ELBOW + '    <Bus name="robot-b"'))
    flying.replace(root / WORLD, ('type="light" bus="robot" node="0x12"', 'type="light" bus="elbow" node="0x12"'))
    flying.replace(root / WORLD, ('    <Supply device="JOINT2"/>\n', ""))
    flying.replace(root / DESCRIPTOR, ('bus="robot" redundantBus="robot-b" node="0x12"', 'bus="elbow" node="0x12"'))
    flying.replace(root / DESCRIPTOR, ('        <Supply unit="0x1F" on="3" off="4"/>\n', ""))
    flight = _fly(root, "telepresence")
    assert flight.code == 0, flight.transcript()
    found, reasons = figures.compute(runs.load(flight.directory))
    assert not reasons
    assert [name for name in figures.BOUNDS if not figures.holds(name, found[name])] == []
    first, second = (re.findall(r"\((\S+)\) \w+ 080#", (flight.directory / f"can-{bus}.log").read_text(encoding="utf-8")) for bus in ("robot", "elbow"))
    assert first[:50000] == second[:50000]
    assert len(first) > 100000
    flying.assert_clean(flight)
