#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Create a mission for an arm from its URDF: descriptor, world, mission and scenario, which fly without changes and without C.

    make new-robot URDF=my-arm.urdf                  all files are named after the robot of the URDF
    make new-robot URDF=my-arm.urdf NAME=arm7        all files have this name
    make new-robot URDF=my-arm.urdf TOOL=flange      the tool is this link, not the last one of the file
    make new-robot URDF=my-arm.urdf START=0,-1.5,1   the arm starts in this pose, not in the computed one
    make new-robot URDF=my-arm.urdf BASE=free        the base flies freely, without gravity; else it is fixed
    make new-robot URDF=my-arm.urdf APID=40          with this APID instead of the first free one
    make new-robot URDF=right.urdf WITH=left         the new mission flies the subsystems of the mission left, too

The program arm flies any chain of 1 to 12 joints (docs/arm.md). The command writes new files only; on an error it changes nothing. The simulator must
accept the new world.
"""

import argparse
import math
import pathlib
import random
import re
import subprocess
import sys

import robot_beside
import urdf
from loads import GRAVITY, TINY, base_inertia_of, carried_by, largest_rate, load_of, loads_of, poses_of, solved
from new_subsystem import ROOT, Refusal, check_name, choose_apid, expect, fill, relative, write_all
from robot_beside import ALONE

SIMULATOR = ROOT / "build" / "bin" / "simulator"
TEMPLATES = pathlib.Path(__file__).resolve().parent / "robot"
STEP_S = 0.0005
JOINTS_OF_A_BUS = 4
FIRST_NODE = 0x51
# Values of a drive for each Nm of its largest torque, taken from the drives of rokviss, which have 40 Nm.
ROTOR, STIFFNESS, DAMPING, COULOMB, STICTION, VISCOUS, BRAKE = 0.0064, 50.0, 0.05, 0.05, 0.06, 0.025, 2.5
KP, KD = 100.0, 1.5
# Values for each N of a linear axis where they differ: its gear deflects by 0.2 mm under the largest force.
LINEAR_STIFFNESS, LINEAR_DAMPING, LINEAR_KP, LINEAR_KD = 5000.0, 5.0, 125.0, 3.1
BASE_MIN_S2 = 1e-6  # Noise of 5e-4 of the effort, for 1 ms, divided by half of the speed: least inertia of a free base, times speed, per effort.
SPEED_BANDWIDTH = KD / ROTOR  # Largest bandwidth of a speed loop [rad/s]: that of a revolute joint whose link has no inertia.
# Units of values of joints: unit of a revolute joint -> unit of a linear axis. An arm with both shows both.
UNITS = {"rad": "m", "rad/s": "m/s", "rad/s2": "m/s2", "Nm": "N", "Nm/rad": "N/m", "Nms/rad": "Ns/m", "kgm2": "kg"}
RATE_MAX = 4.0  # Stability of the gears in the step of the simulator.
STIFFNESS_MIN = 1.0  # Smallest stiffness of a gear that a world may have.
TELEPRESENCE_JOINTS_MAX = 10  # A descriptor has at most 640 <Setting>, 16 of each joint in each configuration.
# The ports of the subsystem of a joystick, from the arm's side.
PORTS = """
    <RTLinkService>
      <Provides name="ROBOT_STATE" id="1" methods="SHARED_MEMORY TIPC UDP">
        <ParamRef name="POSITION" type="DOUBLE" count="2" unit="rad"/>
        <ParamRef name="EXTERNAL_TORQUE" type="DOUBLE" count="2" unit="Nm"/>
      </Provides>
      <Requires name="HAND_POSITION" id="2" methods="SHARED_MEMORY TIPC UDP" required="true" staleAfter="5ms">
        <ParamRef name="POSITION" type="DOUBLE" count="2" unit="rad"/>
      </Requires>
    </RTLinkService>"""
NEXT_STEP = "docs/arm.md lists what to change in the URDF of a manufacturer"
SEED, POSES = 1, 400  # Random poses from which the start pose is chosen.
SHARE, SHARE_MIN = 0.5, 0.01  # SHARE of the motions of the scenario, and the least that a command may have.
MOTION_S = 6.0  # Longest motion of a joint in the scenario; a step of a scenario has 20 s.
TOOL_SPEED = 0.25  # Speed of the tool in the template of the descriptor [m/s].
UPWARD = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0)  # Velocity of the tool along the line.
LINE_BEND = 2.0  # Largest motion of a joint along the line, relative to a motion at its first speed.
LINE_MARGIN = 0.8  # Share of the speeds of the joints in the start pose, because these speeds change along the line.
ERROR, DELAY_S = 1e-3, 2.5e-3  # Bound of the error of a joint at rest [rad or m], and delay of bus and drive.
TOGETHER = 1.5  # Error of the tool relative to the error that independent errors of the joints would cause.
SWING, SWING_MARGIN = 0.2 * ERROR, 1.5  # Swing of a link at which the arm is engaged; factor of its time, because several links swing longer.
ACCELERATION_LOAD = 0.4  # Largest share of the torque of a joint that accelerates the arm.
LOAD_MAX = 0.5  # Largest share of the torque of a joint that carries the arm in the start pose.


def text(values):
    """Numbers as words of a descriptor, whose last digit must not be below 1e-22: a turn of 180 degrees leaves values of 1e-16. -0 becomes 0."""
    return " ".join(f"{round(value, 22) + 0.0:.10g}" for value in values)


def hexadecimal(value, digits):
    """A number with 0x and this number of digits."""
    return f"0x{value:0{digits}X}"


def settling_s(robot, angles, base):
    """Time until the links no longer swing in their gears. When the world starts, no gear is bent; then gravity bends all of them."""
    poses, longest = list(poses_of(robot, angles)), 0.0
    for number, (share, joint) in enumerate(loads_of(robot, angles, base)):
        drive = drive_of(joint)
        swing = share * joint.effort / drive["stiffness"]
        if swing > SWING:
            longest = max(longest, 2.0 * carried_by(robot, poses, number) / drive["damping"] * math.log(swing / SWING))
    return SWING_MARGIN * longest


def jacobian_columns(robot, angles):
    """Pose of the tool, and the columns of its Jacobian: the velocity that a unit velocity of each joint gives the tool."""
    poses = list(poses_of(robot, angles))
    tool = urdf.composed(poses[-1][0], robot.tool)

    def column(joint, origin, axis):
        if joint.is_prismatic:
            return (*axis, *urdf.ZERO)
        return (*urdf.cross(axis, [p - q for p, q in zip(tool[0], origin)]), *axis)

    return tool, [column(joint, pose[0], axis) for joint, (pose, axis) in zip(robot.joints, poses)]


def manipulability(columns):
    """Determinant of J^T J, or of J J^T if the arm has more joints than the tool has directions."""
    rows = columns if len(columns) <= 6 else list(zip(*columns))
    square = [[sum(a * b for a, b in zip(p, q)) for q in rows] for p in rows]
    result = 1.0
    for i, row in enumerate(square):
        result *= max(row[i], 0.0)
        if row[i] <= 0.0:
            return 0.0
        for below in square[i + 1 :]:
            share = below[i] / row[i]
            for k in range(i, len(square)):
                below[k] -= share * row[k]
    return result


def travel_of(joint):
    """Distance that the scenario moves a joint. A slow joint covers it within MOTION_S."""
    return min(0.3, 0.2 * (joint.upper - joint.lower), SHARE * joint.speed * MOTION_S / 1.875)


def away_from(robot, angles):
    """Pose to which the scenario moves the arm: towards the middle of the ranges."""
    return [angle + math.copysign(travel_of(joint), (joint.upper + joint.lower) / 2.0 - angle) for joint, angle in zip(robot.joints, angles)]


def load_in_motion(robot, angles, base):
    """Largest share of its torque that a joint needs to carry the arm in this pose and in that to which the scenario moves it, and that joint."""
    return max((load_of(robot, pose, base) for pose in (angles, away_from(robot, angles))), key=lambda load: load[0])


def start_pose(robot, base="fixed"):
    """The random pose with the best manipulability, within 90 degrees of the middle of the ranges. Only poses count in which each joint needs
    less than LOAD_MAX of its torque to carry the arm, there and where the scenario moves it."""
    generator = random.Random(SEED)

    def pose():
        for joint in robot.joints:
            middle, half = (joint.lower + joint.upper) / 2.0, (joint.upper - joint.lower) / 2.0
            reach = 0.8 * half if joint.is_prismatic else min(0.5 * math.pi, 0.8 * half)
            yield round(middle + generator.uniform(-1.0, 1.0) * reach, 2) + 0.0

    def load(angles):
        return load_in_motion(robot, angles, base)

    poses = [tuple(pose()) for _ in range(POSES)]
    easy = [angles for angles in poses if load(angles)[0] < LOAD_MAX]
    if not easy:
        share, joint = min(map(load, poses), key=lambda found: found[0])
        raise Refusal(f"URDF: {joint.location}: joint {joint.name}: carries {share:.0%} of its effort in the best of {POSES} poses, "
                      f"expected less than {LOAD_MAX:.0%}")
    return max(easy, key=lambda angles: manipulability(jacobian_columns(robot, angles)[1]))


def wanted_pose(robot, given, base="fixed"):
    """The start pose of the option START. No joint may carry its whole torque or more."""
    words = given.split(",")
    inside = len(words) == len(robot.joints) and all(re.fullmatch(r"-?[0-9]+(\.[0-9]*)?", word) for word in words)
    inside = inside and all(joint.lower <= float(word) <= joint.upper for joint, word in zip(robot.joints, words))
    expect(inside, "START", given, f"{len(robot.joints)} positions in rad or m within the ranges of the joints, with commas between them")
    start = tuple(map(float, words))
    share, joint = load_in_motion(robot, start, base)
    expect(share < 1.0, "START", given, f"a pose in which joint {joint.name} carries less than 100% of its effort, also where the scenario moves it; "
                                        f"it carries {share:.0%}")
    return start


def check_base(joint):
    """Refuse a free base that the noise of the torque of the first joint would turn, or shift, in one cycle with half of the speed of the joint."""
    found, least = base_inertia_of(joint), BASE_MIN_S2 * joint.effort / joint.speed
    if found < least:
        raise Refusal(f"URDF: {joint.location}: joint {joint.name}: the free base reacts with {found:.3g} {'kg' if joint.is_prismatic else 'kgm2'}, expected at "
                      f"least {least:.3g} for effort=\"{joint.effort:g}\" and velocity=\"{joint.speed:g}\": use a heavier base, less effort or a larger velocity")


def drive_of(joint):
    """Values of the drive of a joint, computed from its torque. The time step of the simulator limits the stiffness of a gear with a light link."""
    effort = joint.effort
    inertia = sum(a * b for a, b in zip(joint.axis, urdf.turned(joint.link.inertia, joint.axis)))
    inertia = min(joint.link.mass if joint.is_prismatic else inertia, base_inertia_of(joint))
    of_effort = LINEAR_STIFFNESS if joint.is_prismatic else STIFFNESS
    if of_effort * effort < STIFFNESS_MIN:
        raise Refusal(f"URDF: {joint.location}: joint {joint.name}: effort=\"{effort:g}\": expected at least {STIFFNESS_MIN / of_effort:g} {'N' if joint.is_prismatic else 'Nm'}, "
                      "with which its gear has the smallest stiffness that a world may have")
    stiffness = min(of_effort * effort, inertia * (0.5 / STEP_S) ** 2)
    if stiffness < STIFFNESS_MIN:
        raise Refusal(f"URDF: {joint.location}: joint {joint.name}: moves {inertia:.3g} {'kg' if joint.is_prismatic else 'kgm2 about its axis'}, expected "
                      f"at least {STIFFNESS_MIN / (0.5 / STEP_S) ** 2:.3g}, with which the simulator can simulate its gear")
    # In a row of linear axes with equal links the largest relative acceleration is almost four times that of one link. A link that turns
    # has more inertia about its joint than about its centre.
    damping = min(LINEAR_DAMPING * effort, 0.25 * inertia / STEP_S) if joint.is_prismatic else min(DAMPING * effort, 0.5 * inertia / STEP_S)
    return {
        "ratio": "100", "rotorInertia": ROTOR * effort, "stiffness": stiffness, "damping": damping,
        "coulomb": COULOMB * effort, "stiction": STICTION * effort, "stribeck": "0.02", "viscous": VISCOUS * effort, "brake": BRAKE * effort,
        "stopStiffness": 500.0 * effort, "stopDamping": 5.0 * effort, "encoderCounts": "65536",
    }


def check_gears(robot, poses, base):
    """Refuse an arm whose gears are unstable together in the step of the simulator. It computes each velocity from stiffness K and damping D of the
    last step h, then the position: K h^2 + 2 D h, relative to the inertia of a mode, must be less than 4."""
    drives = [drive_of(joint) for joint in robot.joints]
    gains = [drive["stiffness"] * STEP_S**2 + 2.0 * drive["damping"] * STEP_S for drive in drives]
    rate, number = max(largest_rate(robot, pose, base, gains, [drive["rotorInertia"] for drive in drives]) for pose in poses)
    if rate >= RATE_MAX:
        joint = robot.joints[number]
        raise Refusal(f"URDF: {joint.location}: joint {joint.name}: (stiffness x step^2 + 2 x damping x step) / inertia of the arm is {rate:.3g} in its fastest "
                      f"mode, expected less than {RATE_MAX:g}, with which the simulator can simulate the gears: use less effort or more inertia in the links")


def attributes(values):
    return " ".join(f'{key}="{value if isinstance(value, str) else format(value, ".6g")}"' for key, value in values.items())


def eds_of(joint):
    """EDS of the drive of a joint, whose largest torque depends on the effort of the joint."""
    return "joint-drive.eds" if joint.effort <= 40.0 else "joint-drive-large.eds"


def addresses(robot, place=ALONE):
    """(bus, node) of each joint: up to four on a bus."""
    count = len(robot.joints)
    buses = -(-count // JOINTS_OF_A_BUS)
    each = -(-count // buses)
    return [(f"{place.bus}-{i // each + 1}", FIRST_NODE + i) for i in range(count)]


def world(robot, names, start, base, place=ALONE):
    """Words of the template of the world. Joints with equal values share a drive type."""
    types, drives = {}, []
    for number, (joint, (bus, node)) in enumerate(zip(robot.joints, addresses(robot, place)), 1):
        effort = joint.effort
        sensor = attributes({"noise": 5e-4 * effort, "offset": 5e-3 * effort, "drift": 5e-6 * effort, "range": 1.5 * effort})
        kind = types.setdefault(f"{attributes(drive_of(joint))}>\n    <TorqueSensor {sensor}/>\n  </DriveType>", f"{place.prefix.lower()}drive{len(types) + 1}")
        drives.append(f'  <Drive name="{place.prefix}JOINT{number}" joint="{place.robot}.{joint.name}" type="{kind}" bus="{bus}" '
                      f'node="{hexadecimal(node, 2)}" eds="{eds_of(joint)}"/>')
    return names | {
        "base": base,
        "robot": place.robot,
        "state": place.state,
        "gravity": text(GRAVITY[base]),
        "start": " ".join(f'{joint.name}="{angle + 0.0:.10g}"' for joint, angle in zip(robot.joints, start)),
        "drive_types": "\n".join(f'  <DriveType name="{name}" {rest}' for rest, name in types.items()),
        "drives": "\n".join(drives),
    }


def gains_of(joint):
    """Proportional and derivative gain of the control loop of a joint. If a linear axis moves little mass, the delay of the bus limits the second."""
    if not joint.is_prismatic:
        return KP * joint.effort, KD * joint.effort
    moved = ROTOR * joint.effort + min(joint.link.mass, base_inertia_of(joint))
    return LINEAR_KP * joint.effort, min(LINEAR_KD * joint.effort, SPEED_BANDWIDTH * moved)


def device(joint, address, number, mode):
    """A joint's drive in a configuration: CSP by the first RPDO or CST by the second, with one command each millisecond."""
    bus, node = address
    kp, kd = gains_of(joint)
    # CiA 402: torques are in per mille of the rated torque, which is 10 Nm, and 40 Nm for the large drive.
    limit = round(joint.effort / (0.01 if eds_of(joint) == "joint-drive.eds" else 0.04))
    by_first, by_second = (0, 0x80000000) if mode == 8 else (0x80000000, 0)
    # CiA 301: a PDO is made invalid (bit 31 of its identifier) before its other parameters are written.
    settings = [
        ("0x1401:01", "UINT32", hexadecimal(0x80000300 + node, 8)),
        ("0x1400:01", "UINT32", hexadecimal(0x80000200 + node, 8)),
        ("0x1400:05", "UINT16", "4"),
        ("0x1401:05", "UINT16", "4"),
        ("0x1400:01", "UINT32", hexadecimal(by_first + 0x200 + node, 8)),
        ("0x1401:01", "UINT32", hexadecimal(by_second + 0x300 + node, 8)),
        ("0x6060:00", "INT8", str(mode)),
        ("0x60B2:00", "INT16", "0"),  # The drive adds this offset to each torque, and an earlier configuration may have set it.
        ("0x60C2:01", "UINT8", "10"),
        ("0x6072:00", "UINT16", str(limit)),
        ("0x60E0:00", "UINT16", str(limit)),
        ("0x60E1:00", "UINT16", str(limit)),
        ("0x607D:01", "INT32", str(round(joint.lower * 1e6))),
        ("0x607D:02", "INT32", str(round(joint.upper * 1e6))),
        ("0x2230:01", "UINT32", str(round(kp))),
        ("0x2230:02", "UINT32", str(round(1000.0 * kd))),
    ]
    lines = [f'      <Device name="JOINT{number}" type="{eds_of(joint).removesuffix(".eds")}">']
    lines += [f'        <Setting object="{name}" type="{kind}" value="{value}"/>' for name, kind, value in settings]
    return "\n".join([*lines, f'        <Endnode type="CAN" bus="{bus}" node="{hexadecimal(node, 2)}"/>', "      </Device>"])


