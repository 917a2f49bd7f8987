# SPDX-License-Identifier: Apache-2.0
"""Worlds and scenarios of press and hold with values other than those of the mission."""

import random
import re

import flying

CASES = 60
WORLDS = flying.ROOT / "descriptors" / "worlds"
SCENARIO = flying.ROOT / "sim" / "scenarios" / "press.scn"


def _set(text, element, **attributes):
    """Change attributes of the only element of a name."""
    for name, value in attributes.items():
        text, count = re.subn(rf'(<{element} [^>]*\b{name}=")[^"]*"', rf'\g<1>{value:.12g}"', text)
        assert count == 1, (element, name)
    return text


def write_world(directory, base="rokviss", masses=(1.0, 1.0), contact=None, hand=None, drive=None):
    """A world like `base` in a directory; masses are factors of both links. Returns the path of the world."""
    directory.mkdir(parents=True, exist_ok=True)
    urdf = (WORLDS / "rokviss.urdf").read_text(encoding="utf-8")
    parts = iter(masses)
    scaled = []
    for link in re.split(r"(?=<link )", urdf):
        if "<mass" in link and 'name="base"' not in link:
            factor = next(parts)
            link = re.sub(r'((?:mass value|ixx|iyy|izz)=")([^"]*)"', lambda found, factor=factor: f'{found[1]}{float(found[2]) * factor!r}"', link)
        scaled.append(link)
    assert next(parts, None) is None
    (directory / "rokviss.urdf").write_text("".join(scaled), encoding="utf-8")
    text = (WORLDS / f"{base}.xml").read_text(encoding="utf-8")
    text = _set(text, "Contact", **(contact or {}))
    text = _set(text, "Hand", **(hand or {}))
    text = _set(text, "DriveType", **(drive or {}))
    path = directory / "world.xml"
    path.write_text(text, encoding="utf-8")
    return path


def write_scenario(directory, x, force):
    """Write press.scn for another place and another force. Returns its path."""
    text = SCENARIO.read_text(encoding="utf-8")
    text = text.replace("move 0.28 -0.020", f"move {x:.4f} -0.020").replace("press 15 ", f"press {force:.3f} ")
    path = directory / "press.scn"
    path.write_text(text, encoding="utf-8")
    return path


def random_case(directory, seed, base="rokviss"):
    """World and scenario of a random case: (world, scenario, force)."""
    rng = random.Random(seed)
    x, force = rng.uniform(0.23, 0.39), rng.uniform(3, 30)
    stiffness = 2000 * 10 ** rng.uniform(0, 1)
    friction = rng.uniform(0.6, 1.0)
    is_rigid = rng.random() < 0.5
    world = write_world(
        directory,
        base,
        masses=(rng.uniform(0.95, 1.05), rng.uniform(0.95, 1.05)),
        contact={
            "stiffness": stiffness,
            "friction": rng.uniform(0.1, 0.4),
            "shear": 0 if is_rigid else 0.8 * stiffness,
            "shearDamping": 0 if is_rigid else 80,
        },
        hand={"stiffness": rng.uniform(1.5, 4.5), "damping": rng.uniform(0.05, 0.15)},
        drive={"coulomb": 2 * friction, "stiction": 2.4 * friction},
    )
    return world, write_scenario(directory, x, force), force
