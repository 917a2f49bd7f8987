# SPDX-License-Identifier: Apache-2.0
"""A subsystem with 32 devices: on four buses with 1, 15, 8 and 8, and on two with 16 each. Mission, descriptor and world are generated; the
program is that of ACTUATORS, built from the generated descriptor. One device more is refused with file and line."""

import itertools
import re
import shutil
import struct
import subprocess
import sys

import flying
import pytest
import second_reader

sys.path.insert(0, str(flying.ROOT / "gse" / "generator"))

import c_header
import subsystem

pytestmark = pytest.mark.long  # The program is built.

DEVICES, FIRST_NODE = 32, 0x11
COMMAND_US = 56
PERIOD_US = 4000  # In each period, 16 drives on a bus receive and send 32 frames of COMMAND_US.
UNPLUGGED = FIRST_NODE + 9
UNPLUG_S = 3.0
ENABLED = 0x0F
BUS = '<Bus name="platform" bitRate="1000000" dataBitRate="5000000"/>'
BENCH = '<Bench name="D{index}" type="light" bus="bus-{bus}" node="{node:#x}" eds="joint-drive.eds" contact="1" stiffness="0" range="1.5"/>'
DEVICE = """<Device name="D{index}" type="joint-drive">
<Setting object="0x1401:01" type="UINT32" value="{second:#010x}"/>
<Setting object="0x1400:01" type="UINT32" value="{first:#010x}"/>
<Setting object="0x1400:05" type="UINT16" value="16"/>
<Setting object="0x60C2:01" type="UINT8" value="40"/>
<Setting object="0x60E0:00" type="UINT16" value="4000"/>
<Setting object="0x60E1:00" type="UINT16" value="4000"/>
<Setting object="0x2230:02" type="UINT32" value="60000"/>
<Setting object="0x6060:00" type="INT8" value="8"/>
<Endnode type="CAN" bus="bus-{bus}" node="{node:#x}"/></Device>"""
TARGETS = [round(0.002 * (index + 1), 3) for index in range(DEVICES)]
LINES = (
    "0.2 operator state ACTUATORS PRE_OPERATIONAL",
    "0.8 operator config ACTUATORS NOMINAL",
    "1.4 operator state ACTUATORS SAFE_OPERATIONAL",
    "1.7 operator state ACTUATORS OPERATIONAL",
    f"2.0 operator set ACTUATORS.TARGET {','.join(map(str, TARGETS))}",
    "2.8 operator hk once ACTUATORS 1",
    f"{UNPLUG_S} fault unplug bus-{{bus}} {UNPLUGGED:#x}",
    "3.4 operator shutdown",
)


