# SPDX-License-Identifier: Apache-2.0
"""A run as an MCAP file: mcap reads its structure, mcap-ros2-support its ROS 2 messages, and its values equal
those of the logs, of cantools and of the ground segment."""

import collections
import json
import pathlib
import shutil
import subprocess
import sys

import cantools
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIO = (
    "0.0 hand rest",
    "0.0 operator state MANIPULATOR PRE_OPERATIONAL",
    "0.0 operator config MANIPULATOR STAND_ALONE",
    "0.0 operator state MANIPULATOR SAFE_OPERATIONAL",
    "1.0 fault error robot JOINT1 0x4310 on",
    "1.1 operator shutdown",
)

sys.path.insert(0, str(ROOT / "test" / "mission"))
import flying  # noqa: E402
from hirosco_gse import cli, logs  # noqa: E402
from hirosco_gse import run as runs  # noqa: E402
from hirosco_gse.dictionary import STATES  # noqa: E402


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    """The directory of a flight with its MCAP file."""
    place = tmp_path_factory.mktemp("flight")
    flown = flying.fly(place / "run", "--form", "image", "--scenario", flying.write_scenario(place / "short.scn", *SCENARIO))
    assert flown.code == 0, flown.transcript()
    assert cli.main(["mcap", str(flown.directory)]) == 0
    return flown.directory


@pytest.fixture(scope="module")
def run(directory):
    return runs.load(directory)


