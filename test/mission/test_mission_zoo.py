# SPDX-License-Identifier: Apache-2.0
"""Stream devices in flight: one on each type of end node except CAN, in stepped time; devices moved to
another end node by XML only; devices that are unplugged, are silent, or send invalid octets."""

import json
import os
import pathlib
import re
import shutil
import signal
import struct

import flying
import numpy as np
import pytest
from hirosco_gse import logs, truth

INSTRUMENTS = "descriptors/subsystems/instruments.xml"
WORLD = "descriptors/worlds/zoo.xml"
NAMES = ("MIRROR", "SHUTTER", "FILTER", "COVER", "ANTENNA", "BAFFLE")
KINDS = ("SHM", "UDP", "MQUEUE", "TCP", "SERIAL", "FILE")
LOGS = ("packets.log", "records.log")
# For each type, the attributes of the address in the descriptor and the channel in the world.
ADDRESSES = {
    "SHM": ('name="moved"', "moved"),
    "MQUEUE": ('name="moved"', "moved"),
    "UDP": ('address="10.1.2.3" port="15077"', "10.1.2.3:15077"),
    "TCP": ('address="10.1.2.3" port="15078" framing="SLIP"', "10.1.2.3:15078"),
    "SERIAL": ('name="/dev/ttyS7" framing="SLIP" baud="9600"', "/dev/ttyS7"),
    "FILE": ('name="/dev/adc7" framing="SLIP"', "/dev/adc7"),
}
UP = (
    "0.2 operator state INSTRUMENTS PRE_OPERATIONAL",
    "0.6 operator config INSTRUMENTS NOMINAL",
    "0.8 operator state INSTRUMENTS SAFE_OPERATIONAL",
    "1.0 operator state INSTRUMENTS OPERATIONAL",
)


def _fly(directory, scenario="zoo", form="image", root=flying.ROOT):
    return flying.fly(directory, "--mission", "zoo", "--scenario", scenario, "--form", form, root=root)


def _records(flight, name, mark):
    """(time s, octets) of the records that an instrument has sent (>) or received (<)."""
    lines = (line.split(" ") for line in flight.read("records.log").splitlines())
    return [(float(time), bytes.fromhex(octets)) for time, who, way, octets in lines if (who, way) == (name, mark)]


@pytest.fixture(scope="module")
def flights(session_directory):
    """Two flights as processes, two as an image."""
    found = [_fly(session_directory / f"zoo-{form}-{number}", form=form) for form in ("processes", "image") for number in range(2)]
    for flight in found:
        assert flight.code == 0, flight.transcript()
    return found


def test_every_end_node_flies_with_the_same_octets_in_each_form_and_repeat(flights):
    for log in LOGS:
        assert len({flight.octets(log) for flight in flights}) == 1, log


def test_every_device_is_heard_and_commanded(flights):
    for name in NAMES:
        assert len(_records(flights[0], name, ">")) > 400
        taken = _records(flights[0], name, "<")
        assert len(taken) > 4000
        enabled = [time for time, octets in taken if octets[0] == 1]
        assert 2.0 < min(enabled) < 2.02
        assert taken[-1][1][0] == 0, "expected the safe values in the last record"


def test_the_truth_has_every_instrument(flights):
    """The values that the devices have sent equal those of the truth log, in which each value is valid until
    the next one."""
    channels = logs.read_lcm(flights[0].directory / "truth.lcm")
    found = truth.decode(channels)
    (names,) = (entry["name"] for entry in found["NAMES"] if entry["channel"] == "INSTRUMENT")
    assert set(names) == set(NAMES)
    table = found["INSTRUMENT"]
    assert (np.ptp(table["value"], axis=0) > 0).all()
    assert table["enabled"].any(axis=0).all() and not table["enabled"][-1].any() and table["plugged"].all()
    enabled = truth.at(table, "enabled", np.arange(1.9e6, 2.1e6, 500), table["time_us"][-1])
    assert not enabled[0].any() and enabled[-1].all()


