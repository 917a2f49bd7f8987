# SPDX-License-Identifier: Apache-2.0
"""The URDF reader of make new-robot: refused files, and links that are merged into one;
test_arm_against_mujoco.py compares everything else with MuJoCo."""

import io
import math
import pathlib
import re
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[4] / "gse" / "scaffold"))

import new_robot
import urdf
from hirosco_gse import urdf as reader
from loads import mass_matrix
from new_subsystem import Refusal
from source import read_number

LINK = ('<link name="{name}"><inertial><origin xyz="{at} 0 0"/><mass value="{mass}"/>'
        '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>')
JOINT = ('<joint name="{name}" type="{kind}"><origin xyz="{at} 0 0"/><parent link="{parent}"/><child link="{child}"/><axis xyz="0 1 0"/>'
         '{limit}</joint>')
LIMIT = '<limit lower="-1" upper="2" effort="50" velocity="2"/>'


def link(name, at=0.1, mass=1.0):
    return LINK.format(name=name, at=at, mass=mass)


def joint(name, parent, child, kind="revolute", at=0.2, limit=LIMIT):
    return JOINT.format(name=name, kind=kind, parent=parent, child=child, at=at, limit=limit)


@pytest.fixture
def read(tmp_path):
    def reader(*parts, tool=None):
        path = tmp_path / "robot.urdf"
        path.write_text(f'<robot name="robot">{"".join(parts)}</robot>', encoding="utf-8")
        return urdf.read(path, tool)

    return reader


ARM = (link("base"), link("upper"), joint("shoulder", "base", "upper"))