@pytest.fixture(scope="module")
def messages(directory):
    """topic -> list of (time [ns], message): ROS messages decoded by mcap-ros2-support, JSON by json."""
    found, last, factory, decoders = collections.defaultdict(list), 0, DecoderFactory(), {}
    with (directory / "run.mcap").open("rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages(log_time_order=False):
            assert message.log_time >= last, "the messages are not in the order of their times"
            last = message.log_time
            if channel.id not in decoders:
                decoders[channel.id] = json.loads if channel.message_encoding == "json" else factory.decoder_for("cdr", schema)
            found[channel.topic].append((message.log_time, decoders[channel.id](message.data)))
    return found


def test_the_summary_lists_channels_with_their_schemas_and_counts(directory, messages):
    with (directory / "run.mcap").open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert {channel.topic for channel in summary.channels.values()} == messages.keys()
    assert summary.statistics.message_count == sum(map(len, messages.values()))
    assert summary.chunk_indexes
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        assert (channel.message_encoding, schema.encoding) in (("cdr", "ros2msg"), ("json", "jsonschema")), channel.topic
        if schema.encoding == "jsonschema":
            assert json.loads(schema.data)["type"] == "object"


def test_every_frame_is_there_and_signals_are_those_of_cantools(run, messages):
    for bus, log in run.buses.items():
        topics = [topic for topic in messages if topic.startswith(f"/can/{bus}/")]
        assert sum(len(messages[topic]) for topic in topics) == len(log), bus
    database = cantools.database.load_file(ROOT / "build/generated/rokviss-robot.dbc")
    log = run.buses["robot"]
    for name in ("JOINT1_TPDO1", "JOINT2_RPDO1", "JOINT1_EMCY", "JOINT1_HEARTBEAT"):
        message = database.get_message_by_name(name)
        rows = log.frames(message.frame_id)
        shown = messages[f"/can/robot/{name.lower()}"]
        assert len(rows) == len(shown) > 0
        for row, (time_ns, decoded) in list(zip(rows, shown))[::50]:
            wanted = message.decode(bytes(log.data[row, : log.length[row]]), decode_choices=False)
            assert time_ns == log.time_us[row] * 1000
            assert [getattr(decoded, field) for field in decoded.__slots__] == pytest.approx([float(value) for value in wanted.values()])


def test_frames_without_a_message_in_the_database_are_raw(run, messages):
    log = run.buses["robot"]
    requests = [(time_ns, frame) for time_ns, frame in messages["/can/robot/frames"] if frame.id == 0x611]
    rows = log.frames(0x611)
    assert len(rows) == len(requests) > 10
    assert [(time_ns, bytes(frame.data)) for time_ns, frame in requests] == [
        (log.time_us[row] * 1000, bytes(log.data[row, : log.length[row]])) for row in rows]


def test_a_long_frame_is_read_whole():
    log = logs.parse_bus(b"(0000000001.000500) robot 191##1" + b"A1" * 12 + b"\n(0000000001.000600) robot 192#01\n")
    assert [bytes(log.data[row, : log.length[row]]) for row in (0, 1)] == [b"\xa1" * 12, b"\1"]


def test_truth_has_the_names_of_the_world_and_its_values(directory, messages):
    channels = logs.read_lcm(directory / "truth.lcm")
    joints = runs.decode_truth(channels)["JOINTS"]
    reported = messages["/truth/joints"]
    assert [time_ns for time_ns, _ in reported] == [1000 * time_us for time_us in joints["time_us"]]
    for number, name in enumerate(("arm_joint1", "arm_joint2")):
        for field in ("position_rad", "external_torque_nm", "brake_engaged"):
            assert [getattr(getattr(one, name), field) for _, one in reported[::100]] == joints[field][::100, number].tolist()
    forces = np.array([one.arm_finger.force_n for _, one in messages["/truth/contact"][::100]])
    assert forces.shape == (len(channels["CONTACT"][0][::100]), 3)
    assert [one["kind"] for _, one in messages["/truth/fault"]] == ["error"]


def test_housekeeping_states_and_events_are_those_of_the_packets(run, messages):
    reported = messages["/manipulator/housekeeping_4711"]
    reports = [(time_ns, one["values"]) for time_ns, packet, one in run.reports_of("housekeeping") if packet.apid == 16 and one["structure"] == 4711]
    assert len(reported) == len(reports) > 0
    for (time_ns, shown), (wanted_ns, wanted) in zip(reported, reports):
        assert time_ns == wanted_ns
        assert shown["CUR_VALUES"]["POSITION"] == wanted["CUR_VALUES"]["POSITION"]
        state = shown["CUR_VALUES"]["STATE"]
        assert [state] == wanted["CUR_VALUES"]["STATE"] and shown["CUR_VALUES"]["STATE_WORD"] == STATES[state]
    states = [one["state"] for _, one in messages["/manipulator/state"]]
    assert "SAFE_OPERATIONAL" in states and messages["/manipulator/state"][states.index("SAFE_OPERATIONAL")][1]["number"] == 4
    events = run.reports_of("event")
    assert [one["message"].split()[0] for _, one in messages["/events"]] == [one["event"] for _, _, one in events]
    assert len(events) >= 2


def test_the_schema_of_housekeeping_has_units(directory):
    with (directory / "run.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    channel = next(one for one in summary.channels.values() if one.topic == "/manipulator/housekeeping_4711")
    members = json.loads(summary.schemas[channel.schema_id].data)["properties"]["CUR_VALUES"]["properties"]
    assert members["POSITION"]["description"] == "rad" and members["STATE"]["type"] == "number" and members["STATE_WORD"]["type"] == "string"


def test_the_same_run_gives_the_same_file_and_a_database_of_other_descriptors_is_not_used(directory, tmp_path, capsys):
    copy = tmp_path / "copy"
    shutil.copytree(directory, copy, ignore=shutil.ignore_patterns("run.mcap", "storage"))
    assert cli.main(["mcap", str(copy)]) == 0
    assert (copy / "run.mcap").read_bytes() == (directory / "run.mcap").read_bytes()
    capsys.readouterr()
    facts = json.loads((copy / "run.json").read_text())
    (copy / "run.json").write_text(json.dumps({**facts, "configuration_hash": "0x0123456789ABCDEF"}))
    (copy / "truth.lcm").unlink()
    assert cli.main(["mcap", str(copy)]) == 0
    assert "rokviss-robot.dbc: made from other descriptors than those that flew" in capsys.readouterr().err
    with (copy / "run.mcap").open("rb") as stream:
        topics = {channel.topic for channel in make_reader(stream).get_summary().channels.values()}
    assert "/can/robot/frames" in topics and not any("tpdo" in topic or "truth" in topic for topic in topics)


def test_the_command_without_its_packages_prints_what_to_do():
    done = subprocess.run([sys.executable, "-S", ROOT / "gse/gse", "mcap", ROOT], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "make setup" in done.stderr and "Traceback" not in done.stderr
