# SPDX-License-Identifier: Apache-2.0
"""Compares kinematics and dynamics of the subsystem arm with those of MuJoCo from the same URDF files: random robots of 1 to 12 joints,
a third of which are linear axes."""

import ctypes
import pathlib
import random
import subprocess
import sys

import mujoco
import numpy
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[5]
sys.path.insert(0, str(ROOT / "gse" / "scaffold"))

import urdf


ROBOTS, POSES = 20, 10
JOINTS_MAX = 12
GRAVITY = (1.3, -2.1, -9.81)


class Vector(ctypes.Structure):
    _fields_ = [("at", ctypes.c_double * 3)]


class Rotation(ctypes.Structure):
    _fields_ = [("at", (ctypes.c_double * 3) * 3)]


class Pose(ctypes.Structure):
    _fields_ = [("rotation", Rotation), ("position", Vector)]


class Link(ctypes.Structure):
    _fields_ = [("origin", Pose), ("axis", Vector), ("mass", ctypes.c_double), ("centre", Vector), ("inertia", Rotation),
                ("is_prismatic", ctypes.c_bool)]


class Model(ctypes.Structure):
    _fields_ = [("joint_count", ctypes.c_uint), ("link", Link * JOINTS_MAX), ("tool", Pose), ("gravity", Vector)]


class Kinematics(ctypes.Structure):
    _fields_ = [("link", Pose * JOINTS_MAX), ("axis", Vector * JOINTS_MAX), ("tool", Pose)]


class Jacobian(ctypes.Structure):
    _fields_ = [("at", (ctypes.c_double * JOINTS_MAX) * 6)]


class Motion(ctypes.Structure):
    _fields_ = [(name, ctypes.c_double * JOINTS_MAX) for name in ("position", "velocity", "acceleration")]


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """The flight sources as a library."""
    library = tmp_path_factory.mktemp("arm") / "arm.so"
    sources = [f"fsw/subsystems/arm/arm_{name}.c" for name in ("geometry", "model", "inverse")]
    sources += ["fsw/framework/control/elementary.c", "osal/posix/assertion.c"]
    subprocess.run(["cc", "-std=c99", "-O2", "-I.", "-shared", "-fPIC", "-o", library, *sources, "-lm"], cwd=ROOT, check=True)
    return ctypes.CDLL(str(library))


def text(values):
    return " ".join(f"{value:.17g}" for value in values)


def random_robot(dice, count):
    """URDF of a chain with fixed joints in between, inertias with products of inertia, and a tool."""
    lines = ['<robot name="random"><mujoco><compiler fusestatic="false" balanceinertia="false"/></mujoco><link name="link0"/>']

    def link(name):
        moments = sorted(dice.uniform(0.01, 0.1) for _ in range(3))
        # No principal moment of a rigid body exceeds the sum of the two others; MuJoCo refuses such a body.
        moments[2] = min(moments[2], 0.9 * (moments[0] + moments[1]))
        lines.append(f'<link name="{name}"><inertial><origin xyz="{text(dice.uniform(-0.2, 0.2) for _ in range(3))}" '
                     f'rpy="{text(dice.uniform(-3, 3) for _ in range(3))}"/><mass value="{dice.uniform(0.3, 8)}"/>'
                     f'<inertia ixx="{moments[0]}" iyy="{moments[1]}" izz="{moments[2]}" ixy="0" ixz="0" iyz="0"/></inertial></link>')

    def joint(name, kind, parent, child):
        lines.append(f'<joint name="{name}" type="{kind}"><origin xyz="{text(dice.uniform(-0.4, 0.4) for _ in range(3))}" '
                     f'rpy="{text(dice.uniform(-3, 3) for _ in range(3))}"/><parent link="{parent}"/><child link="{child}"/>'
                     f'<axis xyz="{text(dice.uniform(-1, 1) for _ in range(3))}"/>'
                     '<limit lower="-3" upper="3" effort="100" velocity="2"/></joint>')

    for i in range(count):
        link(f"link{i + 1}")
        joint(f"joint{i + 1}", "prismatic" if dice.random() < 0.33 else "revolute", f"link{i}", f"link{i + 1}")
        if dice.random() < 0.4:
            link(f"part{i + 1}")
            joint(f"mount{i + 1}", "fixed", f"link{i + 1}", f"part{i + 1}")
    lines.append('<link name="tool"/>')
    joint("flange", "fixed", f"link{count}", "tool")
    return "".join(lines) + "</robot>"


