# SPDX-License-Identifier: Apache-2.0
"""The schema of worlds and the simulator's reader: every attribute of every element with values at and beyond its limits,
and worlds that contradict themselves. Both must give the same verdict, except where a schema cannot check."""

import math
import pathlib
import re
import subprocess
import xml.etree.ElementTree as ET
from dataclasses import dataclass

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCHEMA = ROOT / "descriptors" / "schema" / "world.xsd"
XS = "{http://www.w3.org/2001/XMLSchema}"
MASS = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
LIMIT = '<limit lower="-1" upper="2" effort="1" velocity="1"/>'
ARM = f"""<robot name="arm"><link name="foot"/><link name="lever">{MASS}{BALL}</link><link name="left">{MASS}</link><link name="right">{MASS}</link>
<joint name="axle" type="revolute"><parent link="foot"/><child link="lever"/>{LIMIT}</joint>
<joint name="near" type="prismatic"><parent link="lever"/><child link="left"/>{LIMIT}</joint>
<joint name="far" type="prismatic"><parent link="lever"/><child link="right"/>{LIMIT}<mimic joint="near"/></joint></robot>"""
BODY = f'<robot name="body"><link name="body">{MASS}{BALL}</link></robot>'
# Every element with every attribute, one element in each line.
WORLD = """<World name="all" step="500us" gravity="0 0 -9.81">
<Robot name="arm" urdf="arm.urdf" base="fixed">
<Start axle="0.5"/>
<StartRate axle="0.1"/>
</Robot>
<Robot name="sat" urdf="body.urdf" base="free">
<State at="1 0 0" rpy="0 0 1" velocity="0 0 1" rate="0 0 0.1" valid="1s" relativeTo="arm.lever"/>
<Spread mass="0.01" inertia="0.02" com="0.001" at="0.1" rpy="0.2" velocity="0.3" rate="0.4"/>
</Robot>
<DriveType name="light" ratio="160" rotorInertia="0.3" stiffness="8000" damping="8" coulomb="2" stiction="2.4" stribeck="0.02" viscous="1" brake="100" stopStiffness="2e4" stopDamping="200" encoderCounts="65536" ripple="0.1" ripplePeriods="3" frictionSpread="0.1" stiffnessSpread="0.1">
<TorqueSensor noise="0.02" offset="0.2" drift="2e-4" range="60" ripple="0.1" ripplePeriods="4"/>
</DriveType>
<Drive name="AXLE" joint="arm.axle" type="light" bus="robot" node="0x11" eds="joint-drive.eds"/>
<Gripper name="CLAW" joint="arm.near" type="light" bus="robot" node="0x12" eds="joint-drive.eds" force="60"/>
<Bench name="BENCH" type="light" bus="bench" node="0x13" eds="joint-drive.eds" contact="1" stiffness="10" range="1.5"/>
<Fixture name="wall" at="0 0 0">
<Box size="1 1 1" at="0 0 0" rpy="0 0 1"/>
<Sphere radius="1" at="0 0 0"/>
<Cylinder radius="1" length="1" at="0 0 0" rpy="0 0 1"/>
</Fixture>
<Contact a="arm.lever" b="wall" stiffness="5000" damping="100" friction="0.3" shear="4000" shearDamping="80"/>
<Contact a="arm.lever" b="sat.body" stiffness="5000" damping="100" friction="0.3"/>
<CableSpring on="arm.lever" hook="0 0 1" catch="0.02" length="0.1" stiffness="500" preload="5" travel="0.002" limit="60"/>
<Joystick name="STICK" bus="stick" node="0x21" eds="joystick.eds" axes="2" inertia="2e-3" friction="0.01" range="0.3" stopStiffness="10" stopDamping="1" encoderCounts="65536"/>
<Hand joystick="STICK" stiffness="3" damping="0.1" positionScale="1" forceScale="0.1" jointStiffness="2667"/>
<PowerUnit name="SUPPLY" bus="robot" node="0x1F">
<Supply device="AXLE"/>
</PowerUnit>
<Wheel name="WHEEL" on="sat.body" axis="0 0 1" momentum="12" torque="0.2" start="-5" gainSpread="0.02" bus="bench" node="0x31" eds="wheel.eds"/>
<ValveBox name="VALVES" bus="bench" node="0x3A" eds="valve-box.eds">
<Valve name="PUSH" on="sat.body" at="0 0 1" direction="1 0 0" force="1" minimum="20ms" output="1"/>
</ValveBox>
<Gyro name="GYRO" on="sat.body" rate="100" noise="1e-5" bias="2e-6" bus="bench" node="0x2B" eds="gyro.eds"/>
<StarTracker name="TRACKER" on="sat.body" rate="5" noise="1e-5 1e-5 1e-5" bus="bench" node="0x2C" eds="star-tracker.eds"/>
<PoseCamera name="CAMERA" on="arm.lever" at="0 0 1" rpy="0 0 1" atSpread="0.001" rpySpread="0.002" sees="sat.body" rate="20" delay="80ms" noise="1 1 1" angleNoise="1 1 1" loss="0.05" bus="bench" node="0x2D" eds="camera.eds"/>
<Latch name="GRASP" a="arm.lever" b="sat.body" distance="0.01" angle="0.1" speed="0.02" when="CLAW" force="15" stall="300ms" release="0.2"/>
<Latch name="DOCK" a="arm.foot" b="sat.body" distance="0.01" angle="0.1" speed="0.02" when="VALVES" output="8"/>
<Instrument name="COVER" type="TCP" channel="192.168.7.3:15002" framing="LENGTH" order="BIG" checksum="true" period="5ms" value="FLOAT" scale="1" offset="2" speed="0.5"/>
</World>
"""
LONG = "a" * 64
# Bad values of each type of the schema; those with limits get more below.
BAD = {
    "Name": ("", "1a", "a b", LONG),
    "LowerIdentifier": ("", "1a", "Aa", "a" * 33),
    "BusName": ("", "Robot", "1a", "a" * 16),
    "Part": ("", "lever", "arm.", "arm." + "a" * 60, ".lever"),
    "Text": ("", LONG),
    "Base": ("", "floating"),
    "Flag": ("", "1", "yes"),
    "Time": ("", "5", "1.5ms", "-1ms", "1h", "0000000001s", "NaNs"),
    "Node": ("", "0", "1", "128", "0x80", "0x1", "-5", "010", "5.5", "0x"),
    "Axes": ("", "0", "1", "3", "0x3", "-2", "02"),
    "Output": ("", "0", "17", "0x11", "-1", "01"),
    "Counts": ("", "0", "-1", "01", "0x100000000", "99999999999"),
    "": ("", "1 other"),  # An attribute whose words the schema lists in place.
}
GOOD = {"Node": ("2", "127", "0x07", "0x7F"), "Axes": ("2", "0x02"), "Output": ("2", "16", "0x10"), "Counts": ("1", "4294967295", "0xFFFFFFFF")}
# (element, attribute, limit) that another attribute or its unit excludes: this limit is not tested as a good value.
NARROWED = {("DriveType", "coulomb", "1e9"), ("DriveType", "stiction", "0"), ("CableSpring", "preload", "1e9"), ("CableSpring", "limit", "1e-9"),
            ("Contact", "shear", "0"), ("Wheel", "momentum", "1e-9"), ("Wheel", "start", "-1e9"), ("Wheel", "start", "1e9"), ("PoseCamera", "rate", "1e4")}


