# SPDX-License-Identifier: Apache-2.0
"""The six-joint arm ur5e, which consists of descriptors, a world and a URDF only: its motions compared with
the truth, and its refusals."""

import json
import os
import re
import shutil
import struct
import subprocess
import sys

import canopen
import cantools
import flying
import mujoco
import numpy as np
import pytest
from hirosco_gse import arm_figures, figure_bounds, figures, report, tool_figures
from hirosco_gse import run as runs
from hirosco_gse.dictionary import Dictionary
from test_tutorial import copy_of_tree

sys.path.insert(0, str(flying.ROOT / "gse" / "scaffold"))

import new_robot
import urdf

URDF = flying.ROOT / "descriptors" / "worlds" / "ur5e.urdf"
FREE_URDF = flying.ROOT / "descriptors" / "worlds" / "free-flyer.urdf"
OPERATIONAL = 5
DELAY_US = 1000  # The values of a cycle were sampled at the SYNC of the cycle before.
RATIO = 100  # Ratio of all gears.
# Largest deviations from the desired motion while the arm moves at up to 0.9 rad/s and 0.12 m/s. The position
# loop of the drives lags by 1.6 cycles of 1 ms.
GANTRY_BOUNDS = {"POSITION": (0.001, 0.003), "TORQUE": (0.001, 0.003)}  # Slide [m], other joints [rad].
BOUNDS = {"POSITION": (0.0025, 0.002), "TORQUE": (0.0015, 0.001)}  # Joint [rad], tool [m].


@pytest.fixture(scope="module")
def flights(session_directory):
    """The scenario in both forms."""
    return flying.fly_in_both_forms(session_directory, "ur5e", "ur5e", "--mission", "ur5e")


@pytest.fixture(scope="module")
def run(flights):
    return runs.load(flights["image"].directory)


