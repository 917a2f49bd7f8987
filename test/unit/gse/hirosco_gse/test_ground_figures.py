# SPDX-License-Identifier: Apache-2.0
"""Figures on synthetic logs with known answers; every figure must be able to fail."""

import copy
import json
import struct

import numpy as np
import pytest
import synthetic
from hirosco_gse import figures, logs, packet_log, report
from hirosco_gse import run as runs
from hirosco_gse import truth as truth_log
from hirosco_gse.dictionary import Dictionary


@pytest.fixture(scope="module")
def flown(flight_directory, dictionary_path):
    return runs.Run(flight_directory, Dictionary.load(dictionary_path))


@pytest.fixture
def run(flown):
    """A copy of the run; a test may change its arrays."""
    return copy.deepcopy(flown)


def value(run, name):
    return figures.compute(run)[0][name]


def test_figures_of_the_synthetic_flight_have_the_known_values(flown):
    found, reasons = figures.compute(flown)
    assert not reasons
    assert all(figures.holds(name, found[name]) for name in figures.BOUNDS)
    assert found["latency_forward_cycles"] == synthetic.FORWARD
    assert found["latency_back_cycles"] == synthetic.BACK
    assert found["tracking_error"] == pytest.approx(synthetic.TRACKING_ERROR, rel=0.05)
    assert found["tracking_periods"] == pytest.approx(4, abs=0.01)
    assert found["tracking_frequency_hz"] == pytest.approx(0.5, abs=0.002)
    assert found["reflection_error"] == pytest.approx(synthetic.REFLECTION_ERROR, rel=0.1)
    assert found["reflection_error_contour"] == pytest.approx(synthetic.REFLECTION_ERROR_CONTOUR, rel=0.1)
    assert found["contact_force_max_n"] == pytest.approx(15.0)
    assert found["unplug_reaction_s"] == pytest.approx(synthetic.UNPLUG_REACTION_US / 1e6)
    assert found["unplug_members_reported"] is True
    assert found["torque_limit_reaction_cycles"] == synthetic.LIMIT_REACTION
    assert found["brake_engagements"] == 4
    assert found["engagements"] == 4
    assert found["free_drag_nm"] < 0.005
    assert found["press_ripple_nm"] < 0.05
    assert found["follow_transparency"] < 0.02


def _later(cycles, names, lag):
    for name in names:
        cycles.words[name] = np.roll(cycles.words[name], lag)


@pytest.mark.parametrize("lag", [1, 2, 3])
def test_forward_latency_is_seen(run, lag):
    for cycles in run.joint_cst:
        _later(cycles, ["torque"], lag)
    assert value(run, "latency_forward_cycles") == lag
    assert figures.holds("latency_forward_cycles", lag) == (lag <= 2)


@pytest.mark.parametrize("lag", [1, 2])
def test_back_latency_is_seen(run, lag):
    _later(run.stick_rpdo, ["0", "1"], lag)
    assert value(run, "latency_back_cycles") == 1 + lag
    assert figures.holds("latency_back_cycles", 1 + lag) == (lag <= 1)


def test_no_answer_to_encoder_counts_gives_no_latency(run):
    for cycles in run.joint_cst:
        cycles.words["torque"][:] = np.random.default_rng(3).normal(0, 100, run.count)
    found, reasons = figures.compute(run)
    assert found["latency_forward_cycles"] is None
    assert "no clear answer to encoder counts" in reasons["latency_forward_cycles"]
    assert not figures.holds("latency_forward_cycles", None)


def test_no_answer_to_noise_gives_no_latency(run):
    run.stick_rpdo.words["0"][:] = 5
    run.stick_rpdo.words["1"][:] = 5
    assert value(run, "latency_back_cycles") is None


def test_the_tracking_error_depends_on_gain_and_not_on_lag(run):
    clean = value(run, "tracking_error")
    for cycles in run.joint_tpdo:
        _later(cycles, ["position"], 5)
    assert value(run, "tracking_error") == pytest.approx(clean, rel=0.05)
    assert figures.tracking(run)["tracking_lag_cycles"] == 5
    for cycles in run.joint_tpdo:
        middle = cycles.words["position"].mean()
        cycles.words["position"] = (middle + 1.02 * (cycles.words["position"] - middle)).astype(np.int64)
    assert value(run, "tracking_error") > 0.01


def test_the_tracking_error_needs_three_periods(run):
    verbs = run.truth["OPERATOR"]["verb"]
    verbs[(run.truth["OPERATOR"]["time_us"] > 8_000_000) & (verbs == "circle")] = "rest"
    found, reasons = figures.compute(run)
    assert found["tracking_error"] is None
    assert "periods" in reasons["tracking_error"]


