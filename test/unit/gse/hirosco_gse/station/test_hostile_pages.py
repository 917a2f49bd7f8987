# SPDX-License-Identifier: Apache-2.0
"""Pages that send too much, read too little, or speak no HTTP: answers are not lost, the station goes on, and its memory is bounded."""

import asyncio
import json
import math
import struct

import pytest
from aiohttp import ClientSession
from hirosco_gse.command import UsageError
from hirosco_gse.station import hub as hub_module
from hirosco_gse.station import server
from hirosco_gse.station.server import MESSAGES_MAX, QUEUE, UNDER_WAY, _Browser, json_of
from conftest import ROOT
from visiting import MANIPULATOR, TELEPRESENCE, Page, answer, station_of, visit

FLOOD = QUEUE + QUEUE // 4


class _Socket:
    """The socket of a page that does not read."""

    async def send_str(self, text):
        await asyncio.Event().wait()


def test_a_page_that_sends_many_requests_gets_an_answer_to_each(place):
    async def story(page, _):
        for number in range(FLOOD):
            await page.socket.send_str(json.dumps({"do": "plan", "text": "ping MANIPULATOR", "id": 1000 + number}))
        await page.until(lambda message: message.get("id") == 1000 + FLOOD - 1)
        return [message["id"] for message in page.heard if message.get("id", 0) >= 1000]

    assert visit(place, story) == list(range(1000, 1000 + FLOOD))


def test_a_page_that_does_not_read_is_served_no_request_and_loses_only_updates():
    """A dropped update is replaced by the next one of its kind; other messages wait."""

    async def run():
        browser = _Browser(_Socket())
        sender = asyncio.create_task(browser.send())
        for number in range(QUEUE):
            browser.put(json.dumps({"kind": "event", "n": number}))
        for kind in ("housekeeping", "truth", "bus", "counts"):
            browser.put(json.dumps({"kind": kind}))
        waiting = asyncio.create_task(browser.room())
        await asyncio.sleep(0)
        is_served = waiting.done()
        sender.cancel()
        await waiting  # The connection has ended.
        return [json.loads(text) for text in browser.waiting], browser.dropped, is_served

    waiting, dropped, is_served = asyncio.run(run())
    assert [message.get("n") for message in waiting][-3:] == [QUEUE - 2, QUEUE - 1, None] and not is_served
    assert dropped == 3 and waiting[-1] == {"kind": "counts"}