def configuration(robot, place, number, name, mode, initial, has_joystick=False):
    """A configuration of the descriptor; `mode` is that of CiA 402, `has_joystick`: a joystick leads the tool."""
    devices = (device(joint, address, i, mode) for i, (joint, address) in enumerate(zip(robot.joints, addresses(robot, place)), 1))
    initials = "".join(f'\n    <Initial parameter="CONTROL" field="{field}" value="{value}"/>' for field, value in initial.items())
    template = (TEMPLATES / "configuration.xml").read_text(encoding="utf-8").rstrip("\n")
    words = {"configuration": name, "number": str(number), "initial": initials, "devices": "\n".join(devices)}
    words |= {"hand": '\n        <ParamRef name="HAND"/>' if has_joystick else "", "ports": PORTS if has_joystick else ""}
    return fill(template, words)


def limits_of(robot, start):
    """Lists with a value for each joint."""
    joints = robot.joints
    return {
        "lower": (joint.lower for joint in joints),
        "upper": (joint.upper for joint in joints),
        "speed": (joint.speed for joint in joints),
        "acceleration": accelerations_of(robot, start),
        "effort": (joint.effort for joint in joints),
        "kp": (gains_of(joint)[0] for joint in joints),
        "kd": (gains_of(joint)[1] for joint in joints),
    }


