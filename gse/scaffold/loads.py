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
