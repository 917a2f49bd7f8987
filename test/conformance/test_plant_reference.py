# SPDX-License-Identifier: Apache-2.0
"""Compares the plant with MuJoCo, from the same URDF: random trees of joints on a fixed base under gravity, and free-flying chains, also with
joints that mimic others or are moved through elastic gears; a free body with reaction wheels; and a cube that touches a table.

The same springs, dampers and sines move the robots of both; MuJoCo integrates by Runge-Kutta at 0.1 ms. The plant integrates by its own step of
0.5 ms, whose error is of first order and grows with accelerations, so gravity is weak where 20 s are compared. Two steps of
different length distinguish this error from a difference of the equations. The comparison must also detect a wrong axis and a wrong
rotation of an inertia in the URDF of the plant."""

import math
import pathlib
import random
import re
import subprocess

import mujoco
import numpy
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCES = [path for directory in ("sim/plant", "sim/world") for path in sorted((ROOT / directory).glob("*.c"))]
REFERENCE_S = 1e-4
BASE_RAD, JOINT_RAD = 1e-5, 1e-4  # Bounds over 20 s; for prismatic joints in m.
EXTRAPOLATED = 5e-7  # Bound on the deviation after the error of first order is removed by extrapolation.
WEAK, EARTH = (0.08, -0.05, -0.5), (0.5, -0.3, -9.81)
STIFF = (-1e6, -2e3)  # Stiffness and damping per inertia of a mimic joint in the reference.
OMEGA, DAMPING = 4.0, 0.5  # Frequency and damping of the motion of each joint, per inertia that it carries.


@pytest.fixture(scope="session")
def probe(tmp_path_factory):
    program = tmp_path_factory.mktemp("plant") / "probe"
    subprocess.run(["gcc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-D_GNU_SOURCE", "-ffp-contract=off", f"-I{ROOT}", "-o", program,
                    ROOT / "test/conformance/plant_probe.c", *SOURCES, "-lode", "-lexpat", "-lm"], check=True)
    return program


