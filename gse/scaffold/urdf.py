# SPDX-License-Identifier: Apache-2.0
"""Convert a robot's URDF to the model of flight software: one chain of joints, and the link at its end. Links that fixed joints
connect become one link."""

import math
import pathlib
import re
import sys
from dataclasses import dataclass, field

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from hirosco_gse.urdf import ZERO, UrdfError
from hirosco_gse.urdf import read as read_file

IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
JOINTS_MAX = 12
EFFORT_MAX = 320.0  # Nm or N, of descriptors/devices/joint-drive-large.eds.
POSITION_MAX = 2147.0  # rad or m: 32 bits of the drives' unit of 1e-6.
SPEED_MIN = 0.001  # rad/s or m/s, of SPEED in the descriptor.
FINGERS = 'make the joints of a gripper type="fixed" without <mimic>, docs/arm.md'
INSTEAD = {  # What to write for a joint type that no drive moves.
    "floating": 'for a base that flies freely, remove this joint with its parent link and give BASE=free; otherwise make it type="fixed"',
    "planar": 'make it type="fixed", or two prismatic joints and a revolute one, each of which moves a link with a mass',
}
NAME = re.compile(r"(?!xml)[A-Za-z][A-Za-z0-9_.-]{0,58}")  # Name of a joint, an attribute of the world's <Start>; with "arm." it has at most 63 octets.


@dataclass
class Mass:
    """Mass, centre of mass, and inertia about it, in the axes of the link."""

    mass: float = 0.0
    centre: tuple = ZERO
    inertia: tuple = ((0.0,) * 3,) * 3


@dataclass
class Joint:
    """A joint with the link that it moves. Values of a prismatic joint are in m and N."""

    name: str
    origin: tuple  # Position and rotation of the link in the previous one.
    axis: tuple
    lower: float
    upper: float
    effort: float
    speed: float
    is_prismatic: bool = False
    location: str = ""  # File and line.
    link: Mass = field(default_factory=Mass)
    free_base: Mass | None = None  # The base on which this joint begins, if it flies freely.


@dataclass
class Robot:
    """A chain of joints; `tool` is a pose in the last link."""

    name: str
    joints: list
    tool: tuple
    tool_name: str
    base: Mass = field(default_factory=Mass)


def product(a, b):
    """Product of two matrices."""
    return tuple(tuple(sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)) for i in range(3))


def transposed(a):
    return tuple(zip(*a))


def turned(a, v):
    return tuple(sum(a[i][k] * v[k] for k in range(3)) for i in range(3))