@pytest.mark.parametrize(("name", "window"), [("reflection_error", (28, 37)), ("reflection_error_contour", (16, 25))])
def test_the_reflection_error_shows_a_wrong_mean(run, name, window):
    part = slice(int(window[0] / synthetic.DT), int(window[1] / synthetic.DT))
    run.stick_rpdo.words["0"][part] = (run.stick_rpdo.words["0"][part] * 1.03).astype(np.int64)
    assert value(run, name) == pytest.approx(0.03, abs=0.01)
    assert not figures.holds(name, value(run, name))


def test_the_reflection_error_needs_a_force(run):
    run.truth["CONTACT"]["external_torque_nm"][:] *= 0.1
    assert value(run, "reflection_error") is None


@pytest.mark.parametrize("second", [20.0, 33.0])
def test_motion_in_either_hold_is_seen(run, second):
    run.stick_tpdo.words["1"][int(second / synthetic.DT)] += 1500
    assert value(run, "hold_motion_rad") == pytest.approx(0.0015, rel=0.01)


def test_motion_before_the_window_does_not_count(run):
    run.stick_tpdo.words["1"][int(17.0 / synthetic.DT)] += 1500
    assert value(run, "hold_motion_rad") < 0.001


def test_lost_contact_and_peaks_are_seen(run):
    contact = run.truth["CONTACT"]
    at = int(18.0 / synthetic.DT)
    contact["in_contact"][at : at + 400] = False
    contact["contact_force_n"][at + 400, 2] = 30.0
    assert value(run, "contact_share") == pytest.approx(1 - 400 / (11.0 / synthetic.DT), abs=1e-4)
    assert not figures.holds("contact_share", value(run, "contact_share"))
    assert value(run, "contact_force_max_n") == pytest.approx(30.0)


def test_an_arm_that_falls_is_detected(run):
    run.truth["JOINTS"]["position_rad"][synthetic.OVER + 200 :, 1] -= 0.002
    assert value(run, "brake_drop_rad") == pytest.approx(0.002)


def test_a_jerk_at_engagement_is_seen(run):
    run.joint_tpdo[1].words["position"][synthetic.ENGAGE + 10 :] += 1200
    assert value(run, "engagement_step_rad") == pytest.approx(0.0012)


def test_a_later_motion_is_no_jerk(run):
    run.joint_tpdo[1].words["position"][synthetic.ENGAGE + 50 :] += 1200
    assert value(run, "engagement_step_rad") < 0.001


def test_a_torque_step_at_engagement_is_seen(run):
    run.joint_cst[0].words["torque"][synthetic.ENGAGE :] += 600
    assert value(run, "engagement_step_rad") == pytest.approx(0.0015, abs=1e-4)


def test_a_jump_of_the_position_command_is_seen(run):
    run.joint_csp, run.joint_cst = run.joint_cst, run.joint_csp
    for joint, cycles in enumerate(run.joint_csp):
        cycles.words["position"] = run.joint_tpdo[joint]["position"] + 3000
    assert value(run, "engagement_step_rad") == pytest.approx(0.003)


def test_lost_link_samples_are_detected(run):
    for _, _, decoded in run.reports_of("links"):
        decoded["rows"][0]["lost"] = 3
    assert value(run, "link_lost") == 3
    run.reports = [report for report in run.reports if report[2]["kind"] not in ("links", "housekeeping")]
    assert value(run, "link_lost") is None


def test_a_slow_drive_is_detected(run):
    for entry in run.truth["DRIVE"]:
        if entry["bus"] == "robot" and entry["node"] == 0x12 and entry["time_us"] > synthetic.UNPLUG * 500:
            entry["time_us"] += 4000
    assert value(run, "unplug_reaction_s") == pytest.approx(0.007)


def test_a_drive_that_stays_enabled_gives_no_figure(run):
    run.truth["DRIVE"] = [e for e in run.truth["DRIVE"] if e["time_us"] < synthetic.UNPLUG * 500 or e["node"] != 0x11]
    assert value(run, "unplug_reaction_s") is None


def test_a_member_that_did_not_react_is_found(run):
    run.reports = [
        r for r in run.reports if not (r[2].get("state") == "ERROR_OPERATIONAL" and r[1].apid == 16)
    ]
    assert value(run, "unplug_members_reported") is False