class Robot:
    """A random tree or chain: its URDF, the law of each joint, and the start."""

    def __init__(self, seed, joints, is_free=False, gravity=WEAK, mimics=()):
        self.rng = random.Random(seed)
        self.is_free, self.gravity = is_free, (0, 0, 0) if is_free else gravity
        self.links, self.joints = [], []
        self.add_link("base", 350.0 if is_free else 5.0, 1.0)
        for index in range(joints):
            self.add_joint(index, index if is_free else self.rng.randrange(max(0, index - 3), index + 1))
        for follower, leader, multiplier, offset in mimics:
            self.joints[follower] |= {"mimic": (self.joints[leader]["name"], multiplier, offset),
                                      "start": multiplier * self.joints[leader]["start"] + offset}
        self.set_laws()

    def vector(self, size):
        return [self.rng.uniform(-size, size) for _ in range(3)]

    def add_link(self, name, mass, size):
        a, b, c = sorted(self.rng.uniform(0.4, 1.0) for _ in range(3))
        moments = [mass * size * size / 6 * x for x in (a, b, min(c, 0.95 * (a + b)))]
        self.links.append({"name": name, "mass": mass, "moments": moments, "at": self.vector(size / 3), "rpy": self.vector(1.5)})

    def add_joint(self, index, parent):
        size = self.rng.uniform(0.2, 0.4)
        self.add_link(f"link{index}", self.rng.uniform(0.5, 3.0), size)
        self.joints.append({
            "name": f"joint{index}", "type": "prismatic" if self.rng.random() < 0.15 else "continuous", "parent": parent,
            "at": self.vector(size), "rpy": self.vector(1.5), "axis": self.rng.choice([[1, 0, 0], [0, -1, 0], [0, 0, 1], self.vector(1)]),
            "start": self.rng.uniform(-0.3, 0.3)})

    def behind(self, index):
        """Indices of the links that a joint moves."""
        found = {index + 1}
        for later, joint in enumerate(self.joints):
            if joint["parent"] in found:
                found.add(later + 1)
        return found

    def set_laws(self):
        for index, joint in enumerate(self.joints):
            moved = [self.links[i] for i in self.behind(index)]
            mass = sum(link["mass"] for link in moved)
            carried = mass if joint["type"] == "prismatic" else mass * 0.05 * len(moved)
            amplitude = self.rng.uniform(0.02, 0.05) if joint["type"] == "prismatic" else self.rng.uniform(0.1, 0.2)
            joint["law"] = (carried * OMEGA**2, 2 * DAMPING * OMEGA * carried, joint["start"], amplitude, self.rng.uniform(0.3, 1.0))

    def urdf(self):
        def words(values):
            return " ".join(repr(float(value)) for value in values)

        text = ['<robot name="random">']
        for link in self.links:
            xx, yy, zz = link["moments"]
            text.append(f'<link name="{link["name"]}"><inertial><origin xyz="{words(link["at"])}" rpy="{words(link["rpy"])}"/>'
                        f'<mass value="{link["mass"]!r}"/><inertia ixx="{xx!r}" ixy="0" ixz="0" iyy="{yy!r}" iyz="0" izz="{zz!r}"/>'
                        "</inertial></link>")
        for index, joint in enumerate(self.joints):
            limit = '<limit lower="-5" upper="5" effort="1" velocity="1"/>' if joint["type"] == "prismatic" else ""
            if "mimic" in joint:
                leader, multiplier, offset = joint["mimic"]
                limit += f'<mimic joint="{leader}" multiplier="{multiplier!r}" offset="{offset!r}"/>'
            text.append(f'<joint name="{joint["name"]}" type="{joint["type"]}"><origin xyz="{words(joint["at"])}" rpy="{words(joint["rpy"])}"/>'
                        f'<parent link="{self.links[joint["parent"]]["name"]}"/><child link="link{index}"/>'
                        f'<axis xyz="{words(joint["axis"])}"/>{limit}</joint>')
        return "\n".join([*text, "</robot>\n"])

    def world(self):
        gravity, base = " ".join(str(g) for g in self.gravity), "free" if self.is_free else "fixed"
        start = " ".join(f'{joint["name"]}="{joint["start"]!r}"' for joint in self.joints if "mimic" not in joint)
        state = '<State at="0.1 -0.2 0.3" rpy="0.3 -0.5 0.7" velocity="0.01 -0.02 0.03" rate="0.02 0.03 -0.01"/>' if self.is_free else ""
        return (f'<World name="w" step="500us" gravity="{gravity}">\n<Robot name="r" urdf="robot.urdf" base="{base}">{state}'
                f"<Start {start}/></Robot>\n</World>\n")


def plant_motion(probe, directory, robot, urdf, seconds, step_us=500):
    (directory / "robot.urdf").write_text(urdf)
    (directory / "w.xml").write_text(robot.world())
    laws = "\n".join(" ".join(repr(float(x)) for x in joint["law"]) for joint in robot.joints)
    done = subprocess.run([probe, directory / "w.xml", str(seconds), str(step_us)], input=laws, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return numpy.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])


def rotation(rpy):
    (cr, cp, cy), (sr, sp, sy) = numpy.cos(rpy), numpy.sin(rpy)
    return numpy.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr], [-sp, cp * sr, cp * cr]])


def reference_model(robot, urdf):
    spec = mujoco.MjSpec.from_string(urdf)
    spec.compiler.fusestatic = False
    spec.option.timestep = REFERENCE_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.gravity = robot.gravity
    if robot.is_free:
        spec.bodies[1].add_freejoint()
    model = spec.compile()
    assert model.neq == sum("mimic" in joint for joint in robot.joints)
    model.eq_solref[:] = STIFF
    model.eq_solimp[:, :2] = 0.9999
    return model