@pytest.mark.parametrize("parts, message", [
    ((*ARM, link("other"), joint("twin", "base", "other")), "robot.urdf:1: joint twin: expected one joint after a link, an arm is a chain; there is shoulder; give each arm a file of its own, or make the joints of a gripper type=\"fixed\" without <mimic>, docs/arm.md"),
    ((link("base"), link("upper"), joint("slide", "base", "upper", "floating")),
     'robot.urdf:1: joint slide: type="floating": expected fixed, or revolute, continuous or prismatic, the joints that the program arm drives; for a base that'
     ' flies freely, remove this joint with its parent link and give BASE=free; otherwise make it type="fixed"'),
    ((link("base"), link("upper"), joint("slide", "base", "upper", "planar")),
     'robot.urdf:1: joint slide: type="planar": expected fixed, or revolute, continuous or prismatic, the joints that the program arm drives; make it type="fixed",'
     ' or two prismatic joints and a revolute one, each of which moves a link with a mass'),
    ((link("base"), '<link name="upper"/>', joint("shoulder", "base", "upper")),
     'robot.urdf:1: joint shoulder: link upper has no mass: expected <inertial> with <mass> and <inertia> in it, or in a link that a joint with type="fixed"'),
    ((ARM[0], re.sub("<inertia .*?/>", "", ARM[1]), ARM[2]), "robot.urdf:1: <inertial>: expected <inertia>"),
    # A joint of a gripper often has no limit of its own: the reason given is that it mimics another.
    ((link("base"), link("upper"), joint("finger", "base", "upper", limit='<mimic joint="other"/>')),
     'joint finger: expected no <mimic>, because a drive moves each joint of an arm; make the joints of a gripper type="fixed" without <mimic>, docs/arm.md'),
    ((link("base"), link("upper"), joint("shoulder", "base", "upper", limit="")), "joint shoulder: no effort, velocity, lower, upper: expected <limit> with effort, velocity, lower, upper"),
    ((*ARM[:2], ARM[2].replace(' effort="50"', "")), "robot.urdf:1: joint shoulder: no effort: expected <limit> with effort, velocity, lower, upper, which"),
    ((*ARM[:2], joint("shoulder", "base", "lower")), "joint shoulder: lower: expected a link of the robot"),
    ((*ARM, link("loose")),
     'robot.urdf:1: link loose: expected one root, and base is no child of a joint either; connect loose by a joint with type="fixed", or remove it'),
    ((link("base"),), "0 joints that move: expected 1 to 12"),
    ((ARM[0], ARM[1].replace('"1.0"', '"heavy"'), ARM[2]), 'value="heavy" of <mass>: expected 1 number'),
    ((ARM[0], ARM[1].replace('iyz="0"', ""), ARM[2]), "<inertia>: expected iyz="),
    ((ARM[0], ARM[1].replace("</inertial>", '<mass value="2"/></inertial>'), ARM[2]), "robot.urdf:1: <mass>: expected only one in <inertial>"),
    ((*ARM[:2], ARM[2].replace("</joint>", LIMIT + "</joint>")), "robot.urdf:1: <limit>: expected only one in <joint>"),
    # Together with the mass of `upper` this mass would be 0.
    ((*ARM, link("hand", mass=-1.0), joint("flange", "upper", "hand", "fixed")), 'robot.urdf:1: value="-1.0" of <mass>: expected more than 0'),
    ((ARM[0], ARM[1].replace('"1.0"', '"0"'), ARM[2]), 'robot.urdf:1: value="0" of <mass>: expected more than 0'),
    ((ARM[0], ARM[1].replace('iyy="0.01"', 'iyy="-0.01"'), ARM[2]), 'robot.urdf:1: iyy="-0.01" of <inertia>: expected more than 0'),
    ((ARM[0], ARM[1], ARM[2].replace("0 1 0", "0 0 0")), "robot.urdf:1: <axis> of joint shoulder: expected a direction"),
    ((ARM[0], ARM[1], ARM[2].replace("</joint>", "")), "robot.urdf:1: mismatched tag: expected XML"),
    ((ARM[0], ARM[1].replace("</link>", "<collision/></link>"), ARM[2]), "<collision>: expected <geometry>"),
    ((ARM[0], ARM[1], ARM[2].replace("0 1 0", "0 1")), 'xyz="0 1" of <axis>: expected 3 numbers'),
    # A cycle after the root, a joint from a link to itself, and a cycle without a root.
    ((*ARM, link("hand"), joint("wrist", "upper", "hand"), joint("back", "hand", "upper", "fixed")),
     "robot.urdf:1: joint back: child upper: expected a link that no other joint moves; there is shoulder; an arm is an open chain: of a closed one, such as a delta robot, only one branch can fly"),
    ((*ARM, joint("own", "upper", "upper", "fixed")), "joint own: child upper: expected a link that no other joint moves; there is shoulder"),
    ((*ARM, joint("back", "upper", "base")),
     "robot.urdf:1: joint shoulder: expected one link that is no child of a joint, the root of the robot; the joints form a ring: remove one"),
    ((), "robot.urdf: no link: expected one link that is no child of a joint, the root of the robot"),
    ((*ARM[:2], ARM[2].replace("</joint>", '<mimic joint="other"/></joint>')), "joint shoulder: expected no <mimic>, because a drive moves each joint of an arm; make the joints of a gripper"),
    ((*ARM[:2], ARM[2].replace("shoulder", "arm/1")), "joint arm/1: expected a name of at most 59 letters, digits, '_', '-' and '.', a letter first"),
    ((*ARM[:2], ARM[2].replace("shoulder", "1st")), "joint 1st: expected a name of at most 59 letters"),
    ((*ARM[:2], ARM[2].replace("shoulder", "j" * 60)), "expected a name of at most 59 letters"),
    ((*ARM[:2], ARM[2].replace("shoulder", "xmlns")), "joint xmlns: expected a name of at most 59 letters"),
    ((*ARM[:2], ARM[2].replace('lower="-1"', 'lower="2"')), 'lower="2" upper="2": expected lower < upper, within +-2147 rad or m'),
    ((*ARM[:2], ARM[2].replace('upper="2"', 'upper="2148"')), 'lower="-1" upper="2148": expected lower < upper, within +-2147 rad or m'),
    ((*ARM[:2], ARM[2].replace('effort="50"', 'effort="321"')), 'robot.urdf:1: joint shoulder: effort="321": expected more than 0 and at most 320'),
    ((*ARM[:2], ARM[2].replace('effort="50"', 'effort="0"')), 'joint shoulder: effort="0": expected more than 0 and at most 320'),
    ((*ARM[:2], ARM[2].replace('velocity="2"', 'velocity="0"')), 'joint shoulder: velocity="0": expected at least 0.001 rad/s or m/s'),
    ((*ARM[:2], ARM[2].replace('velocity="2"', 'velocity="9e-4"')), 'robot.urdf:1: joint shoulder: velocity="0.0009": expected at least 0.001 rad/s'),
    (('<xacro:arm prefix="left"/>',), "robot.urdf:1: <xacro:arm>: expected an element of URDF; a file for xacro must be expanded first"),
])
def test_a_robot_that_is_no_arm_is_refused_with_the_reason(read, parts, message):
    with pytest.raises(urdf.UrdfError) as refusal:
        read(*parts)
    assert message in str(refusal.value)


