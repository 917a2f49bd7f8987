# SPDX-License-Identifier: Apache-2.0
"""Parameters of the flight, position of the tip, segments of the hand, and values of PDOs without gaps, for the modules that compute figures."""

import numpy as np

from .run import CYCLE_US

# Evaluated time of a hold; time before it, in which the motion settles; shortest evaluated time with which a hold has figures.
HOLD_US, SETTLED_US, HOLD_LEAST_US = 10_000_000, 2_000_000, 5_000_000


class Missing(Exception):
    """The logs do not contain the data for a figure."""


def telecommanded(run):
    """Parameters that telecommands have set (TC[20,3]), in order: (time_us, subsystem, parameter, value)."""
    for time_ns, direction, packet, _ in run.packets:
        if direction != "TC" or packet is None or packet.message != (20, 3) or run.dictionary is None:
            continue
        subsystem, offset = run.dictionary.subsystem_of_apid(packet.apid), 1
        for _ in range(packet.data[0]):
            identifier = int.from_bytes(packet.data[offset : offset + 4], "big")
            parameter = subsystem.parameter_of_id(identifier) if subsystem else None
            if parameter is None:
                break
            value, offset = parameter.decode(packet.data, offset + 4)
            yield time_ns // 1000, subsystem, parameter, value


def _configuration(run, subsystem):
    """The configuration that a subsystem had last in the flight; None if it reported none."""
    known = {item.id: item for item in subsystem.configurations.values()}
    found = [known.get(decoded.get("configuration_id")) for _, packet, decoded in run.reports if packet.apid == subsystem.apid]
    return next((item for item in reversed(found) if item), None)


def setting(run, owner, name, field):
    """Numbers of a field of a parameter in the flight: from the last telecommand, else from the configuration flown, else from the descriptor."""
    if run.dictionary is None:
        raise Missing(f"no dictionary with {owner}.{name}.{field}")
    subsystem = run.dictionary.subsystem(owner)
    item, _ = subsystem.parameter(name).field(field)
    configuration = _configuration(run, subsystem)
    text = (configuration.initial if configuration else {}).get((name, field), item.init)
    found = [float(word) for word in text.split()]
    for _, other, parameter, value in telecommanded(run):
        if (other.apid, parameter.name) == (subsystem.apid, name):
            found = value[field]
    return np.array(found)


def position_scale(run):
    """Angle of a joint of the arm divided by the angle of the joystick that commands it."""
    return float(setting(run, "MANIPULATOR", "CONTROL", "POSITION_SCALE")[0])


def force_scale(run):
    """Torque of the joystick divided by the external torque of a joint that it reflects."""
    return float(setting(run, "JOYSTICK", "CONTROL", "FORCE_SCALE")[0])


def tip(run, joints):
    """Position [m] of the last link of the first robot for these joint angles, computed with the world of the run."""
    if run.world is None or not run.world.robots:
        raise Missing("no world with a robot")
    robot = run.world.robots[0]
    parents = {joint.parent for joint in robot.joints}
    last = next(joint.child for joint in robot.joints if joint.child not in parents)
    return np.array(robot.poses(joints)[last])[:3, 3]


def force_of(run, joints, torque):
    """Force on the tip in the plane of an arm of two joints that causes these torques [N]."""
    jacobian = np.stack([(tip(run, joints + step) - tip(run, joints - step)) / 2e-6 for step in np.eye(2) * 1e-6], axis=1)
    return np.linalg.pinv(jacobian.T) @ torque


def segment(run, verb, before):
    """(first, end) cycle of the first segment `verb`. If `before` is not None, only segments after a segment `before` count."""
    seen = before is None
    for name, first, end in run.segments():
        if name == verb and seen:
            return first, end
        seen = seen or (before is not None and name == before)
    raise Missing(f"the hand never did '{verb}'" + (f" after '{before}'" if before else ""))


def filled(cycles, name, start, end):
    """Values of a field of a PDO in the cycles from `start` to `end`. A missing value is replaced by the one before. Raises Missing if more than one in a thousand is missing."""
    seen = cycles.seen[start:end]
    if not len(seen) or seen.mean() < 0.999:
        raise Missing(f"PDOs are missing between {start * CYCLE_US / 1e6:.1f} and {end * CYCLE_US / 1e6:.1f} s")
    index = np.maximum.accumulate(np.where(seen, np.arange(len(seen)), 0))
    return cycles[name][start:end][index]