def fill(pose, given):
    pose.position.at[:] = given[0]
    for i in range(3):
        pose.rotation.at[i][:] = given[1][i]


def model_of(robot):
    """The model as the flight software builds it. The rotations are made from roll, pitch and yaw, so that
    this step is tested as well."""
    model = Model(joint_count=len(robot.joints))
    for link, joint in zip(model.link, robot.joints):
        fill(link.origin, (joint.origin[0], urdf.rotation_of(urdf.rpy_of(joint.origin[1]))))
        link.axis.at[:] = joint.axis
        link.mass = joint.link.mass
        link.is_prismatic = joint.is_prismatic
        link.centre.at[:] = joint.link.centre
        for i in range(3):
            link.inertia.at[i][:] = joint.link.inertia[i]
    fill(model.tool, robot.tool)
    model.gravity.at[:] = GRAVITY
    return model


@pytest.mark.parametrize("seed", range(ROBOTS))
def test_kinematics_and_dynamics_of_a_random_robot_equal_those_of_mujoco(flight, tmp_path, seed):
    dice = random.Random(seed)
    count = 1 + seed % JOINTS_MAX
    path = tmp_path / "random.urdf"
    path.write_text(random_robot(dice, count), encoding="utf-8")
    model = model_of(urdf.read(path, "tool"))
    peer = mujoco.MjModel.from_xml_path(str(path))
    peer.opt.gravity[:] = GRAVITY
    data = mujoco.MjData(peer)
    tool = mujoco.mj_name2id(peer, mujoco.mjtObj.mjOBJ_BODY, "tool")
    for _ in range(POSES):
        motion = Motion()
        for values, limit in ((motion.position, 3.0), (motion.velocity, 2.0), (motion.acceleration, 5.0)):
            values[:] = [dice.uniform(-limit, limit) for _ in range(JOINTS_MAX)]
        data.qpos[:], data.qvel[:], data.qacc[:] = (list(v)[:count] for v in (motion.position, motion.velocity, motion.acceleration))
        mujoco.mj_inverse(peer, data)

        kinematics, jacobian = Kinematics(), Jacobian()
        flight.arm_kinematics(ctypes.byref(model), motion.position, ctypes.byref(kinematics))
        flight.arm_jacobian(ctypes.byref(model), ctypes.byref(kinematics), ctypes.byref(jacobian))
        assert numpy.abs(numpy.array(kinematics.tool.position.at) - data.xpos[tool]).max() < 1e-12
        assert numpy.abs(numpy.array(kinematics.tool.rotation.at) - data.xmat[tool].reshape(3, 3)).max() < 1e-12
        peer_linear, peer_angular = numpy.zeros((3, count)), numpy.zeros((3, count))
        mujoco.mj_jacBody(peer, data, peer_linear, peer_angular, tool)
        ours = numpy.array(jacobian.at)[:, :count]
        assert numpy.abs(ours - numpy.vstack((peer_linear, peer_angular))).max() < 1e-12

        torque = (ctypes.c_double * JOINTS_MAX)()
        flight.arm_inverse_dynamics(ctypes.byref(model), ctypes.byref(motion), torque)
        expected = data.qfrc_inverse
        assert numpy.abs(numpy.array(torque)[:count] - expected).max() < 1e-10 * max(1.0, numpy.abs(expected).max())