def model_of(robot):
    """Lists with one, three or six values for each joint."""
    joints = robot.joints
    return {
        "origin": (x for joint in joints for x in joint.origin[0]),
        "rpy": (x for joint in joints for x in urdf.rpy_of(joint.origin[1])),
        "axis": (x for joint in joints for x in joint.axis),
        "mass": (joint.link.mass for joint in joints),
        "centre": (x for joint in joints for x in joint.link.centre),
        "inertia": (joint.link.inertia[i][k] for joint in joints for i, k in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))),
    }


def of_drives(robot):
    """Lists with a value for the drive of each joint."""
    drives = [drive_of(joint) for joint in robot.joints]
    keys = {"rotor": "rotorInertia", "stiffness": "stiffness", "coulomb": "coulomb", "viscous": "viscous"}
    return {name: [drive[key] for drive in drives] for name, key in keys.items()}


def scalars(robot):
    """Position and torque of each joint as parameters of their own."""
    return "\n".join(f'    <ParamRef name="{name}_{number}" id="{first + number}" type="DOUBLE" unit="{UNITS[unit] if joint.is_prismatic else unit}"/>'
                     for first, name, unit in ((100, "POSITION", "rad"), (200, "TORQUE", "Nm"))
                     for number, joint in enumerate(robot.joints, 1))