@dataclass
class Case:
    text: str
    line: int
    schema_refuses: bool = True
    reader_refuses: bool = True
    words: str = ""


def line_of(part):
    return WORLD[: WORLD.index(part)].count("\n") + 1


class Schema:
    """The attributes of each element, with their types, as the schema lists them."""

    def __init__(self):
        root = ET.parse(SCHEMA).getroot()
        named = {(node.tag, node.get("name")): node for node in root}
        self.simple = {name: node for (tag, name), node in named.items() if tag == f"{XS}simpleType"}
        self.named = named
        self.found = {}  # (element, attribute) -> (type, is required)
        self.add(root.find(f"{XS}element"))

    def add(self, element):
        kind = element.get("type")
        body = self.named[f"{XS}complexType", kind] if kind else element.find(f"{XS}complexType")
        self.take(element.get("name"), body)

    def take(self, owner, body):
        for node in body:
            if node.tag == f"{XS}attribute":
                self.found[owner, node.get("name")] = (node.get("type", ""), node.get("use") == "required")
            elif node.tag == f"{XS}attributeGroup":
                self.take(owner, self.named[f"{XS}attributeGroup", node.get("ref")])
            elif node.tag == f"{XS}element":
                self.add(node)
            else:
                if node.get("base"):
                    self.take(owner, self.named[f"{XS}complexType", node.get("base")])
                self.take(owner, node)


def limits_of(kind):
    """(lowest, highest) as texts of a type From..To.., or None."""
    found = re.fullmatch(r"From(.+)To(.+)", kind)
    return found.groups() if found else None


def beyond(low, high):
    """Numbers outside of the limits, and what is no number."""
    lower = math.nextafter(float(low), -math.inf)
    return ("", "NaN", "INF", "-INF", "1e400", "one", "1 2", "0x10", repr(lower), repr(math.nextafter(float(high), math.inf)))


