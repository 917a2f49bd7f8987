# SPDX-License-Identifier: Apache-2.0
"""A flight whose processes stand still keeps its connection open: the station says that no telemetry arrives."""

import asyncio

import pytest
from hirosco_gse.station import silence as silence_module
from hirosco_gse.station.silence import LIMIT_S, STEP_S, Silence
from visiting import visit


class Clock:
    """A clock that a test sets."""

    now = 100.0

    def __call__(self):
        return self.now


@pytest.mark.parametrize(("speed", "seconds"), [(1.0, LIMIT_S), (0.0, LIMIT_S), (4.0, LIMIT_S), (0.5, 2 * LIMIT_S)])
def test_silence_is_time_without_telemetry_that_is_expected(speed, seconds):
    """At most STEP_S of the time between two calls of `look` counts. Telemetry and a pause set the time to zero."""
    clock = Clock()
    silence = Silence(clock)

    def looks(step, is_expected=True):
        """Number of calls in steps of this time until telemetry is missing; None: it is not missing after 1000 calls."""
        for count in range(1, 1001):
            clock.now += step
            if silence.look(is_expected, speed):
                return count
        return None

    assert looks(0.125) == seconds / 0.125
    silence.heard()
    assert looks(60.0) == pytest.approx(seconds / STEP_S, abs=1)
    assert looks(0.125, is_expected=False) is None and looks(0.125) == seconds / 0.125


def test_a_page_is_informed_that_no_telemetry_arrives_and_that_it_arrives_again(place, spacecraft, monkeypatch):
    """A command is accepted during the silence. A pause is no silence."""
    monkeypatch.setattr(silence_module, "LIMIT_S", 0.3)
    answer, spacecraft._answer = spacecraft._answer, lambda packet: []

    async def story(page, station):
        silent = await page.until(lambda message: message["kind"] == "link" and message.get("is_silent"))
        asked = await page.ask(do="command", text="ping JOYSTICK")
        spacecraft._answer = answer
        await page.ask(do="command", text="ping MANIPULATOR")
        live = await page.until(lambda message: message["kind"] == "link")
        spacecraft._answer = lambda packet: []
        station.hub.pace["is_paused"] = True
        await asyncio.sleep(0.5)
        return silent, asked, live, station.hub.link

    silent, asked, live, paused = visit(place, story)
    assert not silent["is_live"] and silent["text"] == "no telemetry arrives" and "command" in asked
    assert live["is_live"] and "is_silent" not in live and paused == live