def units_of(robot):
    """Units of the values of all joints, as words of the template."""
    linear = {joint.is_prismatic for joint in robot.joints}
    return {f"unit_{turning.replace('/', '_')}": turning if linear == {False} else shifting if linear == {True} else f"{turning} or {shifting}"
            for turning, shifting in UNITS.items()}


def prismatic(robot):
    """Parameter of the descriptor that marks the linear axes; empty if all joints are revolute."""
    flags = " ".join("1" if joint.is_prismatic else "0" for joint in robot.joints)
    return f'\n      <ParamRef name="PRISMATIC" type="BOOL" count="{len(robot.joints)}" init="{flags}"/>' if "1" in flags else ""


def descriptor(robot, names, start, base, place=ALONE):
    """Words of the template of the descriptor."""
    count = len(robot.joints)
    lists = limits_of(robot, start) | model_of(robot) | of_drives(robot)
    lists |= {"tool": robot.tool[0], "tool_rpy": urdf.rpy_of(robot.tool[1]), "gravity": GRAVITY[base]}
    configurations = [
        configuration(robot, place, 1, "POSITION", 8, {}),
        configuration(robot, place, 2, "TORQUE", 10, {}),
        configuration(robot, place, 3, "COMPLIANT", 10, {"COMPLIANT": "1"}),
    ]
    if count <= TELEPRESENCE_JOINTS_MAX:
        configurations.append(configuration(robot, place, 4, "TELEPRESENCE", 10, {"COMPLIANT": "1"}, has_joystick=True))
    words = {"joints": str(count), "joints3": str(3 * count), "joints6": str(6 * count), "configurations": "\n".join(configurations), "scalars": scalars(robot), "prismatic": prismatic(robot)}
    return names | units_of(robot) | words | {name: text(values) for name, values in lists.items()}