def start_reference(robot, model, data, addresses):
    if robot.is_free:
        turn = rotation([0.3, -0.5, 0.7])
        data.qpos[:3] = [0.1, -0.2, 0.3]
        mujoco.mju_mat2Quat(data.qpos[3:7], turn.ravel())
        data.qvel[:3] = [0.01, -0.02, 0.03]
        data.qvel[3:6] = turn.T @ [0.02, 0.03, -0.01]
    for (position, _), joint in zip(addresses, robot.joints, strict=True):
        data.qpos[position] = joint["start"]


def reference_motion(robot, urdf, seconds):
    """The motion of the reference, in the columns of the probe."""
    model = reference_model(robot, urdf)
    data = mujoco.MjData(model)
    addresses = [(model.joint(joint["name"]).qposadr[0], model.joint(joint["name"]).dofadr[0]) for joint in robot.joints]
    positions, speeds = (numpy.array(column) for column in zip(*addresses, strict=True))
    stiffness, damping, centre, amplitude, frequency = numpy.array([joint["law"] for joint in robot.joints]).T
    for joint, spring, damper, at in zip(robot.joints, stiffness, damping, centre, strict=True):
        number = model.joint(joint["name"]).id
        model.jnt_stiffness[number] = spring
        model.qpos_spring[model.joint(joint["name"]).qposadr[0]] = at
        model.dof_damping[model.joint(joint["name"]).dofadr[0]] = damper
    start_reference(robot, model, data, addresses)
    rows = []
    for count in range(round(seconds / REFERENCE_S) + 1):
        if count % 100 == 0:
            mujoco.mj_forward(model, data)
            base = [*data.qpos[:3], *data.xmat[1]] if robot.is_free else []
            rows.append([data.time, *base, *data.qpos[positions]])
        data.qfrc_applied[speeds] = stiffness * amplitude * (1 - numpy.cos(frequency * (count + 0.5) * REFERENCE_S))
        mujoco.mj_step(model, data)
    return numpy.array(rows)


def deviation(robot, plant, reference):
    """Largest deviations of base attitude [rad], base position [m] and joints."""
    assert plant.shape == reference.shape
    assert numpy.ptp(reference[:, -len(robot.joints):], axis=0).min() > 0.01
    joints = abs(plant - reference)[:, -len(robot.joints):].max()
    if not robot.is_free:
        return 0.0, 0.0, joints
    turns = numpy.einsum("nij,nik->njk", plant[:, 4:13].reshape(-1, 3, 3), reference[:, 4:13].reshape(-1, 3, 3))
    angles = abs(numpy.stack([turns[:, 2, 1] - turns[:, 1, 2], turns[:, 0, 2] - turns[:, 2, 0], turns[:, 1, 0] - turns[:, 0, 1]])) / 2
    return angles.max(), abs(plant - reference)[:, 1:4].max(), joints


def compare(probe, directory, robot, seconds, change=lambda urdf: urdf):
    """Deviation of the plant from the reference, and deviation after extrapolation from two steps to a step
    of zero."""
    urdf = robot.urdf()
    reference = reference_motion(robot, urdf, seconds)
    coarse, fine = (plant_motion(probe, directory, robot, change(urdf), seconds, step_us) for step_us in (500, 250))
    found, limit = deviation(robot, coarse, reference), deviation(robot, 2 * fine - coarse, reference)
    print(f"base {found[0]:.1e} rad, {found[1]:.1e} m, joints {found[2]:.1e}; extrapolated {limit[0]:.1e}, {limit[1]:.1e}, {limit[2]:.1e}")
    return found, limit


def expect_same(found):
    assert found[0] < BASE_RAD and found[1] < BASE_RAD and found[2] < JOINT_RAD


MIMICS = ((4, 1, -0.7, 0.1), (5, 1, 0.4, -0.05))


@pytest.mark.parametrize("robot", [Robot(1, 6), Robot(2, 12), Robot(3, 7, is_free=True),
                                   Robot(6, 6, is_free=True, mimics=MIMICS)], ids=["six", "twelve", "free", "mimics"])
def test_a_robot_moves_as_in_the_reference(probe, tmp_path, robot):
    found, limit = compare(probe, tmp_path, robot, 3.0)
    expect_same(found)
    assert max(limit) < EXTRAPOLATED


