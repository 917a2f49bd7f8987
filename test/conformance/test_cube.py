# SPDX-License-Identifier: Apache-2.0
"""A satellite in a separate world, controlled by an independent master (PyPI canopen): wheels turn it, and
sensors measure its rotation.

The simulator waits until the master sends, and each frame of the master lets `--quantum` [us] of simulated time pass. The
results therefore do not depend on the speed of the machine. A cycle of `command` has five frames, and a cycle of `sync` one
frame."""

import importlib
import queue
import subprocess
import sys

import canopen
import lcm
import numpy
import pytest
from canopen.profiles.p402 import BaseNode402
from simulated import BOUND_S, CUBE, ROOT, SHEETS, Simulator, pass_time, patient, until

TORQUE_NM = 2.2e-4  # Unit of the torque objects of a wheel: per mille of 0.22 Nm.
STEP_NS = 500_000  # Step of the world.
WHEELS = (0x31, 0x32, 0x33, 0x34)
TORQUES = (0.2, 0.1, -0.1, 0.05)
# Of the world and its data sheets: the largest momentum and speed of a wheel, and the inertia of the satellite.
MOMENTUM_NMS, SPEED_RAD_S = 12, 6000 * 2 * numpy.pi / 60
INERTIA = numpy.array([[75, 1.5, -2], [1.5, 88, 1], [-2, 1, 82]])


@pytest.fixture(scope="module")
def types(tmp_path_factory):
    """The Python package that lcm-gen makes from the types of the truth log."""
    directory = tmp_path_factory.mktemp("lcm")
    generator = ROOT / "build/venv/bin/lcm-gen"
    subprocess.run([generator, "-p", "--ppath", directory, *sorted((ROOT / "sim/truth").glob("*.lcm"))], check=True)
    sys.path.insert(0, str(directory))
    yield importlib.import_module("hirosco")
    sys.path.remove(str(directory))
    sys.modules.pop("hirosco")


def truth(directory, types, channel):
    """Messages of a channel of the truth log."""
    kind = getattr(types, f"{channel.lower()}_t")
    return [kind.decode(event.data) for event in lcm.EventLog(str(directory / "truth.lcm"), "r") if event.channel == channel]


def at_each_step(messages):
    """Messages of a channel, one for each step: those at rest, which the log leaves out, are filled in."""
    found = []
    for message, following in zip(messages, [*messages[1:], None]):
        found += [message] * (round((following.time_ns - message.time_ns) / STEP_NS) if following else 1)
    return found


def test_the_world_is_valid_by_its_schema():
    subprocess.run(["xmllint", "--noout", "--nonet", "--schema", ROOT / "descriptors/schema/world.xsd", CUBE], check=True)


def booted(simulator, numbers, sheet, kind=canopen.RemoteNode):
    """The network with nodes of one data sheet, which are configured from the sheet."""
    network = simulator.networks[0] if simulator.networks else simulator.connect("platform")
    nodes = []
    for number in numbers:
        node = kind(number, str(SHEETS / f"{sheet}.eds"))
        node.sdo.RESPONSE_TIMEOUT = BOUND_S
        network.add_node(patient(node) if kind is BaseNode402 else node)
        nodes.append(node)
    pass_time(network, 10)
    for node in nodes:
        node.tpdo.read()
        node.rpdo.read()
        node.answers = queue.SimpleQueue()
        node.tpdo[len(node.tpdo)].add_callback(node.answers.put)
    return network, nodes


def command(network, nodes, controlword, torques=(0, 0, 0, 0)):
    """Perform one cycle of the wheels: send each RPDO and SYNC, and wait for the answer of the last wheel, so that no
    cycle overtakes another."""
    for node, torque in zip(nodes, torques):
        node.rpdo[1]["Controlword"].raw = controlword
        node.rpdo[1]["Target torque"].raw = round(torque / TORQUE_NM)
        node.rpdo[1].transmit()
    network.sync.transmit()
    nodes[-1].answers.get(timeout=BOUND_S)


def enable(network, nodes):
    for node in nodes:
        node.nmt.state = "OPERATIONAL"
    for controlword in (0x06, 0x07, 0x0F):
        command(network, nodes, controlword)
    command(network, nodes, 0x0F)
    until(lambda: all(node.tpdo[1]["Statusword"].raw & 0x6F == 0x27 for node in nodes), "operation enabled")


def axes_of_wheels():
    return numpy.array([[1, 1, 1], [-1, 1, 1], [-1, -1, 1], [1, -1, 1]]).T / numpy.sqrt(3)


def rotation(q):
    w, x, y, z = q
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def momentum(base, wheels):
    """Angular momentum of satellite and wheels about the centre of mass, in the axes of the world."""
    turn = rotation(base.rotation[0])
    return turn @ (INERTIA @ turn.T @ numpy.array(base.rate_rad_s[0]) + axes_of_wheels() @ numpy.array(wheels.momentum_nms))