def test_a_slow_answer_to_the_limit_is_seen(run):
    for cycles in run.joint_cst:
        cycles.words["control"][synthetic.OVER : synthetic.OVER + 4] = 0x0F
    assert value(run, "torque_limit_reaction_cycles") == 4


def test_no_answer_to_the_limit_gives_no_figure(run):
    for cycles in run.joint_cst:
        cycles.words["control"][:] = 0x0F
    assert value(run, "torque_limit_reaction_cycles") is None


DELAYS_MS = (20, 100, 300)
FACTS = [{"mission": mission, "scenario": scenario, "joystick_count_rad": count, "relay": {"round_trip_ms": delay_ms}}
         for mission, scenario in figures.TABLES for count in (6e-6, 9.5e-5) for delay_ms in DELAYS_MS]


def test_every_figure_with_a_bound_is_computed_and_has_a_text_and_a_unit():
    bounded = set()
    for facts in FACTS:
        bounds = figures.bounds_of(facts)
        assert bounds
        computed = {name for _, names in figures.TABLES[facts["mission"], facts["scenario"]][0] for name in names}
        assert set(bounds) <= computed <= set(report.TEXTS) | {"joystick_count_rad", "follow_transparency"}
        bounded |= set(bounds)
    for name in bounded:
        text, unit = report.TEXTS[name]
        assert text
        assert unit == "" or name.endswith(("_" + unit.lower(), "_cycles", "lost")), name


@pytest.mark.parametrize(("mission", "scenario"), [("actuators", "actuators"), ("ur5e-telepresence", "press"), ("ur5e", "telepresence"), (None, None)])
def test_a_flight_of_another_mission_has_no_figures(run, mission, scenario):
    run.facts = {"mission": mission, "scenario": scenario} if mission else {}
    assert figures.compute(run) == ({}, {})
    assert figures.bounds_of(run.facts) == {}


def test_another_scenario_of_the_mission_has_figures_without_bounds(run):
    run.facts["scenario"] = "my-scenario.scn"
    assert figures.compute(run)[0]["tracking_error"] > 0
    assert figures.bounds_of(run.facts) == {}


@pytest.mark.parametrize("problem", [KeyError("JOINTS"), IndexError("7"), AttributeError("x"), ZeroDivisionError("x"), ValueError("x")])
def test_a_figure_that_cannot_be_computed_leaves_the_others(run, monkeypatch, problem):
    def fail(_):
        raise problem

    monkeypatch.setitem(figures.TABLES, ("rokviss", "telepresence"), (((fail, ("tracking_error",)), *figures.FIGURES[:2]), lambda facts: figures.BOUNDS))
    found, reasons = figures.compute(run)
    assert found["tracking_error"] is None
    assert reasons == {"tracking_error": f"{type(problem).__name__}: {problem}"}
    assert found["latency_back_cycles"] == synthetic.BACK


def test_an_empty_directory_has_reasons_for_everything(tmp_path, dictionary):
    (tmp_path / "run.json").write_text(json.dumps({"mission": "rokviss", "scenario": "telepresence"}))
    run = runs.Run(tmp_path, dictionary)
    found, reasons = figures.compute(run)
    for name in figures.BOUNDS:
        assert found[name] is None
        assert reasons[name]


def test_lines_of_a_bus_log_are_read_or_refused():
    text = b"(0000000001.000500) robot 191##5010203040506070A\n(0000000002.123456) robot 080#\n(0000000002.200000) robot 20000024#0008000000000000\n"
    bus = logs.parse_bus(text)
    assert list(bus.time_us) == [1_000_500, 2_123_456, 2_200_000]
    assert [hex(i) for i in bus.id] == ["0x191", "0x80", "0x20000024"]
    assert list(bus.length) == [8, 0, 8]
    assert list(bus.is_fd) == [True, False, False]
    assert bus.data[0].tobytes().hex() == "010203040506070a"
    assert bus.field(np.array([0]), 2, "i4")[0] == 0x06050403
    assert len(logs.parse_bus(b"")) == 0
    assert len(logs.parse_bus(text + b"(0000000003.0")) == 3  # The last line is incomplete.
    for wrong in (b"hello world, this is no frame\n", b"(0000000001.000500) robot 191\n", b"(1.5) robot 191#00\n"):
        with pytest.raises(logs.LogError, match=r"line 4: found '.{5,}', expected \(seconds\) bus id#octets"):
            logs.parse_bus(text + wrong)


