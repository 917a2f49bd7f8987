# SPDX-License-Identifier: Apache-2.0
"""The URDF reader of make new-robot: refused files, and links that are merged into one;
test_arm_against_mujoco.py compares everything else with MuJoCo."""

import math
import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[4] / "gse" / "scaffold"))

import new_robot
import urdf
from new_subsystem import Refusal

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


@pytest.mark.parametrize("parts, says", [
    ((*ARM, link("other"), joint("twin", "base", "other")), "robot.urdf:1: joint twin: expected one joint behind a link, an arm is a chain; there is shoulder"),
    ((link("base"), link("upper"), joint("slide", "base", "upper", "floating")),
     'robot.urdf:1: joint slide: type="floating": expected revolute, continuous or prismatic'),
    ((link("base"), link("upper"), joint("shoulder", "base", "upper", limit="")), "joint shoulder: expected <limit> with effort, velocity, lower, upper"),
    ((*ARM[:2], joint("shoulder", "base", "lower")), "joint shoulder: lower: expected a link of the robot"),
    ((*ARM, link("loose")), "roots base loose: expected one link without a parent"),
    ((link("base"),), "0 joints that move: expected 1 to 12"),
    ((ARM[0], ARM[1].replace('"1.0"', '"heavy"'), ARM[2]), 'value="heavy" of <mass>: expected 1 number'),
    ((ARM[0], ARM[1].replace('iyz="0"', ""), ARM[2]), "<inertia>: expected iyz="),
    ((ARM[0], ARM[1], ARM[2].replace("0 1 0", "0 0 0")), "<axis>: expected a direction"),
    ((ARM[0], ARM[1], ARM[2].replace("</joint>", "")), "robot.urdf:1: mismatched tag: expected XML"),
    ((ARM[0], ARM[1].replace("</link>", "<collision/></link>"), ARM[2]), "<collision>: expected <geometry>"),
    ((ARM[0], ARM[1], ARM[2].replace("0 1 0", "0 1")), 'xyz="0 1" of <axis>: expected 3 numbers'),
])
def test_a_robot_that_is_no_chain_of_joints_is_refused(read, parts, says):
    with pytest.raises(urdf.UrdfError) as refusal:
        read(*parts)
    assert says in str(refusal.value)


def test_a_refusal_names_the_line(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="robot">\n{ARM[0]}\n{ARM[1]}\n\n{joint("slide", "base", "upper", "floating")}</robot>', encoding="utf-8")
    with pytest.raises(Refusal, match="robot.urdf:5: joint slide: type=\"floating\": expected revolute, continuous or prismatic"):
        new_robot.plan(path, "slider", None, None, None)
    with pytest.raises(Refusal, match="nowhere.urdf: cannot read: No such file"):
        new_robot.plan(tmp_path / "nowhere.urdf", "slider", None, None, None)
    path.write_text("<arm/>", encoding="utf-8")
    with pytest.raises(Refusal, match="robot.urdf:1: <arm>: expected <robot>"):
        new_robot.plan(path, "slider", None, None, None)


def test_links_that_fixed_joints_connect_become_one(read):
    """Masses of 1 and 3 kg, 0.1 and 0.5 m from the joint: the centre of mass is at 0.4 m, and the transverse
    inertia increases by 0.75 x 0.4^2."""
    robot = read(*ARM, link("hand", 0.0, 3.0), joint("flange", "upper", "hand", "fixed", 0.5))
    moved = robot.joints[0].link
    assert moved.mass == 4.0 and moved.centre == pytest.approx((0.4, 0.0, 0.0))
    assert [moved.inertia[i][i] for i in range(3)] == pytest.approx([0.02, 0.02 + 0.12, 0.02 + 0.12])
    assert robot.tool_name == "hand" and robot.tool[0] == pytest.approx((0.5, 0.0, 0.0))


def test_the_tool_is_a_link_behind_the_last_joint(read):
    parts = (*ARM, link("hand"), joint("flange", "upper", "hand", "fixed", 0.5))
    assert read(*parts, tool="upper").tool[0] == urdf.ZERO
    with pytest.raises(urdf.UrdfError, match="tool base: expected a link behind the last joint: upper hand"):
        read(*parts, tool="base")


def test_roll_pitch_and_yaw_are_found_again_also_straight_up():
    for rpy in ((0.3, -0.7, 2.0), (-3.0, 1.5, -0.1), (0.0, math.pi / 2, 0.4), (0.0, -math.pi / 2, -1.0)):
        rotation = urdf.rotation_of(rpy)
        again = urdf.rotation_of(urdf.rpy_of(rotation))
        assert max(abs(a - b) for p, q in zip(rotation, again) for a, b in zip(p, q)) < 1e-9


def test_a_robot_that_cannot_carry_itself_is_refused(read):
    """The arm is horizontal about y in each pose of its range: 1 kg at 0.1 m needs 1 Nm."""
    weak = [part.replace('effort="50"', 'effort="1"').replace('lower="-1" upper="2"', 'lower="-0.1" upper="0.1"') for part in ARM]
    with pytest.raises(Refusal, match="joint shoulder: carries 9[0-9]% of its effort in the best of 400 poses, expected less than 50%"):
        new_robot.start_pose(read(*weak))


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