def test_a_robot_falls_as_in_the_reference(probe, tmp_path):
    _, limit = compare(probe, tmp_path, Robot(1, 6, gravity=EARTH), 1.0)
    assert max(limit) < 10 * EXTRAPOLATED


def first_is_quick(count):
    return [seed if seed == 0 else pytest.param(seed, marks=pytest.mark.long) for seed in range(count)]


@pytest.mark.timeout(1200)
@pytest.mark.parametrize("seed", first_is_quick(20))
def test_random_robots_move_as_in_the_reference_for_20_s(probe, tmp_path, seed):
    expect_same(compare(probe, tmp_path, Robot(100 + seed, 3 + seed % 10), 20.0)[0])


@pytest.mark.timeout(1200)
@pytest.mark.parametrize("seed", first_is_quick(5))
def test_free_chains_move_as_in_the_reference_for_20_s(probe, tmp_path, seed):
    expect_same(compare(probe, tmp_path, Robot(200 + seed, 3 + seed, is_free=True), 20.0)[0])


GEAR = {"rotor": 0.25, "stiffness": 400.0, "damping": 4.0}


class Elastic(Robot):
    """A chain whose joints are moved by rotors behind elastic gears without friction. The ratio is large, so that the rotors have no
    reaction on the links that carry them."""

    def __init__(self, seed, joints):
        super().__init__(seed, joints, is_free=True)
        for joint in self.joints:
            stiffness, damping, *motion = joint["law"]
            joint["law"] = (stiffness + 4.0, damping + 2.0, *motion)  # This acts on the rotor.

    def world(self):
        drives = "\n".join(f'<Drive name="D{index}" joint="r.{joint["name"]}" type="t" bus="b" node="{10 + index}" eds="e"/>'
                           for index, joint in enumerate(self.joints))
        kind = (f'<DriveType name="t" ratio="1e5" rotorInertia="{GEAR["rotor"]}" stiffness="{GEAR["stiffness"]}" damping="{GEAR["damping"]}" '
                'coulomb="0" stiction="0" stribeck="1" viscous="0" brake="0" stopStiffness="0" stopDamping="0" encoderCounts="65536"/>')
        return super().world().replace("</World>", f"{kind}\n{drives}\n</World>")


def elastic_reference(robot, urdf, seconds):
    """Links move in the reference; rotors are integrated separately, in its steps."""
    model = reference_model(robot, urdf)
    data = mujoco.MjData(model)
    addresses = [(model.joint(joint["name"]).qposadr[0], model.joint(joint["name"]).dofadr[0]) for joint in robot.joints]
    positions, speeds = (numpy.array(column) for column in zip(*addresses, strict=True))
    stiffness, damping, centre, amplitude, frequency = numpy.array([joint["law"] for joint in robot.joints]).T
    start_reference(robot, model, data, addresses)
    angle, rate = data.qpos[positions].copy(), numpy.zeros(len(addresses))
    rows = []
    for count in range(round(seconds / REFERENCE_S) + 1):
        if count % 100 == 0:
            mujoco.mj_forward(model, data)
            rows.append([data.time, *data.qpos[:3], *data.xmat[1], *data.qpos[positions]])
        gear = GEAR["stiffness"] * (angle - data.qpos[positions]) + GEAR["damping"] * (rate - data.qvel[speeds])
        wanted = centre + amplitude * (1 - numpy.cos(frequency * (count + 0.5) * REFERENCE_S))
        rate = rate + REFERENCE_S * (stiffness * (wanted - angle) - damping * rate - gear) / GEAR["rotor"]
        angle = angle + REFERENCE_S * rate
        data.qfrc_applied[speeds] = gear
        mujoco.mj_step(model, data)
    return numpy.array(rows)