def accelerations_of(robot, start):
    """Limit of acceleration of each joint: twice its speed, and less if the links that it carries in the start pose would need more than
    ACCELERATION_LOAD of its torque."""
    poses = list(poses_of(robot, start))
    return [min(2.0 * joint.speed, ACCELERATION_LOAD * joint.effort / carried_by(robot, poses, number)) for number, joint in enumerate(robot.joints)]


def peak_speeds_of(robot, start):
    """Largest speed of each joint in the scenario: that of a minimum jerk motion within SHARE of its limits."""
    return [min(SHARE * joint.speed, 1.875 * math.sqrt(travel_of(joint) * SHARE * acceleration / 5.7735))
            for joint, acceleration in zip(robot.joints, accelerations_of(robot, start))]


def rise_of(robot, share):
    """Length of the upward line [m]: 5 % of the reach, and what the tool covers within MOTION_S."""
    return min(0.05 * sum(math.hypot(*joint.origin[0]) for joint in robot.joints), share * TOOL_SPEED * MOTION_S / 1.875)


def upward_speeds(robot, start):
    """Speeds of the joints at which the tool moves upward with 1 m/s without a rotation; None if it cannot."""
    _, columns = jacobian_columns(robot, start)
    rows = list(zip(*columns))
    squares = [[urdf.dot(p, q) + (TINY if p is q else 0.0) for q in rows] for p in rows]
    forces = solved(squares, UPWARD)
    speeds = [urdf.dot(column, forces) for column in columns]
    return speeds if max(abs(urdf.dot(row, speeds) - wanted) for row, wanted in zip(rows, UPWARD)) < 1e-3 else None