@pytest.mark.parametrize("text", ["x", "x" * (1 << 20)])
def test_a_page_for_which_too_many_messages_wait_is_disconnected(text):
    ended = []
    browser = _Browser(_Socket(), lambda: ended.append(len(browser.waiting)))
    while not ended:
        browser.put(text)
    assert ended == [MESSAGES_MAX + 1 if len(text) == 1 else server.CHARACTERS_MAX // len(text) + 1]


def test_a_request_is_refused_while_the_largest_number_is_under_way(place, spacecraft):
    """The bounds apply to the lists that a page asks for, and to the commands of all pages. STOP ALL is performed at the bound, too."""
    spacecraft._answer = lambda packet: [] if packet.message in ((18, 8), (17, 1)) else answer(packet)

    async def story(page, station):
        for number in range(UNDER_WAY + 1):
            await page.socket.send_str('{"do":"ask","text":"procedure status","id":%d}' % (100 + number))
        refused = await page.until(lambda message: message.get("id", 0) >= 100)
        for _ in range(hub_module.CALLS_MAX):
            station.hub.command("ping MANIPULATOR")
        with pytest.raises(UsageError, match="commands of pages are under way; wait until one has ended"):
            station.hub.command("ping MANIPULATOR")
        station.hub.command("stop")
        return refused

    refused = visit(place, story)
    assert refused["id"] == 100 + UNDER_WAY and refused["refused"].startswith(f"{UNDER_WAY} requests of this page wait")


def test_many_requests_of_a_page_do_not_stop_other_tasks(place, spacecraft):
    """The station has received all these requests before it reads the first one."""
    turns = []

    async def count():
        while True:
            turns.append(None)
            await asyncio.sleep(0)

    async def story(page, station):
        perform, performed = station._perform, []

        async def counted(text, browser):
            performed.append(len(turns))
            return await perform(text, browser)

        station._perform = counted
        task = asyncio.create_task(count())
        await asyncio.gather(*(page.socket.send_str(json.dumps({"do": "forms" if number % 2 else "script", "id": 1000 + number})) for number in range(50)))
        await page.until(lambda message: message.get("id") == 1049)
        task.cancel()
        return performed

    performed = visit(place, story)
    assert len(performed) == 50 and len(set(performed)) == 50


def test_no_request_is_read_while_many_characters_wait_for_a_page():
    browser = _Browser(_Socket())
    browser.put("x" * server.CHARACTERS_ROOM)
    assert browser._room.is_set()
    browser.put("x")
    assert not browser._room.is_set()


def test_a_page_that_hangs_does_not_delay_the_end_of_the_station(place, monkeypatch):
    monkeypatch.setattr(server, "CLOSE_S", 0.01)
    ended = []

    class Hanging:
        async def close(self, code):
            await asyncio.Event().wait()

    async def run():
        async with station_of(place) as (station, _):
            station.browsers.add(_Browser(Hanging(), lambda: ended.append("aborted")))
            await station._close_pages(None)
            station.browsers.clear()
            assert station._close_pages in station.application("127.0.0.1:1").on_shutdown

    asyncio.run(run())
    assert ended == ["aborted"]


def test_structures_are_asked_for_once_at_a_time(place, spacecraft):
    spacecraft._answer = lambda packet: [] if packet.message == (3, 33) else answer(packet)

    async def story(page, station):
        await page.ask(do="command", text="ping MANIPULATOR")
        await page.until(lambda message: message["kind"] == "command" and message["over"])
        for _ in range(20):
            await page.ask(do="structures", subsystem="MANIPULATOR")
        return len([call for call in station.hub.calls if call.procedure.gi_code.co_name == "_ask_once"])

    assert visit(place, story) == 1


def test_a_number_that_is_not_finite_is_null_for_the_page():
    """JSON has no NaN: the browser could not read the message."""
    message = {"kind": "housekeeping", "values": {"A": [math.nan, 1.5], "B": (math.inf, "x")}}
    assert json.loads(json_of(message), parse_constant=pytest.fail) == {"kind": "housekeeping", "values": {"A": [None, 1.5], "B": [None, "x"]}}


def test_a_request_that_is_not_http_prints_no_stack_trace(place, caplog):
    async def run():
        async with station_of(place) as (station, address):
            host, port = station._host.split(":")
            for octets in (b"\x16\x03\x01\x02\x00" * 50, b"GET * HTTP/1.1\r\nHost: x\r\n\r\n", b"GET / HTTP/1.1\r\nHost: x\r\nX: " + 100_000 * b"a" + b"\r\n\r\n"):
                reader, writer = await asyncio.open_connection(host, port)
                writer.write(octets)
                assert b" 400 " in await reader.readline()
                writer.close()
            async with ClientSession() as session, session.get(f"{address}/") as reply:
                return reply.status

    assert asyncio.run(run()) == 200
    assert not caplog.records


def test_a_recording_is_made_once_for_all_pages_and_a_failure_has_its_reason(place, monkeypatch, tmp_path):
    """Each recording is made by a process of its own."""
    made = []

    async def make(directory):
        made.append(directory)
        await asyncio.sleep(0)
        return b"recording"

    async def get(session, address):
        async with session.get(f"{address}/recording") as reply:
            return reply.status, await reply.read()

    async def run(count):
        async with station_of(place, replayed=tmp_path / "nothing") as (_, address), ClientSession() as session:
            return await asyncio.gather(*(get(session, address) for _ in range(count)))

    (status, reason), = asyncio.run(run(1))
    assert status == 500 and b"nothing cannot be replayed: recording: " in reason
    monkeypatch.setattr(server.Station, "_made", staticmethod(make))
    assert asyncio.run(run(5)) == [(200, b"recording")] * 5 and len(made) == 1


def test_the_page_is_informed_that_the_port_of_a_flight_cannot_be_read(place):
    """The station does not use the default port instead: another flight may have it."""

    async def story(page, station):
        (place / "first" / "ground.port").write_text("many\n")
        station.hub._connection.abort()
        return await page.until(lambda message: message["kind"] == "link" and "ground.port" in message["text"])

    assert "name the port of the flight" in visit(place, story)["text"]


def test_pages_are_informed_when_the_interface_of_the_dictionary_flies_again(place, spacecraft, dictionary):
    own = dictionary.subsystem("MANIPULATOR").interface_hash

    def reporting(interface):
        data = struct.pack(">BBBHQQII", 3, 0, 3, 2, interface, 0, 0, 0)
        return lambda packet: answer(packet) + ([(MANIPULATOR, 129, 5, data, 1)] if packet.message == (17, 1) and packet.apid != MANIPULATOR else [])

    async def story(page, _):
        found = []
        for interface in (own ^ 1, own):
            spacecraft._answer = reporting(interface)
            await page.ask(do="command", text="ping JOYSTICK")
            found.append((await page.until(lambda message: message["kind"] == "mismatch"))["words"])
        return found

    differs, none = visit(place, story)
    assert differs.startswith("MANIPULATOR flies interface") and none is None


def test_a_command_that_the_page_disables_is_refused_with_the_same_words(place, spacecraft, dictionary):
    """Another client of the station, or a page that has not heard of the difference yet, may send it."""
    flown = dictionary.subsystem("MANIPULATOR").interface_hash ^ 1
    data = struct.pack(">BBBHQQII", 3, 0, 3, TELEPRESENCE, flown, 0, 0, 0)
    spacecraft._answer = lambda packet: answer(packet) + ([(MANIPULATOR, 129, 5, data, 1)] if packet.message == (17, 1) and packet.apid != MANIPULATOR else [])
    barred = ("cmd MANIPULATOR.TARE", "at 5 cmd MANIPULATOR.TARE", "at +5 cmd MANIPULATOR.TARE", "set MANIPULATOR.CONTROL.FADE_TIME 1", "link open HAND_POSITION")
    free = ("state MANIPULATOR OFFLINE", "reload MANIPULATOR", "process stop MANIPULATOR", "stop", "hk once JOYSTICK 1")

    async def story(page, _):
        await page.ask(do="command", text="ping JOYSTICK")
        words = (await page.until(lambda message: message["kind"] == "mismatch"))["words"]
        before = len([packet for packet in spacecraft.received if packet.message in ((8, 1), (11, 4), (130, 3))])
        refused = [(await page.ask(do="command", text=text))["refused"] for text in barred]
        sent = len([packet for packet in spacecraft.received if packet.message in ((8, 1), (11, 4), (130, 3))])
        return words, refused, sent - before, [await page.ask(do="command", text=text) for text in free]

    words, refused, sent, accepted = visit(place, story)
    assert refused == [f"disabled: {words}"] * len(barred) and not sent
    assert all("command" in reply for reply in accepted)


def test_a_replay_refuses_all_commands_with_the_words_of_the_page(place):
    assert server.REPLAY in (ROOT / "gse" / "page" / "src" / "replay.js").read_text(encoding="utf-8")

    async def run():
        async with station_of(place, replayed=place / "first") as (_, address), ClientSession() as session:
            async with session.ws_connect(f"{address}/ws", headers={"Origin": address}) as socket:
                page = Page(socket)
                orders = ({"do": "command", "text": "stop"}, {"do": "live", "line": "pause"}, {"do": "plan", "text": "ping all"}, {"do": "ask", "text": "file list"},
                          {"do": "upload", "words": ["procedure", "load", "A", "{}"], "data": ""}, {"do": "structures", "subsystem": "MANIPULATOR"})
                return [(await page.ask(**order))["refused"] for order in orders]

    assert set(asyncio.run(run())) == {server.REPLAY}


def test_refusals_repeat_a_part_of_what_a_page_has_sent(place):
    long = 100_000 * "x"

    async def story(page, _):
        orders = ({"do": "plan", "text": f"ping {long}"}, {"do": "plan", "form": long, "values": {}}, {"do": long}, {"do": "ask", "text": long}, {"do": "command", "text": long},
                  {"do": "live", "line": f"hand {long}"}, {"do": "upload", "words": [long, "{}"], "data": ""}, {"do": "structures", "subsystem": long})
        return [(await page.ask(**order))["refused"] for order in orders]

    refused = visit(place, story)
    assert max(map(len, refused)) < 2000
    assert refused.count(f"found a command of 100005 characters, expected at most {server.COMMAND_MAX}") == 1


def test_commands_within_commands_are_bounded(place):
    """Each command contains the octets of the next one; the time to plan them grows with the square of their number."""

    async def story(page, _):
        orders = ({"do": do, "text": f"{count * 'at 5 '}ping MANIPULATOR"} for do, count in (("plan", 4), ("plan", 5), ("command", 10_000)))
        return [await page.ask(**order) for order in orders]

    deep, *refused = visit(place, story)
    assert deep["octets"] and all(each["refused"].endswith("found more than 4 commands within commands") for each in refused)