# Type, scale and offset of each instrument's value, and its value at rest after both targets of the scenario,
# rounded to its resolution.
VALUES = {"MIRROR": ("i", 1e-6, 0.0, -0.2), "SHUTTER": ("h", 1e-3, 2.0, -0.1), "FILTER": ("i", 1e-5, 0.0, 0.1),
          "COVER": ("f", 1.0, 0.0, 0.2), "ANTENNA": ("h", -2e-3, 0.1, -0.3), "BAFFLE": ("d", 1.0, 0.0, 0.0)}
LITTLE = ("SHUTTER", "FILTER", "ANTENNA")


def _values(flight, name, mark, order):
    """(time s, value in rad) of the records; the value follows the count and the word ENABLED, or ENABLE."""
    kind, scale, offset, _ = VALUES[name]
    at = 3 if mark == ">" else 1
    return [(time, struct.unpack_from(order + kind, octets, at)[0] * scale + offset) for time, octets in _records(flight, name, mark)]


def _reported(flight):
    """VALUE of each device in the report at 5.9 s."""
    steps = [json.loads(line) for line in flight.read("operator.log").splitlines()]
    report = next(step["outcome"] for step in steps if step["verb"] == "hk")
    return [float(number) for number in re.search(r" VALUE: \[([-+0-9.e, ]+)\]", report)[1].split(", ")]


def _moves_as_commanded(flight, name, order):
    """Expect that the device moves to both targets with its speed, and that the flight software has read the
    values that it has sent."""
    step, rest = abs(VALUES[name][1]) if VALUES[name][1] != 1.0 else 1e-6, VALUES[name][3]
    sent, commanded = _values(flight, name, ">", order), _values(flight, name, "<", order)
    first = (0.5, 0.4, 0.3, 0.6, 0.2, 0.7)[NAMES.index(name)]  # The first target in the scenario, at 2.5 s; the second one is set at 4 s.
    for time, target in ((3.99, first), (5.8, rest)):
        assert next(value for at, value in reversed(commanded) if at < time) == pytest.approx(target, abs=0.51 * step)
        assert next(value for at, value in reversed(sent) if at < time) == pytest.approx(target, abs=1.01 * step)
    speeds = [abs(after - before) / (later - earlier) for (earlier, before), (later, after) in zip(sent[::10], sent[10::10])]
    assert 0.4 < max(speeds) < 0.6
    assert _reported(flight)[NAMES.index(name)] == pytest.approx(rest, abs=1.01 * step)


def test_values_are_converted_in_both_directions(flights):
    """Type, byte order, scale and offset of each device are those of the values that it sends and receives,
    and of the telemetry."""
    for name in NAMES:
        _moves_as_commanded(flights[0], name, "<" if name in LITTLE else ">")


LOST = 16  # Offset of the number of losses in the memory of a counted hand-over (osal/common/hand_over.c).


def _with_a_loss(directory):
    """A flight as processes in which the counts of a device contain a loss. It is written while the simulator is suspended, early enough
    that the simulator still finds it at the end; a flight that ends before is repeated."""
    path = flying.write_scenario(directory.with_suffix(".scn"), "1.0 operator shutdown")
    while True:
        shutil.rmtree(directory, ignore_errors=True)
        flight = flying.start(directory, "--mission", "zoo", "--scenario", path)
        memories = pathlib.Path("/dev/shm")
        flying.wait_until(lambda: {"simulator", "operator"} <= set(flight.children()) or flight.process.poll() is not None, "the flight")
        simulator = flight.children().get("simulator")
        if simulator is not None:
            os.kill(simulator, signal.SIGSTOP)
            counts = list(memories.glob(f"{flight.identity}.flow.dev.baffle.n"))
            for memory in counts:
                with memory.open("r+b") as file:
                    file.seek(LOST)
                    file.write(struct.pack("=I", 3))
            os.kill(simulator, signal.SIGCONT)
            if counts:
                return flight.wait()
        flight.wait()


