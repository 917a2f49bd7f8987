# SPDX-License-Identifier: Apache-2.0
"""The tutorial, executed step by step in a copy of the tree, and the logs of its flights."""

import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
from dataclasses import dataclass

import pytest

import flying

TUTORIAL = flying.ROOT / "docs" / "tutorial.md"
BLOCK = re.compile(r"^```(sh|diff|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
# Built files are copied, so that only the additions of the tutorial are compiled.
BUILT = ("bin", "lib", "obj", "generated", "setup", "third_party", "flags", "sanitize")
STEP_LIMIT_S = 900


@dataclass
class Step:
    """A block of commands and the output that the text block after it shows."""

    kind: str
    text: str
    line: int
    expected: str = ""


def read_steps():
    """Steps of the tutorial in order."""
    text = TUTORIAL.read_text(encoding="utf-8")
    steps = []
    for found in BLOCK.finditer(text):
        if found[1] == "text":
            steps[-1].expected = found[2]
        else:
            steps.append(Step(found[1], found[2], text.count("\n", 0, found.start()) + 1))
    return steps


STEPS = read_steps()


def copy_of_tree(place, built=BUILT):
    """A copy of the project with the built files, or with the parts `built` of them."""
    shutil.copytree(flying.ROOT, place, ignore=lambda directory, names: {"build", "runs", ".git", "__pycache__"} & set(names))
    (place / "build").mkdir()
    for name in built:
        source, target = flying.ROOT / "build" / name, place / "build" / name
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("test"), symlinks=True)
        elif source.exists():
            shutil.copy2(source, target)
    for name in ("venv", "station"):
        (place / "build" / name).symlink_to(flying.ROOT / "build" / name)
    return place


class Pupil:
    """A user who follows the tutorial."""

    def __init__(self, place):
        self.place = copy_of_tree(place)
        self.has_failed = False
        self.outputs = {}  # line of the step -> output

    def run(self, command, **how):
        """Run a command as in a user's shell. Returns the finished process."""
        kept = {key: os.environ[key] for key in ("PATH", "HOME", "LANG") if key in os.environ}
        kept["PORT"] = str(flying.free_port())  # Tests that run at the same time may connect to the usual port.
        return subprocess.run(
            command, cwd=self.place, env=kept, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=STEP_LIMIT_S, **how
        )

    def do(self, step):
        """Perform a step. Returns its output."""
        if step.kind == "diff":
            done = self.run(["patch", "-p1", "--fuzz=0", "--no-backup-if-mismatch"], input=step.text)
        else:
            # Each line must succeed. Without `|| exit 1`, bash would not stop at a failed `! command`.
            lines = [f"{line} || exit 1" for line in step.text.splitlines()]
            done = self.run(["bash", "-c", "\n".join(lines)])
        self.outputs[step.line] = done.stdout
        assert done.returncode == 0, done.stdout[-6000:]
        return done.stdout


@pytest.fixture(scope="module")
def pupil(session_directory):
    """One user for the whole tutorial."""
    pupil = Pupil(session_directory / "tutorial")
    yield pupil
    if not pupil.has_failed:
        shutil.rmtree(pupil.place, ignore_errors=True)


def expectation(line):
    """Pattern of an expected line, in which ... matches any text."""
    return ".*".join(re.escape(part) for part in line.split("..."))


def assert_contains(output, expected):
    """Expect these lines in this order; a line that consists of ... matches any number of lines."""
    lines = output.splitlines()
    at = 0
    for line in expected.splitlines():
        if line.strip() == "...":
            continue
        found = next((i for i in range(at, len(lines)) if re.search(expectation(line), lines[i])), None)
        assert found is not None, f"expected: {line}\nafter line {at} of:\n{output[-6000:]}"
        at = found + 1


# The last two sections, a device of another manufacturer and a robot of your own, change nothing for the tests below.
LONG_LINE = TUTORIAL.read_text(encoding="utf-8").partition("\n## 7. ")[0].count("\n") + 1


@pytest.mark.parametrize("step", [pytest.param(step, id=f"line{step.line}-{step.kind}", marks=pytest.mark.long if step.line > LONG_LINE else ())
                                  for step in STEPS])
def test_a_step_gives_the_output_of_the_tutorial(pupil, step):
    if pupil.has_failed:
        pytest.skip("an earlier step failed")
    pupil.has_failed = True
    assert_contains(pupil.do(step), step.expected)
    pupil.has_failed = False


def flights(pupil, scenario):
    """Directories of the flights of a scenario, in order."""
    if pupil.has_failed or not pupil.outputs:
        pytest.skip("the tutorial was not executed")
    return sorted((pupil.place / "runs").glob(f"{scenario}-processes-1-*"))


def reports(directory, apid, message):
    """Fields of the telemetry packets of a message, as pusdump decodes them."""
    done = subprocess.run([flying.PUSDUMP, "--json", directory / "packets.log"], capture_output=True, text=True, check=True)
    entries = [json.loads(line) for line in done.stdout.splitlines()]
    return [e["fields"] for e in entries if (e["direction"], e["apid"], e["service"], e["subtype"]) == ("TM", apid, *message)]


