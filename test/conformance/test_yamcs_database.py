# SPDX-License-Identifier: Apache-2.0
"""Yamcs' own reader loads the generated database of a mission, with the generated configuration. It needs no flight and takes two seconds
for each mission. Each run of the tests loads those of two missions (OFTEN), LONG=1 those of all. test_yamcs.py flies with Yamcs."""

import json
import pathlib
import re
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "gse" / "yamcs"), str(ROOT / "gse")]

import run as yamcs_run

OFTEN = ("actuators", "rokviss")
MISSIONS = [pytest.param(path.stem, marks=[] if path.stem in OFTEN else pytest.mark.long)
            for path in sorted((ROOT / "descriptors" / "missions").glob("*.xml"))]
pytestmark = pytest.mark.skipif(bool(yamcs_run.lacking("rokviss")), reason="Yamcs is not installed: make setup")


def verified(place, mission):
    """Result of `yamcsadmin mdb verify` for the configuration of a mission."""
    words = ["java", "-Xmx256m", "-cp", f"{yamcs_run.LIBRARIES}/*", "org.yamcs.cli.YamcsAdminCli", "--etc-dir", place / "etc", "mdb", "verify", "mission"]
    return subprocess.run(words, cwd=place, capture_output=True, text=True, check=False)  # yamcsadmin writes a directory `cache` into its working directory.


@pytest.mark.parametrize("mission", MISSIONS)
def test_yamcs_loads_the_database_of_the_mission(mission, tmp_path):
    yamcs_run.render(tmp_path, mission, 10015, 8080)
    done = verified(tmp_path, mission)
    assert done.returncode == 0 and "MDB loaded successfully" in done.stdout, done.stdout + done.stderr
    contents = {what: int(count) for count, what in re.findall(r"(\d+) (subsystems|parameters|sequence containers|commands)", done.stdout)}
    database = (yamcs_run.GENERATED / f"{mission}.xtce.xml").read_text(encoding="utf-8")
    assert contents["commands"] == len(re.findall(r"<MetaCommand ", database)) > 200
    assert contents["sequence containers"] == len(re.findall(r"<SequenceContainer ", database)) > 100
    dictionary = json.loads((yamcs_run.GENERATED / f"{mission}.json").read_text(encoding="utf-8"))
    assert contents["subsystems"] >= len(dictionary["subsystems"]) and contents["parameters"] > 500


def test_yamcs_refuses_a_database_with_a_type_that_does_not_exist(tmp_path, monkeypatch):
    """So the test above can fail."""
    mission = OFTEN[0]
    database = (yamcs_run.GENERATED / f"{mission}.xtce.xml").read_text(encoding="utf-8")
    damaged = tmp_path / "damaged.xtce.xml"
    damaged.write_text(re.sub(r'arrayTypeRef="[^"]*/statusword"', 'arrayTypeRef="nothing"', database, count=1), encoding="utf-8")
    assert damaged.read_text(encoding="utf-8") != database
    yamcs_run.render(tmp_path, mission, 10015, 8080)
    etc = tmp_path / "etc" / "yamcs.mission.yaml"
    etc.write_text(etc.read_text(encoding="utf-8").replace(str(yamcs_run.GENERATED / f"{mission}.xtce.xml"), str(damaged)), encoding="utf-8")
    done = verified(tmp_path, mission)
    assert done.returncode != 0 and "nothing" in done.stdout + done.stderr, done.stdout + done.stderr
