# SPDX-License-Identifier: Apache-2.0
"""Reader of a robot's URDF: its links and joints as the file defines them, with their lines.

The simulator reads the same file with sim/world/urdf.c, which refuses what it cannot simulate. Units are SI; roll, pitch and yaw are about
the fixed axes x, y, z."""

import math
import xml.parsers.expat
from dataclasses import dataclass, field

ZERO = (0.0, 0.0, 0.0)
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
PRINCIPAL = ("ixx", "iyy", "izz")
WITHOUT_AXIS = ("fixed", "floating")  # Many files give these joints an axis of length 0.


class UrdfError(Exception):
    """An error in the file: file, line, the value found and the value expected."""


@dataclass
class Origin:
    xyz: tuple = ZERO
    rpy: tuple = ZERO


@dataclass
class Inertial:
    """Mass, its centre with axes, and moments of inertia in these axes."""

    mass: float
    origin: Origin
    moments: tuple


@dataclass
class Shape:
    """A collision shape: box (size), cylinder (radius, length along z) or sphere (radius)."""

    kind: str
    origin: Origin
    size: tuple = ()
    radius: float = 0.0
    length: float = 0.0


@dataclass
class Visual:
    """What viewers draw: a shape, or `mesh` (path of its file, as the URDF names it, and scale). `colour`: red, green, blue from 0 to 1, or None."""

    shape: Shape
    colour: tuple | None = None
    mesh: str = ""
    scale: tuple = (1.0, 1.0, 1.0)


@dataclass
class Link:
    name: str
    line: int
    inertial: Inertial | None = None
    shapes: list = field(default_factory=list)
    visuals: list = field(default_factory=list)


@dataclass
class Joint:
    """Connects the link `child` to `parent`; `axis` has length 1. `limit` contains lower, upper, velocity and effort, as far as the file gives them."""

    name: str
    kind: str
    line: int
    parent: str
    child: str
    origin: Origin
    axis: tuple
    limit: dict
    is_mimic: bool = False  # It follows another joint.


@dataclass
class Document:
    name: str
    links: list
    joints: list


class Element:
    """An element with its attributes, children and line."""

    def __init__(self, path, line, name, attributes):
        self.path, self.line, self.name, self.attributes, self.children = path, line, name, attributes, []

    def fail(self, message):
        """Raise an error at this element."""
        raise UrdfError(f"{self.path}:{self.line}: {message}")

    def all(self, name):
        return [child for child in self.children if child.name == name]

    def first(self, name):
        """The only child of a name, or None."""
        found = self.all(name)
        if len(found) > 1:
            found[1].fail(f"<{name}>: expected only one in <{self.name}>")
        return found[0] if found else None

    def need(self, name):
        """First child of a name."""
        return self.first(name) or self.fail(f"<{self.name}>: expected <{name}>")

    def text(self, key):
        return self.attributes[key] if key in self.attributes else self.fail(f"<{self.name}>: expected {key}=")

    def numbers(self, key, count=1, default=None):
        """Values of an attribute."""
        if key not in self.attributes and default is not None:
            return default
        try:
            values = tuple(float(word) for word in self.text(key).split())
        except ValueError:
            values = ()
        if len(values) != count or not all(map(math.isfinite, values)):
            self.fail(f'{key}="{self.attributes[key]}" of <{self.name}>: expected {count} number{"s" if count > 1 else ""}')
        return values

    def number(self, key, default=None):
        return self.numbers(key, 1, None if default is None else (default,))[0]

    def positive(self, key):
        """Value of an attribute that is more than 0."""
        value = self.number(key)
        return value if value > 0.0 else self.fail(f'{key}="{self.attributes[key]}" of <{self.name}>: expected more than 0')