def test_housekeeping_contains_the_values_that_the_drive_sent(pupil):
    """A report has structure 2 once, then five samples; the jaw stops at the object that it touches."""
    first, last = flights(pupil, "grasp")[0], flights(pupil, "grasp")[-1]
    for directory, samples in ((first, 1), (last, 5)):
        found = [bytes.fromhex(r["values"]) for r in reports(directory, 18, (3, 25)) if r["structure"] == 2]
        assert len(found) > 10
        assert {len(octets) for octets in found} == {19 * samples}
        angle, torque, statusword, grip = struct.unpack(">ddHB", found[-1][-19:])
        assert 0.6 < angle < 0.65 and torque > 5.0 and statusword & 0x6F in (0x27, 0x23)
        assert grip == 1, "HOLDING"


def test_event_carries_the_jaw_at_that_moment(pupil):
    """GRASPED samples JAW: the torque exceeds GRASP_TORQUE, and the position is beyond the contact."""
    for directory in flights(pupil, "grasp"):
        (event,) = [e for e in reports(directory, 18, (5, 1)) if e["event"] == 9]
        angle, torque, _, grip = struct.unpack(">ddHB", bytes.fromhex(event["auxiliary"]))
        assert grip == 1
        assert torque > 5.0
        assert 0.6 < angle < 0.65


def test_rate_address_and_method_came_from_the_descriptor(pupil):
    """After changes of the descriptor there are twice as many SYNCs per second, another node, and links by UDP;
    the binaries are the same as before."""
    found = flights(pupil, "grasp")
    first, last = found[0], found[-1]
    for directory, node, link, period_us in ((first, 0x31, "shm", 1000), (last, 0x32, "udp", 500)):
        lines = (directory / "can-gripper.log").read_text(encoding="ascii").splitlines()
        stamps = [int(line[1:18].replace(".", "")) for line in lines if f" {0x180 + node:X}##" in line]
        steps = [b - a for a, b in zip(stamps, stamps[1:])]
        assert sorted(steps)[len(steps) // 2] == period_us
        assert json.loads((directory / "run.json").read_text(encoding="utf-8"))["links"] == link
    programs = [pupil.place / "build" / "bin" / name for name in ("gripper", "dial", "supervisor", "hirosco", "image")]
    assert all(path.stat().st_mtime < (last / "ground.port").stat().st_mtime for path in programs)


def records(directory, name, mark):
    """(time s, octets) of the records that an instrument has sent (>) or received (<)."""
    lines = [line.split(" ") for line in (directory / "records.log").read_text(encoding="ascii").splitlines()]
    return [(float(time), bytes.fromhex(octets)) for time, who, way, octets in lines if (who, way) == (name, mark)]


def test_the_probe_follows_the_motor_over_each_end_node(pupil):
    """By a serial line, then by UDP with the other byte order: the probe stands where the jaw was stopped, and its
    last record is the safe one."""
    found = flights(pupil, "grasp")
    for directory, order in ((found[0], ">"), (found[-1], "<")):
        sent, taken = records(directory, "GRIPPER_PROBE", ">"), records(directory, "GRIPPER_PROBE", "<")
        (value,) = struct.unpack_from(order + "i", next(octets for time, octets in sent if time > 4.5), 3)
        assert 0.6 < value * 1e-6 < 0.65
        assert {octets[0] for time, octets in taken if 2.3 < time < 4.9} == {1}
        assert taken[-1][1][0] == 0


def test_own_failure_and_names_of_numbers_reach_the_ground(pupil):
    """The failure codes are on the wire; XTCE database and dictionary have their names and those of the enumerations."""
    directory = flights(pupil, "gripper")[-1]
    codes = [failure["code"] for failure in reports(directory, 18, (1, 8))]
    assert codes == [0x8001, 0x8002]
    (arrived,) = [e for e in reports(directory, 18, (5, 1)) if e["event"] == 1 and e["auxiliary"].endswith("01")]
    assert struct.unpack(">d", bytes.fromhex(arrived["auxiliary"])[:8])[0] == pytest.approx(0.2)
    generated = pupil.place / "build" / "generated"
    xtce = (generated / "gripper.xtce.xml").read_text(encoding="utf-8")
    dictionary = (generated / "gripper.json").read_text(encoding="utf-8")  # Source of the interface control document.
    for word in ("OBSTRUCTED", "HOLDING", "FAST"):
        assert word in xtce, word
        assert f'"{word}"' in dictionary, word


def test_ground_uses_the_dictionary_of_the_mission_flown(pupil):
    """Without an option, the command line uses the dictionary of the mission of the latest run."""
    latest = pupil.place / "runs" / "latest"
    latest.unlink()  # The tutorial has flown another mission after this one.
    latest.symlink_to(flights(pupil, "grasp")[-1].name)
    done = pupil.run(["gse/gse", "permissions"])
    assert done.returncode == 0, done.stdout
    assert re.search(r"TC\[129,3\] +NOMINAL +to GRIPPER ", done.stdout)
    latest.unlink()
    assert "GRIPPER" not in pupil.run(["gse/gse", "permissions"]).stdout


def test_nothing_was_compiled_for_a_change_of_configuration(pupil):
    """After these changes make starts neither a compiler nor a linker."""
    flights(pupil, "grasp")
    at = next(step.line for step in STEPS if step.kind == "diff" and 'links="UDP"' in step.text)
    # Here a new class of devices is compiled.
    end = next(step.line for step in STEPS if "jaw-drive.eds" in step.text)
    outputs = [text for line, text in pupil.outputs.items() if at < line < end]
    assert len(outputs) >= 3
    for text in outputs:
        assert not re.search(r"^  (gcc|link) ", text, re.MULTILINE), text


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "NAME=: expected a name"),
        ({"NAME": "Gripper"}, "NAME=Gripper: expected 2 to 24 lower-case"),
        ({"NAME": "2fast"}, "NAME=2fast: expected"),
        ({"NAME": "a-b"}, "NAME=a-b: expected"),
        ({"NAME": "x" * 25}, "expected 2 to 24"),
        ({"NAME": "switch"}, "NAME=switch: expected a name that is neither a keyword of C"),
        ({"NAME": "../evil"}, "NAME=../evil: expected"),
        ({"NAME": "drives"}, "NAME=drives: expected another name: drives_t is declared already, in fsw/drives/drives.h:"),
        ({"NAME": "component_runtime"}, "NAME=component_runtime: expected another name: component_runtime_t is declared already, in fsw/programs/"),
        ({"NAME": "parameter"}, "NAME=parameter: expected another name: PARAMETER_APID is declared already, in fsw/framework/parameter/parameter.h:"),
        ({"NAME": "gripper_parameters"}, "gripper_parameters_t is declared already, in fsw/subsystems/gripper/"),
        ({"NAME": "size"}, "NAME=size: expected a name that is not a type of C: size_t is one"),
        ({"NAME": "uint_least8"}, "NAME=uint_least8: expected a name that is not a type of C"),
        ({"NAME": "joystick"}, "there is already descriptors/subsystems/joystick.xml"),
        ({"NAME": "newcomer", "APID": "16"}, "; this is MANIPULATOR in descriptors/subsystems/"),
        ({"NAME": "newcomer", "APID": "0"}, "APID=0: expected a number from 1 to 2046"),
        ({"NAME": "newcomer", "APID": "2047"}, "APID=2047: expected a number from 1 to 2046"),
        ({"NAME": "newcomer", "MISSION": "nowhere"}, "MISSION=nowhere: expected an existing mission: "),
    ],
)
def test_new_subsystem_refuses_and_changes_nothing(pupil, options, words):
    flights(pupil, "grasp")
    before = snapshot(pupil.place)
    done = pupil.run(["make", "new-subsystem", *(f"{key}={value}" for key, value in options.items())])
    assert done.returncode != 0
    assert words in done.stdout
    assert snapshot(pupil.place) == before


