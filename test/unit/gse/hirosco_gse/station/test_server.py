# SPDX-License-Identifier: Apache-2.0
"""The light station with a simulated spacecraft: messages to browsers, requests to the spacecraft, refused
clients."""

import asyncio
import base64
import importlib
import json
import re
import struct
from types import SimpleNamespace

import pytest
from aiohttp import ClientSession, WSServerHandshakeError, web
from conftest import ROOT
from hirosco_gse import commands, telemetry
from hirosco_gse import dictionary as dictionary_module
from hirosco_gse import run_directory
from hirosco_gse.cli import main
from hirosco_gse.command import Command
from hirosco_gse.dictionary import STATES
from hirosco_gse.packets import Packet
from hirosco_gse.script import Script
from hirosco_gse.session import Session, Verification
from hirosco_gse.station import __main__ as station_main
from hirosco_gse.station import display as display_module
from hirosco_gse.station import hub as hub_module
from hirosco_gse.station import targets as targets_module
from hirosco_gse.station.identity import Identity
from hirosco_gse.station.lights import lights_of
from hirosco_gse.station.server import ALIVE, ALIVE_S, QUEUE, Station, _Browser
from spacecraft import Spacecraft, failure, success
from visiting import JOYSTICK, MANIPULATOR, TELEPRESENCE, Page, answer, begin, station_of, visit


def test_a_command_shows_its_lights_and_its_end(place):
    async def story(page, _):
        await page.ask(do="command", text="ping MANIPULATOR")
        return await page.until(lambda message: message["kind"] == "command" and message["over"])

    last = visit(place, story)
    assert last["lights"] == ["done", "done", "none", "done"]
    assert last["answer"] == ["MANIPULATOR is alive"] and "words" not in last


def test_a_refused_command_prints_its_reason(place):
    async def story(page, _):
        await page.ask(do="command", text="state MANIPULATOR OPERATIONAL")
        return await page.until(lambda message: message["kind"] == "command" and message["over"])

    last = visit(place, story)
    assert last["lights"] == ["empty", "failed", "empty", "empty"] and last["code"] == 0x0204  # PUS_FAILURE_STATE.
    assert "refused at start of execution" in last["words"]


def test_the_words_of_a_command_are_checked_before_they_are_sent(place, spacecraft):
    async def story(page, _):
        return [await page.ask(do="plan", text=text) for text in ("cmd MANIPULATOR.MOVE_TO POSITION=0.5,0.1", "state MANIPULATOR SAFE_OPERATIONAL", "'")]

    missing, good, open_quote = visit(place, story)
    assert "DURATION is missing" in missing["refused"] and "refused" in open_quote
    assert good["messages"] == ["TC[129,1]"] and bytes.fromhex(good["octets"][0])[11:12] == bytes([4])
    assert (129, 1) not in [packet.message for packet in spacecraft.received]


def test_the_commands_of_a_flight_are_a_script_that_gse_runs(place, dictionary):
    """In the script, refused commands have the word `try`; commands of forms are written as text."""

    async def story(page, _):
        for order in ({"form": "config MANIPULATOR", "values": {"Configuration": "TELEPRESENCE"}}, {"text": "state MANIPULATOR OPERATIONAL"}):
            await page.ask(do="command", **order)
            await page.until(lambda message: message["kind"] == "command" and message["over"])
        plan = await page.ask(do="plan", form="tc 11,3", values={"Subsystem": "SUPERVISOR"})
        return await page.ask(do="script"), plan, await page.ask(do="forms")

    script, planned, forms = visit(place, story)
    steps = Script.parse(script["text"], "saved.scn", dictionary).steps
    assert [step.text for step in steps] == ["config MANIPULATOR TELEPRESENCE", "try state MANIPULATOR OPERATIONAL"]
    assert planned["line"] == "tc SUPERVISOR 11,3" and planned["critical"] is True
    assert len(forms["forms"]) > 300 and forms["suggestions"]["events"]