def test_a_refusal_names_the_line(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="robot">\n{ARM[0]}\n{ARM[1]}\n\n{joint("slide", "base", "upper", "floating")}</robot>', encoding="utf-8")
    with pytest.raises(Refusal, match="robot.urdf:5: joint slide: type=\"floating\": expected fixed, or revolute, continuous or prismatic"):
        new_robot.plan(path, "slider", None, None, None)
    with pytest.raises(Refusal, match="nowhere.urdf: cannot read: No such file"):
        new_robot.plan(tmp_path / "nowhere.urdf", "slider", None, None, None)
    path.write_text("<arm/>", encoding="utf-8")
    with pytest.raises(Refusal, match="robot.urdf:1: <arm>: expected <robot>"):
        new_robot.plan(path, "slider", None, None, None)


def test_the_parser_gets_a_file_in_one_piece(tmp_path, monkeypatch):
    """In pieces, its time for a comment grows with the square of the length: 11 s for 5 MB."""
    reads = []

    class Counted(io.BytesIO):
        def read(self, *size):
            reads.append(size)
            return super().read(*size)

    text = f'<robot name="robot"><!--{"x" * 100_000}-->{link("base")}{link("arm")}{joint("turn", "base", "arm")}</robot>'
    monkeypatch.setattr(reader, "open", lambda path, mode: Counted(text.encode()), raising=False)
    assert len(urdf.read(tmp_path / "robot.urdf").joints) == 1
    assert len(reads) == 1


def test_a_file_of_another_encoding_is_refused_with_its_line(tmp_path):
    path = tmp_path / "robot.urdf"
    text = f'<?xml version="1.0" encoding="ISO-8859-1"?>\n<robot name="robot">\n<!-- Größe -->{"".join(ARM)}</robot>'
    path.write_text(text, encoding="latin-1")
    with pytest.raises(Refusal, match="robot.urdf:3: found octet 0xF6, expected UTF-8"):
        new_robot.plan(path, "robot", None, None, None)
    for encoding, reason in (("FOO", "unknown encoding: FOO"), ("Shift_JIS", "multi-byte encodings are not supported")):
        path.write_text(f'<?xml version="1.0" encoding="{encoding}"?>\n<robot name="robot">{"".join(ARM)}</robot>', encoding="utf-8")
        with pytest.raises(Refusal, match=f"robot.urdf:1: {reason}: expected UTF-8: convert the file"):
            new_robot.plan(path, "robot", None, None, None)


@pytest.mark.parametrize("name", ["7dof", "ロボット", "r"])
def test_a_robot_whose_name_cannot_name_files_needs_the_option_name(tmp_path, name):
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="{name}">{"".join(ARM)}</robot>', encoding="utf-8")
    with pytest.raises(Refusal, match=f'it comes from the name of the robot, "{name}": give another with NAME='):
        new_robot.plan(path, None, None, None, None)
    assert len(new_robot.plan(path, "my_robot", None, None, None)[0]) == 6


def test_a_link_too_light_for_a_gear_is_refused(read):
    light = [part.replace('iyy="0.01"', 'iyy="9e-7"') for part in ARM]
    with pytest.raises(Refusal, match="robot.urdf:1: joint shoulder: moves 9e-07 kgm2 about its axis, expected at least 1e-06"):
        new_robot.drive_of(read(*light).joints[0])


def test_the_gears_of_a_chain_of_light_links_are_stable_in_the_step_of_the_simulator(read):
    """Linear axes in a row with light links: the simulator computes each velocity from force and damping of the last step, then the position.
    The largest eigenvalue of twelve equal masses in a row is almost four times that of one mass."""
    slide = joint("slide", "base", "upper", "prismatic").replace('effort="50"', 'effort="300"')
    (drive,) = (new_robot.drive_of(one) for one in read(*ARM[:2], slide).joints)
    mass, step, largest = 1.0, new_robot.STEP_S, 4.0
    assert drive["stiffness"] == pytest.approx(1e6) and drive["damping"] < 1500.0  # Both limited by the mass.
    assert largest * (drive["stiffness"] * step**2 + 2.0 * drive["damping"] * step) / mass < 4.0


def _strong(read, at):
    """An arm of two slender links of 1 kg and 0.4 m, with a strong linear axis at this distance from the end of the second one."""
    slender = [link(name, 0.2).replace('"0.01"', '"0.0032"') for name in ("base", "upper", "fore", "slide")]
    turns = [joint("shoulder", "base", "upper"), joint("elbow", "upper", "fore", at=0.4)]
    return read(*slender, *(each.replace("0 1 0", "0 0 1") for each in turns), joint("axis", "fore", "slide", "prismatic", at, LIMIT.replace("2", "1", 1)))


def test_gears_that_are_unstable_together_in_the_step_of_the_simulator_are_refused(read, tmp_path):
    """The force of a linear axis on a lever turns light links, whose other gears are each stable."""
    robot = _strong(read, 0.2)
    poses = list(new_robot.poses_of(robot, (0.3, -0.4, 0.1)))
    matrix = mass_matrix(robot, (0.3, -0.4, 0.1), "fixed")
    assert [matrix[i][i] for i in range(3)] == pytest.approx([new_robot.carried_by(robot, poses, i) for i in range(3)])
    assert matrix[0][1] == pytest.approx(matrix[1][0])
    assert len(new_robot.plan(tmp_path / "robot.urdf", "strong", None, None, None)[0]) == 6
    _strong(read, 1.2)
    with pytest.raises(Refusal, match=r"robot.urdf:1: joint axis: \(stiffness x .* is [0-9.]+ in its fastest mode, expected less than 4"):
        new_robot.plan(tmp_path / "robot.urdf", "strong", None, None, None)


@pytest.mark.parametrize("kind, least", [("revolute", "0.02 Nm"), ("prismatic", "0.0002 N")])
def test_an_effort_too_small_for_a_gear_is_refused(read, kind, least):
    weak = joint("shoulder", "base", "upper", kind).replace('effort="50"', 'effort="1e-4"')
    with pytest.raises(Refusal, match=f'robot.urdf:1: joint shoulder: effort="0.0001": expected at least {least}, with which'):
        new_robot.drive_of(read(*ARM[:2], weak).joints[0])


def test_a_gear_on_a_light_free_base_is_stable_in_the_step_of_the_simulator(read):
    """The base is a hundred times lighter than the link: the gear acts on both. A force beside the centre of mass turns the base, too."""
    robot = read(link("base", mass=0.1).replace('"0.01"', '"1e-4"'), link("upper"), joint("turn", "base", "upper").replace('"50"', '"20"'))
    stiff = new_robot.drive_of(robot.joints[0])
    robot.joints[0].free_base = robot.base
    soft, step = new_robot.drive_of(robot.joints[0]), new_robot.STEP_S
    assert stiff["stiffness"] == pytest.approx(1000.0) and soft["stiffness"] == pytest.approx(100.0, rel=1e-3)
    assert soft["stiffness"] * step**2 + soft["damping"] * step < 4.0 * 1e-4
    slide = read(link("base", mass=0.1).replace('"0.01"', '"1e-4"'), link("upper"), joint("slide", "base", "upper", "prismatic")).joints[0]
    slide.free_base = robot.base  # Its centre is 0.1 m from the axis x of the joint along x: the axis is y.
    assert new_robot.base_inertia_of(slide) == pytest.approx(1.0 / (1.0 / 0.1 + 0.1**2 / 1e-4), rel=1e-3)


def test_a_free_base_that_the_noise_of_a_torque_would_turn_is_refused(tmp_path):
    path = tmp_path / "robot.urdf"
    parts = link("base").replace('"0.01"', '"1e-4"'), link("upper"), joint("turn", "base", "upper").replace('velocity="2"', 'velocity="0.03"')
    path.write_text(f'<robot name="robot">{"".join(parts)}</robot>', encoding="utf-8")
    with pytest.raises(Refusal, match="joint turn: the free base reacts with 0.0001 kgm2, expected at least 0.00167 for effort=\"50\" and velocity=\"0.03\""):
        new_robot.plan(path, "robot", None, None, None, "free")
    assert len(new_robot.plan(path, "robot", None, None, None)[0]) == 6


def test_the_delay_of_the_bus_limits_the_gain_of_a_linear_axis_that_moves_little(read):
    """The bandwidth of the speed loop is the gain divided by the mass of rotor and link."""
    for mass, bandwidth in ((0.1, 234.4), (1.0, 118.0)):
        one = read(link("base"), link("upper", mass=mass), joint("slide", "base", "upper", "prismatic")).joints[0]
        _, kd = new_robot.gains_of(one)
        assert kd / (new_robot.ROTOR * one.effort + mass) == pytest.approx(bandwidth, rel=0.01)


def test_the_axis_of_a_fixed_joint_has_no_effect(read):
    """Manufacturers often write an axis of length 0."""
    tool = joint("flange", "upper", "tool", "fixed", limit="").replace("0 1 0", "0 0 0")
    assert read(*ARM, link("tool"), tool).joints == read(*ARM, link("tool"), tool.replace("0 0 0", "0 0 1")).joints


def test_the_scenario_expects_the_refusal_of_a_range_and_has_lines_that_the_arm_can_follow(read):
    """A line of a slow arm has a smaller SHARE; a planar arm, whose tool cannot move upward, has none."""
    def steps(axes, velocity="2", kinds=("revolute",) * 6):
        parts = [link("l0")]
        for i, axis in enumerate(axes):
            parts += [link(f"l{i + 1}"), joint(f"j{i + 1}", f"l{i}", f"l{i + 1}", kinds[i]).replace('xyz="0 1 0"', f'xyz="{axis}"')]
        robot = read(*(part.replace('velocity="2"', f'velocity="{velocity}"') for part in parts))
        start = new_robot.start_pose(robot, "free")
        return new_robot.scenario(robot, {"NAME": "ARM"}, start)["steps"], [name for name, _, _ in new_robot.bounds(robot, start)]

    z, y, x = "0 0 1", "0 1 0", "1 0 0"
    for axes, velocity, kinds, shares in (((z, y, y, x, y, x), "2", ("revolute",) * 6, ["0.5"] * 4),
                                          ((z, y, y, x, y, x), "0.1", ("revolute",) * 6, ["slow"] * 4),
                                          ((z, y, y, x, y, x), "2", ("revolute", "prismatic", *("revolute",) * 4), ["any"] * 4),
                                          ((z,) * 6, "2", ("revolute",) * 6, [])):
        text, figures = steps(axes, velocity, kinds)
        assert re.findall(r"expect-refusal (\w+) cmd ARM.(.*?=3),", text) == [("JOINT_RANGE", "MOVE_TO POSITION=3")]
        found = re.findall(r"LINE_TO .*SHARE=(\S+)", text)
        assert len(found) == len(shares) and ("goal_tool_error_m" in figures) == bool(shares)
        assert found == shares or shares[0] == "any" or all(0.01 <= float(share) < 0.5 for share in found)


def test_a_slow_arm_ends_each_motion_within_the_time_of_a_step(read):
    """Joints of 0.05 rad/s, as large arms of spacecraft have them: 1.875 is the largest speed of a minimum jerk motion relative to its mean."""
    parts = [link("l0")]
    for i, axis in enumerate(("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0")):
        moved = joint(f"j{i + 1}", f"l{i}", f"l{i + 1}").replace('xyz="0 1 0"', f'xyz="{axis}"').replace('velocity="2"', 'velocity="0.05"')
        parts += [link(f"l{i + 1}"), moved]
    robot = read(*parts)
    assert [new_robot.travel_of(one) for one in robot.joints] == pytest.approx([6.0 * 0.5 * 0.05 / 1.875] * 6)
    steps = new_robot.scenario(robot, {"NAME": "ARM"}, new_robot.start_pose(robot, "free"))["steps"]
    lines = re.findall(r"LINE_TO POSITION=[^,]*,[^,]*,(\S+) ROTATION=\S+ SHARE=(\S+)", steps)
    goal, back = (float(height) for height, _ in lines[:2])
    assert 0.0 < (goal - back) * 1.875 / (float(lines[0][1]) * new_robot.TOOL_SPEED) <= 6.001
    # With ranges that end near the pose there is no line.
    start = new_robot.start_pose(robot, "free")
    for one, angle in zip(robot.joints, start):
        one.lower, one.upper = angle - 1e-4, angle + 1e-4
    assert new_robot.line_share(robot, start) is None


def test_the_scenario_begins_when_no_link_swings_in_its_gear(read):
    """When the world starts, no gear is bent; the weight of the arm then bends it, and the link swings about its new place. It is 0.2 mm or mrad
    at most when the arm is engaged. A free base has no weight, and a linear axis swings, too."""
    def engaged(robot, start, base):
        steps = new_robot.scenario(robot, {"NAME": "ARM"}, start, base)["steps"]
        return float(re.search(r"(?m)^ *(\S+)  operator state ARM OPERATIONAL$", steps)[1])

    heavy = [part.replace('effort="50"', 'effort="250"') for part in (ARM[0], link("upper", 1.0, 12.0), ARM[2])]
    robot = read(*heavy)
    (drive,), inertia, weight_nm = [new_robot.drive_of(joint) for joint in robot.joints], 0.01 + 12.0, 12.0 * 9.81
    assert new_robot.carried_by(robot, list(new_robot.poses_of(robot, (0.7,))), 0) == pytest.approx(inertia)
    swing = weight_nm / drive["stiffness"]
    assert swing * math.exp(-0.5 * drive["damping"] / inertia * engaged(robot, (0.0,), "fixed")) < 2e-4 < swing
    assert engaged(robot, (0.0,), "free") == engaged(read(*ARM), (0.0,), "fixed") == 2.7
    lift = read(*heavy[:2], heavy[2].replace('"revolute"', '"prismatic"').replace("0 1 0", "0 0 1").replace('effort="250"', 'effort="300"'))
    assert new_robot.carried_by(lift, list(new_robot.poses_of(lift, (0.5,))), 0) == 12.0
    assert new_robot.settling_s(lift, (0.5,), "fixed") == 0.0  # 118 N bend the gear by 0.08 mm.


def test_links_that_fixed_joints_connect_become_one(read):
    """Masses of 1 and 3 kg, 0.1 and 0.5 m from the joint: the centre of mass is at 0.4 m, and the transverse
    inertia increases by 0.75 x 0.4^2."""
    robot = read(*ARM, link("hand", 0.0, 3.0), joint("flange", "upper", "hand", "fixed", 0.5))
    moved = robot.joints[0].link
    assert moved.mass == 4.0 and moved.centre == pytest.approx((0.4, 0.0, 0.0))
    assert [moved.inertia[i][i] for i in range(3)] == pytest.approx([0.02, 0.02 + 0.12, 0.02 + 0.12])
    assert robot.tool_name == "hand" and robot.tool[0] == pytest.approx((0.5, 0.0, 0.0))


def test_the_tool_is_a_link_after_the_last_joint(read):
    parts = (*ARM, link("hand"), joint("flange", "upper", "hand", "fixed", 0.5))
    assert read(*parts, tool="upper").tool[0] == urdf.ZERO
    with pytest.raises(urdf.UrdfError, match="tool base: expected a link after the last joint: upper hand"):
        read(*parts, tool="base")


def test_roll_pitch_and_yaw_are_found_again_also_at_a_pitch_of_90_degrees():
    for rpy in ((0.3, -0.7, 2.0), (-3.0, 1.5, -0.1), (0.0, math.pi / 2, 0.4), (0.0, -math.pi / 2, -1.0)):
        rotation = urdf.rotation_of(rpy)
        again = urdf.rotation_of(urdf.rpy_of(rotation))
        assert max(abs(a - b) for p, q in zip(rotation, again) for a, b in zip(p, q)) < 1e-9


def test_every_number_of_a_descriptor_is_one_that_its_readers_accept(read):
    """A rotation by 180 degrees leaves angles of about 1e-16, whose last digits are below those of a descriptor."""
    turned = link("hand"), joint("wrist", "upper", "hand").replace('<origin xyz="0.2 0 0"/>', '<origin xyz="4e-310 1.23456e-40 0.2" rpy="-1.570796326794897 3.141592653589793 0"/>')
    model = {name: list(values) for name, values in new_robot.model_of(read(*ARM, *turned)).items()}
    assert any(0.0 < abs(value) < 1e-12 for value in model["rpy"]) and model["origin"][3] == 4e-310
    for values in (*model.values(), [1.2246467991e-16, -5e-23, 1e-22, 2.5e6]):
        found = [read_number(word, "DOUBLE") for word in new_robot.text(values).split()]
        assert found == pytest.approx(values, rel=1e-9, abs=1e-22)


def test_zero_has_no_sign_in_the_files_of_a_robot(tmp_path, read):
    """An axis against y, and a start pose of -0 rad, have zeros with a sign."""
    against = [part.replace('<axis xyz="0 1 0"/>', '<axis xyz="-0 -1 0"/>') for part in ARM]
    assert against != list(ARM)
    read(*against)
    files = new_robot.plan(tmp_path / "robot.urdf", "against", None, "-0", None)[0]
    made = [text for path, text in files.items() if path.suffix in (".xml", ".scn")]
    assert len(made) >= 3 and not [line for text in made for line in text.splitlines() if re.search(r'(?<![\w.])-0(?![\w.])', line)]
    assert new_robot.text([-0.0, -4e-23, -1.0]) == "0 0 -1"


def test_a_robot_that_cannot_carry_itself_is_refused(read):
    """The arm is horizontal about y in each pose of its range: 1 kg at 0.1 m needs 1 Nm."""
    weak = [part.replace('effort="50"', 'effort="1"').replace('lower="-1" upper="2"', 'lower="-0.1" upper="0.1"') for part in ARM]
    with pytest.raises(Refusal, match="joint shoulder: carries 9[0-9]% of its effort in the best of 400 poses, expected less than 50%"):
        new_robot.start_pose(read(*weak))


def test_the_arm_can_carry_itself_where_its_scenario_moves_it(read):
    """From a start pose in which the arm hangs almost vertically, the scenario moves it by 0.3 rad. There it needs 0.29 Nm; 0.5 x 0.2 Nm are
    permitted."""
    weak = [part.replace('effort="50"', 'effort="0.2"').replace('lower="-1" upper="2"', 'lower="-1" upper="1"') for part in (ARM[0], ARM[1], ARM[2])]
    hanging = [part.replace('<origin xyz="0.1 0 0"/>', '<origin xyz="0 0 -0.1"/>') for part in weak]
    robot = read(*hanging)
    assert new_robot.load_of(robot, (0.0,), "fixed")[0] == 0.0 and new_robot.away_from(robot, (0.01,)) == pytest.approx([-0.29])
    with pytest.raises(Refusal, match="joint shoulder: carries 7[0-9]% of its effort in the best of 400 poses"):
        new_robot.start_pose(robot)
    with pytest.raises(Refusal, match="START=-0.05: expected a pose in which joint shoulder carries less than 100% of its effort, also where .*; it carries 121%"):
        new_robot.wanted_pose(robot, "-0.05")
    assert new_robot.wanted_pose(robot, "-0.05", "free") == (-0.05,)


def test_no_joint_accelerates_more_than_its_torque_permits(read):
    """A joint that is fast and weak: 5 kg at 0.5 m, with 20 Nm and 20 rad/s."""
    fast = link("upper", 0.5, 5.0), ARM[2].replace('effort="50" velocity="2"', 'effort="20" velocity="20"').replace("0 1 0", "0 0 1")
    robot = read(ARM[0], *fast)
    assert list(new_robot.limits_of(robot, (0.0,))["acceleration"]) == pytest.approx([0.4 * 20.0 / (0.01 + 5.0 * 0.25)])
    assert new_robot.peak_speeds_of(robot, (0.0,)) == pytest.approx([1.875 * math.sqrt(0.3 * 0.5 * 0.4 * 20.0 / 1.26 / 5.7735)])
    assert list(new_robot.limits_of(read(*ARM), (0.0,))["acceleration"]) == [4.0]


@pytest.mark.parametrize("given", ["1,2", "3", "up", ""])
def test_a_start_pose_has_an_angle_within_the_range_of_each_joint(read, given):
    robot = read(*ARM)
    assert new_robot.wanted_pose(robot, "-0.5") == (-0.5,)
    with pytest.raises(Refusal, match="1 positions in rad or m within the ranges"):
        new_robot.wanted_pose(robot, given)


def test_a_free_base_has_a_mass_and_no_weight_to_carry(read, tmp_path):
    """Here this is an arm that could not carry itself on the ground."""
    weak = [part.replace('effort="50"', 'effort="0.1"') for part in ARM]
    assert read(*weak).base.mass == 1.0
    with pytest.raises(Refusal, match="BASE=floating: expected fixed or free"):
        new_robot.plan(tmp_path / "robot.urdf", "weak", None, None, None, "floating")
    files, mission, _, _ = new_robot.plan(tmp_path / "robot.urdf", "weak", None, None, None, "free")
    worlds = [text for path, text in files.items() if path.parent.name == "worlds" and path.suffix == ".xml"]
    assert 'gravity="0 0 0"' in worlds[0] and 'base="free"' in worlds[0] and mission in files
    read('<link name="base"/>', *weak[1:])
    with pytest.raises(Refusal, match="expected the root link with a mass"):
        new_robot.plan(tmp_path / "robot.urdf", "weak", None, None, None, "free")