def snapshot(place):
    """Every source file with its modification time."""
    directories = ("descriptors", "fsw", "sim", "test/unit")
    return {path: path.stat().st_mtime_ns for directory in directories for path in pathlib.Path(place, directory).rglob("*")}


@pytest.mark.long
def test_long_and_short_names_fly_in_the_house_format(pupil):
    """Subsystems with names of 2 and of 24 characters: formatted, compiled without a warning, flown in both
    forms."""
    flights(pupil, "grasp")
    for name, apid in (("ox", "300"), ("a_star_tracker_of_size24", "2046")):
        done = pupil.run(["make", "new-subsystem", f"NAME={name}", f"APID={apid}", "MISSION=gripper"])
        assert done.returncode == 0, done.stdout
        assert re.search(rf'id="{apid}"', (pupil.place / f"descriptors/subsystems/{name.replace('_', '-')}.xml").read_text())
    done = pupil.run(["make"])
    assert done.returncode == 0, done.stdout
    sources = [str(path) for directory in ("fsw/subsystems", "fsw/programs", "test/unit/fsw/subsystems") for path in (pupil.place / directory).rglob("*.[ch]")]
    assert pupil.run(["clang-format", "--dry-run", "-Werror", *sources]).returncode == 0
    for scenario in ("ox", "a-star-tracker-of-size24"):
        for form in ("processes", "image"):
            flight = flying.fly(pupil.place / "runs" / f"{scenario}-{form}", "--mission", "gripper", "--scenario", scenario, "--form", form, root=pupil.place)
            assert flight.code == 0, flight.transcript()
            flying.assert_clean(flight)
        logs = [(pupil.place / "runs" / f"{scenario}-{form}" / "packets.log").read_bytes() for form in ("processes", "image")]
        assert logs[0] == logs[1]
    done = pupil.run(["make", "new-subsystem", "NAME=newcomer", "MISSION=gripper"])
    assert done.returncode != 0
    assert "descriptors/missions/gripper.xml: has 8 buses, expected fewer, because the new subsystem needs one of its own" in done.stdout