def test_wheels_take_and_give_momentum(tmp_path, types):
    """Each wheel gets the commanded torque times the time, the satellite gets the opposite, and the sum does
    not change."""
    simulator = Simulator(tmp_path, "--in-step", "--quantum", "2000", world=CUBE)
    network, nodes = booted(simulator, WHEELS, "wheel", BaseNode402)
    enable(network, nodes)
    for _ in range(200):
        command(network, nodes, 0x0F, TORQUES)
    until(lambda: abs(nodes[0].tpdo[1]["Torque actual value"].raw * TORQUE_NM - TORQUES[0]) < TORQUE_NM, "the torque")
    speeds = [node.tpdo[1]["Velocity actual value"].raw * 1e-6 for node in nodes]
    simulator.close()
    bases, wheels = (at_each_step(truth(tmp_path, types, channel)) for channel in ("BASE", "WHEEL"))
    (names,) = (names.name for names in truth(tmp_path, types, "NAMES") if names.channel == "WHEEL")
    assert names == ["WHEEL1", "WHEEL2", "WHEEL3", "WHEEL4"]
    assert len(bases) == len(wheels) > 4000
    for index, torque in enumerate(TORQUES):
        given = sum(wheel.torque_nm[index] for wheel in wheels) * 5e-4
        assert abs(given - wheels[-1].momentum_nms[index] + wheels[0].momentum_nms[index]) < 2e-4
        assert abs(given / torque - 2.0) < 0.05  # 200 cycles of five frames, 10 ms each.
    inertia = MOMENTUM_NMS / SPEED_RAD_S  # Of a wheel.
    assert abs(wheels[-1].momentum_nms[1] / inertia - speeds[1]) < 2.0
    drift = max(abs(momentum(base, wheel) - momentum(bases[0], wheels[0])).max() for base, wheel in zip(bases[::50], wheels[::50], strict=True))
    print(f"{wheels[-1].time_ns * 1e-9:.1f} s: drift {drift:.1e} Nms, wheels {wheels[-1].momentum_nms}")
    assert drift < 1e-6


SENSORS = {"gyro": 0x39, "star-tracker": 0x38, "pose-camera": 0x48}
UNIT = (0.1, -0.2, numpy.pi / 2)  # Attitude of the link `unit`, which has gyro and tracker, on the satellite: roll, pitch, yaw.


def of_angles(rpy):
    (cr, cp, cy), (sr, sp, sy) = numpy.cos(rpy), numpy.sin(rpy)
    return numpy.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr], [-sp, cp * sr, cp * cr]])


def values(node, *numbers):
    """Raw numbers of the mapped objects of all TPDOs in order."""
    mapped = [variable.raw for number in range(1, len(node.tpdo) + 1) for variable in node.tpdo[number]]
    return numpy.array([mapped[number] for number in numbers], float)


def sync(network, node):
    """Send one SYNC and wait for the last answer to it."""
    network.sync.transmit()
    node.answers.get(timeout=BOUND_S)


def angle(turn):
    return numpy.arccos(numpy.clip((numpy.trace(turn) - 1) / 2, -1, 1))


def test_a_master_stops_the_satellite_by_its_gyro(tmp_path, types):
    """The master computes torques of the wheels from rates of the gyro, with the pseudo-inverse: the
    satellite stops, and the wheels have its momentum."""
    simulator = Simulator(tmp_path, "--in-step", "--quantum", "8000", world=CUBE)
    network, wheels = booted(simulator, WHEELS, "wheel", BaseNode402)
    _, (gyro,) = booted(simulator, [SENSORS["gyro"]], "gyro")
    _, (tracker,) = booted(simulator, [SENSORS["star-tracker"]], "star-tracker")
    gyro.nmt.state = tracker.nmt.state = "OPERATIONAL"
    enable(network, wheels)
    mount, share = of_angles(UNIT), numpy.linalg.pinv(axes_of_wheels())
    seen = set()
    for _ in range(320):
        rate = mount @ (values(gyro, 0, 1, 2) * 1e-7)
        command(network, wheels, 0x0F, numpy.clip(share @ (INERTIA @ rate), -0.22, 0.22))
        gyro.answers.get(timeout=BOUND_S)
        tracker.answers.get(timeout=BOUND_S)
        seen.add(tuple(values(tracker, 0, 1, 2, 3)))
    measured, (stamp_syncs, stamp_us, status) = values(tracker, 0, 1, 2, 3) * 1e-9, values(tracker, 4, 5, 6)
    simulator.close()
    bases, spun = (at_each_step(truth(tmp_path, types, channel)) for channel in ("BASE", "WHEEL"))
    drift = max(abs(momentum(base, wheel) - momentum(bases[0], spun[0])).max() for base, wheel in zip(bases[::50], spun[::50], strict=True))
    print(f"{spun[-1].time_ns * 1e-9:.1f} s: rate {numpy.linalg.norm(bases[-1].rate_rad_s[0]):.1e} rad/s, drift {drift:.1e} Nms, exposure {stamp_us} us after SYNC {stamp_syncs}")
    assert numpy.linalg.norm(bases[0].rate_rad_s[0]) > 0.03
    assert numpy.linalg.norm(bases[-1].rate_rad_s[0]) < 3e-4
    assert drift < 1e-6
    # Within noise and rate times 0.2 s.
    assert angle(rotation(measured).T @ rotation(bases[-1].rotation[0]) @ mount) < 1e-3
    assert 45 < len(seen) < 85  # 5 Hz, for 320 cycles of five frames, 40 ms each.
    # The last exposure was after one of the last SYNCs and before the next, which follows after 40 ms.
    assert stamp_syncs > 300 and stamp_us < 50000 and status == 0