def rotation_of(rpy):
    """Rotation of roll, pitch, yaw."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(angle), math.cos(angle)) for angle in rpy)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def rpy_of(a):
    """Roll, pitch, yaw of a rotation; with a pitch of 90 degrees, roll is 0."""
    pitch = math.atan2(-a[2][0], math.hypot(a[0][0], a[1][0]))
    if abs(math.cos(pitch)) < 1e-9:
        return (0.0, pitch, math.atan2(-a[0][1], a[1][1]))
    return (math.atan2(a[2][1], a[2][2]), pitch, math.atan2(a[1][0], a[0][0]))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def rotation_about(axis, angle):
    """Rotation by an angle about an axis of length 1."""
    sine, cosine = math.sin(angle), math.cos(angle)
    skew = ((0.0, -axis[2], axis[1]), (axis[2], 0.0, -axis[0]), (-axis[1], axis[0], 0.0))
    return tuple(
        tuple((cosine if i == k else 0.0) + (1.0 - cosine) * axis[i] * axis[k] + sine * skew[i][k] for k in range(3)) for i in range(3)
    )


def rotation_vector_of(a):
    """Axis times angle of a rotation."""
    w = math.sqrt(max(0.0, 1.0 + a[0][0] + a[1][1] + a[2][2])) / 2.0
    sides = [math.copysign(math.sqrt(max(0.0, 1.0 + 2.0 * a[i][i] - a[0][0] - a[1][1] - a[2][2])) / 2.0, sign)
             for i, sign in enumerate((a[2][1] - a[1][2], a[0][2] - a[2][0], a[1][0] - a[0][1]))]
    length = math.hypot(*sides)
    return tuple(side * 2.0 * math.atan2(length, w) / length for side in sides) if length > 0.0 else ZERO


def composed(outer, inner):
    """Pose `inner` in the frame in which `outer` is given."""
    return (tuple(p + q for p, q in zip(outer[0], turned(outer[1], inner[0]))), product(outer[1], inner[1]))


def parallel(mass, arm):
    """Inertia of a point mass, with `arm` as the vector to it."""
    square = sum(x * x for x in arm)
    return [[mass * ((square if i == k else 0.0) - arm[i] * arm[k]) for k in range(3)] for i in range(3)]


def joined(a, b, pose):
    """Mass properties of the rigid body that consists of a and b, where b has this pose in the axes of a."""
    centre_b, rotation = composed(pose, (b.centre, IDENTITY))
    if b.mass == 0.0:
        return a
    mass = a.mass + b.mass
    centre = tuple((a.mass * p + b.mass * q) / mass for p, q in zip(a.centre, centre_b))
    turned_b = product(product(rotation, b.inertia), transposed(rotation))
    shift_a = parallel(a.mass, [p - q for p, q in zip(a.centre, centre)])
    shift_b = parallel(b.mass, [p - q for p, q in zip(centre_b, centre)])
    inertia = tuple(tuple(a.inertia[i][k] + turned_b[i][k] + shift_a[i][k] + shift_b[i][k] for k in range(3)) for i in range(3))
    return Mass(mass, centre, inertia)


def pose_of(origin):
    """Position and rotation of an origin."""
    return (origin.xyz, rotation_of(origin.rpy))


def mass_of(link):
    """Mass properties of a link, in its own axes."""
    inertial = link.inertial
    if inertial is None:
        return Mass()
    position, rotation = pose_of(inertial.origin)
    xx, xy, xz, yy, yz, zz = inertial.moments
    return Mass(inertial.mass, position, product(product(rotation, ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))), transposed(rotation)))


class _Chain:
    """Follows the joints of a robot from the root to the tool."""

    def __init__(self, path, document, tool):
        self.path, self.tool = path, tool
        self.links = {link.name: mass_of(link) for link in document.links}
        self.lines = {link.name: link.line for link in document.links}
        self.children, self.moved = {}, {}
        for joint in document.joints:
            for end in (joint.parent, joint.child):
                if end not in self.links:
                    self.refuse(joint, f"{end}: expected a link of the robot")
            if joint.child in self.moved:  # With two parents a link may follow itself.
                self.refuse(joint, f"child {joint.child}: expected a link that no other joint moves; there is {self.moved[joint.child]}; "
                                   f"an arm is an open chain: of a closed one, such as a delta robot, only one branch can fly")
            self.children.setdefault(joint.parent, []).append(joint)
            self.moved[joint.child] = joint.name

    def fail(self, message):
        """Raise an error about the whole file."""
        raise UrdfError(f"{self.path}: {message}")

    def refuse(self, joint, message):
        """Raise an error at a joint."""
        raise UrdfError(f"{self.path}:{joint.line}: joint {joint.name}: {message}")

    def root(self):
        roots = [name for name in self.links if name not in self.moved]
        if len(roots) > 1:
            raise UrdfError(f"{self.path}:{self.lines[roots[1]]}: link {roots[1]}: expected one root, and {roots[0]} is no child of a joint either; "
                            f'connect {roots[1]} by a joint with type="fixed", or remove it')
        if not roots:
            joint = next(iter(self.children.values()))[0] if self.children else None
            message = "expected one link that is no child of a joint, the root of the robot"
            self.refuse(joint, f"{message}; the joints form a ring: remove one") if joint else self.fail(f"no link: {message}")
        return roots[0]

    def rigid(self, link):
        """Mass of a link together with the links that fixed joints connect to it, the movable joints that begin on it, and the frames on it."""
        mass, leaving, frames, pending = Mass(), [], {}, [(link, (ZERO, IDENTITY))]
        while pending:
            name, pose = pending.pop(0)
            frames[name] = pose
            mass = joined(mass, self.links[name], pose)
            for joint in self.children.get(name, []):
                placed = composed(pose, pose_of(joint.origin))
                if joint.kind == "fixed":
                    pending.append((joint.child, placed))
                else:
                    leaving.append((joint, placed))
        return mass, leaving, frames

    def joint_of(self, joint, placed):
        if joint.kind not in ("revolute", "continuous", "prismatic"):
            kinds = "expected fixed, or revolute, continuous or prismatic, the joints that the program arm drives"
            self.refuse(joint, f'type="{joint.kind}": {kinds}{"; " * (joint.kind in INSTEAD)}{INSTEAD.get(joint.kind, "")}')
        if joint.is_mimic:
            self.refuse(joint, f"expected no <mimic>, because a drive moves each joint of an arm; {FINGERS}")
        bounds = ("effort", "velocity") if joint.kind == "continuous" else ("effort", "velocity", "lower", "upper")
        missing = [name for name in bounds if name not in joint.limit]
        if missing:
            self.refuse(joint, f"no {', '.join(missing)}: expected <limit> with {', '.join(bounds)}, which bound motion and torque")
        if not NAME.fullmatch(joint.name):
            self.refuse(joint, "expected a name of at most 59 letters, digits, '_', '-' and '.', a letter first and not xml, because it is a name in the world")
        turns = {"lower": -2.0 * math.pi, "upper": 2.0 * math.pi}
        limit = joint.limit | (turns if joint.kind == "continuous" else {})
        self.check_limit(joint, limit)
        return Joint(joint.name, placed, joint.axis, limit["lower"], limit["upper"], limit["effort"], limit["velocity"], joint.kind == "prismatic",
                     f"{self.path}:{joint.line}")

    def check_limit(self, joint, limit):
        """Refuse limits that no drive of the project has."""
        if not 0.0 < limit["effort"] <= EFFORT_MAX:
            self.refuse(joint, f'effort="{limit["effort"]:g}": expected more than 0 and at most {EFFORT_MAX:g} Nm or N, as the drives have')
        if not limit["velocity"] >= SPEED_MIN:
            self.refuse(joint, f'velocity="{limit["velocity"]:g}": expected at least {SPEED_MIN:g} rad/s or m/s')
        if not -POSITION_MAX <= limit["lower"] < limit["upper"] <= POSITION_MAX:
            self.refuse(joint, f'lower="{limit["lower"]:g}" upper="{limit["upper"]:g}": expected lower < upper, within +-{POSITION_MAX:g} rad or m')

    def joints_to_tool(self):
        joints = []
        base, leaving, frames = self.rigid(self.root())
        while leaving:
            if len(leaving) > 1:
                self.refuse(leaving[1][0], f"expected one joint after a link, an arm is a chain; there is {leaving[0][0].name}; "
                                        f"give each arm a file of its own, or {FINGERS}")
            found, placed = leaving[0]
            joint = self.joint_of(found, placed)
            joint.link, leaving, frames = self.rigid(found.child)
            if joint.link.mass == 0.0:
                self.refuse(found, f"link {found.child} has no mass: expected <inertial> with <mass> and <inertia> in it, or in a link that a joint with "
                                   'type="fixed" connects to it')
            joints.append(joint)
        if not 1 <= len(joints) <= JOINTS_MAX:
            self.fail(f"{len(joints)} joints that move: expected 1 to {JOINTS_MAX}")
        tool = self.tool or list(frames)[-1]
        if tool not in frames:
            self.fail(f"tool {tool}: expected a link after the last joint: {' '.join(frames)}")
        return joints, frames[tool], tool, base


def read(path, tool=None):
    """The robot of a file; `tool` names the link whose frame is that of the tool, by default the last one after the last joint."""
    document = read_file(path)
    joints, pose, name, base = _Chain(path, document, tool).joints_to_tool()
    return Robot(document.name, joints, pose, name, base)
