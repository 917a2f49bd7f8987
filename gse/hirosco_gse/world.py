# SPDX-License-Identifier: Apache-2.0
"""Reader of the world of a mission: robots (URDF), fixtures, springs, devices on buses, wheels and valves of descriptors/worlds/<mission>.xml.

The simulator reads the same files and reports errors with file and line; this reader expects files that the simulator accepts.
Units are SI. A pose is a 4 x 4 matrix from a frame to its parent, as four rows. The station reads worlds, and numpy would take 13 MB of its
memory: this module does without it."""

import math
import pathlib
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field

from . import urdf


class WorldError(Exception):
    """There is no world, or it cannot be read."""

DRAWN = ("box", "cylinder", "sphere", "mesh")  # Visuals that page and report can draw.
IDENTITY = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))
MESH_OCTETS = 4_000_000  # Maximum of one mesh file; each page receives all meshes of the world.


@dataclass
class Shape:
    """A shape: box (size), cylinder (radius, length along z) or sphere (radius). `pose` is in the frame of its link, for a fixture in the world."""

    kind: str
    pose: tuple
    size: tuple = ()
    radius: float = 0.0
    length: float = 0.0


@dataclass
class Visual:
    """What viewers draw: a shape, or the mesh of an STL file in the frame of shape.pose. `colour`: red, green, blue from 0 to 1, or None."""

    shape: Shape
    colour: tuple | None = None
    mesh: pathlib.Path | None = None
    scale: tuple = (1.0, 1.0, 1.0)


@dataclass
class Link:
    """A link. `solid` is the box that has the mass and the moments of inertia of the link; None if the link has no mass, or no box has them."""

    name: str
    shapes: list = field(default_factory=list)
    solid: Shape | None = None
    visuals: list = field(default_factory=list)


@dataclass
class Joint:
    """Connects the link `child` to `parent`. `pose` is the pose of the child at position 0 in the frame of the parent."""

    name: str
    kind: str
    parent: str
    child: str
    pose: tuple
    axis: tuple
    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf
    effort: float = math.inf

    @property
    def moves(self):
        return self.kind != "fixed"


@dataclass
class Robot:
    """A tree of links. `joints` are in the order of the file; `moving` are those that are not fixed."""

    name: str
    links: dict
    joints: list
    start: dict = field(default_factory=dict)
    base: str = "fixed"
    at: tuple = IDENTITY  # Pose of the root link in its State: at time 0, or at the time `valid`.

    @property
    def moving(self):
        return [joint for joint in self.joints if joint.moves]

    @property
    def root(self):
        children = {joint.child for joint in self.joints}
        return next(name for name in self.links if name not in children)

    def poses(self, positions, base=None):
        """Dict link name -> pose, in the frame in which `base` is the pose of the root link; without base, in the frame of the root link.
        positions: those of the moving joints in their order."""
        values = dict(zip([joint.name for joint in self.moving], positions))
        found = {self.root: IDENTITY if base is None else base}
        waiting = list(self.joints)
        while waiting:
            ready = [joint for joint in waiting if joint.parent in found]
            for joint in ready:
                found[joint.child] = product(product(found[joint.parent], joint.pose), motion(joint, values.get(joint.name, 0.0)))
            if not ready:
                moved = {joint.child for joint in waiting}
                lost = next((joint for joint in waiting if joint.parent not in moved), waiting[0])
                raise WorldError(f"robot {self.name}: joint {lost.name}: parent {lost.parent}: expected a link that the root carries")
            waiting = [joint for joint in waiting if joint.child not in found]
        return found


@dataclass
class Device:
    """A device on a bus. `kind` is the name of its element, `joint` the name of the joint (`robot.joint`) that a drive moves."""

    kind: str
    name: str
    bus: str
    node: int
    eds: str = ""
    joint: str = ""


@dataclass
class Wheel:
    """A reaction wheel about `axis` of the link `on` (`robot.link`); `momentum` is the largest that it takes [Nms]."""

    name: str
    on: str
    axis: tuple
    momentum: float


@dataclass
class Valve:
    """The valve of a thruster that pushes the link `on` (`robot.link`) at `at` along `direction`, both in the link, with `force` [N].
    `device`: its valve box."""

    name: str
    device: str
    on: str
    at: tuple
    direction: tuple
    force: float


@dataclass
class World:
    name: str
    path: pathlib.Path
    robots: list
    fixtures: dict
    springs: list
    devices: list
    wheels: list = field(default_factory=list)
    valves: list = field(default_factory=list)


def product(first, second):
    """Matrix product of two matrices as rows."""
    columns = tuple(zip(*second))
    return tuple(tuple(sum(one * other for one, other in zip(row, column)) for column in columns) for row in first)


def rotation(rpy):
    """Rotation matrix of roll, pitch and yaw about the fixed axes x, y, z."""
    (a, b, c), (sa, sb, sc) = map(math.cos, rpy), map(math.sin, rpy)
    return ((c * b, c * sb * sa - sc * a, c * sb * a + sc * sa), (sc * b, sc * sb * sa + c * a, sc * sb * a - c * sa), (-sb, b * sa, b * a))


def _placed(rows, at):
    """Pose of a rotation matrix and a place."""
    return (*((*row, place) for row, place in zip(rows, at)), IDENTITY[3])


def pose(at=(0, 0, 0), rpy=(0, 0, 0)):
    return _placed(rotation(rpy), at)