def test_a_file_of_the_page_is_uploaded_and_a_list_is_asked_for(place, spacecraft):
    """A command with a file cannot be repeated, so no script contains it; a request for a list is not among
    the commands."""
    code = b"local a = 1\n"
    listed = struct.pack(">H8sHB", 1, b"STATION", 7, 1)
    spacecraft._answer = lambda packet: success(packet, (18, 9, listed)) if packet.message == (18, 8) else answer(packet)

    async def story(page, _):
        await page.ask(do="upload", words=["procedure", "load", "STATION", "{}"], data=base64.b64encode(code).decode())
        last = await page.until(lambda message: message["kind"] == "command" and message["over"])
        await page.socket.send_str('{"do":"ask","text":"procedure status","id":8}')
        listing = await page.until(lambda message: message.get("id") == 8)
        script = await page.ask(do="script")
        await page.socket.send_json({"do": "upload", "words": ["file", "upload", "{}", "x"], "data": "?"})
        return last, listing, script, await page.until(lambda message: "refused" in message)

    last, listing, script, refused = visit(place, story)
    sent, = [packet.data for packet in spacecraft.received if packet.message == (18, 1)]
    assert code in sent and last["number"] == 1 and last["lights"][3] == "done"
    assert [row["obcp_id"] for row in listing["rows"][0]["n"]] == ["STATION"]
    assert "procedure" not in script["text"] and "not understood" in refused["refused"]


def test_a_page_asks_for_the_kinds_of_packets_and_for_the_octets_of_one(place):
    """A read-only station answers, too."""

    async def story(page, _):
        await page.until(lambda message: message["kind"] == "counts" and message["rows"])
        kinds = (await page.ask(do="packets"))["rows"]
        asked = next(row for row in kinds if row["message"] == "TC[131,8]")
        shown, refused = (await page.ask(do="packets", kind=asked["kind"]))["packets"][-1], []
        for wrong in ({"kind": ["TM"]}, {"kind": [[1]]}, {"kind": 7}):
            await page.socket.send_json({"do": "packets", **wrong})
            refused.append((await page.until(lambda message: "refused" in message))["refused"])
        return shown, refused

    shown, refused = visit(place, story, is_read_only=True)
    assert bytes.fromhex(shown["octets"])[7:9] == bytes([131, 8]) and shown["fields"][0]["text"].startswith("TC, 1 SUPERVISOR")
    assert refused[0] == "no packet of this kind is stored" and all(words.startswith("not understood") for words in refused[1:]), refused


def test_the_order_ask_is_refused_for_all_but_lists(place, spacecraft):
    """A request by `ask` is not in the list of commands, so it must not command anything."""

    async def story(page, _):
        await page.socket.send_str('{"do":"ask","text":"stop","id":8}')
        return await page.until(lambda message: message.get("id") == 8)

    assert visit(place, story)["refused"].startswith("'stop' is no list; lists are file list, procedure status,")
    assert (129, 1) not in [packet.message for packet in spacecraft.received]


def test_a_station_that_is_read_only_commands_only_housekeeping_for_display(place, spacecraft):
    """The server refuses all commands of a page, critical or not; housekeeping for display arrives as in
    other stations."""
    orders = (
        {"do": "command", "text": "ping JOYSTICK"},
        {"do": "command", "text": "stop", "display": True},
        {"do": "command", "text": "hk disable JOYSTICK 4711", "display": True},
        {"do": "live", "line": "pause"},
        {"do": "upload", "words": ["procedure", "load", "STATION", "{}"], "data": "AA=="},
    )

    async def story(page, station):
        is_read_only = station.hub.hello()["read_only"]
        refused = [(await page.ask(**order)).get("refused", "") for order in orders]
        asked = [await page.ask(do="plan", text="ping JOYSTICK"), await page.ask(do="forms"), await page.ask(do="watch", bus=None)]
        shown = await page.ask(do="command", text="hk enable JOYSTICK 4711", display=True)
        await page.until(lambda message: message["kind"] == "command" and message["over"])
        return is_read_only, refused, asked, shown, [(packet.apid, *packet.message) for packet in spacecraft.received]

    is_read_only, refused, asked, shown, sent = visit(place, story, is_read_only=True)
    assert is_read_only is True and all("this station is read only" in words for words in refused)
    assert not any("refused" in each for each in asked) and "refused" not in shown
    assert (JOYSTICK, 17, 1) not in sent and (JOYSTICK, 3, 6) not in sent and (JOYSTICK, 3, 5) in sent