def test_elastic_drives_move_a_chain_as_in_the_reference(probe, tmp_path):
    robot = Elastic(5, 4)
    urdf = robot.urdf()
    reference = elastic_reference(robot, urdf, 3.0)
    found = deviation(robot, plant_motion(probe, tmp_path, robot, urdf, 3.0), reference)
    print(f"elastic: base {found[0]:.1e} rad, {found[1]:.1e} m, joints {found[2]:.1e}")
    expect_same(found)
    GEAR["stiffness"] *= 0.5  # The test must detect a softer gear in the plant.
    softer = deviation(robot, plant_motion(probe, tmp_path, robot, urdf, 3.0), reference)
    GEAR["stiffness"] /= 0.5
    assert softer[2] > JOINT_RAD


BODY = {"mass": 350.0, "inertia": numpy.array([[75, 1.5, -2], [1.5, 88, 1], [-2, 1, 82]])}
# Of each rotor: axis, momentum at the start [Nms], amplitude [Nm] and frequency [rad/s] of its torque.
ROTORS = [((1, 1, 1), 1.0, 0.05, 0.5), ((-1, 1, 1), -1.0, 0.04, 0.8), ((-1, -1, 1), 0.0, -0.04, 0.3), ((1, -1, 1), 2.0, 0.03, 1.1)]
ROTOR_KG, ROTOR_KGM2 = 1.0, 0.019  # Mass, and moment about the axis; half of it about the other axes.
RATE, SECONDS = (0.02, -0.03, 0.04), 20.0


def inertia_words(inertia):
    pairs = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
    return " ".join(f'{name}="{float(inertia[row][column])!r}"' for name, row, column in pairs)


def wheels_of_the_plant(probe, directory, step_us):
    """Rows of the probe. The body of the plant contains its rotors, but not their moments about their
    axes."""
    inertia = BODY["inertia"].astype(float)
    for axis, *_ in ROTORS:
        along = numpy.array(axis) / numpy.linalg.norm(axis)
        inertia = inertia + ROTOR_KGM2 / 2 * (numpy.eye(3) - numpy.outer(along, along))
    (directory / "robot.urdf").write_text(f'<robot name="b"><link name="base"><inertial><mass value="{BODY["mass"] + len(ROTORS) * ROTOR_KG!r}"/>'
                                       f"<inertia {inertia_words(inertia)}/></inertial></link></robot>")
    wheels = "\n".join(f'<Wheel name="W{number}" on="r.base" axis="{axis[0]} {axis[1]} {axis[2]}" momentum="30" torque="1" start="{start!r}" '
                       f'bus="b" node="{10 + number}" eds="wheel.eds"/>' for number, (axis, start, _, _) in enumerate(ROTORS))
    (directory / "w.xml").write_text('<World name="w" step="500us" gravity="0 0 0">\n<Robot name="r" urdf="robot.urdf" base="free">'
                                  f'<State rate="{RATE[0]} {RATE[1]} {RATE[2]}"/></Robot>\n{wheels}\n</World>\n')
    laws = "\n".join(f"{amplitude!r} {frequency!r}" for _, _, amplitude, frequency in ROTORS)
    done = subprocess.run([probe, directory / "w.xml", str(SECONDS), str(step_us)], input=laws, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return numpy.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])


def wheels_of_the_reference():
    """Rows of the reference, in which the rotors are separate bodies on hinges."""
    rotors = "".join(f'<body><joint name="w{number}" type="hinge" axis="{axis[0]} {axis[1]} {axis[2]}"/>'
                     f'<inertial pos="0 0 0" mass="{ROTOR_KG}" fullinertia="{full(rotor_inertia(axis))}"/></body>'
                     for number, (axis, *_) in enumerate(ROTORS))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{REFERENCE_S}" integrator="RK4" gravity="0 0 0"/><worldbody><body><freejoint/>'
        f'<inertial pos="0 0 0" mass="{BODY["mass"]}" fullinertia="{full(BODY["inertia"])}"/>{rotors}</body></worldbody></mujoco>')
    data = mujoco.MjData(model)
    data.qvel[3:6] = RATE
    for number, (axis, start, _, _) in enumerate(ROTORS):
        data.qvel[6 + number] = start / ROTOR_KGM2 - numpy.dot(axis, RATE) / numpy.linalg.norm(axis)
    rows = []
    for count in range(round(SECONDS / REFERENCE_S) + 1):
        if count % 100 == 0:
            mujoco.mj_forward(model, data)
            rows.append([data.time, *data.qpos[:3], *data.xmat[1]])
        for number, (_, _, amplitude, frequency) in enumerate(ROTORS):
            data.qfrc_applied[6 + number] = amplitude * numpy.sin(frequency * (count + 0.5) * REFERENCE_S)
        mujoco.mj_step(model, data)
    return numpy.array(rows)