def motion(joint, value):
    """Pose of the child at a position of the joint, relative to its pose at position 0."""
    if joint.kind == "fixed":
        return IDENTITY
    if joint.kind == "prismatic":
        return pose([part * value for part in joint.axis])
    x, y, z = joint.axis
    cross = ((0, -z, y), (z, 0, -x), (-y, x, 0))
    twice, sine, rest = product(cross, cross), math.sin(value), 1 - math.cos(value)
    rows = [[IDENTITY[n][m] + sine * cross[n][m] + rest * twice[n][m] for m in range(3)] for n in range(3)]
    return _placed(rows, (0.0, 0.0, 0.0))


def _numbers(text, default):
    return tuple(float(word) for word in text.split()) if text is not None else default


def _shape(element, where, size="size"):
    if element.tag.lower() == "box":
        return Shape("box", where, size=_numbers(element.get(size), ()))
    return Shape(element.tag.lower(), where, radius=float(element.get("radius")), length=float(element.get("length", 0)))


def _joint(joint):
    return Joint(joint.name, joint.kind, joint.parent, joint.child, pose(joint.origin.xyz, joint.origin.rpy), tuple(joint.axis),
                 **joint.limit)


def _solid(inertial):
    """Box with the mass and the moments of inertia of a link; products of inertia are ignored."""
    if inertial is None:
        return None
    moments = dict(zip(urdf.MOMENTS, inertial.moments))
    ixx, iyy, izz = (moments[name] for name in ("ixx", "iyy", "izz"))
    squares = [6 * (other + third - own) / inertial.mass for own, other, third in ((ixx, iyy, izz), (iyy, izz, ixx), (izz, ixx, iyy))]
    if min(squares) <= 0:
        return None
    return Shape("box", pose(inertial.origin.xyz, inertial.origin.rpy), size=tuple(math.sqrt(square) for square in squares))


def _in_world(shape):
    return Shape(shape.kind, pose(shape.origin.xyz, shape.origin.rpy), shape.size, shape.radius, shape.length)


def _visuals(link, directory):
    """Visuals of a link that a viewer can draw: shapes, and STL files in the directory of the URDF or below it."""
    found = []
    for visual in link.visuals:
        mesh = None
        if visual.shape.kind not in DRAWN:
            continue
        if visual.mesh:
            mesh = (directory / visual.mesh).resolve()
            if mesh.suffix.lower() != ".stl" or not mesh.is_relative_to(directory.resolve()) or not mesh.is_file():
                continue
            if mesh.stat().st_size > MESH_OCTETS:
                continue
        found.append(Visual(_in_world(visual.shape), visual.colour, mesh, visual.scale))
    return found


def read_urdf(path, name=None):
    """Robot of a URDF file."""
    try:
        document = urdf.read(path)
    except urdf.UrdfError as problem:
        raise WorldError(str(problem)) from problem
    directory = pathlib.Path(path).parent
    links = {link.name: Link(link.name, [_in_world(shape) for shape in link.shapes], _solid(link.inertial), _visuals(link, directory))
             for link in document.links}
    return Robot(name or document.name, links, [_joint(joint) for joint in document.joints])


def _parse(path):
    try:
        return ET.parse(path).getroot()
    except (OSError, ET.ParseError) as problem:
        raise WorldError(f"{path}: {problem}") from problem


def _robot(element, directory):
    robot = read_urdf(directory / element.get("urdf"), element.get("name"))
    robot.base = element.get("base", "fixed")
    start = element.find("Start")
    robot.start = {key: float(value) for key, value in start.attrib.items()} if start is not None else {}
    return robot


def _start_pose(element, robots):
    """Pose of the root link of a robot in its State, in the world. The State may be in the frame of the link `relativeTo` of a robot before it."""
    state = element.find("State")
    if state is None:
        return IDENTITY
    own = pose(_numbers(state.get("at"), (0, 0, 0)), _numbers(state.get("rpy"), (0, 0, 0)))
    name, _, link = state.get("relativeTo", "").partition(".")
    other = next((robot for robot in robots if robot.name == name and link in robot.links), None)
    if other is None:
        return own
    return product(other.poses([other.start.get(joint.name, 0.0) for joint in other.moving], other.at)[link], own)


def _robots(root, directory):
    found = []
    for element in root.findall("Robot"):
        robot = _robot(element, directory)
        robot.at = _start_pose(element, found)
        found.append(robot)
    return found


def _fixture(element):
    own = pose(_numbers(element.get("at"), (0, 0, 0)), _numbers(element.get("rpy"), (0, 0, 0)))
    places = [pose(_numbers(shape.get("at"), (0, 0, 0)), _numbers(shape.get("rpy"), (0, 0, 0))) for shape in element]
    return [_shape(shape, product(own, place)) for shape, place in zip(element, places)]


def _wheel(element):
    return Wheel(element.get("name"), element.get("on"), _numbers(element.get("axis"), ()), float(element.get("momentum")))


def _valve(element, box):
    return Valve(element.get("name"), box.get("name"), element.get("on"), _numbers(element.get("at"), ()), _numbers(element.get("direction"), ()),
                 float(element.get("force")))


def read(path):
    """World of a file."""
    path = pathlib.Path(path)
    root = _parse(path)
    devices = [Device(element.tag, element.get("name"), element.get("bus"), int(element.get("node", "0"), 0), element.get("eds", ""),
                      element.get("joint", ""))
               for element in root if element.get("bus") is not None]
    return World(root.get("name"), path, _robots(root, path.parent),
                 {element.get("name"): _fixture(element) for element in root.findall("Fixture")},
                 [{key: _numbers(element.get(key), ()) for key in ("hook", "length")} for element in root.findall("CableSpring")],
                 devices, [_wheel(element) for element in root.findall("Wheel")],
                 [_valve(element, box) for box in root.findall("ValveBox") for element in box.findall("Valve")])
