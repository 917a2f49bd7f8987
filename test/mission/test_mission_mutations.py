# SPDX-License-Identifier: Apache-2.0
"""Descriptors in which a seed has changed one place: each is refused with file and line, or flies; an event
explains each failure in flight.

    build/venv/bin/python -m pytest test/mission/test_mission_mutations.py -k 'seed3'        repeat one seed
    MUTATION_SEEDS=500 build/venv/bin/python -m pytest test/mission/test_mission_mutations.py    a campaign"""

import os
import random
import re
import shutil
import subprocess
import sys

import flying
import pytest

sys.path[:0] = [str(flying.ROOT / "test" / "conformance"), str(flying.ROOT / "gse" / "generator")]

import mission as mission_reader
import test_descriptors as damages
from source import DescriptorError

SEEDS = int(os.environ.get("MUTATION_SEEDS", "8"))
FILES = ("missions/rokviss.xml", "subsystems/joystick.xml", "subsystems/manipulator.xml", "subsystems/communication.xml", "subsystems/supervisor.xml")
PLACE = re.compile(r"\w+\.xml:\d+: ")


def _mutate(place, rng):
    """Change one place of a descriptor until the readers accept the result with the compiled interface.
    Returns the name of the file."""
    plain = mission_reader.load(flying.ROOT / "descriptors" / FILES[0]).interface_hash
    while True:
        name = rng.choice(FILES)
        text = (flying.ROOT / "descriptors" / name).read_text(encoding="utf-8")
        changed = damages.damage(text, rng)
        (place / name).write_text(changed, encoding="utf-8")
        try:
            if changed != text and mission_reader.load(place / FILES[0]).interface_hash == plain:
                return name
        except DescriptorError as error:
            assert PLACE.search(str(error)), error
        (place / name).write_text(text, encoding="utf-8")


@pytest.mark.parametrize("seed", range(SEEDS), ids=lambda seed: f"seed{seed}")
def test_a_descriptor_is_refused_with_its_place_or_flies(directory, seed):
    rng = random.Random(seed)
    directory.mkdir()
    shutil.copytree(flying.ROOT / "descriptors", directory / "descriptors")
    for name in ("build", "sim", "gse"):
        (directory / name).symlink_to(flying.ROOT / name)
    changed = _mutate(directory / "descriptors", rng)
    difference = f"diff {flying.ROOT}/descriptors/{changed} {directory}/descriptors/{changed}"
    flight = flying.fly(directory / "out", "--scenario", "hil", "--form", rng.choice(("image", "processes")), root=directory)
    printed = flight.output + flight.console
    assert "ssertion" not in printed, f"{difference}\n{printed}"
    assert "ended by signal" not in printed, f"{difference}\n{printed}"
    if flight.code != 0 and not PLACE.search(printed):
        assert _explains(flight), f"{difference}\n{flight.transcript()}"
    flying.assert_clean(flight)


def _explains(flight):
    """True if the failure of a flight is explained: a failed step of a transition (0x0301) by an event of a
    subsystem, any other failure by its message."""
    if "0x0301" not in flight.console:
        return re.search(r"FAILED: .+|[Cc]annot|expected", flight.console + flight.output) is not None
    done = subprocess.run([flying.PUSDUMP, flight.directory / "packets.log"], capture_output=True, text=True, check=False)
    return re.search(r" TM (2|16|17) #\d+ \[5,[1-4]\]", done.stdout) is not None