def test_a_run_in_which_octets_of_a_device_are_lost_is_not_reproducible(tmp_path, flights):
    assert all(flight.facts["reproducible"] for flight in flights)
    flight = _with_a_loss(tmp_path / "lossy")
    assert flight.code == 0, flight.transcript()
    assert "3 octets and datagrams sent between flight software and stream devices did not arrive; the run is not reproducible" in flight.console
    assert flight.facts["reproducible"] is False


def test_a_run_leaves_no_names(flights):
    for flight in flights:
        flying.assert_clean(flight)


@pytest.fixture
def root(tmp_path):
    """A copy of the descriptors; programs and scenarios are those of the project."""
    return flying.descriptors_copied(tmp_path / "root")


def _edit(root, path, pattern, new):
    text = (root / path).read_text(encoding="utf-8")
    changed, count = re.subn(pattern, new, text, flags=re.DOTALL)
    assert count == 1, pattern
    (root / path).write_text(changed, encoding="utf-8")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["MIRROR", "ANTENNA"])
def test_a_device_moves_to_another_end_node_by_xml_only(root, tmp_path, name, kind):
    address, channel = ADDRESSES[kind]
    order = ' order="LITTLE"' if name == "ANTENNA" else ""
    framing = ' framing="SLIP"' if kind in ("TCP", "SERIAL", "FILE") else ""
    _edit(
        root,
        INSTRUMENTS,
        rf'(<Device name="{name}".*?)<Endnode [^>]*/>',
        rf'\1<Endnode type="{kind}" {address}{order} checksum="true" silence="50ms"/>',
    )
    _edit(
        root,
        WORLD,
        rf'<Instrument name="{name}" .*?(period=[^>]*/>)',
        rf'<Instrument name="{name}" type="{kind}" channel="{channel}"{order}{framing} checksum="true" \1',
    )
    flight = _fly(tmp_path / "run", root=root)
    assert flight.code == 0, flight.transcript()
    assert len(_records(flight, name, "<")) > 4000
    _moves_as_commanded(flight, name, "<" if name == "ANTENNA" else ">")
    flying.assert_clean(flight)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (r'framing="LENGTH" checksum="true" silence="20ms" retry="5ms"', 'silence="20ms" retry="5ms"', "expected LENGTH or SLIP"),
        (r'(name="/dev/baffle") framing="SLIP"', r'\1 framing="SLIP" direction="READ"', "direction of <Endnode>"),
        (r'<Device name="MIRROR" type="stream">', '<Device name="MIRROR" type="gyro">', 'expected "stream"'),
    ],
)
def test_a_descriptor_that_does_not_fit_is_refused_before_the_flight(root, tmp_path, old, new, words):
    _edit(root, INSTRUMENTS, old, new)
    flight = _fly(tmp_path / "run", root=root)
    assert flight.code == 1
    assert re.search(r"instruments\.xml:\d+: [^\n]*" + re.escape(words), flight.output + flight.console), flight.transcript()
    flying.assert_clean(flight)


def test_devices_on_hosts_are_refused_on_two_computers_before_the_flight(root):
    """The network between two on-board computers has no connection to a device on a host. The scenario does not
    exist: a launcher that accepted the devices would end with that reason instead."""
    _edit(root, "descriptors/missions/zoo.xml", r'(<Subsystem name="INSTRUMENTS")', r'\1 node="2"')
    for kind, name in (("UDP", "SHUTTER"), ("TCP", "COVER")):
        text = (root / INSTRUMENTS).read_text(encoding="utf-8")
        line = text[: text.index(f'<Endnode type="{kind}"')].count("\n") + 1
        done = flying.refuse("run", "--mission", "zoo", "--nodes", 2, "--scenario", "nowhere", root=root)
        assert done.returncode == 1
        assert f'subsystems/instruments.xml:{line}: type="{kind}" of <Endnode>: expected no host with --nodes 2' in done.stderr, done.stderr
        assert "fly with --nodes 1" in done.stderr
        _edit(root, INSTRUMENTS, rf'(<Device name="{name}".*?)<Endnode [^>]*/>', rf'\1<Endnode type="SHM" name="{name.lower()}"/>')
    done = flying.refuse("run", "--mission", "zoo", "--nodes", 2, "--scenario", "nowhere", root=root)
    assert done.returncode == 1 and "Endnode" not in done.stderr, done.stderr


