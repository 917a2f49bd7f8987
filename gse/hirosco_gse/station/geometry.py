# SPDX-License-Identifier: Apache-2.0
"""The world of a mission as dictionaries and lists, for the scene of the page. Units are SI. A pose is the 4 x 4 matrix from a frame to its
parent (hirosco_gse.world) as 16 numbers, row by row."""

import base64
import math

from ..run_directory import ROOT

SHEETS = ROOT / "descriptors" / "devices"
BRAKE = "ParameterName=Holding brake state"


def _pose(matrix):
    return [float(number) for row in matrix for number in row]


def _bound(value):
    return float(value) if math.isfinite(value) else None


def _shape(shape):
    return {
        "kind": shape.kind,
        "pose": _pose(shape.pose),
        "size": list(shape.size),
        "radius": shape.radius,
        "length": shape.length,
    }


def _visual(visual):
    found = _shape(visual.shape) | {"colour": visual.colour and list(visual.colour), "scale": list(visual.scale)}
    if visual.mesh:
        found["stl"] = base64.b64encode(visual.mesh.read_bytes()).decode("ascii")
    return found


def _joint(joint):
    return {
        "name": joint.name,
        "kind": joint.kind,
        "parent": joint.parent,
        "child": joint.child,
        "pose": _pose(joint.pose),
        "axis": [float(number) for number in joint.axis],
        "lower": _bound(joint.lower),
        "upper": _bound(joint.upper),
    }


def _shapes(robot, link):
    """Shapes that the page draws for a link. A free body without shapes is drawn as a box with its mass and moments of inertia."""
    if link.shapes or robot.base != "free" or link.name != robot.root or link.solid is None:
        return link.shapes
    return [link.solid]


def _robot(robot, braked=frozenset()):
    """Content of a robot. `braked`: joints (`robot.joint`) of drives with a holding brake."""
    return {
        "name": robot.name,
        "root": robot.root,
        "start": robot.start,
        "at": _pose(robot.at),
        "free": robot.base == "free",
        "links": {name: [_shape(shape) for shape in _shapes(robot, link)] for name, link in robot.links.items()},
        "visuals": {name: [_visual(visual) for visual in link.visuals] for name, link in robot.links.items() if link.visuals},
        "joints": [_joint(joint) for joint in robot.joints],
        "braked": [joint.name for joint in robot.moving if f"{robot.name}.{joint.name}" in braked],
    }


def _has_brake(device):
    """True if the EDS of the drive has the object 'Holding brake state'; the simulator recognizes a brake by this name, too."""
    sheet = SHEETS / device.eds
    return bool(device.eds) and sheet.is_file() and BRAKE in sheet.read_text(encoding="utf-8", errors="replace")


def as_lists(world):
    """Robots, fixtures, springs, drives, wheels and thrusters (key `valves`) of a world (hirosco_gse.world.World)."""
    braked = {device.joint for device in world.devices if device.joint and _has_brake(device)}
    return {
        "name": world.name,
        "robots": [_robot(robot, braked) for robot in world.robots],
        "fixtures": {name: [_shape(shape) for shape in shapes] for name, shapes in world.fixtures.items()},
        "springs": [{"hook": list(spring["hook"]), "length": list(spring["length"])} for spring in world.springs],
        "drives": {device.name: device.joint for device in world.devices if device.joint},
        "wheels": [{"name": wheel.name, "on": wheel.on, "axis": list(wheel.axis), "momentum": wheel.momentum} for wheel in world.wheels],
        "valves": [{"name": valve.name, "device": valve.device, "on": valve.on, "at": list(valve.at), "direction": list(valve.direction)}
                   for valve in world.valves],
    }