def line_share(robot, start):
    """SHARE of the upward line, at which no joint is faster than in its motions in joint space; None if the tool cannot move upward without a
    rotation, or if a joint, moving LINE_BEND times as far as it begins, would leave its range."""
    speeds = upward_speeds(robot, start) if len(robot.joints) >= 6 else None
    if speeds is None:
        return None
    shares = [peak / (abs(speed) * TOOL_SPEED) for peak, speed in zip(peak_speeds_of(robot, start), speeds) if speed]
    share = min([SHARE, *(math.floor(100.0 * LINE_MARGIN * share) / 100.0 for share in shares)])
    ends = [angle + LINE_BEND * speed * rise_of(robot, share) for angle, speed in zip(start, speeds)]
    is_inside = all(joint.lower < end < joint.upper for joint, end in zip(robot.joints, ends))
    return share if share >= SHARE_MIN and is_inside else None


def bounds(robot, start):
    """Bounds of the figures of the scenario: (figure, relation, bound). A joint lags by the delay of bus and drive; the tool has the errors of all
    joints, whose lags act together in part."""
    _, columns = jacobian_columns(robot, start)
    levers = [math.hypot(*column[:3]) for column in columns]
    errors = [ERROR + DELAY_S * peak for peak in peak_speeds_of(robot, start)]
    found = [(f"joint{number}_error_{'m' if joint.is_prismatic else 'rad'}", "<=", error)
             for number, (joint, error) in enumerate(zip(robot.joints, errors), 1)]
    found.append(("tool_error_m", "<=", TOGETHER * math.hypot(*(error * lever for error, lever in zip(errors, levers)))))
    kinds = {joint.is_prismatic for joint in robot.joints}
    found += [(name, "<=", ERROR) for name, kind in (("goal_error_rad", False), ("goal_error_m", True)) if kind in kinds]
    if line_share(robot, start):
        found.append(("goal_tool_error_m", "<=", TOGETHER * math.hypot(*(ERROR * lever for lever in levers))))
    return [*found, ("joint_range_margin", ">=", 0.0), ("joint_speed_share", "<", 1.0), ("joint_torque_share", "<", 1.0)]


