# SPDX-License-Identifier: Apache-2.0
"""Figures of a flight of arms of the program arm: their true joints and tools compared with the desired motion, with the goals of the telecommands,
and with their limits. Positions of linear axes are in m, those of other joints in rad.

In a mission with several arms the name of a figure begins with that of the arm in small letters and a dot: left.tool_error_m."""

import functools
import re
from dataclasses import dataclass

import numpy as np

from . import telecommands, world
from . import truth as truth_log
from .dictionary import STATES
from .figures_common import Missing, setting

OPERATIONAL = STATES.index("OPERATIONAL")
SETTLE_US = 500_000  # Longest time after the end of a motion at which its goal is compared with the truth.
JOINT_GOALS = {"MOVE_TO": None, "MOVE_VIA": "ADD_VIA"}  # Motion -> function that has given its goal; None: the motion itself.
TOOL_GOALS = {"LINE_TO": None, "LINE_VIA": "ADD_POSE"}
ERROR = re.compile(r"joint([0-9]+)_error_(rad|m)")


@dataclass
class Arm:
    """An arm of a run. `places`: column of each joint in the truth; `is_linear`: whether the joint is a linear axis."""

    run: object
    subsystem: object
    configurations: dict  # id -> whether its tool is compliant
    period_us: int
    places: list
    is_linear: list

    def truth(self, name, times_us):
        """Column of the truth of the joints at these instants."""
        table = self.run.truth.get("JOINTS")
        if table is None or not len(table["time_us"]):
            raise Missing("the truth log has no channel JOINTS")
        return table[name][truth_log.held(table, times_us)][:, self.places]

    def setting(self, name, field):
        return setting(self.run, self.subsystem.name, name, field)


def _joint_of(run, device):
    """Column in the truth of the joint that a device of the descriptor drives."""
    ends = [(end.get("bus"), int(end.get("node", "0"), 0)) for end in device["endnodes"]]
    joint = next((other.joint for other in run.world.devices if (other.bus, other.node) in ends and other.joint), None)
    names = (run.truth.get("WORLD") or [{}])[0].get("joint", [])
    if joint not in names:
        raise Missing(f"no joint of the world is moved by the device {device['name']}")
    return names.index(joint)


def arms_of(run):
    """The subsystems of a run that are arms, by their names in small letters."""
    subsystems = run.dictionary.subsystems.values() if run.dictionary else ()
    return {one.name.lower(): one for one in subsystems if {"GEOMETRY", "LIMITS", "CUR_VALUES"} <= set(one.parameters)}


def arm_of(run, name=None):
    """The arm of this name in a run; without a name, the only one."""
    found = arms_of(run)
    names = ", ".join(found) or "none"
    if name and name not in found:
        raise Missing(f"no arm {name}; the arms (subsystems with GEOMETRY, LIMITS and CUR_VALUES) are: {names}")
    if not name and len(found) != 1:
        raise Missing(f"{len(found)} arms (subsystems with GEOMETRY, LIMITS and CUR_VALUES): {names}; "
                      "expected one, or the name of the arm and a dot before the name of the figure")
    if run.world is None:
        raise Missing("no world")
    arm = found[name] if name else next(iter(found.values()))
    (content,) = (item for item in run.dictionary.content["subsystems"] if item["name"] == arm.name)
    places = [_joint_of(run, device) for device in content["configurations"][0]["devices"]]
    kinds = {field.name: field.init for field in arm.parameter("GEOMETRY").fields}
    is_linear = [word in ("1", "true") for word in (kinds.get("PRISMATIC") or "0 " * len(places)).split()]
    configurations = {item.id: item.initial.get(("CONTROL", "COMPLIANT"), "0") in ("1", "true") for item in arm.configurations.values()}
    return Arm(run, arm, configurations, content["configurations"][0]["sampling_us"], places, is_linear)