def rotor_inertia(axis):
    along = numpy.array(axis) / numpy.linalg.norm(axis)
    return ROTOR_KGM2 / 2 * (numpy.eye(3) + numpy.outer(along, along))


def full(inertia):
    return " ".join(repr(float(inertia[row][column])) for row, column in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


def test_wheels_turn_a_free_body_as_rotors_do_in_the_reference(probe, tmp_path):
    reference = wheels_of_the_reference()
    coarse, fine = (wheels_of_the_plant(probe, tmp_path, step_us) for step_us in (500, 250))
    found, limit = (angle_between(rows, reference) for rows in (coarse, 2 * fine - coarse))
    print(f"wheels: {found:.1e} rad, extrapolated {limit:.1e}; turned by {angle_between(reference, reference[:1]):.2f} rad")
    assert angle_between(reference, reference[:1]) > 0.3
    assert found < BASE_RAD and limit < EXTRAPOLATED


def angle_between(rows, others):
    """Largest difference of two series of attitudes about an axis [rad]; valid for small angles."""
    turns = numpy.einsum("nij,nik->njk", rows[:, 4:13].reshape(-1, 3, 3), numpy.broadcast_to(others[:, 4:13], (len(rows), 9)).reshape(-1, 3, 3))
    return max(abs(turns[:, 2, 1] - turns[:, 1, 2]).max(), abs(turns[:, 0, 2] - turns[:, 2, 0]).max(),
               abs(turns[:, 1, 0] - turns[:, 0, 1]).max()) / 2


def turned_axis(urdf):
    return re.sub(r'<axis xyz="(\S+) (\S+) (\S+)"/>', r'<axis xyz="\2 \3 \1"/>', urdf, count=1)


def turned_inertia(urdf):
    """The URDF in which the inertia of the last link refers to other axes."""
    before, after = urdf[: urdf.rindex("<inertial>")], urdf[urdf.rindex("<inertial>"):]
    return before + re.sub(r'rpy="(\S+) ', 'rpy="0.5 ', after, count=1)


@pytest.mark.parametrize("change", [turned_axis, turned_inertia])
def test_a_planted_fault_is_found(probe, tmp_path, change):
    found, limit = compare(probe, tmp_path, Robot(4, 5), 1.0, change)
    assert found[2] > 2 * JOINT_RAD and limit[2] > 20 * EXTRAPOLATED


class Block:
    """A free cube of 0.2 m and 2 kg on or above a table whose surface is the plane z = 0."""

    MASS, HALF = 2.0, 0.1
    joints = ()

    def __init__(self, gravity, height, velocity, friction=0.3, stiffness=2000.0, damping=10.0):
        self.gravity, self.height, self.velocity = gravity, height, velocity
        self.friction, self.stiffness, self.damping = friction, stiffness, damping

    def urdf(self):
        moment = self.MASS * (2 * self.HALF) ** 2 / 6
        cube = f'<geometry><box size="{2 * self.HALF} {2 * self.HALF} {2 * self.HALF}"/></geometry>'
        return (f'<robot name="block"><link name="cube"><inertial><mass value="{self.MASS}"/><inertia ixx="{moment!r}" ixy="0" ixz="0" '
                f'iyy="{moment!r}" iyz="0" izz="{moment!r}"/></inertial><collision>{cube}</collision></link></robot>\n')

    def world(self):
        def words(values):
            return " ".join(repr(float(value)) for value in values)

        return (f'<World name="w" step="500us" gravity="{words(self.gravity)}">\n<Fixture name="table" at="0 0 -0.5"><Box size="8 8 1" at="0 0 0"/></Fixture>\n'
                f'<Robot name="r" urdf="robot.urdf" base="free"><State at="0 0 {self.HALF + self.height!r}" rpy="0 0 0" rate="0 0 0" velocity="{words(self.velocity)}"/></Robot>\n'
                f'<Contact a="r.cube" b="table" stiffness="{self.stiffness}" damping="{self.damping}" friction="{self.friction}"/>\n</World>\n')

    def reference(self, seconds):
        """Positions of the cube in the reference: a point mass on a spring and a damper, so that no contact of several points is weighted."""
        spec = mujoco.MjSpec()
        spec.option.timestep = REFERENCE_S
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
        spec.option.gravity = self.gravity
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        spec.option.impratio = 1e4
        contact = {"solref": [-self.stiffness / self.MASS, -self.damping / self.MASS], "solimp": [0.9999, 0.9999, 0.001, 0.5, 2],
                   "friction": [self.friction, 0, 0]}
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[4, 4, 1], **contact)
        body = spec.worldbody.add_body(pos=[0, 0, self.HALF + self.height], mass=self.MASS, inertia=[1, 1, 1], explicitinertial=True)
        for axis in numpy.eye(3):
            body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[self.HALF, 0, 0], **contact)
        model = spec.compile()
        data = mujoco.MjData(model)
        data.qvel[:] = self.velocity
        rows = []
        for count in range(round(seconds / REFERENCE_S) + 1):
            if count % 100 == 0:
                rows.append([*(data.qpos + [0, 0, self.HALF + self.height])])
            mujoco.mj_step(model, data)
        return numpy.array(rows)