def buses_of(count, buses):
    """Number of the bus of each device. Each bus has count / buses devices; but of four buses the first has one device, and the second has
    those that the first lacks."""
    first = count // buses
    own = [1 + index * buses // count for index in range(count)]
    return [2 if buses == 4 and 0 < index < first else bus for index, bus in enumerate(own)]


def descriptor(count, buses):
    """Text of the descriptor of ACTUATORS with `count` drives on `buses` buses, and with parameters for 32 axes."""
    text = (flying.ROOT / "descriptors" / "subsystems" / "actuators.xml").read_text(encoding="utf-8")
    listed = [DEVICE.format(index=index, bus=bus, node=FIRST_NODE + index, first=0x200 + FIRST_NODE + index, second=0x80000300 + FIRST_NODE + index)
              for index, bus in enumerate(buses_of(count, buses))]
    configuration = re.search(r'  <Configuration name="NOMINAL".*?</Configuration>\n', text, re.DOTALL)[0]
    head, tail = text[: text.index("  <!-- The boom runs against")], "</Subsystem>\n"
    configuration = configuration.replace('samplingTime="1ms"', f'samplingTime="{PERIOD_US}us"').replace('id="2"', 'id="1"', 1)
    configuration = re.sub(r"<Devices>.*</Devices>", lambda _: "<Devices>\n" + "\n".join(listed) + "\n</Devices>", configuration, flags=re.DOTALL)
    return head.replace('count="8"', f'count="{DEVICES}"') + configuration + tail


def put(tree, count, buses, sync="AFTER_COMMANDS"):
    """Write descriptor, mission and world. Returns the bus of each device."""
    own = buses_of(count, buses)
    text = descriptor(count, buses).replace("<Subsystem ", f'<Subsystem sync="{sync}" ', 1)
    (tree / "descriptors" / "subsystems" / "actuators.xml").write_text(text, encoding="utf-8")
    mission = (flying.ROOT / "descriptors" / "missions" / "actuators.xml").read_text(encoding="utf-8")
    mission = mission.replace(BUS, "\n".join(BUS.replace("platform", f"bus-{1 + number}") for number in range(buses)))
    (tree / "descriptors" / "missions" / "actuators.xml").write_text(mission, encoding="utf-8")
    world = (flying.ROOT / "descriptors" / "worlds" / "actuators.xml").read_text(encoding="utf-8")
    benches = [BENCH.format(index=index, bus=own[index], node=FIRST_NODE + index) for index in range(min(count, DEVICES))]
    world = re.sub(r"  <Bench .*(?=</World>)", lambda _: "\n".join(benches) + "\n", world, flags=re.DOTALL)
    (tree / "descriptors" / "worlds" / "actuators.xml").write_text(world, encoding="utf-8")
    return own


@pytest.fixture(scope="module")
def tree(session_directory):
    """A copy of the project whose program of ACTUATORS is built from the descriptor with 32 axes."""
    place = flying.descriptors_copied(session_directory / "many")
    for name in ("build", "gse"):
        (place / name).unlink()
    shutil.copytree(flying.ROOT / "gse", place / "gse", ignore=shutil.ignore_patterns("__pycache__"))  # gse reads the dictionary of the tree that it is in.
    for name in ("base", "fsw", "pus"):
        (place / name).symlink_to(flying.ROOT / name)
    second_reader._link_all(flying.ROOT / "build", place / "build", ("bin", "generated", "test"))
    shutil.copytree(flying.BIN, place / "build" / "bin")  # The launcher looks for programs in its own directory.
    put(place, DEVICES, 4)
    made = place / "build" / "shadow" / "generated"
    made.mkdir(parents=True)
    path = place / "descriptors" / "subsystems" / "actuators.xml"
    (made / "actuators_descriptor.h").write_text(c_header.header(subsystem.load(path), path.name), encoding="utf-8")
    sources = [*flying.ROOT.glob("fsw/programs/actuators_*.c"), *flying.ROOT.glob("fsw/subsystems/actuators/*.c")]
    second_reader._link("actuators", place, second_reader.FLIGHT, sources)
    return place


def generate(tree):
    command = [sys.executable, tree / "gse" / "generator" / "generate.py", "--mission", tree / "descriptors" / "missions" / "actuators.xml",
               "--out", tree / "build" / "generated"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def fly(tree, directory, bus):
    scenario = flying.write_scenario(directory.with_suffix(".scn"), *(line.replace("{bus}", str(bus)) for line in LINES))
    return flying.fly(directory, "--mission", "actuators", "--scenario", scenario, "--form", "processes", root=tree)


def frames(flight, bus):
    """(time [us], identifier, octets) of the frames on a bus."""
    found = re.findall(rf"\((\d+)\.(\d+)\) bus-{bus} ([0-9A-F]{{3}})#(?:#.)?([0-9A-F]*)", flight.read(f"can-bus-{bus}.log"))
    return [(int(seconds) * 1_000_000 + int(rest), int(identifier, 16), bytes.fromhex(data)) for seconds, rest, identifier, data in found]


@pytest.mark.parametrize(("buses", "sync"), [(4, "AFTER_COMMANDS"), (2, "AFTER_COMMANDS"), (4, "BEFORE_COMMANDS")])
def test_32_devices_of_one_subsystem_fly_and_are_secured_together(tree, tmp_path, buses, sync):
    own = put(tree, DEVICES, buses, sync)
    generate(tree)
    flight = fly(tree, tmp_path / "run", own[UNPLUGGED - FIRST_NODE])
    assert flight.code == 0, flight.transcript()
    report = next(line for line in reversed(flight.read("operator.log").splitlines()) if '"verb": "hk"' in line)
    positions = [float(word) for word in re.search(r"POSITION: \[([-+0-9.e, ]+)\]", report)[1].split(",")]
    assert max(abs(found - wanted) for found, wanted in zip(positions, TARGETS, strict=True)) < 1e-3, positions
    seen = {number: frames(flight, number) for number in range(1, 1 + buses)}
    assert [own.count(number) for number in seen] == ([1, 15, 8, 8] if buses == 4 else [16, 16])

    # SYNC is sent in the same cycles on all buses. After the commands, a bus with fewer drives sends it earlier, and the numbers of stuff bits of the
    # commands, each of which takes 1 us at most, differ from bus to bus. Before the commands, all buses send it at the same instant.
    syncs = {number: [time for time, identifier, _ in rows if identifier == 0x080] for number, rows in seen.items()}
    assert len({len(times) for times in syncs.values()}) == 1 and len(syncs[1]) > 400
    for one, other in itertools.combinations(seen, 2):
        more = abs(own.count(one) - own.count(other))
        apart = max(abs(first - second) for first, second in zip(syncs[one], syncs[other]))
        permitted = COMMAND_US * more + 2 * min(own.count(one), own.count(other)) if sync == "AFTER_COMMANDS" else 0
        assert apart <= permitted, (one, other, apart)

    # One device is lost: all others are commanded out of operation in one cycle, each before the answer of any.
    words = {}
    for index, number in enumerate(own):
        node = FIRST_NODE + index
        words[node] = [(time, struct.unpack_from("<H", data)[0]) for time, identifier, data in seen[number] if identifier == 0x200 + node]
    left = {node: next(time for time, word in rows if time > UNPLUG_S * 1e6 and word != ENABLED) for node, rows in words.items()}
    assert all(next(word for time, word in rows if time > 2_500_000) == ENABLED for rows in words.values())
    assert len(left) == DEVICES and max(left.values()) - min(left.values()) < PERIOD_US, left
    for index, number in enumerate(own):
        node = FIRST_NODE + index
        last = [struct.unpack_from("<H", data)[0] for _, identifier, data in seen[number] if identifier == 0x180 + node][-1]
        assert (last & 0x6F != 0x27) or node == UNPLUGGED, f"node {node:#x} ends with statusword {last:#06x}"
    flying.assert_clean(flight)


@pytest.mark.parametrize(("count", "buses", "refused", "words"), [
    (DEVICES + 1, 3, DEVICES, "too many nodes of one subsystem, at most 32"),
    (DEVICES, 1, 16, "too many nodes on one bus, at most 16"),
], ids=["33-devices", "17-on-one-bus"])
def test_one_device_more_is_refused_with_file_and_line(tree, tmp_path, count, buses, refused, words):
    put(tree, count, buses)
    path = tree / "descriptors" / "subsystems" / "actuators.xml"
    lines = path.read_text(encoding="utf-8").splitlines()
    line = 1 + next(number for number, text in enumerate(lines) if f'node="{FIRST_NODE + refused:#x}"/></Device>' in text)
    flight = fly(tree, tmp_path / "run", 1)
    assert flight.code == 1
    assert re.search(rf"actuators\.xml:{line}: {words}", flight.output + flight.console), flight.transcript()
    flying.assert_clean(flight)