def samples(run, configuration):
    """Time [us] and CUR_VALUES of each report in operation, in a configuration."""
    names = {11: "POSITION", 21: "TORQUE"}  # Structures of housekeeping and the configurations that report them.
    found = []
    for time_ns, _, decoded in run.reports_of("housekeeping"):
        values = decoded["values"].get("CUR_VALUES")
        if values and names.get(decoded["structure"]) == configuration and np.ravel(values["STATE"])[0] == OPERATIONAL:
            found.append((time_ns // 1000, values))
    assert len(found) > 100
    return [time for time, _ in found], {name: np.array([values[name] for _, values in found]) for name in found[0][1]}


def assert_bounds_hold(run, bounds):
    """The figures of a run are within the bounds of its scenario, which are these."""
    found, reasons = figures.compute(run)
    assert figures.bounds_of(run.facts) == bounds and bounds
    assert not reasons and set(bounds) <= set(found)
    assert not figures.failures(run.facts | found)
    assert all(report.text_of(name)[0] != name for name in bounds)


def tools(poses):
    """Position of the tool in each pose, computed from the URDF."""
    robot = urdf.read(URDF)
    return np.array([new_robot.jacobian_columns(robot, angles)[0][0] for angles in poses])


def test_no_c_source_names_this_arm():
    name = re.compile(r"ur5e", re.IGNORECASE)
    sources = [path for layer in ("base", "osal", "pus", "fsw", "launcher", "sim") for path in (flying.ROOT / layer).rglob("*.[ch]")]
    assert sources and not [path for path in sources if name.search(path.read_text(encoding="utf-8"))]


def test_both_forms_fly_the_same_octets(flights):
    for name in ("packets.log", "can-arm-1.log", "can-arm-2.log", "truth.lcm"):
        assert flights["image"].octets(name) == flights["processes"].octets(name), name


@pytest.mark.parametrize("configuration", BOUNDS)
def test_joints_and_tool_follow_the_desired_motion(run, configuration):
    """Telemetry contains the desired motion, and the truth contains all links; the figures of the run are the same numbers."""
    times, values = samples(run, configuration)
    joint_bound, tool_bound = BOUNDS[configuration]
    desired = values["DESIRED"]
    assert np.ptp(desired, axis=0).min() > 0.25  # Every joint has moved.
    assert np.abs(values["POSITION"] - desired).max() < joint_bound
    assert values["TOOL_ERROR"][:, 0].max() < tool_bound
    truth = run.truth["JOINTS"]
    true = truth["position_rad"][np.searchsorted(truth["time_us"], np.array(times) - DELAY_US)]
    assert np.abs(true - desired).max() < joint_bound
    tool_error = np.linalg.norm(tools(true) - tools(desired), axis=1).max()
    assert tool_error < tool_bound
    assert arm_figures.joint_errors(run, configuration) == pytest.approx(np.abs(true - desired).max(axis=0))
    assert arm_figures.tool_error(run, configuration) == pytest.approx(tool_error)
    assert_bounds_hold(run, figure_bounds.read(flying.ROOT / "sim" / "scenarios" / "ur5e.bounds"))
    assert np.abs(true - values["POSITION"]).max() < 0.0005  # The arm measures its true positions.


def test_the_tool_moves_along_a_straight_line(run):
    """The path of the tool is computed from the desired motion and the URDF; the scenario has a line straight
    up and back."""
    times, values = samples(run, "POSITION")
    tool = tools(values["DESIRED"])
    during = (np.array(times) > 9_300_000) & (np.array(times) < 10_000_000)
    assert during.sum() > 10
    line = tool[during]
    assert np.ptp(line[:, 2]) > 0.05
    assert np.ptp(line[:, :2], axis=0).max() < 1e-5


def test_the_tool_passes_poses_within_its_limits_without_a_stop(session_directory):
    """The true tool comes within BLEND of the via poses, one after the other, and rests at the last one; between them it does not
    stop, and it is never faster than the scenario permits."""
    name = "ur5e-poses"
    flight = flying.fly(session_directory / name, "--mission", "ur5e", "--scenario", name, "--form", "image")
    assert flight.code == 0, flight.transcript()
    lines = (flying.ROOT / "sim" / "scenarios" / f"{name}.scn").read_text(encoding="utf-8")
    poses = np.array([list(map(float, words.split(","))) for words in re.findall(r"ADD_POSE POSITION=(\S+)", lines)])
    began, share, blend = (float(word) for word in re.search(r"(?m)^ *([0-9.]+) .*LINE_VIA SHARE=(\S+) BLEND=(\S+)$", lines).groups())
    steps = [json.loads(line) for line in (flight.directory / "operator.log").read_text(encoding="utf-8").splitlines()]
    ended = next(step["end"] for step in steps if "LINE_VIA" in step["text"])
    found = runs.load(flight.directory)
    joints = found.truth["JOINTS"]
    inside = (joints["time_us"] > 1e6 * began) & (joints["time_us"] < 1e6 * (ended + 0.8))
    times, tool = joints["time_us"][inside][::10] * 1e-6, tools(joints["position_rad"][inside][::10])
    away = np.linalg.norm(tool[:, None] - poses, axis=2)
    passed = [away[:, number].argmin() for number in range(3)]
    assert passed == sorted(passed)
    assert (away[passed, range(3)] < blend + 0.001).all() and away[-1, 3] < 0.001
    speed = np.linalg.norm(np.diff(tool, axis=0), axis=1) / np.diff(times)
    (limits,) = (parameter for parameter in found.dictionary.content["subsystems"][0]["parameters"] if parameter["name"] == "LIMITS")
    (most,) = (float(field["init"]) for field in limits["fields"] if field["name"] == "TOOL_SPEED")
    smooth = np.convolve(speed, np.ones(5) / 5, "valid")
    assert 0.05 < smooth.max() < 1.05 * share * most
    assert smooth[passed[0] : passed[2]].min() > 0.01
    assert smooth[-1] < 0.002


@pytest.fixture(scope="module")
def pressed(session_directory):
    """A flight with the compliant tool; its target is below the top of a table."""
    flight = flying.fly(session_directory / "ur5e-press", "--mission", "ur5e", "--scenario", "ur5e-press", "--form", "image")
    assert flight.code == 0, flight.transcript()
    return runs.load(flight.directory)


def test_a_tool_that_yields_lies_on_the_table_with_the_force_of_its_springs(pressed):
    """The target is 28.6 mm below the table, and the tool has a stiffness of 1000 N/m. Friction of the joints
    and offsets of the torque sensors make the force differ from their product by up to 15 %."""
    contact = pressed.truth["CONTACT"]
    force = contact["contact_force_n"][:, 2]
    held = (contact["time_us"] > 9_000_000) & (contact["time_us"] < 12_000_000)
    assert contact["in_contact"][held].all()
    times = [time_ns for time_ns, _, decoded in pressed.reports_of("housekeeping") if decoded["structure"] == 31]
    values = [decoded["values"]["CUR_VALUES"] for _, _, decoded in pressed.reports_of("housekeeping") if decoded["structure"] == 31]
    below = np.mean([value["TOOL_ERROR"][0] for time_ns, value in zip(times, values) if 9e9 < time_ns < 12e9])
    assert 0.025 < below < 0.03
    assert abs(force[held].mean() / (1000.0 * below) - 1.0) < 0.15
    assert np.ptp(force[held]) < 0.1  # The tool rests.
    assert force.max() < 1.25 * force[held].mean()


def test_a_joystick_moves_the_tool_and_reflects_the_force_of_the_table(session_directory):
    """The subsystem of the joystick is unchanged; all figures of the run have bounds."""
    flights = flying.fly_in_both_forms(session_directory, "ur5e-telepresence", "ur5e-telepresence", "--mission", "ur5e-telepresence")
    for name in ("packets.log", "can-arm-1.log", "can-arm-2.log", "can-joystick.log", "truth.lcm"):
        assert flights["image"].octets(name) == flights["processes"].octets(name), name
    run = runs.load(flights["image"].directory)
    found, _ = figures.compute(run)
    assert not figures.failures(run.facts | found)
    assert set(figures.bounds_of(run.facts)) == set(tool_figures.BOUNDS) <= set(report.TEXTS) and found["tool_force_n"] > 10.0
    states = {int(np.ravel(decoded["values"]["HAND"]["STATE"])[0]) for _, _, decoded in run.reports_of("housekeeping")
              if "HAND" in decoded["values"]}
    assert states == {0, 1}  # The hand leads the tool or is missing.


def test_a_target_out_of_reach_is_refused_with_its_reason(run):
    said = [str(entry) for entry in run.operator if "expect-refusal" in str(entry)]
    assert said and "failed at completion: LINE [0x8003]" in said[-1]


def fields_of(run, service, subtype):
    """Decoded reports of one kind."""
    found = [decoded for _, packet, decoded in run.reports if packet.message == (service, subtype)]
    assert not [fields for fields in found if "error" in fields]
    return found


def snake(path, count):
    """URDF of a chain of equal links, which turn about y and z alternately, with a fixed flange."""
    lines = ['<robot name="snake"><link name="link0"/>']
    for i in range(count):
        axis = "0 1 0" if i % 2 else "0 0 1"
        lines.append(
            f'<link name="link{i + 1}"><inertial><origin xyz="0.08 0 0"/><mass value="0.5"/>'
            '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>'
            f'<joint name="joint{i + 1}" type="revolute"><origin xyz="{0.16 if i else 0} 0 0"/><parent link="link{i}"/>'
            f'<child link="link{i + 1}"/><axis xyz="{axis}"/><limit lower="-2" upper="2" effort="150" velocity="2"/></joint>'
        )
    lines.append(f'<link name="hand"/><joint name="flange" type="fixed"><origin xyz="0.16 0 0"/><parent link="link{count}"/>'
                 '<child link="hand"/></joint></robot>')
    path.write_text("".join(lines), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def free_flyer(session_directory):
    """A flight with an arm of seven joints on a free-flying satellite."""
    flight = flying.fly(session_directory / "free-flyer", "--mission", "free-flyer", "--scenario", "free-flyer", "--form", "image")
    assert flight.code == 0, flight.transcript()
    flying.assert_clean(flight)
    return runs.load(flight.directory)


def momenta(run, every):
    """Linear and angular momentum of the whole robot, and the angular momentum of its base, about its centre
    of mass: computed by MuJoCo from URDF and truth, plus the momentum of the rotors, which turn RATIO times
    as fast as their joints."""
    spec = mujoco.MjSpec.from_file(str(FREE_URDF))
    spec.compiler.fusestatic = False
    spec.bodies[1].add_freejoint()
    model = spec.compile()
    data = mujoco.MjData(model)
    types = {name: float(inertia) / RATIO for name, inertia in re.findall(
        rf'<DriveType name="(\w+)" ratio="{RATIO}" rotorInertia="([0-9.]+)"', FREE_URDF.with_suffix(".xml").read_text(encoding="utf-8"))}
    spin = [types[name] for name in re.findall(r'<Drive [^>]* type="(\w+)"', FREE_URDF.with_suffix(".xml").read_text(encoding="utf-8"))]
    base, joints = run.truth["BASE"], run.truth["JOINTS"]
    turn = np.zeros(9)
    # A body at rest has no new sample.
    present = np.searchsorted(joints["time_us"], base["time_us"], side="right") - 1
    for i in range(0, len(base["time_us"]), every):
        joint = present[i]
        mujoco.mju_quat2Mat(turn, base["rotation"][i, 0])
        rate = base["rate_rad_s"][i, 0]
        data.qpos[:] = np.concatenate((base["position_m"][i, 0], base["rotation"][i, 0], joints["position_rad"][joint]))
        data.qvel[:] = np.concatenate((base["velocity_m_s"][i, 0], turn.reshape(3, 3).T @ rate, joints["velocity_rad_s"][joint]))
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_subtreeVel(model, data)
        inertia = data.ximat[1].reshape(3, 3) @ np.diag(model.body_inertia[1]) @ data.ximat[1].reshape(3, 3).T
        rotors = (spin * joints["velocity_rad_s"][joint]) @ data.xaxis[1:]
        yield model.body_subtreemass[1] * data.subtree_linvel[1], data.subtree_angmom[1] + rotors, inertia @ rate


def test_a_free_base_turns_by_reaction_and_the_momentum_stays(free_flyer):
    """The bound is 0.2 % of the momentum that base and arm exchange. The truth gives the pose of each link
    through the joints, and the integrator keeps the bodies together only within the error of its step."""
    rotation = free_flyer.truth["BASE"]["rotation"][:, 0]
    turned = 2.0 * np.arccos(np.clip(np.abs(rotation @ rotation[0]), 0.0, 1.0))
    assert np.degrees(turned.max()) > 1.5
    linear, angular, of_base = (np.linalg.norm(values, axis=1) for values in zip(*momenta(free_flyer, 40)))
    assert of_base.max() > 3.0
    assert linear.max() < 0.01 and angular.max() < 0.002 * of_base.max()


@pytest.mark.parametrize("configuration", BOUNDS)
def test_the_arm_of_a_free_base_follows_its_desired_motion(free_flyer, configuration):
    _, values = samples(free_flyer, configuration)
    assert np.ptp(values["DESIRED"], axis=0).min() > 0.25
    assert arm_figures.joint_errors(free_flyer, configuration).max() < BOUNDS[configuration][0]
    assert_bounds_hold(free_flyer, figure_bounds.read(flying.ROOT / "sim" / "scenarios" / "free-flyer.bounds"))


def test_joints_pass_via_points_without_a_stop(free_flyer):
    """The points are those of the scenario. The true joints come within BLEND of both points in turn, and
    stop only at the last."""
    lines = (flying.ROOT / "sim" / "scenarios" / "free-flyer.scn").read_text(encoding="utf-8")
    first, second, last = (np.array(list(map(float, words.split(",")))) for words in re.findall(r"ADD_VIA POSITION=(\S+)", lines)[:3])
    began, blend = (float(word) for word in re.search(r"(?m)^ *([0-9.]+)  operator cmd \S+MOVE_VIA SHARE=0.5 BLEND=([0-9.]+)$", lines).groups())
    ended = next(step["end"] for step in map(json.loads, (free_flyer.directory / "operator.log").read_text(encoding="utf-8").splitlines())
                 if "MOVE_VIA" in step["text"])
    joints = free_flyer.truth["JOINTS"]
    inside = (joints["time_us"] > 1e6 * began) & (joints["time_us"] < 1e6 * ended)
    true = joints["position_rad"][inside]
    nearest = [np.abs(true - point).max(axis=1) for point in (first, second)]
    assert [distance.min() < blend + 0.002 for distance in nearest] == [True, True]
    turns = [distance.argmin() for distance in nearest]
    assert turns[0] < turns[1]
    speed = np.linalg.norm(joints["velocity_rad_s"][inside], axis=1)
    assert speed[turns[0] - 100 : turns[1] + 100].min() > 0.1
    assert np.abs(true[-1] - last).max() < 0.003 and ended - began < 3.0


STRUCTURE, LIMITS = 24, 1  # Parts of the id of the parameter LIMITS: the layout code of a structure, and its number.
NODE = 0x52  # Drive of the second joint.


def gantry(path):
    """URDF of a linear axis that carries an arm of three joints."""
    lines = ['<robot name="gantry"><link name="rail"/>']
    joints = [("slide", "prismatic", "0 0 0.2", "1 0 0", (-0.4, 0.6, 300, 0.4), 6.0), ("turn", "revolute", "0 0 0.1", "0 0 1", (-2, 2, 60, 1.5), 3.0),
              ("shoulder", "revolute", "0 0 0.1", "0 1 0", (-1.5, 1.5, 60, 1.5), 2.0), ("elbow", "revolute", "0.3 0 0", "0 1 0", (-2, 2, 40, 2), 1.5)]
    for i, (name, kind, place, axis, (lower, upper, effort, speed), mass) in enumerate(joints):
        parent = joints[i - 1][0] + "_link" if i else "rail"
        lines.append(
            f'<link name="{name}_link"><inertial><origin xyz="{0.12 if i > 1 else 0} 0 0"/><mass value="{mass}"/>'
            '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>'
            f'<joint name="{name}" type="{kind}"><origin xyz="{place}"/><parent link="{parent}"/><child link="{name}_link"/>'
            f'<axis xyz="{axis}"/><limit lower="{lower}" upper="{upper}" effort="{effort}" velocity="{speed}"/></joint>'
        )
    lines.append('<link name="tip"/><joint name="flange" type="fixed"><origin xyz="0.25 0 0"/><parent link="elbow_link"/>'
                 '<child link="tip"/></joint></robot>')
    path.write_text("".join(lines), encoding="utf-8")
    return path


# Another mapping for the drive of the slide: the entries of RPDO1 and TPDO1 are in another order.
REMAPPED = {
    0x1A00: (("0x1800:01", "UINT32", "0x800001D1"), ("0x1A00:00", "UINT8", "0"), ("0x1A00:01", "UINT32", "0x60770010"),
             ("0x1A00:02", "UINT32", "0x60410010"), ("0x1A00:03", "UINT32", "0x60640020"), ("0x1A00:00", "UINT8", "3"),
             ("0x1800:01", "UINT32", "0x000001D1")),
    0x1600: (("0x1400:01", "UINT32", "0x80000251"), ("0x1600:00", "UINT8", "0"), ("0x1600:01", "UINT32", "0x60B20010"),
             ("0x1600:02", "UINT32", "0x607A0020"), ("0x1600:03", "UINT32", "0x60400010"), ("0x1600:00", "UINT8", "3")),
}


def remap(path):
    """Write the settings of REMAPPED before the other settings of the slide, in each configuration."""
    settings = "".join(f'<Setting object="{name}" type="{kind}" value="{value}"/>' for group in REMAPPED.values() for name, kind, value in group)
    text, count = re.subn(r'(<Device name="JOINT1" [^>]*>)', rf"\1{settings}", path.read_text(encoding="utf-8"))
    assert count == 4
    path.write_text(text, encoding="utf-8")


def frames(path, identifier):
    """(time [us], data) of each frame of a bus log."""
    found = re.findall(rf"(?m)^\((\d+)\.(\d+)\) \S+ {identifier:03X}(?:##\w|#)([0-9A-F]*)$", path.read_text(encoding="ascii"))
    return [(int(seconds) * 1_000_000 + int(fraction), bytes.fromhex(data)) for seconds, fraction, data in found]


# While the first joint moves, its angle is monitored and its statistics are taken; the torque of the second
# joint violates its limits at once. Then memory is dumped, at the place of the ranges of the first joints,
# and the identity of a drive is read: 10180104 is index 0x1018, subindex 1 (vendor), 4 octets.
SERVICES = """
 2.8  operator monitor limit SNAKE 1 POSITION_1 {low} {high} VALUE_OUT_OF_LIMITS VALUE_OUT_OF_LIMITS
 2.8  operator monitor limit SNAKE 2 TORQUE_2 0.001 0.002 VALUE_OUT_OF_LIMITS VALUE_OUT_OF_LIMITS
 2.8  operator monitor enable SNAKE 1
 2.8  operator monitor enable SNAKE 2
 2.9  operator tc SNAKE 4,6 'n=[{{"parameter_id":"SNAKE.POSITION_1","sampling_interval":0.01}}]'
 3.0  operator monitor start SNAKE
 3.0  operator tc SNAKE 4,3
{moves}
 6.0  operator tc SNAKE 4,1 reset_flag=0
 6.0  operator tc SNAKE 6,3 memory_id=1 base_id={base} 'n=[{{"offset":0,"length":16}}]'
 6.0  operator tc SNAKE 2,8 'n=[{{"transaction_id":5,"physical_device_id":{node},"protocol_specific_data":"10180104"}}]'
"""


def make(place, path, *options):
    """Run make new-robot in a copy of the project. Returns the finished process."""
    command = [sys.executable, "gse/scaffold/new_robot.py", "--urdf", path, *options]
    return subprocess.run(command, cwd=place, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def made_robots(session_directory):
    """A copy of the project with two robots made from their URDF, and the process that was refused because it
    would have overwritten one of them."""
    place = copy_of_tree(session_directory / "robot")
    for path in (snake(session_directory / "snake.urdf", 12), gantry(session_directory / "gantry.urdf")):
        made = make(place, path)
        assert made.returncode == 0, made.stderr
    again = make(place, session_directory / "snake.urdf")
    remap(place / "descriptors" / "subsystems" / "gantry.xml")
    missions = sorted(map(str, (place / "descriptors" / "missions").glob("*.xml")))
    subprocess.run([sys.executable, "gse/generator/generate.py", "--mission", *missions, "--out", "build/generated"], cwd=place, check=True)
    yield place, again
    shutil.rmtree(place)


@pytest.mark.parametrize("old, new, message", [
    ('name="gantry"', 'name="again" axes="4"', ":1: found 'axes=\"4\"', expected name version xmlns:xacro; docs/arm.md lists what to change in the URDF of a manufacturer; nothing was changed"),
    ("</robot>", '<gazebo reference="base"/></robot>', "found 'gazebo', expected link, joint, material or transmission; docs/arm.md lists what to change in the URDF of a manufacturer; nothing was changed"),
    ('<mass value="3.0"/>', '<mass value="1e300"/>', ":1: found 'value=\"1e300\"', expected a number from 1e-09 to 1e+07; docs/arm.md lists"),
    ("</link>", '<collision><geometry><mesh filename="cover.stl"/></geometry></collision></link>', "found 'mesh', expected one box, sphere or cylinder; docs/arm.md lists what to change"),
])
def test_a_robot_that_the_simulator_refuses_leaves_no_file(made_robots, tmp_path, old, new, message):
    place, _ = made_robots
    text = gantry(tmp_path / "again.urdf").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "again.urdf").write_text(text.replace(old, new), encoding="utf-8")
    there = sorted(place.glob("descriptors/*/*")) + sorted(place.glob("sim/scenarios/*"))
    made = make(place, tmp_path / "again.urdf", "--name", "again")
    assert made.returncode == 1 and "Traceback" not in made.stderr
    assert f"{tmp_path}/again.urdf:" in made.stderr and message in made.stderr
    assert sorted(place.glob("descriptors/*/*")) + sorted(place.glob("sim/scenarios/*")) == there


def test_the_free_flyer_is_what_make_new_robot_makes(made_robots):
    place, _ = made_robots
    made = [place / name for name in ("descriptors/subsystems/free-flyer.xml", "descriptors/worlds/free-flyer.xml",
                                      "descriptors/missions/free-flyer.xml", "sim/scenarios/free-flyer.scn", "sim/scenarios/free-flyer.bounds")]
    for path in made:
        path.unlink()
    again = make(place, place / "descriptors" / "worlds" / "free-flyer.urdf", "--base", "free", "--apid", "33")
    assert again.returncode == 0, again.stderr
    for path in made:
        assert path.read_text(encoding="utf-8") == (flying.ROOT / path.relative_to(place)).read_text(encoding="utf-8"), path.name


@pytest.fixture(scope="module")
def flown_snake(session_directory, made_robots):
    """A flight of a robot made from its URDF, with services of its descriptor, and the refusal of the tool to
    overwrite the robot."""
    place, again = made_robots
    scenario = place / "sim" / "scenarios" / "snake.scn"
    before, first, after = re.split(r"(?m)^( 3\.2 .*\n)", scenario.read_text(encoding="utf-8"))
    start, goal = (float(re.search(r"POSITION=([-0-9.]+)", line)[1]) for line in (after.splitlines()[0], first))
    dictionary = Dictionary.load(place / "build" / "generated" / "snake.json")
    base = dictionary.subsystem("SNAKE").apid << 21 | STRUCTURE << 16 | LIMITS
    low, high = sorted((start + 0.5 * (goal - start), start - (goal - start)))
    added = SERVICES.format(low=low, high=high, moves=first.rstrip(), base=base, node=NODE)
    scenario.write_text(before + added.lstrip("\n") + after, encoding="utf-8")
    flight = flying.fly(session_directory / "snake", "--mission", "snake", "--scenario", "snake", "--form", "image", root=place)
    return flight, again, dictionary, (start, goal)


def test_a_robot_of_twelve_joints_flies_from_its_urdf(flown_snake):
    """The robot flies as make new-robot made it, on three buses; existing files are not overwritten."""
    flight, again, _, _ = flown_snake
    assert again.returncode == 1 and "there is already descriptors/subsystems/snake.xml" in again.stderr
    assert flight.code == 0, flight.transcript()
    assert len(list(flight.directory.glob("can-arm-*.log"))) == 3


def test_services_of_a_descriptor_fly_without_a_line_of_c(flown_snake):
    """The services are monitoring of an angle and a torque, statistics of an angle, a dump of memory, and
    reading of an object of a drive."""
    flight, _, dictionary, (start, goal) = flown_snake
    run = runs.Run(flight.directory, dictionary)
    (statistics,) = fields_of(run, 4, 2)
    (entry,) = statistics["n"]
    assert sorted((entry["min_value"], entry["max_value"])) == pytest.approx(sorted((start, goal)), abs=0.004)
    assert min(start, goal) < entry["mean_value"] < max(start, goal) and entry["standard_deviation"] > 0.05
    assert 100 < entry["number_of_samples"] < 400
    (dump,) = fields_of(run, 6, 4)
    assert struct.unpack("=2d", bytes.fromhex(dump["n"][0]["data"])) == (-2.0, -2.0)  # LOWER
    (acquired,) = fields_of(run, 2, 9)
    eds = (flying.ROOT / "descriptors" / "devices" / "joint-drive-large.eds").read_text(encoding="utf-8")
    vendor = int(re.search(r"(?m)^VendorNumber=(\S+)", eds)[1], 0)
    assert int.from_bytes(bytes.fromhex(acquired["data_block"]), "little") == vendor
    violations = [event["values"] for event in fields_of(run, 5, 2) if event["event"] == "VALUE_OUT_OF_LIMITS"]
    angle, torque = ([np.ravel(values["VALUE"])[0] for values in violations if np.ravel(values["MONITOR"])[0] == number] for number in (1, 2))
    crossed = start + 0.5 * (goal - start)  # At most two cycles of 1 ms after the limit, at up to 1 rad/s.
    assert angle and abs(angle[0] - crossed) < 0.002 and (angle[0] - crossed) * (goal - start) > 0.0
    assert torque and not 0.001 <= torque[0] <= 0.002


@pytest.fixture(scope="module")
def flown_gantry(session_directory, made_robots):
    place, _ = made_robots
    flight = flying.fly(session_directory / "gantry", "--mission", "gantry", "--scenario", "gantry", "--form", "image", root=place, report="yes")
    assert flight.code == 0, flight.transcript()
    return flight


def test_a_run_fails_if_a_figure_of_its_robot_is_out_of_its_bound(flown_gantry, made_robots, tmp_path):
    """The scaffold has written the bounds. A robot that is less accurate than a bound fails with a line; a damaged file of bounds is refused with
    its line before the flight, and no report is made with it."""
    place, flight = made_robots[0], flown_gantry
    path = place / "sim" / "scenarios" / "gantry.bounds"
    text, bounds = path.read_text(encoding="utf-8"), figure_bounds.read(path)
    assert set(bounds) == {"joint1_error_m", *(f"joint{number}_error_rad" for number in (2, 3, 4)), "tool_error_m", "goal_error_rad", "goal_error_m",
                           "joint_range_margin", "joint_speed_share", "joint_torque_share"}
    assert flight.facts["figures_hold"] is True and flight.facts["figures_missing"] == {}
    page = flight.read("report.html")
    assert all(f'title="{name}"' in page and isinstance(flight.facts[name], float) for name in bounds)

    def judged(changed):
        path.write_text(changed, encoding="utf-8")
        copy = tmp_path / "copy"
        shutil.copytree(flight.directory, copy, dirs_exist_ok=True)
        done = subprocess.run([sys.executable, "-m", "hirosco_gse.report", copy], cwd=place, capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONPATH": str(place / "gse")})
        return done, json.loads((copy / "run.json").read_text(encoding="utf-8"))

    try:
        done, facts = judged(text.replace("goal_error_m <= 0.001", "goal_error_m <= 0.0001") + "joint9_error_rad <= 1\n")
        assert done.returncode == report.FIGURES_FAILED and facts["exit_code"] == 1
        assert facts["exit_reason"] == "figures missing or out of their bounds: goal_error_m joint9_error_rad"
        assert f"figure goal_error_m <= 0.0001: {facts['goal_error_m']:.4g}" in done.stdout.splitlines()
        assert "figure joint9_error_rad <= 1: missing: no function computes a figure of this name for this flight" in done.stdout.splitlines()
        done, facts = judged("# only a comment\ngoal_error_m < much\n")
        assert done.returncode == report.FIGURES_UNKNOWN and facts["exit_code"] == 1
        assert "gantry.bounds:2: found 'much', expected a finite number" in done.stderr
        refused = flying.fly(tmp_path / "refused", "--mission", "gantry", "--scenario", "gantry", "--form", "image", root=place)
        assert refused.code == 1 and "gantry.bounds:2: found 'much', expected a finite number" in refused.read("console.log")
    finally:
        path.write_text(text, encoding="utf-8")


def test_a_linear_axis_follows_as_the_joints_that_turn_do(flown_gantry, made_robots):
    """The slide of the gantry moves together with the arm that it carries, in both control loops; its unit is
    metres."""
    place, flight = made_robots[0], flown_gantry
    dictionary = Dictionary.load(place / "build" / "generated" / "gantry.json")
    run = runs.Run(flight.directory, dictionary)
    units = {name: parameter.unit for name, parameter in dictionary.subsystem("GANTRY").parameters.items()}
    assert (units["POSITION_1"], units["TORQUE_1"], units["POSITION_2"], units["TORQUE_2"]) == ("m", "N", "rad", "Nm")
    truth = run.truth["JOINTS"]
    for configuration, (slide_bound, joint_bound) in GANTRY_BOUNDS.items():
        times, values = samples(run, configuration)
        desired = values["DESIRED"]
        true = truth["position_rad"][np.searchsorted(truth["time_us"], np.array(times) - DELAY_US)]
        errors = np.abs(true - desired).max(axis=0)
        assert np.ptp(desired[:, 0]) > 0.15 and np.ptp(desired, axis=0).min() > 0.15
        assert errors[0] < slide_bound and errors[1:].max() < joint_bound, (configuration, errors)


def test_process_data_have_the_mapping_of_the_descriptor(flown_gantry, made_robots):
    """python-canopen applies the settings that it reads from the bus in their order, and decodes the process
    data accordingly; so does the CAN database."""
    log = flown_gantry.directory / "can-arm-1.log"
    drive = canopen.LocalNode(0x51, str(flying.ROOT / "descriptors" / "devices" / "joint-drive-large.eds"))
    network = canopen.Network()
    network[0x51] = drive
    # 0x651 has the SDO requests to node 0x51. Of a download (0x20) bits 2 and 3 give the number of unused octets.
    written = [(data[1] | data[2] << 8, data[3], data[4:8 - (data[0] >> 2 & 3)]) for _, data in frames(log, 0x651) if data[0] & 0xE0 == 0x20]
    for index, group in REMAPPED.items():
        expected = [(int(name[2:6], 16), int(name[7:], 16), int(value, 0)) for name, _, value in group]
        on_bus = [(at, sub, int.from_bytes(data, "little")) for at, sub, data in written if at in (index, index - 0x200)]
        assert on_bus[: len(expected)] == expected
        for at, sub, value in expected:
            drive.set_data(at, sub, value.to_bytes(1 if sub == 0 else 4, "little"), check_writable=True)
    run = runs.Run(flown_gantry.directory, None)
    truth = run.truth["JOINTS"]
    database = cantools.database.load_file(made_robots[0] / "build" / "generated" / "gantry-arm-1.dbc")
    message = database.get_message_by_frame_id(0x1D1)
    # TPDO1 has the actual position, RPDO1 the target position.
    for pdo, identifier, index, bound in ((drive.tpdo[1], 0x1D1, 0x6064, 5e-4), (drive.rpdo[1], 0x251, 0x607A, 2e-3)):
        pdo.read()
        (variable,) = (entry for entry in pdo.map if entry.index == index)
        moving = [(time, data) for time, data in frames(log, identifier) if 5_000_000 < time < 7_000_000]
        assert len(moving) == 2000 and len(moving[0][1]) == 8
        read = []
        for _, data in moving:
            pdo.data = bytearray(data)
            read.append(variable.raw * 1e-6)
        true = truth["position_rad"][np.searchsorted(truth["time_us"], [time for time, _ in moving]), 0]
        assert np.ptp(true) > 0.05 and np.abs(np.array(read) - true).max() < bound
        if identifier == 0x1D1:
            (name,) = (signal.name for signal in message.signals if signal.start == 32)  # After two words of 16 bit.
            assert message.decode(moving[-1][1])[name] == pytest.approx(read[-1], abs=1e-9)


@pytest.mark.skipif(not os.environ.get("LONG"), reason="flies with LONG=1")
def test_two_arms_fly_in_one_mission_and_each_has_its_figures(made_robots, session_directory):
    """The mission consists of the gantry and a snake of three joints that make new-robot puts beside it, as docs/arm.md shows."""
    place, _ = made_robots
    made = make(place, snake(session_directory / "beside.urdf", 3), "--name", "beside", "--with", "gantry")
    assert made.returncode == 0, made.stderr
    subprocess.run([sys.executable, "gse/generator/generate.py", "--mission", "descriptors/missions/beside.xml", "--out", "build/generated"], cwd=place, check=True)
    flight = flying.fly(session_directory / "beside", "--mission", "beside", "--scenario", "beside", root=place, report="yes")
    assert flight.code == 0, flight.transcript()
    assert flight.facts["figures_hold"] is True and flight.facts["figures_missing"] == {}
    assert {name.split(".")[0] for name in flight.facts if "." in name} == {"gantry", "beside"}


def _torso(path, *sides):
    """URDF of a body with an arm of three joints on each of these sides."""
    lines = ['<robot name="torso"><link name="torso"/>']
    for side, place in sides:
        for i, axis in enumerate(("0 0 1", "0 1 0", "0 1 0")):
            parent, at = (f"{side}_link{i}", "0.25 0 0") if i else ("torso", place)
            lines.append(f'<link name="{side}_link{i + 1}"><inertial><origin xyz="0.12 0 0"/><mass value="{2.0 - 0.5 * i}"/>'
                         '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>'
                         f'<joint name="{side}{i + 1}" type="revolute"><origin xyz="{at}"/><parent link="{parent}"/><child link="{side}_link{i + 1}"/>'
                         f'<axis xyz="{axis}"/><limit lower="-1.5" upper="1.5" effort="60" velocity="1.5"/></joint>')
    path.write_text("".join([*lines, "</robot>"]), encoding="utf-8")
    return path


@pytest.mark.skipif(not os.environ.get("LONG"), reason="flies with LONG=1")
def test_two_arms_on_one_body_fly(made_robots, session_directory):
    """The robots of both arms are replaced by one robot, as docs/arm.md says."""
    place, _ = made_robots
    worlds, sides = place / "descriptors" / "worlds", (("left", "0 0.3 0.6"), ("right", "0 -0.3 0.6"))
    for side, *options in (("left",), ("right", "--with", "left")):
        made = make(place, _torso(session_directory / f"{side}.urdf", *(each for each in sides if each[0] == side)), "--name", side, *options)
        assert made.returncode == 0, made.stderr
    _torso(worlds / "torso.urdf", *sides)
    text = (worlds / "right.xml").read_text(encoding="utf-8")
    starts = " ".join(re.findall(r"<Start (.*)/>", text))
    text = re.sub(r'(?s)<Robot name="arm".*?</Robot>', f'<Robot name="arm" urdf="torso.urdf" base="fixed"><Start {starts}/></Robot>', text)
    text = re.sub(r'(?s)  <Robot name="right".*?</Robot>\n', "", text).replace('joint="right.', 'joint="arm.')
    (worlds / "right.xml").write_text(text, encoding="utf-8")
    subprocess.run([sys.executable, "gse/generator/generate.py", "--mission", "descriptors/missions/right.xml", "--out", "build/generated"], cwd=place, check=True)
    flight = flying.fly(session_directory / "right", "--mission", "right", "--scenario", "right", root=place, report="yes")
    assert flight.code == 0, flight.transcript()
    assert flight.facts["figures_hold"] is True and flight.facts["figures_missing"] == {}
