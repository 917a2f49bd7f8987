# SPDX-License-Identifier: Apache-2.0
"""Poses of an arm's links, and what each joint carries in a pose: weight and inertia. Units are SI."""

import math

import urdf

GRAVITY = {"fixed": (0.0, 0.0, -9.81), "free": urdf.ZERO}  # Gravity for each kind of base.
TINY = 1e-9  # Makes the equations of a singular matrix solvable.


def poses_of(robot, angles):
    """Pose of each link, and the axis of its joint, in the base."""
    pose = (urdf.ZERO, urdf.IDENTITY)
    for joint, angle in zip(robot.joints, angles):
        moved = (urdf.ZERO, urdf.rotation_about(joint.axis, angle))
        if joint.is_prismatic:
            moved = (tuple(angle * a for a in joint.axis), urdf.IDENTITY)
        pose = urdf.composed(urdf.composed(pose, joint.origin), moved)
        yield pose, urdf.turned(pose[1], joint.axis)


def loads_of(robot, angles, base):
    """(share of its torque that a joint needs to carry the arm, the joint) for each joint."""
    poses = list(poses_of(robot, angles))
    centres = [urdf.composed(pose, (joint.link.centre, urdf.IDENTITY))[0] for joint, (pose, _) in zip(robot.joints, poses)]
    loads = []
    for i, (joint, (pose, axis)) in enumerate(zip(robot.joints, poses)):
        torque = 0.0
        for carried, centre in zip(robot.joints[i:], centres[i:]):
            moment = [carried.link.mass * g for g in GRAVITY[base]]
            if not joint.is_prismatic:
                moment = urdf.cross([p - q for p, q in zip(centre, pose[0])], moment)
            torque -= urdf.dot(moment, axis)
        loads.append((abs(torque) / joint.effort, joint))
    return loads


def load_of(robot, angles, base):
    """Largest share of its torque that a joint needs to carry the arm, and that joint."""
    return max(loads_of(robot, angles, base), key=lambda load: load[0])


def carried_by(robot, poses, number):
    """Inertia about the axis of a joint, or mass, of all links that the joint carries."""
    (origin, _), axis = poses[number]
    if robot.joints[number].is_prismatic:
        return sum(joint.link.mass for joint in robot.joints[number:])
    total = 0.0
    for joint, (pose, _) in zip(robot.joints[number:], poses[number:]):
        own_axis = urdf.turned(urdf.transposed(pose[1]), axis)
        centre, _ = urdf.composed(pose, (joint.link.centre, urdf.IDENTITY))
        lever = urdf.cross(axis, [p - q for p, q in zip(centre, origin)])
        total += urdf.dot(own_axis, urdf.turned(joint.link.inertia, own_axis)) + joint.link.mass * urdf.dot(lever, lever)
    return total


def solved(rows, right):
    """Solution of linear equations; `rows` is a square matrix that is not singular."""
    rows = [[*row, value] for row, value in zip(rows, right)]
    for i in range(len(rows)):
        pivot = max(range(i, len(rows)), key=lambda row: abs(rows[row][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for below in range(len(rows)):
            if below != i:
                share = rows[below][i] / rows[i][i]
                rows[below] = [a - share * b for a, b in zip(rows[below], rows[i])]
    return [row[-1] / row[i] for i, row in enumerate(rows)]


def base_inertia_of(joint):
    """Inertia, or mass, with which a free base reacts to the torque, or force, of the joint on it; infinite for all other joints."""
    base = joint.free_base
    if base is None:
        return math.inf
    axis = urdf.turned(joint.origin[1], joint.axis)
    lever = [p - q for p, q in zip(joint.origin[0], base.centre)]
    torque = urdf.cross(lever, axis) if joint.is_prismatic else axis
    rows = [[base.inertia[i][k] + (TINY if i == k else 0.0) for k in range(3)] for i in range(3)]
    return 1.0 / (urdf.dot(torque, solved(rows, torque)) + (1.0 / base.mass if joint.is_prismatic else 0.0))


def _velocities(robot, poses, base):
    """For each body its Mass, rotation, and the velocities (of its centre, angular) that unit velocities of the coordinates give it: those of the
    joints, then six of a free base."""
    free = robot.base if base == "free" else None
    bodies = [(joint.link, pose) for joint, (pose, _) in zip(robot.joints, poses)]
    bodies += [(free, (urdf.ZERO, urdf.IDENTITY))] if free else []
    for number, (mass, pose) in enumerate(bodies):
        centre = urdf.composed(pose, (mass.centre, urdf.IDENTITY))[0]
        columns = []
        for i, (joint, (own, axis)) in enumerate(zip(robot.joints, poses)):
            is_carried = i <= number < len(robot.joints)
            lever = [p - q for p, q in zip(centre, own[0])]
            moved = (axis, urdf.ZERO) if joint.is_prismatic else (urdf.cross(axis, lever), axis)
            columns.append(moved if is_carried else (urdf.ZERO, urdf.ZERO))
        if free:
            units, lever = list(zip(*urdf.IDENTITY)), [p - q for p, q in zip(centre, free.centre)]
            columns += [(unit, urdf.ZERO) for unit in units] + [(urdf.cross(unit, lever), unit) for unit in units]
        yield mass, urdf.transposed(pose[1]), columns


def mass_matrix(robot, angles, base):
    """Mass matrix of the links in a pose: rows of the joints, then six of a free base."""
    size = len(robot.joints) + (6 if base == "free" else 0)
    rows = [[TINY if i == k else 0.0 for k in range(size)] for i in range(size)]
    for mass, turn, columns in _velocities(robot, list(poses_of(robot, angles)), base):
        turned = [urdf.turned(turn, angular) for _, angular in columns]
        moments = [urdf.turned(mass.inertia, angular) for angular in turned]
        for i, (linear, _) in enumerate(columns):
            for k, (other, _) in enumerate(columns):
                rows[i][k] += mass.mass * urdf.dot(linear, other) + urdf.dot(turned[i], moments[k])
    return rows


def largest_rate(robot, angles, base, gains, rotors):
    """Largest eigenvalue of (M^-1 + R^-1) G, and the joint that moves most in its mode. M: mass matrix of the links, R: `rotors`, G: `gains` of the
    gears between them."""
    rows, count = mass_matrix(robot, angles, base), len(gains)
    units = [[1.0 if i == k else 0.0 for k in range(len(rows))] for i in range(count)]
    inverse = [solved(rows, unit)[:count] for unit in units]
    for i, rotor in enumerate(rotors):
        inverse[i][i] += 1.0 / rotor
    mode, rate = [1.0 + 0.1 * i for i in range(count)], 0.0
    for _ in range(50):
        mode = [sum(a * gain * x for a, gain, x in zip(row, gains, mode)) for row in inverse]
        rate = max(map(abs, mode))
        mode = [x / rate for x in mode]
    return rate, max(range(count), key=lambda i: gains[i] * mode[i] * mode[i])
