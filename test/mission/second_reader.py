# SPDX-License-Identifier: Apache-2.0
"""A mission with a port that feeds two readers: rokviss with a second arm, SHADOW, which also reads
HAND_POSITION. SHADOW is the manipulator's code compiled for a descriptor with another name and id; its two
joints are motor benches on a separate bus."""

import pathlib
import shutil
import subprocess
import sys

import flying

sys.path.insert(0, str(flying.ROOT / "gse" / "generator"))

import c_header
import subsystem

FLIGHT = ("base", "fsw", "osal", "pus")
MEMBERS = ("JOYSTICK", "MANIPULATOR", "SHADOW")
READERS = {"MANIPULATOR": "HAND_POSITION", "SHADOW": "SHADOWED"}
LISTED = '    <Subsystem name="SHADOW" id="18" executable="shadow" descriptor="../subsystems/shadow.xml" restarts="5"/>\n'
LINKED = '    <Link name="SHADOWED" from="JOYSTICK.HAND_POSITION" to="SHADOW.HAND_POSITION"/>\n'
BENCH = '  <Bench name="{}" type="light" bus="bench" node="{}" eds="joint-drive.eds" contact="10" stiffness="0" range="1.5707963267948966"/>\n'


def _link_all(source, tree, but=()):
    tree.mkdir()
    for entry in source.iterdir():
        if entry.name not in but:
            (tree / entry.name).symlink_to(entry)


def _descriptors(tree):
    """Copy the descriptors and add SHADOW. Returns the path of SHADOW's descriptor."""
    shutil.copytree(flying.ROOT / "descriptors", tree)
    arm, shadow = tree / "subsystems" / "manipulator.xml", tree / "subsystems" / "shadow.xml"
    text = arm.read_text(encoding="utf-8").replace('name="MANIPULATOR" id="16"', 'name="SHADOW" id="18"', 1)
    text = text.replace('bus="robot" redundantBus="robot-b"', 'bus="bench"')
    shadow.write_text("\n".join(line for line in text.split("\n") if "<Supply " not in line and 'object="0x2000:03"' not in line), encoding="utf-8")
    mission = tree / "missions" / "rokviss.xml"
    text = mission.read_text(encoding="utf-8")
    for after, more in (("  </Subsystems>", LISTED), ("  </Links>", LINKED), ("  </Buses>", '    <Bus name="bench" bitRate="1000000" dataBitRate="5000000"/>\n')):
        text = text.replace(after, more + after)
    for old, new in (('select="TELEPRESENCE" to="MANIPULATOR"', 'select="TELEPRESENCE" to="SHADOW"'),):
        rule = next(line for line in text.split("\n") if old in line)
        text = text.replace(rule, rule + "\n" + rule.replace(old, new))
    for rule in [line for line in text.split("\n") if 'select="HAND_POSITION" to="SUPERVISOR"' in line]:
        text = text.replace(rule, rule + "\n" + rule.replace("HAND_POSITION", "SHADOWED"))
    mission.write_text(text.replace('name="rokviss"', 'name="shadow"', 1), encoding="utf-8")
    mission.rename(mission.with_name("shadow.xml"))
    world = tree / "worlds" / "rokviss.xml"
    benches = BENCH.format("SHADOW1", "0x11") + BENCH.format("SHADOW2", "0x12")
    text = world.read_text(encoding="utf-8").replace('name="rokviss"', 'name="shadow"', 1).replace("</World>", benches + "</World>")
    world.with_name("shadow.xml").write_text(text, encoding="utf-8")
    return shadow


def _gcc(tree, *words):
    include = [f"-I{directory}" for directory in (tree / "build" / "shadow", flying.ROOT, flying.ROOT / "build")]
    command = ["gcc", "-std=c99", "-D_POSIX_C_SOURCE=200809L", "-O1", *include, *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def _link(name, tree, tops, objects, *externals):
    directories = {path.parent.relative_to(flying.ROOT) for top in tops for path in (flying.ROOT / top).rglob("*.c")}
    libraries = [flying.ROOT / "build" / "lib" / f"lib{'_'.join(directory.parts)}.a" for directory in sorted(directories)]
    _gcc(tree, "-o", tree / "build" / "bin" / name, *objects, "-Wl,--start-group", *filter(pathlib.Path.exists, libraries), "-Wl,--end-group", "-Wl,--as-needed", *externals,
         "-lexpat", "-llua5.4", "-lnettle", "-lpthread", "-lm")


def _compile(tree, descriptor):
    """Compile the manipulator's sources with the ids of another descriptor under the same names, as a program
    and into an image."""
    model = subsystem.load(descriptor)
    model.name = "MANIPULATOR"
    made = tree / "build" / "shadow"
    (made / "generated").mkdir(parents=True)
    (made / "generated" / "manipulator_descriptor.h").write_text(c_header.header(model, descriptor.name), encoding="utf-8")
    listed = (flying.ROOT / "build" / "generated" / "programs.h").read_text(encoding="utf-8")
    (made / "generated" / "programs.h").write_text(listed + 'COMPONENT(shadow, "shadow")\n', encoding="utf-8")
    own = [path for path in flying.ROOT.glob("fsw/programs/manipulator_*.c") if not path.name.endswith("_main.c")]
    arm = [*own, *flying.ROOT.glob("fsw/subsystems/manipulator/*.c")]
    main = [path for path in flying.ROOT.glob("fsw/programs/manipulator_*.c") if path.name.endswith("_main.c")]
    _link("shadow", tree, FLIGHT, [*arm, *main])
    # The image also contains the manipulator, whose functions have the same names: all functions of SHADOW
    # become local, except the one that opens it.
    _gcc(tree, "-r", "-o", made / "arm.o", *arm)
    command = ["objcopy", "--redefine-sym", "manipulator_open=shadow_open", "--keep-global-symbol=shadow_open", made / "arm.o", made / "shadow.o"]
    subprocess.run(command, check=True)
    image = [flying.ROOT / "fsw" / "programs" / "component_instance.c", flying.ROOT / "launcher" / "image_main.c"]
    _link("image", tree, (*FLIGHT, "launcher", "sim"), [made / "shadow.o", *image], "-lode", "-llcm", "-lsqlite3")


def build(tree):
    """A copy of the project's directory with this mission in it."""
    tree.mkdir(parents=True)
    descriptor = _descriptors(tree / "descriptors")
    (tree / "sim").symlink_to(flying.ROOT / "sim")
    shutil.copytree(flying.ROOT / "gse", tree / "gse", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("base", "fsw", "pus"):
        (tree / name).symlink_to(flying.ROOT / name)
    _link_all(flying.ROOT / "build", tree / "build", ("bin", "generated", "test"))
    shutil.copytree(flying.BIN, tree / "build" / "bin")
    _compile(tree, descriptor)
    command = [sys.executable, tree / "gse" / "generator" / "generate.py", "--mission", tree / "descriptors" / "missions" / "shadow.xml",
               "--out", tree / "build" / "generated"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return tree


def fly(tree, directory, scenario, *options):
    """Fly a scenario in that directory to its end."""
    return flying.fly(directory, "--mission", "shadow", "--scenario", scenario, *options, root=tree)