def _parse(path):
    """Root element of a file."""
    parser, open_elements = xml.parsers.expat.ParserCreate(), [Element(path, 1, "", {})]

    def begin(name, attributes):
        element = Element(path, parser.CurrentLineNumber, name, attributes)
        open_elements[-1].children.append(element)
        open_elements.append(element)

    parser.StartElementHandler, parser.EndElementHandler = begin, lambda name: open_elements.pop()
    try:
        with open(path, "rb") as file:
            parser.Parse(file.read(), True)  # In pieces, expat would scan a long comment from its begin again for each piece.
    except OSError as error:
        raise UrdfError(f"{path}: cannot read: {error.strerror}") from error
    except xml.parsers.expat.ExpatError as error:
        raise UrdfError(f"{path}:{error.lineno}: {xml.parsers.expat.errors.messages[error.code]}: expected XML") from error
    except (LookupError, ValueError) as error:  # The encoding that the file declares is unknown, or has several octets for a character.
        raise UrdfError(f"{path}:{parser.CurrentLineNumber}: {error}: expected UTF-8: convert the file, for example with iconv") from error
    return open_elements[0].children[0]


def _origin(element):
    """Pose of the element's <origin>; the identity if there is none."""
    origin = element.first("origin")
    return Origin(origin.numbers("xyz", 3, ZERO), origin.numbers("rpy", 3, ZERO)) if origin else Origin()


def _shape(collision):
    geometry = collision.need("geometry")
    if not geometry.children:
        geometry.fail("<geometry>: expected a shape")
    shape = geometry.children[0]
    return Shape(shape.name, _origin(collision), shape.numbers("size", 3, ()), shape.number("radius", 0.0), shape.number("length", 0.0))


def _colour(element, materials):
    """Colour of a <visual>: its own, or that of the material of the robot that it names."""
    material = element.first("material")
    if material is None:
        return None
    colour = material.first("color")
    return colour.numbers("rgba", 4)[:3] if colour else materials.get(material.attributes.get("name"))


def _visual(element, materials):
    mesh = element.need("geometry").first("mesh")
    if mesh is None:
        return Visual(_shape(element), _colour(element, materials))
    return Visual(Shape("mesh", _origin(element)), _colour(element, materials), mesh.text("filename"), mesh.numbers("scale", 3, (1.0, 1.0, 1.0)))


def _link(element, materials):
    inertial = element.first("inertial")
    mass = None
    if inertial:
        moments = inertial.need("inertia")
        mass = Inertial(inertial.need("mass").positive("value"), _origin(inertial),
                        tuple(moments.positive(key) if key in PRINCIPAL else moments.number(key) for key in MOMENTS))
    return Link(element.text("name"), element.line, mass, [_shape(collision) for collision in element.all("collision")],
                [_visual(visual, materials) for visual in element.all("visual")])


def _joint(element):
    axis, limit = element.first("axis"), element.first("limit")
    kind = element.text("type")
    direction = axis.numbers("xyz", 3) if axis and kind not in WITHOUT_AXIS else (1.0, 0.0, 0.0)
    length = math.hypot(*direction)
    if length == 0.0:
        axis.fail(f'<axis> of joint {element.text("name")}: expected a direction')
    limits = {key: limit.number(key) for key in ("lower", "upper", "velocity", "effort") if limit and key in limit.attributes}
    return Joint(element.text("name"), kind, element.line, element.need("parent").text("link"),
                 element.need("child").text("link"), _origin(element), tuple(x / length for x in direction), limits,
                 element.first("mimic") is not None)


def read(path):
    """Links and joints of a file. Raises UrdfError."""
    root = _parse(path)
    if root.name != "robot":
        root.fail(f"<{root.name}>: expected <robot>")
    for child in root.children:
        if ":" in child.name:
            child.fail(f"<{child.name}>: expected an element of URDF; a file for xacro must be expanded first: xacro arm.urdf.xacro -o arm.urdf")
    materials = {item.text("name"): colour.numbers("rgba", 4)[:3] for item in root.all("material") if (colour := item.first("color"))}
    return Document(root.text("name"), [_link(element, materials) for element in root.all("link")],
                    [_joint(element) for element in root.all("joint")])