def samples(run, configuration=None, name=None):
    """(instants of the samples [us], CUR_VALUES) of each report in operation in the configuration of this name; without a name, in all
    configurations whose tool is not compliant. The values of a report were sampled one cycle before."""
    arm = arm_of(run, name)
    wanted = {arm.subsystem.configuration(configuration).id} if configuration else {number for number, yields in arm.configurations.items() if not yields}
    present, times, values = None, [], []
    for time_ns, packet, decoded in run.reports:
        if packet.apid != arm.subsystem.apid or "error" in decoded:
            continue
        present = decoded.get("configuration_id", present)
        found = decoded["values"].get("CUR_VALUES") if decoded["kind"] == "housekeeping" else None
        if found and present in wanted and np.ravel(found["STATE"])[0] == OPERATIONAL:
            times.append(time_ns // 1000 - arm.period_us)
            values.append(found)
    if not times:
        raise Missing("no housekeeping with CUR_VALUES in operation")
    return np.array(times), {name: np.array([found[name] for found in values]) for name in values[0]}


def _motions(joint, positions):
    """world.motion() for each position of a joint."""
    found = np.tile(np.eye(4), (len(positions), 1, 1))
    if joint.kind == "prismatic":
        found[:, :3, 3] = positions[:, None] * joint.axis
    elif joint.moves:
        cross = np.cross(np.eye(3), joint.axis)
        found[:, :3, :3] += np.sin(positions)[:, None, None] * cross + (1 - np.cos(positions))[:, None, None] * (cross @ cross)
    return found


def tools(run, poses, name=None):
    """Pose of the tool in the frame of the base for each row of joint positions, computed with the URDF of the world."""
    arm, poses = arm_of(run, name), np.asarray(poses)
    names = run.truth["WORLD"][0]["joint"]
    robot_name, _, last = names[arm.places[-1]].partition(".")
    robot = next(one for one in run.world.robots if one.name == robot_name)
    link = next(joint.child for joint in robot.joints if joint.name == last)
    tool = world.pose(arm.setting("GEOMETRY", "TOOL"), arm.setting("GEOMETRY", "TOOL_RPY"))
    moved = {names[place]: poses[:, number] for number, place in enumerate(arm.places)}
    found = np.tile(tool, (len(poses), 1, 1))
    while link != robot.root:
        joint = next(one for one in robot.joints if one.child == link)
        found = joint.pose @ _motions(joint, moved.get(f"{robot_name}.{joint.name}", np.zeros(len(poses)))) @ found
        link = joint.parent
    return found


def joint_errors(run, configuration=None, name=None):
    """Largest difference of each true joint from its desired position in operation."""
    arm = arm_of(run, name)
    times, values = samples(run, configuration, name)
    return np.abs(arm.truth("position_rad", times) - values["DESIRED"]).max(axis=0)


def tool_error(run, configuration=None, name=None):
    """Largest distance [m] of the true tool from its desired position in operation."""
    arm = arm_of(run, name)
    times, values = samples(run, configuration, name)
    true, desired = (tools(run, positions, name) for positions in (arm.truth("position_rad", times), values["DESIRED"]))
    return float(np.linalg.norm(true[:, :3, 3] - desired[:, :3, 3], axis=1).max())


def tracking(run, name=None):
    arm = arm_of(run, name)
    return {f"joint{number}_error_{'m' if is_linear else 'rad'}": float(error)
            for number, (is_linear, error) in enumerate(zip(arm.is_linear, joint_errors(run, name=name)), 1)}


def tool_tracking(run, name=None):
    return {"tool_error_m": tool_error(run, name=name)}


def _commands(run, arm):
    """(time [us], decoded telecommand, time [us] of its successful completion or None) of each telecommand to the arm."""
    done = {(decoded["request_apid"], decoded["request_sequence"]): time_ns // 1000 for time_ns, packet, decoded in run.reports
            if packet.message == (1, 7) and "error" not in decoded}
    for time_ns, direction, packet, _ in run.packets:
        if direction == "TC" and packet is not None and packet.apid == arm.subsystem.apid:
            yield time_ns // 1000, telecommands.decode(packet, run.dictionary), done.get((packet.apid, packet.sequence))


def goals(run, name=None):
    """(instant [us], whether it is a goal of the tool, arguments) of each motion that was carried out. The instant is SETTLE_US after the end of the
    motion, or that of the next telecommand to the arm if that is earlier."""
    arm = arm_of(run, name)
    listed, given, found = list(_commands(run, arm)), {}, []
    for row, (_, decoded, done_us) in enumerate(listed):
        function = decoded.get("function")
        if done_us is None or function is None:
            continue
        given[function] = decoded["values"]
        for motions, is_tool in ((JOINT_GOALS, False), (TOOL_GOALS, True)):
            if function in motions:
                following = [time_us for time_us, _, _ in listed[row + 1 :] if time_us > done_us]
                found.append((min([done_us + SETTLE_US, *following[:1]]), is_tool, given[motions[function] or function]))
    if not found:
        raise Missing("no motion was carried out")
    return found


def joint_goals(run, name=None):
    """Largest distance of a true joint from its goal at the end of a motion."""
    arm = arm_of(run, name)
    ends = [(instant, values["POSITION"]) for instant, is_tool, values in goals(run, name) if not is_tool]
    if not ends:
        raise Missing("no motion had positions of the joints as its goal")
    errors = np.abs(arm.truth("position_rad", [instant for instant, _ in ends]) - [position for _, position in ends]).max(axis=0)
    kinds = {"goal_error_rad": False, "goal_error_m": True}
    return {figure: float(errors[np.equal(arm.is_linear, kind)].max()) for figure, kind in kinds.items() if kind in arm.is_linear}


def tool_goals(run, name=None):
    """Largest distance of the true tool from its goal at the end of a line."""
    arm = arm_of(run, name)
    ends = [(instant, values["POSITION"]) for instant, is_tool, values in goals(run, name) if is_tool]
    if not ends:
        raise Missing("no motion had a pose of the tool as its goal")
    true = tools(run, arm.truth("position_rad", [instant for instant, _ in ends]), name)
    return {"goal_tool_error_m": float(np.linalg.norm(true[:, :3, 3] - [position for _, position in ends], axis=1).max())}


def limits(run, name=None):
    """Least distance of a true joint from an end of its range, divided by the range; largest shares of speed and torque of a true joint whose brake is
    released: with the brakes engaged, links swing in their gears."""
    arm = arm_of(run, name)
    lower, upper, speed, torque = (arm.setting("LIMITS", field) for field in ("LOWER", "UPPER", "SPEED", "TORQUE"))
    times = run.truth.get("JOINTS", {}).get("time_us", ())
    position = arm.truth("position_rad", times)
    released = arm.truth("brake_engaged", times) == 0
    if not released.any():
        raise Missing("no brake was released")
    return {
        "joint_range_margin": float((np.minimum(position - lower, upper - position) / (upper - lower)).min()),
        "joint_speed_share": float((np.abs(arm.truth("velocity_rad_s", times)) / speed)[released].max()),
        "joint_torque_share": float((np.abs(arm.truth("motor_torque_nm", times)) / torque)[released].max()),
    }


TEXTS = {
    "tool_error_m": ("Error of the tool from its desired motion", "m"),
    "goal_error_rad": ("Error of a joint at the end of a motion", "rad"),
    "goal_error_m": ("Error of a linear axis at the end of a motion", "m"),
    "goal_tool_error_m": ("Error of the tool at the end of a line", "m"),
    "joint_range_margin": ("Least distance from the end of the range of a joint, relative to the range", ""),
    "joint_speed_share": ("Largest share of the speed of a joint", ""),
    "joint_torque_share": ("Largest share of the torque of a joint", ""),
}


def _parted(name):
    """(arm or None, figure) of the name of a figure."""
    arm, dot, figure = name.rpartition(".")
    return (arm if dot else None), figure


def text_of(name):
    """(title, unit) of a figure of this module; None for another one."""
    arm, figure = _parted(name)
    found = ERROR.fullmatch(figure)
    text = (f"Error of joint {found[1]} from its desired motion", found[2]) if found else TEXTS.get(figure)
    return (f"{arm.upper()}: {text[0]}", text[1]) if text and arm else text


def _named(function, arm, run):
    """The figures of an arm under the names that they have in a mission with several."""
    return {f"{arm}.{name}": value for name, value in function(run, name=arm).items()}


def _figures_of_arm(arm, names):
    listed = (
        (tracking, [name for name in names if ERROR.fullmatch(name)]),
        (tool_tracking, ["tool_error_m"]),
        (joint_goals, ["goal_error_rad", "goal_error_m"]),
        (tool_goals, ["goal_tool_error_m"]),
        (limits, ["joint_range_margin", "joint_speed_share", "joint_torque_share"]),
    )
    for function, known in listed:
        if wanted := [name for name in known if name in names]:
            yield (functools.partial(_named, function, arm), tuple(f"{arm}.{name}" for name in wanted)) if arm else (function, tuple(wanted))


def figures_of(names):
    """(function, its figures) for these names of figures, without those of other modules."""
    by_arm = {}
    for arm, figure in map(_parted, names):
        by_arm.setdefault(arm, []).append(figure)
    return tuple(found for arm, figures in by_arm.items() for found in _figures_of_arm(arm, figures))