SLOPE = (9.81 * math.sin(0.4), 0.0, -9.81 * math.cos(0.4))
ON_TABLE_M = -9.81 * math.cos(0.4) * Block.MASS / 2000.0  # The spring of the contact carries the cube.


def motions(probe, directory, block, seconds):
    """Positions of the cube in the plant with steps of 0.5 and 0.25 ms, and in the reference."""
    coarse, fine = (plant_motion(probe, directory, block, block.urdf(), seconds, step_us)[:, 1:4] for step_us in (500, 250))
    return coarse, fine, block.reference(seconds)


def test_a_cube_bounces_as_in_the_reference(probe, tmp_path):
    """Spring and damper of a contact without other forces. The error of the step is that of the instant of the touch: of first order."""
    coarse, fine, reference = motions(probe, tmp_path, Block((0, 0, 0), 0.05, (0, 0, -0.5)), 1.0)
    assert reference[-1, 2] > 0.4 and reference[:, 2].min() < 0.09
    assert abs(fine - reference).max() < 4e-3
    assert abs(2 * fine - coarse - reference).max() < 1e-3


def test_a_cube_slides_down_a_slope_as_in_the_reference(probe, tmp_path):
    """Coulomb friction. The depth of a contact under load has another law in MuJoCo, so only the motion along the slope is compared."""
    coarse, fine, reference = motions(probe, tmp_path, Block(SLOPE, ON_TABLE_M, (0.2, 0, 0), friction=0.2), 1.0)
    assert reference[-1, 0] > 1.2
    assert abs(coarse - reference)[:, 0].max() < 3e-3 and abs(fine - reference)[:, 0].max() < 3e-3


def test_a_cube_lies_on_a_slope_with_enough_friction(probe, tmp_path):
    """The cube sinks in until the spring carries it, and does not creep."""
    block = Block(SLOPE, ON_TABLE_M, (0, 0, 0), friction=0.6)
    positions = plant_motion(probe, tmp_path, block, block.urdf(), 4.0)[:, 1:4]
    assert abs(positions[-1] - positions[-101]).max() < 1e-6
    assert positions[-1, 2] == pytest.approx(Block.HALF + ON_TABLE_M, abs=2e-4)
