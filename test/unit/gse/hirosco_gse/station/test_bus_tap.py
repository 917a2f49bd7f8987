# SPDX-License-Identifier: Apache-2.0
"""Frames of a bus on the page: the newest frame of each identifier, decoded, with its rate; error frames as
text."""

import asyncio
import copy
import socket

import pytest
from conftest import ROOT
from hirosco_gse.frames import Database
from hirosco_gse.station import world_port
from hirosco_gse.station.bus_tap import BusTap, error_of
from hirosco_gse.values import bits_of


def test_the_newest_frame_of_each_identifier_is_sent_with_its_rate():
    tap = BusTap("robot", 1e6, 5e6, Database(ROOT / "build" / "generated" / "rokviss-robot.dbc"))
    tap.message()
    tap.feed(b"ok 1.000000000\nframe (0000000001.000000) robot 080#\nframe (00000000")
    tap.message()
    lines = b"".join(b"frame (0000000001.%06d) robot 191##1%02X\n" % (n * 1000, n) for n in range(1, 101))
    tap.feed(b"01.000500) robot 080#\n" + lines + b"dropped 12\n")
    said = tap.message()
    sync, joint = said["frames"]
    tap.feed(b"frame (0000000002.000000) robot 191##137121600F4010A00\n")
    assert "PositionActualValue" in tap.message()["frames"][1]["words"]
    assert (sync["id"], sync["name"], joint["id"], joint["octets"]) == ("080", "SYNC", "191", "64")
    assert joint["rate"] == pytest.approx(1000, rel=0.02) and said["dropped"] == 12
    assert said["load"] == pytest.approx(100 * (30 * 1.08 + 39 * 1.08 / 5) / 1e5, rel=0.05)


def test_a_statusword_is_shown_by_its_state(dictionary):
    """The names are those of the dictionary, as in the other tabs of the page. Each of two axes has its own signal."""
    bits = bits_of(dictionary.content)
    tap = BusTap("robot", 1e6, 5e6, Database(ROOT / "build" / "generated" / "rokviss-robot.dbc"), bits=bits)
    for octets, state in (("3712", "OPERATION_ENABLED"), ("5002", "SWITCH_ON_DISABLED"), ("1802", "FAULT")):
        tap.feed(f"frame (0000000002.000000) robot 191##1{octets}1600F4010A00\n".encode())
        assert f"Statusword {state}, " in tap.message()["frames"][0]["words"] + ", "
    assert [tap._word(name, 0x27) for name in ("StatuswordAxis2", "Status")] == ["OPERATION_ENABLED", 0x27]


def test_error_frames_are_listed_one_by_one_as_text():
    tap = BusTap("robot", 1e6, 5e6, None)
    tap.feed(b"frame (0000000064.000039) robot 20000220#0000000000008000\nframe (0000000064.000725) robot 20000204#0008000000006000\n")
    said = tap.message()
    assert [(error["name"], error["symbol"]) for error in said["errors"]] == [("NO_ACK", "critical"), ("CONTROLLER", "caution")]
    assert said["errors"][0]["words"] == "no node acknowledges; tx errors 128, rx errors 0"
    assert said["errors"][1]["words"] == "transmit errors: error warning; tx errors 96, rx errors 0"
    assert (said["error_count"], said["transmit_errors"]) == (2, 96)
    assert error_of(0x20000040, bytes(8))[0] == "BUS_OFF" and error_of(0x20000400, b"")[2] == "error"


def test_the_page_is_informed_that_names_of_frames_may_be_wrong(dictionary):
    """This happens if the database was made from other descriptors than the dictionary, or if a subsystem
    has another interface."""
    taps, mismatches = world_port.Taps(None), {}
    taps.move_to("run", dictionary, mismatches)
    tap = taps._tap("robot")
    assert taps._message_of(tap)["warning"] is None
    mismatches[16] = "MANIPULATOR flies interface 0x0a"
    assert taps._message_of(tap)["warning"] == "MANIPULATOR flies interface 0x0a"
    other = copy.copy(dictionary)
    other.content = dictionary.content | {"configuration_hash": "0x00000000000000BB"}
    taps.move_to("run", other, {})
    assert taps._message_of(taps._tap("robot"))["warning"].startswith("rokviss-robot.dbc: made from other descriptors than the dictionary")
    other.mission = "unknown"
    assert taps._message_of(taps._tap("robot"))["warning"].startswith("frames are not decoded: ")


def test_the_page_is_informed_why_no_frames_arrive(dictionary, tmp_path):
    """The file live.port stays in the directory of a flight that has ended; its port is closed."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        (tmp_path / "live.port").write_text(str(server.getsockname()[1]), encoding="ascii")

    async def problem():
        reported = asyncio.Queue()
        taps = world_port.Taps(reported.put_nowait)
        taps.move_to(tmp_path, dictionary, {})
        taps.watch({"robot"})
        message = await reported.get()
        taps.watch(set())
        return message["problem"]

    assert asyncio.run(problem()) == "the simulator does not answer: Connection refused"
    (tmp_path / "run.json").write_text("{}", encoding="utf-8")
    assert asyncio.run(problem()) == "the flight has ended"
