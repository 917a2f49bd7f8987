# SPDX-License-Identifier: Apache-2.0
"""The structures that stations of one flight use, also stations that were killed, and which station disables them."""

import asyncio
import os
import subprocess
import sys

import pytest
from conftest import ROOT
from hirosco_gse.station import display as display_module
from hirosco_gse.station import hub as hub_module
from hirosco_gse.station.display_uses import Uses
from visiting import MANIPULATOR, visit

DISPLAY = 4720  # Display structure of MANIPULATOR.
USE = ("MANIPULATOR", DISPLAY)
NOTED = "import sys; from hirosco_gse.station.display_uses import Uses; uses = Uses(sys.argv[1]); uses.note(('A', 1)); uses.note(('B', 2)); uses.note(('A', 1), False); print(flush=True); sys.stdin.read()"


def test_the_uses_of_a_killed_station_are_taken_over_once(tmp_path):
    """Other stations know the uses of the living station. The uses of a station that was killed are taken over once."""
    with subprocess.Popen([sys.executable, "-c", NOTED, tmp_path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": str(ROOT / "gse")}) as other:
        other.stdout.readline()
        one, third = Uses(tmp_path), Uses(tmp_path)
        one.note(("C", 3))
        assert one.of_others() == ({("B", 2)}, set())
        other.kill()
        other.wait()
    assert one.of_others() == (set(), {("B", 2)}) and one.of_others() == (set(), set())
    assert third.of_others() == ({("C", 3)}, set())
    one.clear()
    assert third.of_others() == (set(), set()) and not list(tmp_path.iterdir())


@pytest.mark.parametrize("text, expected", [("A 1\nB", {("A", 1)}), ("A 1\nA 1", {("A", 1)}), ("\n\nx\nA y\nA ²\n-A 1\n\x00", set()), ("", set())])
def test_a_damaged_list_is_read_as_far_as_it_is_complete(tmp_path, text, expected):
    (tmp_path / "station-1-x.display").write_text(text)
    assert Uses(tmp_path).of_others() == (set(), expected)


def test_a_directory_that_cannot_be_written_has_no_lists(tmp_path):
    uses = Uses(tmp_path / "absent")
    uses.note(USE)
    uses.clear()
    assert uses.of_others() == (set(), set())


def disabled(spacecraft):
    return [(packet.apid, int.from_bytes(packet.data[1:3], "big")) for packet in spacecraft.received if packet.message == (3, 6)]


def test_a_station_disables_the_structures_that_a_killed_station_enabled(place, spacecraft, monkeypatch):
    """It disables them although its own page has enabled nothing, but not while a page is open."""
    monkeypatch.setattr(hub_module, "LEAVE_S", 0.0)
    monkeypatch.setattr(display_module, "LOOK_S", 0.0)

    async def story(page, station):
        # The list is written when the page is open: without a page the station would disable the structures at once.
        (place / "first" / "station-1-x.display").write_text(f"MANIPULATOR {DISPLAY}\nABSENT 7\n")
        while USE not in station.hub.display.enabled:
            await asyncio.sleep(0.01)
        before = disabled(spacecraft)
        await page.socket.close()
        while not disabled(spacecraft):
            await asyncio.sleep(0.01)
        return before

    assert visit(place, story) == [] and disabled(spacecraft) == [(MANIPULATOR, DISPLAY)]
    assert not list((place / "first").glob("*.display"))


def test_the_last_station_that_uses_a_structure_disables_it(place, spacecraft, monkeypatch):
    monkeypatch.setattr(hub_module, "LEAVE_S", 0.0)
    monkeypatch.setattr(display_module, "REPORT_TIMEOUT_S", 20.0)  # One status report is enough, also for a station that is late.
    other = Uses(place / "first")
    other.note(USE)

    async def story(page, station):
        await page.ask(do="command", text="ping MANIPULATOR")
        await page.until(lambda message: message["kind"] == "command" and message["over"])
        while USE not in station.hub.display.enabled:
            await asyncio.sleep(0.01)
            station.hub.display.keep()
        assert other.of_others() == ({USE}, set())
        await page.socket.close()
        while station.hub.display.enabled:
            await asyncio.sleep(0.01)

    async def story_of_one(page, station):
        await page.ask(do="command", text="ping MANIPULATOR")
        while USE not in station.hub.display.enabled:
            await asyncio.sleep(0.01)
        await page.socket.close()
        while not disabled(spacecraft):
            await asyncio.sleep(0.01)

    visit(place, story)
    assert not disabled(spacecraft)
    other.clear()
    visit(place, story_of_one)
    assert disabled(spacecraft) == [(MANIPULATOR, DISPLAY)]
