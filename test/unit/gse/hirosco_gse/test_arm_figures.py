# SPDX-License-Identifier: Apache-2.0
"""Figures of a mission with two arms, which `make new-robot WITH=` makes: each arm has its own, under its name."""

import json
import shutil
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from hirosco_gse import arm_figures, figure_bounds, figures, report, telecommands, tool_figures
from hirosco_gse import run as runs
from hirosco_gse.dictionary import Dictionary
from hirosco_gse.figures_common import Missing
from hirosco_gse.run_directory import ROOT

sys.path.insert(0, str(ROOT / "gse" / "scaffold"))

import new_robot
from new_subsystem import Refusal

LINK = ('<link name="l{0}"><inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>'
        '</inertial></link>')
JOINT = ('<joint name="j{0}" type="{kind}"><origin xyz="0.2 0 0"/><parent link="l{before}"/><child link="l{0}"/><axis xyz="0 {axis}"/>'
         '<limit lower="-1" upper="1" effort="60" velocity="2"/></joint>')
PERIOD_US, END_US = 1000, 2_000_000
ERRORS = {"UR5E": [1e-4, 2e-4, 3e-4, 4e-4, 5e-4, 6e-4], "TESTARM": [7e-4, 8e-4]}  # Error of each joint [rad], of the first joint of TESTARM [m].
CONFIGURATION = 1


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """Directory with the descriptors and scenarios of a mission with the arms UR5E and TESTARM, and its dictionary."""
    place = tmp_path_factory.mktemp("pair")
    (place / "testarm.urdf").write_text(
        '<robot name="testarm">' + "".join(map(LINK.format, range(3))) + JOINT.format(1, before=0, kind="prismatic", axis="1 0")
        + JOINT.format(2, before=1, kind="revolute", axis="0 1") + "</robot>", encoding="utf-8")
    for name in ("descriptors", "sim/scenarios"):
        shutil.copytree(ROOT / name, place / name)
    files, *_ = new_robot.plan(place / "testarm.urdf", None, None, "0.1,0.2", None, "fixed", "ur5e")
    for path, text in files.items():
        assert not path.exists()  # Only new files.
        (place / path.relative_to(ROOT)).write_text(text, encoding="utf-8")
    subprocess.run([sys.executable, ROOT / "gse" / "generator" / "generate.py", "--mission", place / "descriptors/missions/testarm.xml", "--out", place],
                   check=True, cwd=ROOT)
    return place, Dictionary.load(place / "testarm.json")