def test_lines_of_a_packet_log_are_read_or_refused(dictionary):
    from hirosco_gse import packets

    raw = packets.build_tc(16, 0, 17, 1)
    line = f"12.000500000 TC {raw.hex()}\n"
    found = packet_log.parse_packets([line, "\n", f"13.000000000 TC {raw.hex()[:-1]}0\n", "14.0000"])
    assert found[0][0] == 12_000_500_000
    assert found[0][2].message == (17, 1)
    assert found[1][2] is None
    assert len(found) == 2
    for wrong in ("x\n", "1.0 TC 00\n", "1.000000000 TX 00\n", "1.000000000 TC zz\n"):
        with pytest.raises(logs.LogError, match=":1:"):
            packet_log.parse_packets([wrong])


def test_a_truth_log_that_is_cut_is_read_up_to_the_cut(flight_directory, tmp_path):
    octets = (flight_directory / "truth.lcm").read_bytes()[: 1_000_003]
    channels = logs.parse_lcm(octets)
    assert len(channels["JOINTS"][0]) > 1000
    with pytest.raises(logs.LogError, match="octet 0: found 0x00000000, expected the sync word 0xEDA1DA01"):
        logs.parse_lcm(b"\0" * 100)


def _event(body):
    return b"\x11" * 8 + struct.pack(">q", 500_000) + body


def _channel(*events):
    """Content of a channel, as logs.parse_lcm returns it."""
    ends = np.cumsum([len(octets) for octets in events])
    return np.zeros(len(events), np.int64), logs.Events(b"".join(events), np.concatenate([[0], ends[:-1]]), ends)


def test_truth_has_all_joints_and_what_is_in_the_world():
    joints = _event(struct.pack(">i21d3B", 3, *range(21), 0, 1, 0))
    bases = _event(struct.pack(">i26d", 2, *range(26)))
    wheels = _event(struct.pack(">i4d", 2, *range(4)))
    names = _event(struct.pack(">I6sII3s", 6, b"WHEEL\0", 1, 3, b"W1\0"))
    truth = runs.decode_truth({"NAMES": _channel(names), "JOINTS": _channel(joints), "BASE": _channel(bases), "WHEEL": _channel(wheels)})
    assert truth["WHEEL"]["momentum_nms"].tolist() == [[0, 1]] and truth["WHEEL"]["torque_nm"].tolist() == [[2, 3]]
    assert truth["JOINTS"]["velocity_rad_s"].tolist() == [[3, 4, 5]]
    assert truth["JOINTS"]["external_torque_nm"].tolist() == [[18, 19, 20]]
    assert truth["JOINTS"]["brake_engaged"].tolist() == [[False, True, False]]
    assert truth["BASE"]["rotation"].tolist() == [[[6, 7, 8, 9], [10, 11, 12, 13]]]
    assert "CONTACT" not in truth and "STICK" not in truth
    springs = _event(struct.pack(">i12d2?", 2, *range(12), True, False))
    scene = runs.decode_truth({"JOINTS": _channel(joints), "SPRING": _channel(springs)})["CONTACT"]
    assert scene["tip_m"].tolist() == [[0, 1, 2]] and scene["spring_force_n"].tolist() == [[6, 7, 8]]
    assert scene["spring_hooked"].tolist() == [True] and scene["in_contact"].tolist() == [False]


def test_events_give_their_first_octets_and_a_short_one_is_refused():
    _, events = _channel(b"abcd", b"efg", b"hij")
    assert [bytes(octets) for octets in events] == [b"abcd", b"efg", b"hij"] and bytes(events[2]) == b"hij"
    assert events.heads(3) == b"abcefghij" and events.heads(2) == b"abefhi"
    with pytest.raises(logs.LogError, match="an event has 3 octets, expected 4"):
        events.heads(4)
    none = logs.Events(b"", np.zeros(0, np.int64), np.zeros(0, np.int64))
    assert len(none) == 0 and none.heads(4) == b""


def test_a_log_is_read_event_by_event_though_its_data_look_like_events():
    def event(time_us, name, data):
        return struct.pack(">IQQII", 0xEDA1DA01, 0, time_us, len(name), len(data)) + name + data

    inner = event(9, b"NONE", b"123")
    whole = event(1, b"A", inner) + event(2**33, b"LONGER", b"x") + event(3, b"A", b"\xed\xa1\xda\x01" * 9) + event(4, b"B", b"")
    for octets in (whole, whole + inner[:20], whole + inner[:-1]):
        found = {name: (times.tolist(), [bytes(data) for data in events]) for name, (times, events) in logs.parse_lcm(octets).items()}
        assert found == {"A": ([1, 3], [inner, b"\xed\xa1\xda\x01" * 9]), "LONGER": ([2**33], [b"x"]), "B": ([4], [b""])}
    with pytest.raises(logs.LogError, match=f"octet {len(whole)}: found 0x78787878, expected the sync word"):
        logs.parse_lcm(whole + b"x" * 28)