VECTORS = {"Vector": ("-1e4", "1e4"), "AngleVector": ("-1e3", "1e3"), "GravityVector": ("-100", "100"), "SizeVector": ("1e-6", "1e4"), "DeviationVector": ("0", "1e3")}


def bad_values(kind):
    if limits_of(kind):
        return beyond(*limits_of(kind))
    if kind in VECTORS:
        return ("", "1 1", "1 1 1 1", *(f"1 {word} 1" for word in beyond(*VECTORS[kind]) if word and " " not in word))
    return (*beyond("-1e9", "1e9"), "0", "-0.0") if kind == "Scale" else BAD[kind]


def good_values(kind):
    if limits_of(kind):
        return limits_of(kind)
    return (" ".join(VECTORS[kind][:1] * 3), " ".join(VECTORS[kind][1:] * 3)) if kind in VECTORS else GOOD.get(kind, ())


def attribute_cases():
    """A case for each attribute of the schema and each value, and for each attribute that is missing."""
    for (element, attribute), (kind, is_required) in Schema().found.items():
        there = re.search(rf'<{element} [^>\n]*?\b{attribute}="([^"]*)"', WORLD)
        assert there, f"the world of this test has no attribute {attribute} of {element}"
        line = WORLD[: there.start()].count("\n") + 1

        def put(value):
            return WORLD[: there.start(1)] + value + WORLD[there.end(1) :]

        for value in bad_values(kind):
            yield f"{element}.{attribute}={value[:20]}", Case(put(value), line)
        for value in good_values(kind):
            if (element, attribute, value) not in NARROWED:
                yield f"{element}.{attribute}={value} is allowed", Case(put(value), line, False, False)
        if is_required:
            start = WORLD.rindex(" ", 0, there.start(1))
            yield f"{element} without {attribute}", Case(WORLD[:start] + WORLD[there.end(1) + 1 :], line)
    for element in sorted({element for element, _ in Schema().found}):
        line = line_of(f"<{element} ")
        yield f"{element}.unknown", Case(WORLD.replace(f"<{element} ", f'<{element} unknown="1" ', 1), line)


def added(text, after, words, schema_refuses=True):
    """A case with a line after the line of an element, which is refused there."""
    lines = WORLD.split("\n")
    place = line_of(after)
    return Case("\n".join([*lines[:place], text, *lines[place:]]), place + 1, schema_refuses, True, words)


def changed(old, new, words, schema_refuses=True):
    """A case with another text in one line."""
    return Case(WORLD.replace(old, new, 1), line_of(old), schema_refuses, True, words)


def repeated(part, words, change=("", ""), schema_refuses=True):
    """A case in which a line occurs twice, the second time with a change."""
    line = WORLD.split("\n")[line_of(part) - 1]
    return added(line.replace(*change, 1) if change[0] else line, part, words, schema_refuses)