@pytest.fixture
def run(pair, tmp_path):
    """A flight in which all joints move, each with its constant error; its bounds are those that the scaffold has written."""
    place, dictionary = pair
    facts = {"mission": "testarm", "world": str(place / "descriptors/worlds/testarm.xml"), "scenario": str(place / "sim/scenarios/testarm.scn"), "exit_code": 0}
    (tmp_path / "run.json").write_text(json.dumps(facts), encoding="utf-8")
    flown = runs.Run(tmp_path, dictionary)
    names = [device.joint for device in flown.world.devices if device.joint]
    # The joints of the truth are in another order than those of the arms.
    order = [number for number in range(len(names)) if names[number].startswith("testarm.")] + [n for n in range(len(names)) if names[n].startswith("arm.")]
    errors = np.array([*ERRORS["TESTARM"], *ERRORS["UR5E"]])
    times = np.arange(0, END_US, PERIOD_US)
    desired = 0.1 + 0.1 * np.arange(1, 9) * np.sin(2e-6 * np.pi * times)[:, None]
    flown.truth = {"WORLD": [{"joint": [names[number] for number in order]}],
                   "JOINTS": {"time_us": times, "position_rad": desired + errors, "velocity_rad_s": np.full_like(desired, 0.5),
                              "motor_torque_nm": np.full_like(desired, 6.0), "brake_engaged": np.zeros(desired.shape, int)}}
    flown.reports = [report_of(dictionary.subsystem(name), time_us, desired[time_us // PERIOD_US, place])
                     for time_us in range(0, END_US, 50 * PERIOD_US) for name, place in (("TESTARM", slice(0, 2)), ("UR5E", slice(2, 8)))]
    return flown


def report_of(subsystem, time_us, desired, **more):
    """Housekeeping of an arm in operation. A report has the values of one cycle before."""
    values = {"CUR_VALUES": {"STATE": [arm_figures.OPERATIONAL], "DESIRED": list(desired)}, **more}
    packet = SimpleNamespace(apid=subsystem.apid, message=(3, 25), sequence=0)
    return (time_us + PERIOD_US) * 1000, packet, {"kind": "housekeeping", "configuration_id": CONFIGURATION, "values": values}


def test_each_arm_has_its_own_figures(run):
    found, reasons = figures.compute(run)
    for name, errors in ERRORS.items():
        for number, error in enumerate(errors, 1):
            unit = "m" if (name, number) == ("TESTARM", 1) else "rad"
            assert found[f"{name.lower()}.joint{number}_error_{unit}"] == pytest.approx(error, abs=1e-9)
    # The tool of TESTARM is 0.2 m from its second joint, and its first joint is a slide.
    assert found["testarm.tool_error_m"] == pytest.approx(arm_figures.tool_error(run, name="testarm")) and 7e-4 <= found["testarm.tool_error_m"] < 1e-3
    assert found["ur5e.joint_torque_share"] == pytest.approx(6.0 / 28.0) and found["testarm.joint_torque_share"] == pytest.approx(0.1)
    assert found["ur5e.tool_error_m"] != found["testarm.tool_error_m"]
    assert set(reasons) == {f"{arm}.goal_{name}" for arm, name in (("ur5e", "error_rad"), ("ur5e", "tool_error_m"), ("testarm", "error_rad"), ("testarm", "error_m"))}
    assert set(reasons.values()) == {"no motion was carried out"}


def test_the_goals_of_an_arm_are_those_of_its_own_telecommands(run, monkeypatch):
    """Both arms carry out a MOVE_TO at the same time."""
    times, table = (1_000_000, 1_400_000), run.truth["JOINTS"]
    for sequence, (name, columns) in enumerate((("TESTARM", slice(0, 2)), ("UR5E", slice(2, 8)))):
        apid = run.dictionary.subsystem(name).apid
        reached = table["position_rad"][(times[1] + arm_figures.SETTLE_US) // PERIOD_US, columns]
        decoded = {"function": "MOVE_TO", "values": {"POSITION": list(reached + 0.002 * (sequence + 1))}}
        run.packets.append((times[0] * 1000, "TC", SimpleNamespace(apid=apid, sequence=sequence, message=(8, 1), decoded=decoded), None))
        run.reports.append((times[1] * 1000, SimpleNamespace(apid=1, message=(1, 7)), {"kind": "verification", "request_apid": apid, "request_sequence": sequence}))
    monkeypatch.setattr(telecommands, "decode", lambda packet, _: packet.decoded)
    found, reasons = figures.compute(run)
    assert (found["testarm.goal_error_m"], found["testarm.goal_error_rad"]) == pytest.approx((0.002, 0.002))
    assert found["ur5e.goal_error_rad"] == pytest.approx(0.004)
    assert reasons == {"ur5e.goal_tool_error_m": "no motion had a pose of the tool as its goal"}


def test_a_run_of_two_arms_fails_by_the_figures_of_either(run, pair, capsys):
    """Missing figures and those out of their bounds have a line each, and the report shows them with the names of their arms."""
    path = figure_bounds.path_of(run.facts["scenario"])
    text = path.read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if "goal" not in line and not line.startswith("ur5e.joint1_error")]
    path.write_text("\n".join([*lines, "ur5e.joint1_error_rad <= 5e-5", "tool_error_m <= 1", "left.tool_error_m <= 1"]), encoding="utf-8")
    try:
        facts = report.complete_facts(run)
        assert (facts["exit_code"], facts["figures_hold"]) == (1, False)
        arms = "ur5e, testarm" if list(arm_figures.arms_of(run))[0] == "ur5e" else "testarm, ur5e"
        assert facts["figures_failed"] == [
            "ur5e.joint1_error_rad <= 5e-05: 0.0001",
            f"tool_error_m <= 1: missing: 2 arms (subsystems with GEOMETRY, LIMITS and CUR_VALUES): {arms}; expected one, or the name of the arm and a dot"
            " before the name of the figure",
            f"left.tool_error_m <= 1: missing: no arm left; the arms (subsystems with GEOMETRY, LIMITS and CUR_VALUES) are: {arms}",
        ]
        page = report._side(facts)
        assert "TESTARM: Error of joint 1 from its desired motion" in page and 'title="ur5e.joint1_error_rad"' in page
    finally:
        path.write_text(text, encoding="utf-8")


def test_the_titles_of_figures_have_the_name_of_the_arm():
    assert report.text_of("left.joint12_error_m") == ("LEFT: Error of joint 12 from its desired motion", "m")
    assert report.text_of("joint12_error_m") == ("Error of joint 12 from its desired motion", "m")
    assert report.text_of("left.goal_tool_error_m") == ("LEFT: Error of the tool at the end of a line", "m")
    assert report.text_of("left.hold_motion_rad") == ("left.hold_motion_rad", "")


def test_the_joystick_leads_the_arm_that_reports_its_hand(run, monkeypatch):
    """Both arms have TELEPRESENCE."""
    monkeypatch.setattr(tool_figures, "setting", lambda run, owner, name, field: owner)
    with pytest.raises(Missing, match=r"2 arms that a joystick may have led \((UR5E, TESTARM|TESTARM, UR5E)\), expected one"):
        tool_figures._led(run, "POSITION_SCALE")
    run.reports.append(report_of(run.dictionary.subsystem("TESTARM"), END_US, [0.0, 0.0], HAND={"STATE": [0]}))
    assert tool_figures._led(run, "POSITION_SCALE") == "TESTARM"


def test_the_new_mission_has_all_of_the_other_and_the_new_arm(pair):
    """The arm has drives, buses, permissions and a place of its own; both scenarios and their bounds are there, with one end."""
    place, dictionary = pair
    read = {kind: (place / kind).read_text(encoding="utf-8") for kind in
            ("descriptors/missions/testarm.xml", "descriptors/worlds/testarm.xml", "sim/scenarios/testarm.scn", "sim/scenarios/testarm.bounds")}
    mission, world, scenario, bounds = read.values()
    old = (ROOT / "descriptors/missions/ur5e.xml").read_text(encoding="utf-8")
    assert mission.replace("TESTARM", "UR5E").count('to="UR5E"') == old.count('to="UR5E"') + mission.count('to="TESTARM"') and mission.count('to="TESTARM"') > 10
    assert [bus["name"] for bus in dictionary.buses] == ["arm-1", "arm-2", "testarm-1"]
    assert '<Drive name="TESTARM_JOINT2" joint="testarm.j2" type="testarm_drive' in world and '<State at="0 0.8 0"/>' in world
    times = [float(line.split()[0]) for line in scenario.splitlines() if line and line[0] != "#"]
    assert times == sorted(times) and scenario.count("shutdown") == scenario.count("ping all") == 1 and scenario.rstrip().endswith("operator shutdown")
    assert {line.split(".")[0] for line in bounds.splitlines() if line[0] != "#"} == {"ur5e", "testarm"}


@pytest.mark.parametrize("other, base, words", [
    ("no-such", "fixed", "WITH=no-such: expected an existing mission: actuators, classic, "),
    ("free-flyer", "fixed", "WITH=free-flyer: expected a mission whose world has the gravity 0 0 -9.81, as for this BASE, not 0 0 0"),
    ("ur5e", "free", "WITH=ur5e: expected a mission whose world has the gravity 0 0 0, as for this BASE, not 0 0 -9.81"),
])
def test_a_mission_that_cannot_take_the_arm_is_refused(pair, other, base, words):
    with pytest.raises(Refusal) as refused:
        new_robot.plan(pair[0] / "testarm.urdf", None, None, "0.1,0.2", None, base, other)
    assert words in str(refused.value)