def test_gyro_and_camera_measure_rate_and_pose_of_their_links(tmp_path, types):
    simulator = Simulator(tmp_path, "--in-step", "--quantum", "2000", world=CUBE)
    network, (gyro,) = booted(simulator, [SENSORS["gyro"]], "gyro")
    _, (camera,) = booted(simulator, [SENSORS["pose-camera"]], "pose-camera")
    gyro.nmt.state = camera.nmt.state = "OPERATIONAL"
    rates = []
    for _ in range(200):
        network.sync.transmit()
        gyro.answers.get(timeout=BOUND_S)
        camera.answers.get(timeout=BOUND_S)
        rates.append(values(gyro, 0, 1, 2) * 1e-7)
    status, found, lost = values(gyro, 4)[0], values(camera, 0, 1, 2) * 1e-6, values(camera, 8)[0]
    simulator.close()
    bases = at_each_step(truth(tmp_path, types, "BASE"))
    # Each cycle has one frame and lasts 2 ms, four steps.
    true = numpy.array([of_angles(UNIT).T @ rotation(base.rotation[0]).T @ numpy.array(base.rate_rad_s[0]) for base in bases[-800::4]])
    errors = numpy.array(rates) - true[: len(rates)]
    print(f"bias {errors.mean(axis=0)}, noise {errors.std(axis=0)}")
    assert (status, lost) == (0, 0)
    assert (abs(errors.mean(axis=0)) < 5e-6).all() and (abs(errors.std(axis=0) - 1e-5) < 2e-6).all()
    ours, other = bases[-1].position_m
    turn = rotation(bases[-1].rotation[0])
    # Origins, in their satellites, of the link that the camera observes and of the link with the camera.
    observed_at = numpy.array(other) + rotation(bases[-1].rotation[1]) @ [0.3, 0.1, 0.6]
    camera_at = numpy.array(ours) + turn @ [0.6, 0, 0]
    # The pose is up to 0.13 s old (a delay of 80 ms, 20 poses a second) and has noise.
    assert numpy.linalg.norm((turn @ of_angles((0, 0.1, 0))).T @ (observed_at - camera_at) - found) < 0.03


def test_faults_of_a_scenario_act_on_sensors_and_wheels(tmp_path, types):
    scenario = tmp_path / "faults.scn"
    scenario.write_text("6 fault error platform TRACKER 0x5000 on\n8 fault error platform TRACKER 0x5000 off\n"
                        "9 fault error platform WHEEL1 0x2310 on\n10 fault unplug platform GYRO\n12 fault plug platform GYRO\n")
    simulator = Simulator(tmp_path, "--in-step", "--quantum", "8000", "--scenario", str(scenario), world=CUBE)
    network, (tracker,) = booted(simulator, [SENSORS["star-tracker"]], "star-tracker")
    boots = []
    network.subscribe(0x700 + SENSORS["gyro"], lambda identifier, data, stamp: boots.append((bytes(data), stamp)))
    tracker.nmt.state = "OPERATIONAL"
    rows = []
    for _ in range(1600):
        sync(network, tracker)
        rows.append((tracker.tpdo[3].timestamp, *values(tracker, 6, 7)))
    simulator.close()
    times, status, counter = numpy.array(rows).T
    assert (status[(times > 6.1) & (times < 7.9)] == 1).all() and len(set(counter[(times > 6.1) & (times < 7.9)])) == 1
    assert (status[(times > 2) & (times < 5.9)] == 0).all() and (status[times > 8.3] == 0).all()
    assert [code for code in (message.code for message in tracker.emcy.log) if code] == [0x5000]
    heard = [stamp for _, stamp in boots]
    assert not [stamp for stamp in heard if 10.1 < stamp < 11.9] and [stamp for data, stamp in boots if data == b"\0" and stamp > 12]
    drives = truth(tmp_path, types, "DRIVE")
    assert any(drive.node == SENSORS["gyro"] and not drive.plugged for drive in drives)
    assert any(drive.node == WHEELS[0] and drive.statusword & 0x4F == 0x08 and abs(drive.time_ns * 1e-9 - 9) < 0.01 for drive in drives)
    assert [fault.target for fault in truth(tmp_path, types, "FAULT")][:2] == ["platform TRACKER", "platform TRACKER"]