def test_a_row_that_was_left_out_equals_the_row_before():
    table = {"time_us": np.array([500, 100_500, 137_000, 137_500]), "x": np.array([1, 1, 1, 2])}
    assert truth_log.at(table, "x", [0, 500, 99_000, 137_000, 137_499, 137_500, 140_000], 140_000).tolist() == [1, 1, 1, 1, 1, 2, 2]
    assert np.isnan(truth_log.at(table, "x", [140_001], 140_000)).all()


def test_contacts_springs_and_joints_have_common_times_although_rows_are_left_out():
    def rows(*times):
        return {"time_us": np.array(times)}

    contact = {**rows(500, 1000, 3000), "place_m": np.arange(9.0).reshape(3, 1, 3), "point_m": np.zeros((3, 1, 3)),
               "force_n": np.arange(9.0).reshape(3, 1, 3), "is_touching": np.array([[False], [True], [False]])}
    spring = {**rows(500, 2000), "place_m": np.zeros((2, 1, 3)), "force_n": np.ones((2, 1, 3)), "is_hooked": np.array([[False], [True]])}
    joints = {**rows(500, 2500), "external_torque_nm": np.array([[1.0], [2.0]])}
    scene = runs.scene({"CONTACT": contact, "SPRING": spring, "JOINTS": joints})
    assert scene["time_us"].tolist() == [500, 1000, 2000, 2500, 3000]
    assert scene["in_contact"].tolist() == [False, True, True, True, False]
    assert scene["spring_hooked"].tolist() == [False, False, True, True, True]
    assert scene["external_torque_nm"][:, 0].tolist() == [1, 1, 1, 2, 2]
    assert scene["contact_force_n"][:, 0].tolist() == [0, 3, 3, 3, 6]


def test_a_cut_truth_log_is_a_problem_of_the_run(tmp_path):
    cut = _event(struct.pack(">q", 4096))
    (tmp_path / "truth.lcm").write_bytes(struct.pack(">IQQII", 0xEDA1DA01, 0, 2_500_000, 3, len(cut)) + b"CUT" + cut)
    assert any("truth.lcm: cut at 2.500 s" in problem for problem in runs.load(tmp_path).problems)


def test_a_run_that_has_not_ended_is_read_with_the_mission_that_the_launcher_names(tmp_path):
    (tmp_path / "ground.mission").write_text("ur5e\n", encoding="utf-8")
    run = runs.load(tmp_path)
    assert run.problems == []
    assert run.dictionary.mission == run.world.name == "ur5e"
    assert {joint.bus for joint in run.joints} == {"arm-1", "arm-2"}


def test_a_truth_log_of_other_types_is_a_problem_of_the_run(tmp_path):
    joints = _event(struct.pack(">i", 0))
    for name, reported in ((b"JOINTS", "channel JOINTS has the fingerprint 0x1111111111111111"), (b"NOTHING", "channel NOTHING has no type")):
        head = struct.pack(">IQQII", 0xEDA1DA01, 0, 500, len(name), len(joints))
        (tmp_path / "truth.lcm").write_bytes(head + name + joints)
        run = runs.load(tmp_path)
        assert any(reported in problem for problem in run.problems), run.problems
        assert run.truth == {"DRIVE": [], "FAULT": []}


@pytest.mark.parametrize("text", ["", "struct a_t { int32_t x; }", "struct a_t { int64_t time_ns; other_t x; }"])
def test_a_type_that_cannot_be_read_is_refused(text):
    with pytest.raises(truth_log.TruthError, match="a_t.lcm: expected a struct"):
        truth_log.parse(text, "a_t.lcm")


def test_truth_is_read_as_lcm_reads_it(flight_directory):
    lcm = pytest.importorskip("lcm")
    channels = logs.read_lcm(flight_directory / "truth.lcm")
    counts, first = {}, {}
    for event in lcm.EventLog(str(flight_directory / "truth.lcm"), "r"):
        counts[event.channel] = counts.get(event.channel, 0) + 1
        first.setdefault(event.channel, (event.timestamp, event.data))
    assert counts == {name: len(times) for name, (times, _) in channels.items()}
    for name, (timestamp, data) in first.items():
        assert channels[name][0][0] == timestamp
        assert bytes(channels[name][1][0]) == data