def test_a_page_reads_and_writes_no_file_of_the_machine_of_the_station(place, spacecraft, tmp_path):
    """A command that names such a file is refused, also within `at` and in the preview. The page stays connected."""
    secret, target = tmp_path / "secret", tmp_path / "target"
    secret.write_text("secret")
    attributes = struct.pack(">H1sH1sIB", 1, b"/", 1, b"h", 0, 0)
    spacecraft._answer = lambda packet: success(packet, (23, 4, attributes)) if packet.message == (23, 3) else answer(packet)
    reading = [f"file upload {secret} /h", f"procedure load P {secret}", f"at +5 file upload {secret} /h", f"file upload {tmp_path / 'absent'} /h", "file upload {} /h"]

    async def story(page, _):
        refused = [await page.ask(do=do, text=text) for text in reading for do in ("plan", "command")]
        await page.ask(do="command", text=f"file download /h {target}")
        return refused, await page.until(lambda message: message["kind"] == "command" and message["over"])

    refused, last = visit(place, story)
    assert all("a page cannot send '" in each["refused"] for each in refused)
    assert f"a page cannot write '{target}'" in last["words"] and not target.exists()


def test_a_defect_of_one_command_does_not_end_the_station(place, monkeypatch, capsys):
    def defective(session, timeout_ns):
        yield None
        raise IndexError("the planted defect")

    monkeypatch.setitem(commands.VERBS, "networks", (lambda dictionary, words: Command("networks", defective), "networks", ""))

    async def story(page, _):
        ended = []
        for text in ("networks", "ping MANIPULATOR"):
            await page.ask(do="command", text=text)
            ended.append(await page.until(lambda message: message["kind"] == "command" and message["over"]))
        return ended

    broken, ping = visit(place, story)
    assert broken["unknown"] and "the planted defect" in broken["words"] and ping["answer"] == ["MANIPULATOR is alive"]
    assert "the planted defect" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["", "[]", "{}", "null", '{"do": "fly"}', '{"do": "command"}', '{"do": "live", "line": "time\\npause"}', '{"do": "live", "line": "truth 100"}', "[" * 100_000])
def test_invalid_orders_are_refused(place, text):
    async def story(page, _):
        await page.socket.send_str(text)
        return await page.until(lambda message: "refused" in message)

    assert visit(place, story)["refused"]


@pytest.mark.parametrize("headers", [{}, {"Connection": "Upgrade", "Upgrade": "websocket"}, {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "x"}])
def test_a_client_that_opens_no_websocket_is_told_what_is_expected(place, headers):
    async def run():
        async with station_of(place) as (_, address), ClientSession() as session:
            found = []
            for origin in ({}, {"Origin": address}):
                async with session.get(f"{address}/ws", headers={**origin, **headers}) as answer:
                    found.append((answer.status, await answer.text()))
            return found

    (no_origin, first), (no_upgrade, second) = asyncio.run(run())
    assert (no_origin, no_upgrade) == (403, 400)
    assert first.startswith("found no header Origin, expected that of the page of this station: open http://127.0.0.1:")
    assert second.startswith("found a request without the headers of a WebSocket, expected Upgrade: websocket")