def scenario(robot, names, start, base="fixed"):
    """Motions that any arm can perform from its start pose: towards the middle of the ranges, along a line and back, through points without
    a stop, and a refusal. They begin when the links no longer swing."""
    away = away_from(robot, start)
    tool, _ = jacobian_columns(robot, start)
    rotation = urdf.rotation_vector_of(tool[1])
    share = line_share(robot, start)
    goal = [tool[0][0], tool[0][1], tool[0][2] + rise_of(robot, share or 0.0)]
    outside = [robot.joints[0].upper + 1.0, *start[1:]]
    partly = [angles[i % 2] for i, angles in enumerate(zip(away, start))]
    at = {key: ",".join(f"{value + 0.0:.6g}" for value in values) for key, values in
          {"away": away, "partly": partly, "start": start, "rotation": rotation, "tool": tool[0], "goal": goal,
           "outside": outside}.items()}
    name, lines, time = names["NAME"], [], 0.2

    def step(command, seconds):
        nonlocal time
        lines.append(f"{time:4.1f}  operator {command}")
        time += seconds

    def motions():
        step(f"cmd {name}.MOVE_TO POSITION={at['away']} SHARE=0.5", 3.0)
        step(f"cmd {name}.MOVE_TO POSITION={at['start']} SHARE=0.5", 3.0)
        for point in ("goal", "tool") if share else ():
            step(f"cmd {name}.LINE_TO POSITION={at[point]} ROTATION={at['rotation']} SHARE={share:g}", 3.0)
        for point in ("away", "partly", "start"):
            step(f"cmd {name}.ADD_VIA POSITION={at[point]}", 0.1)
        step(f"cmd {name}.MOVE_VIA SHARE=0.5 BLEND=0.05", 6.0)

    to_engage = time + 1.5  # OPERATIONAL is ordered 1.5 s after the end of the next step.
    step(f"state {name} PRE_OPERATIONAL", max(1.0, math.ceil(10.0 * (settling_s(robot, start, base) - to_engage)) / 10.0))
    for configuration_name in ("POSITION", "TORQUE"):
        step(f"config {name} {configuration_name}", 1.0)
        step(f"state {name} SAFE_OPERATIONAL", 0.5)
        step(f"state {name} OPERATIONAL", 0.5)
        motions()
        if configuration_name == "POSITION":
            step(f"expect-refusal JOINT_RANGE cmd {name}.MOVE_TO POSITION={at['outside']} SHARE=0.5", 0.5)
        step(f"hk once {name} 11" if configuration_name == "POSITION" else f"hk once {name} 21", 0.3)
        step(f"state {name} SAFE_OPERATIONAL", 0.5)
        step(f"state {name} PRE_OPERATIONAL", 0.5)
    step(f"state {name} OFFLINE", 1.0)
    step("shutdown", 0.0)
    in_space = ", along lines" if share else ""
    return names | {"steps": "\n".join(lines), "in_space": in_space, "end": f"{time:.0f}"}


def read(path, tool):
    """The robot of a file, and the text of the file."""
    try:
        robot = urdf.read(path, tool)
        source = pathlib.Path(path).read_bytes()
        return robot, source.decode("utf-8").replace("\r\n", "\n")
    except (OSError, urdf.UrdfError) as error:
        raise Refusal(f"URDF: {error}") from error
    except UnicodeDecodeError as error:
        line = source.count(b"\n", 0, error.start) + 1
        raise Refusal(f"URDF: {path}:{line}: found octet 0x{source[error.start]:02X}, expected UTF-8: convert the file, for example with iconv") from error


def name_from(robot_name):
    """The name of the files, made from the name of the robot."""
    name = re.sub(r"[^a-z0-9]+", "_", robot_name.lower()).strip("_")
    try:
        check_name(name)
    except Refusal as refusal:
        raise Refusal(f'{refusal}; it comes from the name of the robot, "{robot_name}": give another with NAME=') from refusal
    return name


def check_world(path, urdf_path, own_urdf):
    """Refuse what the simulator refuses. The message names the given URDF instead of its copy, which is removed after the refusal."""
    try:
        done = subprocess.run([SIMULATOR, "--world", relative(path), "--free-run", "0"], cwd=ROOT, capture_output=True, text=True, errors="replace",
                              check=False)
    except OSError as error:
        raise Refusal(f"{relative(SIMULATOR)}: {error.strerror}, expected the simulator: make") from error
    if done.returncode != 0:
        messages = done.stderr.strip().splitlines() or [f"ended with {done.returncode}"]
        raise Refusal(f"{messages[-1].replace(relative(own_urdf), str(urdf_path))}; {NEXT_STEP}")


def reach_of(robot):
    """Distance [m] from the base that the tool cannot exceed, for arms whose joints turn."""
    return sum(math.hypot(*joint.origin[0]) for joint in robot.joints) + math.hypot(*robot.tool[0])