@pytest.mark.parametrize(
    ("fault", "end", "cause"),
    [("unplug {}", "plug {}", {"UDP": 2}), ("silent {} on", "silent {} off", dict.fromkeys(KINDS, 2)), ("garbage {} on", "garbage {} off", dict.fromkeys(KINDS, 3))],
    ids=["unplug", "silent", "garbage"],
)
def test_a_faulty_device_is_lost_with_its_cause_and_returns(session_directory, fault, end, cause):
    """Each device in turn: DEVICE_LOST, out of operation, DEVICE_RETURNED, and the same octets in both forms. `cause`
    gives the cause in DEVICE_LOST for a type of end node: 2 SILENT, 3 NO_RECORD; for a type that is not listed: 1
    CLOSED."""
    lines = list(UP)
    for index, name in enumerate(NAMES):
        start = 2.0 + index * 1.5
        lines += [
            f"{start:.4f} fault {fault.format(name)}",
            f"{start:.4f} operator wait-event INSTRUMENTS DEVICE_LOST 0.2",
            f"{start + 0.3:.4f} fault {end.format(name)}",
            f"{start + 0.3:.4f} operator wait-event INSTRUMENTS DEVICE_RETURNED 0.8",
            f"{start + 1.2:.4f} operator wait-state INSTRUMENTS SAFE_OPERATIONAL 0.1",
            f"{start + 1.2:.4f} operator state INSTRUMENTS OPERATIONAL",
        ]
    lines.append("12.0 operator shutdown")
    name = fault.split(" ")[0]
    path = flying.write_scenario(session_directory / f"zoo-{name}.scn", *lines)
    flights = [_fly(session_directory / f"zoo-{name}-{form}", str(path), form) for form in ("processes", "image")]
    for flight in flights:
        assert flight.code == 0, flight.transcript()
    for log in LOGS:
        assert flights[0].octets(log) == flights[1].octets(log)
    lost = [octets for _, way, octets in flights[0].packets if way == "TM" and octets[7:9] == bytes((5, 3))]
    lost = [octets for octets in lost if octets[:2] == bytes((0x08, 40))]
    seen = [tuple(octets[-4:-2]) for octets in lost]
    assert seen == [(index, cause.get(kind, 1)) for index, kind in enumerate(KINDS)], seen


STATES = {"offline": 0.1, "initialized": 0.4, "configured": 0.7, "safe": 0.9, "operational": 1.5}
# Each device in one or two of the states, and two devices in each state; with LONG=1 each device in each state.
UNPLUGS = [pytest.param(name, at, id=f"{name}-{state}", marks=() if (device + number) % 3 == 0 else pytest.mark.long)
           for device, name in enumerate(NAMES) for number, (state, at) in enumerate(STATES.items())]


@pytest.mark.parametrize(("name", "at"), UNPLUGS)
def test_a_device_unplugged_in_each_state_is_commissioned_again(tmp_path, name, at):
    """The device is disconnected for 0.5 s; afterwards all are brought up from OFFLINE."""
    lines = sorted(
        [
            f"{at:.4f} fault unplug {name}",
            f"{at + 0.5:.4f} fault plug {name}",
            "3.0 operator state INSTRUMENTS OFFLINE",
            "3.5 operator state INSTRUMENTS PRE_OPERATIONAL",
            "4.0 operator config INSTRUMENTS NOMINAL",
            "4.2 operator state INSTRUMENTS SAFE_OPERATIONAL",
            "4.4 operator state INSTRUMENTS OPERATIONAL",
            "5.0 operator shutdown",
            *UP[:1],
        ],
        key=lambda line: float(line.split(" ")[0]),
    )
    path = flying.write_scenario(tmp_path / "out.scn", *lines)
    flight = _fly(tmp_path / "run", str(path))
    assert flight.code == 0, flight.transcript()
    flying.assert_clean(flight)