@pytest.mark.parametrize(("text", "words"), [
    ("", "not understood: found '', expected a JSON object such as {\"do\": \"command\", \"text\": \"ping all\"}"),
    ("[" * 100_000, f"not understood: found '{'[' * 200}...' (100000 characters), expected a JSON object"),
    ('{"id": 7}', 'not understood: found no "do", expected "do" with one of command, plan, ask, live, structures, upload, watch, packets, forms, script'),
    ('{"do": 1}', "not understood: found \"do\": '1', expected \"do\" with one of command"),
    ('{"do": "command"}', 'not understood: found no "text" in a request command, expected "text" with a text'),
    ('{"do": "plan", "form": "ping", "values": [1]}', "not understood: found \"values\": '[1]' in a request plan, expected \"values\" with an object"),
    ('{"do": "ask"}', 'not understood: found no "text" in a request ask'),
    ('{"do": "ask", "text": ' + "[" * 5000, "not understood: found '{\"do\": \"ask\", \"text\": "),
    ('{"do": "upload", "words": [], "data": "?"}', "not understood: found \"data\": '?', expected the octets of a file in base64"),
    ('{"do": "packets", "kind": [[1]]}', "not understood: found \"kind\": '[[1]]', expected the \"kind\" of a row"),
])
def test_a_client_that_is_no_page_is_refused_in_plain_words(place, text, words):
    """What it has sent and what was expected, without names of the language in which the station is written."""
    async def story(page, _):
        await page.socket.send_str(text)
        return await page.until(lambda message: "refused" in message)

    refused = visit(place, story)["refused"]
    assert refused.startswith(words) and not re.search(r"Error|NoneType|object is not", refused)


DISPLAY = 4720  # Display structure of MANIPULATOR.


def test_the_display_structure_is_enabled_once_and_disabled_at_the_end(place, spacecraft):
    async def story(page, station):
        for _ in range(2):
            await page.ask(do="command", text="ping MANIPULATOR")
            await page.until(lambda message: message["kind"] == "command" and message["over"])
            while not any(packet.message == (3, 5) for packet in spacecraft.received):
                await asyncio.sleep(0.01)
                station.hub.display.keep()

    visit(place, story)
    made = [packet for packet in spacecraft.received if packet.service == 3 and packet.apid == MANIPULATOR]
    assert [packet.subtype for packet in made] == [5, 6]
    assert {packet.data for packet in made} == {struct.pack(">BH", 1, DISPLAY)}