def texts_alone(robot, names, start, base):
    """Texts of world, scenario, bounds and mission of an arm that flies alone."""
    buses = sorted({bus for bus, _ in addresses(robot)})
    words = {
        "world.xml": world(robot, names, start, base),
        "scenario.scn": scenario(robot, names, start, base),
        "scenario.bounds": names | {"bounds": bound_lines(robot, start)},
        "mission.xml": names | {"buses": "\n".join(map(robot_beside.BUS.format, buses))},
    }
    return [fill((TEMPLATES / template).read_text(encoding="utf-8"), each) for template, each in words.items()]


def texts_beside(existing, robot, names, start, base, place):
    """Texts of world, scenario, bounds and mission of an arm that flies with the subsystems of an existing mission."""
    buses = sorted({bus for bus, _ in addresses(robot, place)})
    words = scenario(robot, names, start, base)
    words["steps"] = robot_beside.steps(existing, words["steps"])
    judged = robot_beside.bounds(existing, bound_lines(robot, start), names["file"])
    return [
        robot_beside.world(existing, world(robot, names, start, base, place)),
        fill((TEMPLATES / "beside.scn").read_text(encoding="utf-8"), words | {"with": existing.name}),
        fill((TEMPLATES / "scenario.bounds").read_text(encoding="utf-8"), names | {"bounds": judged}),
        robot_beside.mission(existing, names, buses),
    ]


def bound_lines(robot, start):
    """The bounds as lines of their file."""
    return "\n".join(f"{name} {relation} {bound:.2g}" for name, relation, bound in bounds(robot, start))


def plan(path, name, tool, start_given, apid, base="fixed", other=None):
    """(dict path -> text of the new files, path of the mission, name of the files, the robot). `other`: mission with whose subsystems the arm flies."""
    robot, source = read(path, tool)
    expect(base in GRAVITY, "BASE", base, "fixed or free")
    expect(base == "fixed" or robot.base.mass > 0.0, "URDF", path, "the root link with a mass, or a link fixed to it: the base flies freely")
    robot.joints[0].free_base = robot.base if base == "free" else None
    check_base(robot.joints[0])
    name = name or name_from(robot.name)
    check_name(name)
    file = name.replace("_", "-")
    names = {"name": file, "NAME": name.upper(), "file": file, "apid": str(choose_apid(apid)), "urdf": pathlib.Path(path).name}
    start = wanted_pose(robot, start_given, base) if start_given else start_pose(robot, base)
    check_gears(robot, (start, away_from(robot, start)), base)
    existing = robot_beside.read(other, GRAVITY[base]) if other else None
    place = robot_beside.place_in(existing, file, names["apid"], reach_of(robot)) if other else ALONE
    texts = texts_beside(existing, robot, names, start, base, place) if other else texts_alone(robot, names, start, base)
    made = [f"descriptors/worlds/{file}.xml", f"sim/scenarios/{file}.scn", f"sim/scenarios/{file}.bounds", f"descriptors/missions/{file}.xml"]
    own = fill((TEMPLATES / "descriptor.xml").read_text(encoding="utf-8"), descriptor(robot, names, start, base, place))
    files = {ROOT / f"descriptors/subsystems/{file}.xml": own} | {ROOT / each: text for each, text in zip(made, texts)}
    own_urdf = ROOT / f"descriptors/worlds/{file}.urdf"
    if own_urdf != pathlib.Path(path).resolve():
        files[own_urdf] = source
    there = [relative(each) for each in files if each.exists()]
    expect(not there, "NAME", name, f"a name that is new; there is already {', '.join(there)}")
    return files, ROOT / f"descriptors/missions/{file}.xml", file, robot


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="make new-robot", description=__doc__.splitlines()[0])
    for option in ("urdf", "name", "tool", "start", "apid", "with"):
        parser.add_argument(f"--{option}")
    parser.add_argument("--base", default="fixed")
    options = parser.parse_args(arguments)
    try:
        expect(options.urdf, "URDF", "", "a file: make new-robot URDF=my-arm.urdf")
        files, mission, file, robot = plan(options.urdf, options.name, options.tool, options.start, options.apid, options.base, getattr(options, "with"))
        worlds = ROOT / "descriptors" / "worlds"
        write_all(files, mission, lambda: check_world(worlds / f"{file}.xml", options.urdf, worlds / f"{file}.urdf"))
    except Refusal as refusal:
        print(f"new-robot: {refusal}", file=sys.stderr)
        return 1
    made = "\n".join(f"  {relative(path)}" for path in files)
    print(f"{file}: {len(robot.joints)} joints, tool {robot.tool_name}:\n{made}\nNext:\n  make sim-run MISSION={file} SCENARIO={file}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
