# SPDX-License-Identifier: Apache-2.0
"""History, kinematics, strips of a robot, pace of pictures and what is under way, of the page (gse/page/src/), run by Node.js."""

import gzip
import json
import math
import pathlib
import struct
import subprocess

import pytest

SOURCES = pathlib.Path(__file__).resolve().parents[4] / "gse" / "page" / "src"
TABLES = """
const hour = new Float64Array(180000), value = new Float64Array(180000);
for (let n = 0; n < 180000; n++) { hour[n] = n / 50; value[n] = Math.sin(n / 9000); }
value[77777] = 5; value[123456] = -7;
const history = new History([{ t: hour, leaves: new Map([["X", [value]]]) }], (name) => name, 1);
"""


@pytest.fixture(scope="module")
def modules(tmp_path_factory):
    directory = tmp_path_factory.mktemp("page")
    for name in ("arm_strips", "bus_devices", "history", "kinematics", "pace", "recording", "under_way"):
        text = (SOURCES / f"{name}.js").read_text(encoding="utf-8")
        (directory / f"{name}.mjs").write_text(text.replace('.js";', '.mjs";'), encoding="utf-8")
    return directory


def printed(directory, script):
    """The JSON that an ECMAScript script prints."""
    (directory / "test.mjs").write_text(f'import {{ History }} from "./history.mjs";\nimport {{ apart, columnsFor, firstMeasured, isLowest, stripsOf }} from "./arm_strips.mjs";\nimport {{ agesOf, busOf, devicesOn, stateOf }} from "./bus_devices.mjs";\nimport {{ controlsMotor, jointsOf, leadOf, placedByTelemetry, placedByTruth, poses, posesBetween, tipForce, unitAt }} from "./kinematics.mjs";\nimport {{ Pace }} from "./pace.mjs";\nimport {{ unpack }} from "./recording.mjs";\nimport {{ ledTo, planOf, secondsOf, underWay }} from "./under_way.mjs";\n{script}')
    done = subprocess.run(["node", directory / "test.mjs"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_line_over_an_hour_has_its_extremes_at_each_pixel(modules):
    times, values = printed(modules, TABLES + """
        const line = { of: (row) => row.X[0] };
        console.log(JSON.stringify(history.drawn([line], [0, 3600], 900)));""")
    assert 1750 < len(times) < 1850 and all(a < b for a, b in zip(times, times[1:]))
    assert max(values) == 5 and min(values) == -7
    # Each of the 900 pixels covers 4 s of the hour.
    assert abs(times[values.index(5)] - 77777 / 50) < 4 and abs(times[values.index(-7)] - 123456 / 50) < 4


def test_a_short_part_is_drawn_with_all_samples(modules):
    times, values = printed(modules, TABLES + "console.log(JSON.stringify(history.drawn([{ of: (row) => row.X[0] }], [1555, 1556], 900)));")
    assert times[0] == 1555 and times[-1] == pytest.approx(1556.02) and len(times) == 52
    assert values[27] == 5


def test_tables_are_one_history_with_gaps(modules):
    found = printed(modules, """
        const table = (t, name) => ({ t: Float64Array.from(t), leaves: new Map([[name, [Float64Array.from(t), Float64Array.from(t)]]]) });
        const history = new History([table([0, 2, 10], "A"), table([1, 3], "B")], (name) => name.toLowerCase(), 1.5);
        const far = new History([table([0, 1, 2, 3, 100, 101, 102, 103], "A")], (name) => name, 5);
        console.log(JSON.stringify([[...history.t], [0, 1, 2, 3, 4, 5, 6, -1].map((n) => history.row(n)), far.drawn([{ of: (row) => row.A[1] }], [0, 103], 2)]));""")
    assert found[0] == [0, 1, 2, 3, 3.001, 10]
    assert found[1] == [{"a": [0, 0]}, {"b": [1, 1]}, {"a": [2, 2]}, {"b": [3, 3]}, None, {"a": [10, 10]}, None, None]
    assert None in found[2][1] and [value for value in found[2][1] if value is not None][:2] == [0, 3]


def test_each_robot_is_placed_by_its_own_entries_of_the_truth(modules):
    found = printed(modules, """
        const joint = { name: "j", kind: "prismatic", parent: "body", child: "tip", axis: [1, 0, 0], pose: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] };
        const robot = (name) => ({ name, root: "body", start: { j: 0.5 }, links: { body: [], tip: [] }, joints: [joint], at: [1, 0, 0, 7, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] });
        const names = { joints: ["a.j", "b.j"], bases: ["b"] };
        const row = { "CUR_VALUES.POSITION": [2, 3], BRAKE: [1, 0], BASE: [1, 2, 3, Math.SQRT1_2, 0, 0, Math.SQRT1_2] };
        const tip = (one) => { const { positions, base } = placedByTruth(one, row, names); return poses(one, positions, base).links.get("tip"); };
        console.log(JSON.stringify([placedByTruth(robot("a"), row, names), placedByTruth(robot("b"), row, names).brakes, tip(robot("b")),
          placedByTelemetry(robot("a"), { "CUR_VALUES.POSITION": [9] }, true, null, null), placedByTruth(robot("a"), undefined, {})]));""")
    assert found[0]["positions"] == [2] and found[0]["base"][3] == 7 and found[0]["brakes"] == [True] and found[1] == [False]
    # The base is rotated by 90 degrees about z, so the joint moves the link by 3 m along y of the world.
    assert [found[2][3], found[2][7], found[2][11]] == pytest.approx([1, 5, 3])
    assert found[3]["positions"] == [9] and found[3]["brakes"] is None
    assert found[4]["positions"] == [0.5]


def test_telemetry_places_the_lead_robot_and_the_truth_what_it_does_not_contain(modules):
    """The base is that of telemetry, if it reports one, else that of the truth. Brakes are those of drives that have one, by their
    statuswords: released in operation enabled, quick stop active and fault reaction active."""
    found = printed(modules, """
        const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
        const joint = (name) => ({ name, kind: "revolute", parent: "body", child: name, axis: [0, 0, 1], pose: identity });
        const robot = (name) => ({ name, root: "body", free: true, start: {}, links: {}, joints: [joint("j1"), joint("j2")], braked: ["j1"], at: identity });
        const truth = { names: { joints: ["b.j1", "b.j2", "a.j1", "a.j2"], bases: ["a", "b"] },
          row: { "CUR_VALUES.POSITION": [0.1, 0.2, 0.3, 0.4], BRAKE: [1, 1, 1, 1], BASE: [1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 1, 0, 0, 0] } };
        const row = (one, other) => ({ "CUR_VALUES.POSITION": [5, 6], "CUR_VALUES.STATUSWORD": [one, other] });
        const brief = ({ positions, base, brakes }) => [positions, base[3], brakes];
        const lead = (one, other, base, given) => brief(placedByTelemetry(robot("a"), row(one, other), true, base, given));
        console.log(JSON.stringify([lead(0x0237, 0x0237, null, truth), lead(0x0233, 0x0233, [7, 0, 0, 1, 0, 0, 0], truth), lead(0x0217, 0, null, null),
          brief(placedByTelemetry(robot("b"), row(0x0237, 0x0237), false, null, truth)), brief(placedByTelemetry(robot("a"), undefined, true, null, truth)),
          [0x0250, 0x0231, 0x0233, 0x0237, 0x0217, 0x021f, 0x0218].map(controlsMotor)]));""")
    assert found[0] == [[5, 6], 1, [False, None]]
    assert found[1] == [[5, 6], 7, [True, None]]
    assert found[2] == [[5, 6], 0, [False, None]]
    assert found[3] == [[0.1, 0.2], 2, None]
    assert found[4] == [[0.3, 0.4], 1, None]
    assert found[5] == [False, False, False, True, True, True, False]


def test_an_attitude_turns_by_the_shorter_way_between_two_reports(modules):
    """The attitude makes a quarter turn about z, from -45 to 45 degrees; the quaternion of the second report has the other sign. Bases are interpolated one by one."""
    half = 2 ** -0.5
    found = printed(modules, f"""
        const c = Math.cos(Math.PI / 8), s = Math.sin(Math.PI / 8);
        const from = [0, 0, 0, c, 0, 0, -s, 1, 1, 1, 1, 0, 0, 0], to = [2, 0, 0, -c, 0, 0, -s, 1, 1, 1, {half}, {half}, 0, 0];
        console.log(JSON.stringify([0, 0.5, 1].map((share) => posesBetween(from, to, share))));""")
    assert found[1][:7] == pytest.approx([1, 0, 0, 1, 0, 0, 0])
    assert found[2][3:7] == pytest.approx([math.cos(math.pi / 8), 0, 0, math.sin(math.pi / 8)])
    assert found[1][7:] == pytest.approx([1, 1, 1, math.cos(math.pi / 8), math.sin(math.pi / 8), 0, 0])
    assert all(math.hypot(*row[n:n + 4]) == pytest.approx(1) for row in found for n in (3, 10))


def test_an_incomplete_recording_is_refused(modules):
    """The recordings are not compressed, have no end or have a damaged head; only the last one is whole."""
    head = b'{"tables": [{"rows": 2, "per": 1, "leaves": []}]}'
    whole = gzip.compress(struct.pack("<I", len(head)) + head + bytes(8))
    files = [b"no recording", whole[:40], gzip.compress(struct.pack("<I", len(head)) + head + bytes(7)), gzip.compress(b"\2\0\0\0{]"), whole]
    found = printed(modules, f"""
        const all = {[list(octets) for octets in files]}.map((octets) => unpack(Uint8Array.from(octets)).then(() => "read", (error) => error.message));
        console.log(JSON.stringify(await Promise.all(all)));""")
    assert found[2] == "its end is missing" and found[4] == "read" and "read" not in found[:4], found


def test_pictures_that_take_too_long_get_fewer_pixels_and_short_ones_more(modules):
    """Three pictures in succession that take longer than the budget reduce the pixels; twenty that leave room for twice as many increase them."""
    found = printed(modules, """
        const pace = new Pace(), scales = [];
        const note = (took, count) => { for (let n = 0; n < count; n++) pace.note(0, took); scales.push(pace.scale); };
        for (const [took, count] of [[26, 2], [25, 1], [26, 2], [26, 1], [26, 6], [400, 9], [12, 19], [13, 1], [12, 19], [12, 1], [12, 20], [1, 60]]) note(took, count);
        console.log(JSON.stringify(scales));""")
    assert found == [1, 1, 1, 0.7, 0.5, 0.5, 0.5, 0.5, 0.5, 0.7, 1, 1]


def test_a_pause_follows_each_picture(modules):
    """The pause is as long as the last picture took, but at most a second; from picture to picture at least 40 ms pass."""
    found = printed(modules, """
        const pace = new Pace(), waits = [pace.wait(7)];
        for (const took of [5, 30, 800, 9000]) { pace.note(100, 100 + took); waits.push(pace.wait(100 + took)); }
        waits.push(pace.wait(1e6));
        console.log(JSON.stringify(waits));""")
    assert found == [0, 35, 30, 800, 1000, 0]


ARM = """
const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const arm = (...kinds) => ({ name: "arm", root: "l0", start: {}, joints: kinds.map((kind, n) => (
    { name: `j${n}`, kind, parent: `l${n}`, child: `l${n + 1}`, axis: [0, 0, 1], pose: identity })),
    links: Object.fromEntries([...Array(kinds.length + 1).keys()].map((n) => [`l${n}`, []])) });
const row = { "CUR_VALUES.POSITION": [0, 1, 2, 3, 4, 5, 6, 7], "CUR_VALUES.TORQUE": [10, 11, 12, 13, 14, 15, 16, 17],
    "CUR_VALUES.EXTERNAL_TORQUE": [20, 21], "CUR_VALUES.DESIRED": [30, 31] };
const told = (strips) => strips.map(({ title, unit, lines }) => [title, unit, ...lines.map((line) => [line.name, line.of(row)])]);
"""


def test_strips_show_every_joint_and_torques_under_their_own_name(modules):
    """Torques that contain those of gravity are not called external. With more than two joints, the name of a line is only the number of its joint."""
    planar, spatial = printed(modules, ARM + """
        const turning = Array(2).fill("revolute");
        console.log(JSON.stringify([told(stripsOf(arm(...turning), ["CUR_VALUES.TORQUE", "CUR_VALUES.EXTERNAL_TORQUE"], () => 9)),
            told(stripsOf(arm("prismatic", "fixed", ...turning, ...turning, ...turning), ["CUR_VALUES.TORQUE"], () => 9))]));""")
    force = ["Force at the tip", "N", ["from joint torques", 9]]
    assert planar == [["Joint position", "rad", ["POSITION.1", 0], ["POSITION.2", 1], ["desired 1", 30], ["2", 31]],
                      ["External torque", "Nm", ["EXTERNAL.1", 20], ["EXTERNAL.2", 21]], force]
    assert spatial == [["Joint position", "m", ["1", 0]],
                       ["Joint position", "rad", *([f"{n + 1}", n] for n in range(1, 5))],
                       ["Joint position", "rad", *([f"{n + 1}", n] for n in range(5, 7))],
                       ["Joint force", "N", ["1", 10]],
                       ["Joint torque", "Nm", *([f"{n + 1}", 10 + n] for n in range(1, 5))],
                       ["Joint torque", "Nm", *([f"{n + 1}", 10 + n] for n in range(5, 7))], force]


def test_names_at_the_ends_of_curves_do_not_cover_each_other(modules):
    """They stay in order and between the edges of the plot."""
    found = printed(modules, """
        console.log(JSON.stringify([[30, 10, 12, 60], [100, 99, 101], [-4, -8], [], [50]].map((wanted) => apart(wanted, 10, 0, 100))));""")
    assert found == [[30, 10, 20, 60], [90, 80, 100], [10, 0], [], [50]]


def test_the_lines_of_a_strip_have_different_colours(modules):
    """The colour of desired values is not that of a fourth joint."""
    names = printed(modules, ARM + """
        console.log(JSON.stringify(stripsOf(arm(...Array(4).fill("revolute")), [], () => 9)[0].lines.map((line) => line.colour)));""")
    assert len(set(names)) == 4 and "desired" not in names


def test_the_force_at_the_tip_is_that_which_the_subsystem_reports(modules):
    """The force is in the axes of the base, which is turned by 90 degrees about z. Without a reported force, it follows from the external torques."""
    told, computed, truth = printed(modules, ARM + """
        const base = [0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7, 0, 0, 0, 1];
        const lead = leadOf({ robots: [{ ...arm(), name: "client" }, arm("prismatic")], drives: { JOINT1: "arm.j0" } });
        const force = (row) => tipForce(lead, { "CUR_VALUES.POSITION": [0], ...row }, [0], base);
        console.log(JSON.stringify([force({ "CUR_VALUES.TOOL_FORCE": [3, 0, 4] }), force({ "CUR_VALUES.EXTERNAL_TORQUE": [2] }),
            force({ "CUR_VALUES.TOOL_FORCE": [3, 0, 4], FORCE: [0, 0, 1] })].map((found) => [found.force, found.size])));""")
    assert told == [[0, 3, 4], 5]
    assert computed[0] == pytest.approx([0, 0, 2], abs=1e-4)
    assert truth == [[0, 0, 1], 1]


def test_a_number_of_a_joint_has_the_unit_of_its_kind(modules):
    """In a list of another length, for a subsystem without joints, and for a command that is an angle or a torque, the unit remains as the
    descriptor has it."""
    found = printed(modules, ARM + """
        const world = { robots: [arm("revolute"), { ...arm("revolute", "fixed", "prismatic"), name: "lift" }], drives: { AXIS: "lift.j2" } };
        const joints = jointsOf(world, ["CAMERA", "AXIS"]), leaf = (count, unit) => ({ count, unit });
        console.log(JSON.stringify([...[0, 1].map((n) => unitAt(leaf(2, "rad/s or m/s"), n, joints)), unitAt(leaf(2, "Nm"), 1, joints),
            unitAt(leaf(3, "rad or m"), 1, joints), unitAt(leaf(2, "rad or Nm"), 0, joints), unitAt(leaf(2, "rad or m"), 1, jointsOf(world, ["CAMERA"])), jointsOf(null, ["AXIS"])]));""")
    assert found == ["rad/s", "m/s", "Nm", "rad or m", "rad or Nm", "rad or m", []]


def test_one_function_makes_the_heads_of_tables():
    assert [path.name for path in sorted(SOURCES.glob("*.js")) if '"thead"' in path.read_text(encoding="utf-8")] == ["dom.js"]


def test_more_than_three_strips_are_in_two_columns(modules):
    """The last strip of each column has the time axis."""
    found = printed(modules, """
        console.log(JSON.stringify([1, 3, 4, 5, 6].map((count) => [columnsFor(count), [...Array(count).keys()].filter((n) => isLowest(n, count))])));""")
    assert found == [[1, [0]], [1, [2]], [2, [2, 3]], [2, [3, 4]], [2, [4, 5]]]


MOMENT = """
const plans = [{ name: "GRIPLESS", severity: "HIGH", subsystem: "HAND", event: "DEVICE_LOST", actions: [{ do: "LOG" }, { do: "MODE", mode: "SAFE", after: "2s" }] },
    { name: "NETWORK_DOWN", severity: "HIGH", actions: [{ do: "STATE", target: "NETWORK", state: "OFFLINE", after: "500ms" }] },
    { name: "EASE", severity: "MEDIUM", actions: [{ do: "STATE", target: "SELF", state: "SAFE_OPERATIONAL" }] }];
const started = { event: "PLAN_STARTED", time: 10, values: { APID: "ARM", EVENT: "DEVICE_LOST" } };
const lanes = new Map([["ARM", [[3, "OPERATIONAL"], [10.001, "ERROR_OPERATIONAL"], [10.52, "OFFLINE"]]]]);
const at = (time, more = {}) => underWay({ time, events: [started], commands: [], plans, lanes, phases: [], severityOf: () => "HIGH", ...more });
const said = (found) => found && [found.title, found.note, found.share === null ? null : Number(found.share.toFixed(3)), ...found.steps.map(({ words, is, time }) => `${is} ${words} ${time}`.trim())];
"""


def test_a_recovery_plan_is_under_way_until_its_last_state_is_reached(modules):
    """Its first step is the reaction that precedes each plan. Its end is shown for 2 s, and a plan of a higher severity ends it at once. A step
    whose process has died is not waited for."""
    found = printed(modules, MOMENT + """
        const over = { event: "PLAN_OVERRULED", time: 10.1, values: { APID: "ARM", EVENT: "DEVICE_LOST", BY_APID: "ARM", BY_EVENT: "PROCESS_LOST" } };
        console.log(JSON.stringify([at(10.31), at(10.6), at(12.4), at(12.6), at(10.31, { events: [started, over] }), at(10.4, { severityOf: () => "MEDIUM" }),
            at(14, { lanes: new Map() }), at(16, { lanes: new Map() }), at(10.31, { plans: [] })].map(said)));""")
    done, last = "done network to ERROR_OPERATIONAL 10.0010 s", "done network to OFFLINE 10.5200 s"
    assert found[0] == ["Plan NETWORK_DOWN", "running, step 2 of 2", 0.62, done, "running network to OFFLINE in 0.2 s"]
    assert found[1] == found[2] == ["Plan NETWORK_DOWN", "completed", 1, done, last]
    assert found[3] is None and found[4] is None
    assert found[5] == ["Plan EASE", "running, step 1 of 1", None, "running ARM to SAFE_OPERATIONAL"]
    assert found[6][1] == "running, step 1 of 2" and found[7][1] == "completed"
    assert found[8][0] == "Plan built in" and found[8][4] == "running network to OFFLINE in 0.2 s"


def test_a_plan_is_that_of_the_event_or_of_its_severity(modules):
    names, seconds = printed(modules, MOMENT + """
        const name = (...event) => planOf(plans, ...event)?.name ?? null;
        console.log(JSON.stringify([[name("HIGH", "HAND", "DEVICE_LOST"), name("HIGH", "ARM", "DEVICE_LOST"), name("MEDIUM", "HAND", "X"), name("LOW", "HAND", "X")],
            ["500ms", "2s", "250us", undefined, "odd"].map(secondsOf)]));""")
    assert names == ["GRIPLESS", "NETWORK_DOWN", "EASE", None]
    assert seconds == [0.5, 2, pytest.approx(250e-6), 0, 0]


def test_a_procedure_a_command_and_a_phase_are_under_way(modules):
    """A plan precedes a procedure, this a command, and this a phase of the scenario."""
    found = printed(modules, MOMENT + """
        const seen = (WHAT, STEP, PROCEDURE = "SWING") => ({ event: "PROCEDURE_OBSERVED", time: 20, values: { PROCEDURE, WHAT, STEP } });
        const call = (text, lights, more) => ({ text, time: 20, lights, over: false, ...more });
        const begun = ["done", "done", "empty", "waiting"], move = call("cmd ARM.MOVE_TO POSITION=1,2 DURATION=4", begun), phases = [[18, 28, "follow"]];
        console.log(JSON.stringify([
            at(21, { events: [started, seen("STARTED", 0), seen("STEP", 3), seen("ENDED", 1, "OTHER")], commands: [move], phases }),
            at(21, { events: [seen("STEP", 3), seen("ENDED", 3)], commands: [move], phases }), at(21, { events: [seen("HELD", 2)] }),
            at(23, { events: [], commands: [call("state ARM OFFLINE", begun), call("ping", ["done", "waiting", "empty", "empty"]), call("x", begun, { over: true })] }),
            at(25, { events: [], commands: [move] }), at(23, { events: [], phases }), at(28, { events: [], phases })].map(said)));""")
    assert found == [["Procedure SWING", "running, step 3", None], ["cmd ARM.MOVE_TO POSITION=1,2 DURATION=4", "3.0 s to go", 0.25],
                     ["Procedure SWING", "suspended, step 2", None], ["state ARM OFFLINE", "for 3.0 s", None],
                     ["cmd ARM.MOVE_TO POSITION=1,2 DURATION=4", "ends now", 1], ["follow", "5.0 s to go", 0.5], None]


def test_a_mission_without_a_robot_charts_the_display_structure_that_is_reported(modules):
    """A page that is open enables the display structure. A recording without one has reports of the other structure only."""
    found = printed(modules, """
        const structure = (id, display, leaves) => ({ id, display, leaves });
        const valves = { name: "VALVES", parameters: [{ name: "STATE", type: "UINT8" }], configurations: [{ structures: [structure(9, true, ["STATE"])] }] };
        const parameters = [{ name: "LEVEL", type: "DOUBLE" }, { name: "COUNT", type: "UINT32" }];
        const tank = { name: "TANK", parameters, configurations: [{ structures: [structure(1, false, ["LEVEL"]), structure(20, true, ["COUNT", "LEVEL"])] }] };
        const first = (isReported) => { const { name, id, leaves } = firstMeasured([valves, tank], () => undefined, isReported); return [name, id, leaves.map((leaf) => leaf.name)]; };
        const other = firstMeasured([tank], () => ({ structures: [structure(3, false, ["LEVEL"])] }), () => true);
        console.log(JSON.stringify([first(() => true), first((name, id) => id === 1), other.id, firstMeasured([valves], () => undefined, () => true)]));""")
    assert found == [["TANK", 20, ["LEVEL"]], ["TANK", 1, ["LEVEL"]], 3, None]


def test_a_device_has_a_row_for_each_of_its_buses_and_the_ages_of_its_frames(modules):
    """Its node answers with a heartbeat and sends its process data; the frames to it have no age."""
    found = printed(modules, """
        const part = { name: "NOMINAL", devices: ["ARM", "LAMP"], nodes: { ARM: "0x11" }, endnodes: { ARM: "robot, robot-b", LAMP: "UDP" } };
        const store = { hello: { buses: [{ name: "robot" }, { name: "robot-b" }] }, time: 9, lanes: new Map(), members: () => [{ name: "MANIPULATOR", configurations: [part] }],
          configuration: () => undefined, events: [{ subsystem: "MANIPULATOR", event: "DEVICE_LOST", device: "ARM", time: 8 }] };
        const frame = (id, name, time) => ({ id, name, time });
        const said = { time: 5, frames: [frame("711", "ARM_HEARTBEAT", 4.5), frame("191", "ARM_TPDO1", 4.75), frame("211", "ARM_RPDO1", 5), frame("712", "", 5)] };
        console.log(JSON.stringify([devicesOn(store), busOf(store, "UDP") ?? null, busOf(store, "robot-b"), agesOf("ARM", "0x11", said), agesOf("ARM", "0x11", undefined),
          [[null, null], [null, 2.9], [3, null], [3, 0.1]].map((ages) => stateOf(...ages)[1])]));""")
    assert found[0] == [{"device": "ARM", "bus": bus, "node": "0x11", "isLost": True} for bus in ("robot", "robot-b")]
    assert found[1:] == [None, "robot-b", {"heartbeat": 0.5, "data": 0.25}, {"heartbeat": None, "data": None}, ["no frame", "live", "silent", "live"]]


def test_an_alarm_tells_the_event_that_it_began_with_and_the_reports_of_the_next_second(modules):
    """The second HIGH event came when the alarm was open already. A page that has connected later has not received the event."""
    found = printed(modules, """
        const event = (severity, time) => ({ severity, time, subsystem: "ARM", event: "DEVICE_LOST", device: time === 8 ? "JOINT1" : null });
        const events = [event("HIGH", 2), event("LOW", 3), event("HIGH", 8), event("LOW", 8.5), event("INFORMATIVE", 9), event("LOW", 9.01), event("HIGH", 12)];
        console.log(JSON.stringify([ledTo(events, 8.001), ledTo(events, Infinity), ledTo(events.slice(0, 1), 2), ledTo(events, 1), ledTo([], 5)]));""")
    high = {"severity": "HIGH", "words": "ARM DEVICE_LOST", "count": 0}
    assert found == [{**high, "time": 8, "words": "ARM DEVICE_LOST JOINT1", "count": 2}, {**high, "time": 12}, {**high, "time": 2}, None, None]