def test_a_station_enables_the_display_structure_again_after_another_one_has_disabled_it(place, spacecraft, dictionary, monkeypatch):
    """While the reports that another station has enabled arrive, this station enables nothing and has nothing to disable."""
    clock = [100.0]
    monkeypatch.setattr(display_module, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    structure = dictionary.subsystem("MANIPULATOR").configuration("TELEPRESENCE").display
    report = struct.pack(">H", structure.id) + bytes(sum(parameter.size for parameter in structure.once))
    spacecraft._answer = lambda packet: [*([(MANIPULATOR, 3, 25, report, 1)] if clock[0] < 101 else []), *answer(packet)]

    async def story(page, station):
        enabled = []
        for clock[0] in (100.0, 102.0):
            await page.ask(do="command", text="ping MANIPULATOR")
            await page.until(lambda message: message["kind"] == "command" and message["over"])
            station.hub.display.keep()
            enabled.append(set(station.hub.display.enabled))
        return enabled

    assert visit(place, story) == [set(), {("MANIPULATOR", DISPLAY)}]
    assert (3, 5) in [packet.message for packet in spacecraft.received if packet.apid == MANIPULATOR]


def test_a_configuration_without_a_display_structure_is_left_alone(place, spacecraft, monkeypatch):
    monkeypatch.setattr(dictionary_module.Configuration, "display", None)

    async def story(page, station):
        await page.ask(do="command", text="ping MANIPULATOR")
        await page.until(lambda message: message["kind"] == "command" and message["over"])
        station.hub.display.keep()
        assert not station.hub.display.enabled

    visit(place, story)
    assert not [packet for packet in spacecraft.received if packet.message in ((3, 1), (3, 5), (3, 6))]


def test_structures_enabled_for_pages_are_disabled_when_the_last_page_leaves(place, spacecraft, monkeypatch):
    """The display structure and a structure that a page has enabled in its tables are disabled; one that an operator
    has enabled is not."""
    monkeypatch.setattr(hub_module, "LEAVE_S", 0.0)

    async def story(page, station):
        for order in ({"text": "hk enable MANIPULATOR 4712", "display": True}, {"text": "hk enable MANIPULATOR 4711"}, {"text": "ping MANIPULATOR"}):
            await page.ask(do="command", **order)
            await page.until(lambda message: message["kind"] == "command" and message["over"])
        while ("MANIPULATOR", DISPLAY) not in station.hub.display.enabled:
            await asyncio.sleep(0.01)
        await page.socket.close()
        while len(disabled(spacecraft)) < 2:
            await asyncio.sleep(0.01)

    visit(place, story)
    assert sorted(disabled(spacecraft)) == [4712, DISPLAY]


def disabled(spacecraft):
    """Ids of the structures that were disabled."""
    return [int.from_bytes(packet.data[1:3], "big") for packet in spacecraft.received if packet.message == (3, 6)]


def test_the_page_is_informed_which_structures_are_enabled(place, spacecraft):
    properties = {4711: 1, 4712: 0}

    def asked(packet):
        if packet.message == (3, 33):
            number = int.from_bytes(packet.data[1:3], "big")
            return success(packet, (3, 35, struct.pack(">HHBI", 1, number, properties[number], 500))) if number in properties else failure(packet, 4, 0x0201, 0)
        return answer(packet)

    spacecraft._answer = asked

    async def story(page, _):
        await page.ask(do="command", text="ping MANIPULATOR")
        await page.until(lambda message: message["kind"] == "command" and message["over"])
        await page.ask(do="structures", subsystem="MANIPULATOR")
        return await page.until(lambda message: message["kind"] == "structures")

    rows = visit(place, story)["rows"]
    assert [(row["id"], row["enabled"]) for row in rows] == [(4711, True), (4712, False)]


def test_a_gap_in_the_counters_of_messages_is_a_loss(dictionary):
    hub = hub_module.Hub("nowhere", lambda message: None)
    hub.identity = Identity(3, "WEB", True)
    for counter, user in ((7, 0), (8, 0), (11, 0), (3, 3), (5, 3), (9, 2), (30, 2), (0, 0), (60000, 0), (60001, 0)):
        hub._count(Packet("TM", MANIPULATOR, 0, 3, 25, user, b"", b"", counter=counter), "MANIPULATOR")
    assert hub.counts["rows"] == {"MANIPULATOR": {"received": 10, "lost": 3}}


def test_pages_follow_the_end_of_a_flight_and_the_next_flight(place, spacecraft):
    """The page is informed that the link is lost, then it gets all data of the next flight, and commands
    reach that flight."""
    second = Spacecraft(answer)

    async def story(page, station):
        begin(place, "second", second.port, "none.xml")
        spacecraft.close()
        station.hub._connection.abort()
        await page.until(lambda message: message["kind"] == "link" and not message["is_live"])
        hello = await page.until(lambda message: message["kind"] == "hello")
        await page.until(lambda message: message["kind"] == "link" and message["is_live"])
        await page.ask(do="command", text="ping JOYSTICK")
        await page.until(lambda message: message["kind"] == "command" and message["over"])
        return hello, [message["kind"] for message in station.hub.snapshot()]

    hello, kinds = visit(place, story)
    second.close()
    assert hello["world"] is None and "none.xml" in hello["world_problem"]
    assert hello["flight"].endswith("second") and kinds.count("command") == 1
    assert (17, 1) in [packet.message for packet in second.received]


@pytest.mark.parametrize("facts, expected", [
    ({}, {"text": "the flight of first has ended; run.json: exit_code: found none, expected a whole number"}),
    ({"exit_code": 0, "exit_reason": "", "simulated_s": 93.62}, {"text": "flight ended at 93.62 s, code 0", "code": 0}),
    ({"exit_code": 1, "exit_reason": "simulated time stands still", "simulated_s": 7}, {"text": "flight failed at 7.00 s, code 1: simulated time stands still", "code": 1}),
])
def test_the_port_of_a_flight_that_has_ended_is_not_connected_again(place, spacecraft, facts, expected):
    """The launcher uses the first free port: the port of a flight that has ended may belong to a flight with
    another run directory. The page says how the flight ended."""

    async def story(page, station):
        (place / "first" / "run.json").write_text(json.dumps(facts))
        station.hub._connection.abort()
        return await page.until(lambda message: message["kind"] == "link" and message["text"] == expected["text"])

    assert visit(place, story) == {"kind": "link", "is_live": False, **expected}


def test_a_command_under_way_ends_with_the_link(place, spacecraft):
    """The page shows the reason."""

    def silent(packet):
        return None if packet.message == (17, 1) else answer(packet)

    spacecraft._answer = silent

    async def story(page, _):
        await page.ask(do="command", text="ping MANIPULATOR")
        return await page.until(lambda message: message["kind"] == "command" and message["over"])

    assert "the link was lost" in visit(place, story)["words"]


def test_only_the_page_of_the_station_is_served(place):
    """A page of another origin, a client without an origin, and another host name for this address are
    refused."""

    async def run():
        async with station_of(place) as (_, address), ClientSession() as session:
            found = []
            for headers in ({"Origin": "http://elsewhere.example"}, {}, {"Origin": "null"}, {"Host": "elsewhere.example", "Origin": "http://elsewhere.example"}):
                with pytest.raises(WSServerHandshakeError) as refused:
                    await session.ws_connect(f"{address}/ws", headers=headers)
                found.append(refused.value.status)
            async with session.get(f"{address}/", headers={"Host": "elsewhere.example"}) as reply:
                found.append(reply.status)
            for path in ("page/../secret", f"page/{300 * 'x'}", f"page/{2500 * 'x/'}", f"{5000 * 'x'}"):
                async with session.get(f"{address}/{path}") as reply:
                    found.append(reply.status)
            async with session.get(f"{address}/") as reply:
                return found, reply.status, reply.headers["Content-Security-Policy"], await reply.text()

    answers, code, policy, text = asyncio.run(run())
    assert answers == [403] * 5 + [404] * 4
    assert code == 200 and policy.startswith("default-src 'self'") and "page" in text


def test_a_slow_browser_loses_housekeeping_only():
    """The browser receives the number of dropped messages before the rest."""
    sent = []

    class Socket:
        async def send_str(self, text):
            sent.append(json.loads(text))

    browser = _Browser(Socket())
    browser.put('{"kind": "event"}')
    for number in range(QUEUE + 50):
        browser.put(json.dumps({"kind": "housekeeping", "n": number}))
    assert len(browser.waiting) == QUEUE and browser.dropped == 51
    assert browser.waiting[0] == '{"kind": "event"}' and json.loads(browser.waiting[-1])["n"] == QUEUE + 49

    async def send():
        sender = asyncio.create_task(browser.send())
        while browser.waiting:
            await asyncio.sleep(0)
        browser.put('{"kind": "event", "n": 2}')
        while browser.waiting:
            await asyncio.sleep(0)
        sender.cancel()

    asyncio.run(send())
    assert sent[:2] == [{"kind": "dropped", "updates": 51}, {"kind": "event"}] and len(sent) == QUEUE + 2 and sent[-1]["n"] == 2


def test_a_station_without_other_messages_sends_that_it_runs():
    sent = []

    class Socket:
        async def send_str(self, text):
            sent.append(text)

    async def listen():
        browser = _Browser(Socket())
        sender = asyncio.create_task(browser.send())
        while sent.count(ALIVE) < 2:
            await asyncio.sleep(ALIVE_S / 10)
        browser.put("last")
        while sent[-1] != "last":
            await asyncio.sleep(0)
        sender.cancel()

    asyncio.run(asyncio.wait_for(listen(), 60 * ALIVE_S))
    assert set(sent) == {ALIVE, "last"} and sent.count("last") == 1


def test_requestable_states_are_those_of_the_documentation():
    text = (ROOT / "docs" / "states.md").read_text(encoding="utf-8")
    table = text.split("<!-- table: requests -->")[1].split("<!-- end -->")[0]
    rest = (0, 3, 4, 5, 6)
    for row in re.findall(r"^\| (\d) \w+ \|(.*)\|$", table, re.MULTILINE):
        cells = [cell.strip() for cell in row[1].split("|")]
        legal = {target for target, cell in zip(rest, cells) if cell not in ("no", "done", "busy")}
        assert set(targets_module.LEGAL[int(row[0])]) == legal


@pytest.mark.parametrize(
    "mode, configuration, links, state, partner, target, reason",
    [
        ("NOMINAL", TELEPRESENCE, {"ROBOT_STATE", "HAND_POSITION"}, 3, 3, 4, None),
        ("SAFE", TELEPRESENCE, {"ROBOT_STATE", "HAND_POSITION"}, 3, 3, 4, "not permitted in mode SAFE"),
        ("NOMINAL", 0, set(), 3, 3, 4, "no configuration is selected"),
        ("NOMINAL", TELEPRESENCE, {"ROBOT_STATE"}, 3, 3, 4, "link HAND_POSITION is not open"),
        ("NOMINAL", TELEPRESENCE, {"ROBOT_STATE", "HAND_POSITION"}, 5, 5, 0, "JOYSTICK is still OPERATIONAL"),
        ("NOMINAL", TELEPRESENCE, {"ROBOT_STATE", "HAND_POSITION"}, 5, 4, 0, None),
        ("NOMINAL", TELEPRESENCE, {"ROBOT_STATE", "HAND_POSITION"}, 5, 5, 6, None),
    ],
)
def test_a_state_that_cannot_be_commanded_has_the_reason(dictionary, mode, configuration, links, state, partner, target, reason):
    session = Session(dictionary)
    session.mode = mode
    session.configurations[MANIPULATOR] = configuration
    session.states.update({MANIPULATOR: STATES[state], JOYSTICK: STATES[partner]})
    assert targets_module.targets(session, dictionary.subsystem("MANIPULATOR"), links)[target] == reason


@pytest.mark.parametrize(
    "stages, is_finished, cells",
    [
        ([], False, ["waiting", "empty", "empty", "empty"]),
        ([1], False, ["done", "waiting", "empty", "empty"]),
        ([1, 3], False, ["done", "done", "empty", "waiting"]),
        ([1, 3, 5, 7], True, ["done", "done", "done", "done"]),
        ([1, 3, 7], True, ["done", "done", "none", "done"]),
        ([2], True, ["failed", "empty", "empty", "empty"]),
        ([1, 3, 8], True, ["done", "done", "empty", "failed"]),
    ],
)
def test_the_lights_show_the_stages_of_a_request(stages, is_finished, cells):
    verification = Verification(None, b"", 0, stages, is_finished=is_finished)
    assert lights_of([verification]) == cells


def test_housekeeping_becomes_leaves_with_their_paths():
    values = {"CUR": {"A": [1.0, 2.0], "B": [3]}, "SAMPLED": [[1.0, 2.0], [3.0, 4.0]], "ONE": (5,)}
    assert telemetry.leaves(values) == {"CUR.A": [1.0, 2.0], "CUR.B": [3], "SAMPLED": [3.0, 4.0], "ONE": [5]}


def test_only_a_page_of_this_machine_may_show_the_station_in_a_frame(tmp_path, capsys):
    parser = station_main._parser()
    assert parser.parse_args([]).framed_by == "http://127.0.0.1:8080" and parser.parse_args(["--framed-by", "none"]).framed_by == "'none'"
    for wrong in ("http://example.org:80", "https://127.0.0.1:80", "*"):
        with pytest.raises(SystemExit):
            parser.parse_args(["--framed-by", wrong])
        assert f"found '{wrong}', expected none or a page of this machine" in capsys.readouterr().err
    for framed_by in ("'none'", "http://127.0.0.1:8081"):
        policy = Station(tmp_path, tmp_path, framed_by=framed_by)._headers["Content-Security-Policy"]
        assert f"frame-ancestors {framed_by};" in policy


def test_a_run_is_replayed_by_the_command_line(flight_directory, tmp_path, monkeypatch, capsys):
    """`gse replay RUN` opens the page as a replay with the recording of this run."""
    found = {}

    async def visit_page(application, listener):
        runner = web.AppRunner(application)
        await runner.setup()
        await web.SockSite(runner, listener).start()
        address = re.search(r"http://127.0.0.1:[0-9]+/", capsys.readouterr().out)[0]
        async with ClientSession() as browser:
            async with browser.get(address, allow_redirects=False) as answered:
                found["page"] = answered.status, answered.headers.get("Location")
            async with browser.get(f"{address}recording") as answered:
                found["recording"] = answered.status, await answered.read()
        await runner.cleanup()

    monkeypatch.setattr(web, "run_app", lambda application, sock, print, shutdown_timeout: asyncio.run(visit_page(application, sock)))
    monkeypatch.setattr(station_main, "ROOT", tmp_path)
    assert main(["replay", str(flight_directory), "--http-port", "0"]) == 2
    assert capsys.readouterr().err == f"gse: station: {tmp_path}/build/station/page has no page; run make gse\n"
    (tmp_path / "build" / "station" / "page").mkdir(parents=True)
    (tmp_path / "build" / "station" / "page" / "index.html").write_text("<html>", encoding="utf-8")
    assert main(["replay", str(flight_directory), "--http-port", "0"]) == 0
    assert found["page"] == (302, "/?replay")
    assert found["recording"][0] == 200 and len(found["recording"][1]) > 1000
    (tmp_path / "kept.recording").write_bytes(found["recording"][1][:500])
    assert main(["replay", str(tmp_path / "kept.recording"), "--http-port", "0"]) == 0
    assert found["recording"] == (200, (tmp_path / "kept.recording").read_bytes())  # A file is sent as it is.
    monkeypatch.setattr(station_main, "_load", lambda: importlib.import_module("hirosco_gse.no_package"))
    assert main(["replay", str(flight_directory), "--http-port", "0"]) == 2
    assert capsys.readouterr().err.endswith("after make setup call build/venv/bin/gse replay\n")
    assert main(["replay", str(tmp_path / "nothing")]) == 2 and "there is no run directory" in capsys.readouterr().err
    assert main(["replay", "a", "b"]) == 2 and "usage: replay [RUN] [--http-port PORT]" in capsys.readouterr().err


def test_a_dictionary_that_cannot_be_read_is_named(place, monkeypatch):
    monkeypatch.setattr(run_directory, "default_dictionary", lambda run: place / "none.json")

    async def run():
        async with station_of(place) as (_, address), ClientSession() as session:
            async with session.ws_connect(f"{address}/ws", headers={"Origin": address}) as socket:
                page = Page(socket)
                await page.until(lambda message: "none.json" in message.get("text", ""))
                await page.ask(do="forms")
                return [message["text"] for message in page.heard if message["kind"] == "link"][-1]

    assert asyncio.run(run()) == f"{place}/none.json: No such file or directory; run make"