ONCE = "expected only one of these in its parent"
CONTRADICTIONS = {
    "start twice": repeated("<Start ", ONCE, ("0.5", "0.6")),
    "start rate twice": repeated("<StartRate ", ONCE),
    "state twice": repeated("<State ", ONCE),
    "spread twice": repeated("<Spread ", ONCE),
    "torque sensor twice": repeated("<TorqueSensor ", ONCE),
    "contact twice": repeated("<Contact ", "a pair that no Contact above has", ("5000", "6000")),
    "contact twice in the other order": added('<Contact a="sat.body" b="arm.lever" stiffness="1" damping="1" friction="1"/>', '<Contact a="arm.lever" b="sat', "a pair that no Contact", False),
    "spring twice": repeated("<CableSpring ", "a hook that no CableSpring above has on this link", ('stiffness="500"', 'stiffness="900"')),
    "spring twice with other digits": repeated("<CableSpring ", "a hook that no CableSpring above has on this link", ("0 0 1", "0.0 0 1e0")),
    "supply twice": repeated("<Supply ", "a device that no Supply above has"),
    "robot twice": added('<Robot name="arm" urdf="body.urdf" base="free"/>', "</Robot>\n<DriveType", "a name that no robot above has"),
    "drive type twice": added('<DriveType name="light" ratio="1" rotorInertia="1" stiffness="1" damping="1" coulomb="1" stiction="1" stribeck="1" viscous="1" '
                              'brake="1" stopStiffness="1" stopDamping="1" encoderCounts="1"/>', "</DriveType>", "a name that no DriveType above has"),
    "joint with two drives": repeated("<Drive ", "a joint that no drive above moves", ('name="AXLE" ', 'name="OTHER" ')),
    "device name twice": repeated("<Bench ", "a name that no device above has", ("0x13", "0x14")),
    "node twice": repeated("<Bench ", "a node id that no device above has", ("BENCH", "OTHER")),
    "node twice in other digits": repeated("<Bench ", "a node id that no device above has", ('BENCH" type="light" bus="bench" node="0x13"', 'OTHER" type="light" bus="bench" node="19"'), False),
    "fixture twice": added('<Fixture name="wall" at="0 0 0"><Sphere radius="1" at="0 0 0"/></Fixture>', "</Fixture>", "a name that no Fixture above has"),
    "valve name twice": repeated("<Valve ", "a name that no Valve above has", ('output="1"', 'output="2"')),
    "valve output twice": repeated("<Valve ", "an output that no Valve above has", ("PUSH", "PULL")),
    "latch name twice": added('<Latch name="GRASP" a="arm.foot" b="sat.body" distance="1" angle="1" speed="1"/>', '<Latch name="DOCK"', "a name that no Latch above has"),
    "latch twice": repeated('<Latch name="GRASP"', "links that no Latch above connects by the same", ("GRASP", "OTHER"), False),
    "latch twice in the other order": repeated('<Latch name="DOCK"', "links that no Latch above connects by the same",
                                               ('DOCK" a="arm.foot" b="sat.body"', 'OTHER" a="sat.body" b="arm.foot"'), False),
    "instrument name twice": repeated("<Instrument ", "a name that no Instrument above has", ("15002", "15003")),
    "channel twice": repeated("<Instrument ", "a channel that no Instrument of this type above has", ("COVER", "OTHER")),
    "instrument named as a bus": repeated("<Instrument ", "a name that no bus has", ('name="COVER" type="TCP" channel="192', 'name="bench" type="TCP" channel="193'), False),
    "bus named as an instrument": Case(WORLD.replace("</World>", '<Instrument name="late" type="SHM" channel="x" period="1ms" value="INT16" speed="1"/>\n'
                                                     '<Bench name="LATE" type="light" bus="late" node="5" eds="e" contact="1" stiffness="0" range="1"/>\n</World>'),
                                       WORLD.count("\n") + 1, False, True, "a name of a bus that no Instrument above has"),
    "two hands": repeated("<Hand ", "at most 1 of them", schema_refuses=False),
    "unknown robot of a joint": changed('joint="arm.axle"', 'joint="leg.axle"', "robot.joint of a robot above", False),
    "unknown joint": changed('joint="arm.axle"', 'joint="arm.elbow"', "robot.joint of a robot above", False),
    "unknown joint of a start": changed('<Start axle=', '<Start elbow=', "a joint of this robot that moves", False),
    "start that is no number": changed('<Start axle="0.5"', '<Start axle="NaN"', "a number inside of the limits", False),
    "start beyond the limits": changed('<Start axle="0.5"', '<Start axle="2.1"', "a number inside of the limits", False),
    "unknown drive type": changed('joint="arm.axle" type="light"', 'joint="arm.axle" type="heavy"', "a DriveType above"),
    "unknown link of a contact": changed('a="arm.lever" b="wall"', 'a="arm.hand" b="wall"', "robot.link of a robot above", False),
    "unknown fixture": changed('b="wall"', 'b="floor"', "a Fixture, or robot.link", False),
    "unknown link of a spring": changed('on="arm.lever" hook', 'on="arm.hand" hook', "robot.link of a robot above", False),
    "unknown joystick": changed('joystick="STICK"', 'joystick="OTHER"', "a Joystick above"),
    "unknown supplied device": changed('<Supply device="AXLE"', '<Supply device="OTHER"', "a device above"),
    "unknown latching device": changed('when="CLAW"', 'when="OTHER"', "a Gripper, Drive or ValveBox above"),
    "unknown link of a state": changed('relativeTo="arm.lever"', 'relativeTo="arm.hand"', "robot.link of another robot", False),
    "missing urdf": changed('urdf="body.urdf"', 'urdf="gone.urdf"', "gone.urdf", False),
    "a device named FLIGHT": changed('name="BENCH"', 'name="FLIGHT"', "another name", False),
    "a fixture without shapes": added('<Fixture name="air" at="0 0 0"/>', "</Fixture>", "a Box, Sphere or Cylinder inside"),
    "a power unit without supplies": changed('<Supply device="AXLE"/>', "", "a Supply inside of the PowerUnit"),
    "stiction below coulomb": changed('stiction="2.4"', 'stiction="1.9"', "a stiction of at least coulomb", False),
    "preload above the limit": changed('preload="5"', 'preload="61"', "a limit of at least the preload", False),
    "damping along a rigid surface": changed('shear="4000" shearDamping="80"', 'shearDamping="80"', "no shearDamping in a contact without shear", False),
    "a wheel without axis": changed('axis="0 0 1"', 'axis="0 0 0"', "a vector of length", False),
    "a thruster without direction": changed('direction="1 0 0"', 'direction="0 0 0"', "a direction other than 0 0 0", False),
    "half of the scales of a hand": changed(' forceScale="0.1"', "", "all of positionScale, forceScale and jointStiffness", False),
    "a step beyond its limits": changed('step="500us"', 'step="99us"', "from 100 to 10000 us", False),
    "a delay beyond its limits": changed('delay="80ms"', 'delay="401ms"', "at most 8 periods of rate", False),
    "too many counts": changed('encoderCounts="65536" ripple', 'encoderCounts="4294967296" ripple', "from 1 to 4.29497e+09", False),
}
# A power unit ends in the line after the one that names the missing element.
CONTRADICTIONS["a power unit without supplies"].line = line_of("<PowerUnit ")
CASES = {"the world as it is": Case(WORLD, 1, False, False), **dict(attribute_cases()), **CONTRADICTIONS}


@pytest.fixture(scope="module")
def probe(tmp_path_factory):
    """A function that returns for each of these worlds what the reader says: `ok`, or the error."""
    program = tmp_path_factory.mktemp("probe") / "probe"
    sources = [ROOT / "test" / "conformance" / "world_probe.c", *sorted(ROOT.glob("sim/world/*.c"))]
    command = ["gcc", "-std=c99", "-D_POSIX_C_SOURCE=200809L", f"-I{ROOT}", "-o", program, *sources, "-lexpat", "-lm"]
    subprocess.run(command, check=True)
    return lambda paths: subprocess.run([program, *paths], capture_output=True, text=True, check=True).stdout.splitlines()


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory, probe):
    """For each case, what the schema and the reader say: None, or the error."""
    directory = tmp_path_factory.mktemp("worlds")
    (directory / "arm.urdf").write_text(ARM, encoding="utf-8")
    (directory / "body.urdf").write_text(BODY, encoding="utf-8")
    paths = {}
    for number, (name, case) in enumerate(CASES.items()):
        paths[name] = directory / f"case-{number}.xml"
        paths[name].write_text(case.text, encoding="utf-8")
    read = probe(paths.values())
    assert len(read) == len(CASES)
    by_schema = {}
    done = subprocess.run(["xmllint", "--noout", "--nonet", "--schema", SCHEMA, *paths.values()], capture_output=True, text=True, check=False)
    for refusal in done.stderr.splitlines():
        found = re.match(r"(.*?/case-\d+\.xml):(\d+): .*", refusal)
        if found:
            by_schema.setdefault(found[1], refusal)
    assert done.stderr.count(" validates") + done.stderr.count(" fails to validate") == len(CASES)
    return {name: (by_schema.get(str(path)), None if line == "ok" else line) for (name, path), line in zip(paths.items(), read)}


def verdict_of(refusal, refuses, case, slack):
    """None if the refusal is the one that the case expects, in the right line; otherwise what is wrong."""
    if (refusal is not None) != refuses:
        return f"expected {'a refusal' if refuses else 'no refusal'}, found {refusal}"
    line = int(re.search(r"\.xml:(\d+): ", refusal)[1]) if refusal and ".xml:" in refusal else case.line
    return None if line - case.line in slack else f"expected line {case.line}: {refusal}"


def test_the_schema_and_the_reader_agree_on_every_attribute_and_every_contradiction(verdicts):
    problems = []
    for name, case in CASES.items():
        by_schema, by_reader = verdicts[name]
        wrong = {"schema": verdict_of(by_schema, case.schema_refuses, case, range(2)), "reader": verdict_of(by_reader, case.reader_refuses, case, range(1))}
        problems += [f"{name}: {end}: {text}" for end, text in wrong.items() if text]
        if case.words and by_reader and case.words not in by_reader:
            problems.append(f"{name}: expected '{case.words}': {by_reader}")
    assert not problems, "\n".join(problems)
    assert len(CASES) > 1000


def test_the_worlds_of_the_project_are_accepted_by_both(probe):
    worlds = sorted((ROOT / "descriptors" / "worlds").glob("*.xml"))
    for path in worlds:
        subprocess.run(["xmllint", "--noout", "--nonet", "--schema", SCHEMA, path], capture_output=True, check=True)
    assert dict(zip(worlds, probe(worlds), strict=True)) == dict.fromkeys(worlds, "ok")
