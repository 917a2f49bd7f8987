# SPDX-License-Identifier: Apache-2.0
"""The light station among other clients and over time: its user number, commands that last, faults and hand,
links, the world of the flight."""

import asyncio
import os
import pathlib
import re
import struct
import subprocess
import sys

import pytest
from conftest import ROOT
from hirosco_gse import live
from hirosco_gse import run_directory
from hirosco_gse.session import LinkLost, TimedOut
from hirosco_gse.station import hub as hub_module
from hirosco_gse.station import network as network_module
from hirosco_gse.station import world_port as world_port_module
from hirosco_gse.station.identity import Identity
from spacecraft import success
from tm_packets import build_tm
from visiting import JOYSTICK, MANIPULATOR, TELEPRESENCE, answer, visit


def test_each_station_at_a_flight_is_a_user_of_its_own(dictionary):
    """Stations in other processes count, too; the user number of a station that has ended is free again. If
    there are more stations than users, each further station shares the first number."""
    here, elsewhere = 100_000 + 2 * os.getpid(), 100_001 + 2 * os.getpid()  # Larger than each number of a port, so no other process uses them.
    numbers = [user["id"] for user in dictionary.content["users"] if user["name"].startswith("WEB")]
    claimed = [Identity.claim(dictionary, here) for _ in numbers]
    assert [each.number for each in claimed] == numbers and len(numbers) >= 4 and all(each.is_own for each in claimed)
    words = "import sys; from hirosco_gse.dictionary import Dictionary; from hirosco_gse.station.identity import Identity; " \
            "found = Identity.claim(Dictionary.load(sys.argv[1]), int(sys.argv[2])); print(found.number, found.is_own)"
    path = ROOT / "build" / "generated" / f"{dictionary.mission}.json"
    shared = subprocess.run([sys.executable, "-c", words, path, str(here)], env={"PYTHONPATH": str(ROOT / "gse")}, capture_output=True, text=True, check=True)
    assert shared.stdout.split() == [str(numbers[0]), "False"]
    assert Identity.claim(dictionary, elsewhere).number == numbers[0]  # At another flight.
    claimed[1].release()
    assert Identity.claim(dictionary, here).number == numbers[1]


@pytest.mark.parametrize("mission", sorted(path.stem for path in (ROOT / "descriptors" / "missions").glob("*.xml")))
def test_every_mission_has_users_for_stations(mission):
    """This includes the missions that the scaffolds make: copies of these or of
    gse/scaffold/robot/mission.xml."""
    for path in (ROOT / "descriptors" / "missions" / f"{mission}.xml", ROOT / "gse" / "scaffold" / "robot" / "mission.xml"):
        names = re.findall(r'<User name="(\w+)"', path.read_text(encoding="utf-8"))
        assert {"CLI", "YAMCS"} <= set(names) and sum(name.startswith("WEB") for name in names) >= 4


def test_a_command_that_lasts_has_not_failed(place, spacecraft):
    """Between start and completion 600 s of simulated time pass, during which telemetry arrives: the lights
    wait for the spacecraft's report."""
    pinged = []

    def late(packet):
        if packet.message == (17, 1) and packet.apid == JOYSTICK:
            pinged.append(packet)
            return success(packet)[:2]
        return answer(packet)

    spacecraft._answer = late

    async def story(page, station):
        asked = await page.ask(do="command", text="ping JOYSTICK")
        await page.until(lambda message: message["kind"] == "command" and message["lights"][1] == "done")
        call, at = next(call for call in station.hub.calls if call.number == asked["command"]), station.hub.session.now_ns
        for seconds in (30, 300, 600):
            station.hub.session.advance(at + seconds * 10**9)
            station.hub._resume_all()
        before = call.message()
        for apid, service, subtype, data, user in success(pinged[0], (17, 2, b""))[2:]:
            station.hub.session.feed(build_tm(apid, 0, service, subtype, data, user, station.hub.session.now_ns))
        station.hub._resume_all()
        return asked["command"], before, call.message()

    number, before, after = visit(place, story)
    assert (before["number"], before["over"], before["silent"], before["lights"]) == (number, False, False, ["done", "done", "empty", "waiting"])
    assert after["over"] and "words" not in after and after["lights"] == ["done", "done", "none", "done"]


def test_a_request_without_any_report_is_not_answered_and_has_not_failed(place, spacecraft):
    spacecraft._answer = lambda packet: [] if packet.apid == JOYSTICK else answer(packet)

    async def story(page, station):
        asked = await page.ask(do="command", text="ping JOYSTICK")
        call = next(call for call in station.hub.calls if call.number == asked["command"])
        # The telecommand may wait until the first requests of the station have ended.
        while not call.is_silent:
            station.hub.session.advance(station.hub.session.now_ns + 11 * 10**9)
            station.hub._resume_all()
            await asyncio.sleep(0.01)
        silent = await page.until(lambda message: message["kind"] == "command" and message["silent"])
        station.hub._connection.abort()
        return silent, await page.until(lambda message: message["kind"] == "command" and message["over"])

    silent, lost = visit(place, story)
    assert not silent["over"] and "failed" not in silent["lights"] and "words" not in silent
    assert lost["unknown"] and "failed" not in lost["lights"]


class World:
    """Replaces WorldPort, the client of the live port: stores each line and accepts it."""

    def __init__(self):
        self.lines, self.speed, self.hand = [], 1.0, None

    async def ask(self, line):
        self.lines.append(line)
        return 2.5, False


def test_a_page_causes_faults_and_moves_the_hand_unless_another_client_has_it(place, monkeypatch):
    """Faults are typed and come from a form. While one page aims the hand, another page and lines of other
    programs are refused; the message says who has the hand."""
    world = World()

    async def story(page, station):
        station.hub.world_port = world
        typed = await page.ask(do="command", text="fault unplug robot JOINT1")
        filled = await page.ask(do="command", form="fault loss", values={"bus": "robot", "probability": "0.1"})
        planned = await page.ask(do="plan", text="hand press 10 0.05")
        aimed = await page.ask(do="live", line="hand aim 0.1 0 0.03")
        reported = next(message for message in page.heard if message["kind"] == "hand" and message["page"])
        other = await station.hub.live("hand rest", -1)
        own = await page.ask(do="live", line="hand rest")
        world.hand = "station-WEB_2"
        later = await page.ask(do="live", line="hand aim 0.1 0 0.03")
        return typed, filled, planned, aimed, reported, other, own, later

    typed, filled, planned, aimed, reported, other, own, later = visit(place, story)
    assert (typed["time"], filled["time"], aimed["time"]) == (2.5, 2.5, 2.5) and planned["messages"] == ["line for the simulator"]
    assert [line for line in world.lines if line != "time"] == ["fault unplug robot JOINT1", "fault loss robot 0.1", "hand aim 0.1 0 0.03", "hand rest"]
    assert reported["page"] > 0 and other["refused"] == "the hand is taken by another page" and "refused" not in own
    assert later["refused"] == "the hand is taken by station-WEB_2"


def test_simulated_time_is_paused_in_a_step(place):
    """While the step lasts, the live port answers that simulated time passes."""
    answers = {"pause": (2.0, True), "step 0.5": (2.0, False), "time": (2.4, False), "resume": (2.5, False)}

    class Stepping(World):
        async def ask(self, line):
            return answers[line]

    async def story(page, station):
        station.hub.world_port = Stepping()
        paused = []
        for line in ("pause", "step 0.5", "time", "resume", "time"):
            await page.ask(do="live", line=line)
            paused.append(station.hub.pace["is_paused"])
        return paused

    assert visit(place, story) == [True, True, True, False, False]


@pytest.mark.parametrize("has_hand", [True, False])
def test_the_hand_rests_when_the_page_that_aimed_last_is_closed(place, has_hand):
    """Closing another page leaves the hand as it is."""
    world = World()

    async def story(page, station):
        station.hub.world_port = world
        if has_hand:
            await page.ask(do="live", line="hand aim 0.1 0 0.03")
        else:
            await station.hub.live("hand aim 0.1 0 0.03", -1)
        await page.socket.close()
        while station.browsers or has_hand and "hand rest" not in world.lines:
            await asyncio.sleep(0.01)
        return [line for line in world.lines if line.startswith("hand")]

    assert visit(place, story) == ["hand aim 0.1 0 0.03", *(["hand rest"] if has_hand else [])]


def test_lines_of_a_page_do_not_wait_for_the_answers_of_others(place):
    """The simulator answers when it has three lines, which keep their order; the page can send other requests meanwhile."""
    class Slow(World):
        is_full = asyncio.Event()

        async def ask(self, line):
            if line != "time":
                self.lines.append(line)
                if len(self.lines) == 3:
                    self.is_full.set()
                await self.is_full.wait()
            return 2.5, False

    world = Slow()

    async def story(page, station):
        station.hub.world_port = world
        for number, do in enumerate(("live", "live", "plan", "live")):
            await page.socket.send_json({"do": do, "line": f"hand aim 0.{number} 0 0.03", "text": "ping JOYSTICK", "id": 10 + number})
        answered = [(await page.until(lambda message: message.get("id", 0) >= 10))["id"] for _ in range(4)]
        return answered[0], sorted(answered)

    assert visit(place, story) == (12, [10, 11, 12, 13])
    assert [line.split()[2] for line in world.lines[:3]] == ["0.0", "0.1", "0.3"]


async def _port(directory, answered):
    """A live port that calls answered(line, writer) for each line; its file is in the directory."""
    async def serve(reader, writer):
        while line := await reader.readline():
            answered(line.decode().strip(), writer)

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    (directory / "live.port").write_text(f"{server.sockets[0].getsockname()[1]}\n", encoding="ascii")
    return server


def test_answers_of_the_live_port_belong_to_lines_in_their_order(tmp_path):
    """The port answers the name and three lines at once. The task that asked the second of the three has ended by then."""
    lines = []

    def answered(line, writer):
        lines.append(line)
        if len(lines) == 4:
            writer.write(b"ok 0.1\nok 0.2 speed 2\nok 0.3 speed 3\nrefused live:4: found 'x'\n")

    async def story():
        async with await _port(tmp_path, answered):
            port = world_port_module.WorldPort("me")
            port.move_to(tmp_path, "me")
            asked = [asyncio.create_task(port.ask(line)) for line in ("hand rest", "hand hold", "hand x")]
            while len(lines) < 3:
                await asyncio.sleep(0)
            asked[1].cancel()
            found = await asyncio.gather(*asked, return_exceptions=True)
            port.close()
            return found

    first, second, third = asyncio.run(story())
    assert first == (0.2, False) and isinstance(second, asyncio.CancelledError)
    assert isinstance(third, live.LiveRefused) and lines == ["name me", "hand rest", "hand hold", "hand x"]


def test_all_lines_without_an_answer_are_lost_with_the_connection(tmp_path):
    """The next line opens another connection."""
    lines = []

    def answered(line, writer):
        lines.append(line)
        if len(lines) == 3:
            writer.close()
        elif len(lines) > 3:
            writer.write(b"ok 1.5\n")

    async def story():
        async with await _port(tmp_path, answered):
            port = world_port_module.WorldPort("me")
            port.move_to(tmp_path, "me")
            found = await asyncio.gather(port.ask("hand rest"), port.ask("hand hold"), return_exceptions=True)
            again = await port.ask("time")
            port.close()
            return found, again

    found, again = asyncio.run(story())
    assert [str(problem) for problem in found] == ["the flight has ended"] * 2 and all(isinstance(problem, LinkLost) for problem in found)
    assert again == (1.5, False)


def test_a_row_of_the_true_state_becomes_values_of_the_page():
    names = "time arm.j1.position arm.j1.torque arm.j1.brake arm.j2.position arm.j2.torque arm.j2.brake STICK.1.position STICK.1.torque STICK.1.hand " \
            "arm.tip.contact arm.tip.contact-x arm.tip.contact-y arm.tip.contact-z arm.hook.spring arm.hook.spring-x arm.hook.spring-y arm.hook.spring-z " \
            "arm.x arm.y arm.z arm.qw arm.qx arm.qy arm.qz target.x target.y target.z target.qw target.qx target.qy target.qz RW1.momentum RW2.momentum PUSH.open"
    columns = names.split()
    assert world_port_module.poses_of(columns, list(range(35))) == {
        "CUR_VALUES.POSITION": [1, 4], "CUR_VALUES.TORQUE": [2, 5], "BRAKE": [3, 6], "FORCE": [26, 28, 30], "HOOKED": [14],
        "BASE": list(range(18, 32)), "WHEEL": [32, 33], "VALVE": [34]}
    assert world_port_module.names_of(columns) == {"joints": ["arm.j1", "arm.j2"], "contacts": ["arm.tip"], "springs": ["arm.hook"],
                                                   "bases": ["arm", "target"], "wheels": ["RW1", "RW2"], "valves": ["PUSH"]}
    assert world_port_module.poses_of(["time", "a.j.position", "a.j.torque", "a.j.brake"], [0.0, 1.0, 2.0, 0.0]) == {
        "CUR_VALUES.POSITION": [1.0], "CUR_VALUES.TORQUE": [2.0], "BRAKE": [0.0]}


def test_only_pages_that_request_the_true_state_get_it(place):
    async def story(page, station):
        truth = {"kind": "truth", "time": 1.0, "values": {}}
        station.publish(truth)
        await page.ask(do="watch", truth=True)
        is_followed = station.hub.truth._task is not None
        station.publish({**truth, "time": 2.0})
        await page.ask(do="watch", bus=None)
        heard = [message["time"] for message in page.heard if message["kind"] == "truth"]
        await page.ask(do="watch", truth=False)
        return heard, is_followed, station.hub.truth._task

    assert visit(place, story) == ([2.0], True, None)


def test_the_page_shows_the_pace_that_another_client_sets(place):
    world = World()

    async def story(page, station):
        station.hub.world_port = world
        world.speed = 0.25
        return await page.until(lambda message: message["kind"] == "pace" and message["speed"] == 0.25)

    assert visit(place, story)["is_there"]


@pytest.mark.parametrize(("words", "pace"), [("ok 1.0", (1.0, None)), ("ok 1.0 paused speed 0.5", (0.5, None)), ("ok 1.0 speed 0 hand station-WEB", (0.0, "station-WEB"))])
def test_answers_of_the_live_port_have_pace_and_hand(words, pace):
    answer_words = words.split()
    assert live.pace_of(answer_words) == pace and live.taken(answer_words) == (1.0, "paused" in words)


def test_rows_of_the_true_state_are_no_answers(tmp_path):
    """A client of this port may have requested them, for example AsyncSpacecraft.live."""

    async def answering(reader, writer):
        while line := await reader.readline():
            writer.write(b"truth 0.9 0\nframe (0.9) robot 080#\nok 1.0\n" if line != b"pause\n" else b"columns time x\nok 2.0 paused\n")

    async def story():
        async with await asyncio.start_server(answering, "127.0.0.1", 0) as server:
            (tmp_path / "live.port").write_text(f"{server.sockets[0].getsockname()[1]}\n")
            port = world_port_module.WorldPort()
            port.move_to(tmp_path, "test")
            found = await port.ask("truth 100"), await port.ask("pause")
            port.close()
            return found

    assert asyncio.run(story()) == ((1.0, False), (2.0, True))


def test_the_world_is_that_of_the_flight(tmp_path):
    (tmp_path / "ground.mission").write_text("rokviss\n")
    assert run_directory.world_of(tmp_path).name == "rokviss.xml"
    assert run_directory.scenario_of(tmp_path) == ""
    for name in ("telepresence", "none", "own/telepresence.scn"):
        (tmp_path / "ground.scenario").write_text(f"{name}\n")
        assert run_directory.scenario_of(tmp_path) == pathlib.Path(name).stem
    (tmp_path / "ground.world").write_text("rokviss-20bit\n")
    assert run_directory.world_of(tmp_path).name == "rokviss-20bit.xml" and run_directory.world_of(tmp_path).exists()
    (tmp_path / "ground.world").write_text(f"{tmp_path}/own.xml\n")
    assert run_directory.world_of(tmp_path) == tmp_path / "own.xml"


def links_answer(received):
    """Answers of supervisor and members about the link ROBOT_STATE, which is open and has received `received[0]` samples."""
    def row(count):
        return struct.pack(">HHBHHHH", 1, 1, 3, MANIPULATOR, 1, JOYSTICK, 2) + struct.pack(">IIBIHBBI", 1, 32, 0, 500, 10, 0, 1, 2000) + struct.pack(">IIIII", 0, count, 2, 0, 0)

    def answered(packet):
        if packet.message == (130, 8):
            return success(packet, (130, 9, row(received[0] if packet.apid == JOYSTICK else 0)))
        return answer(packet)

    return answered


def test_the_status_of_links_is_requested_while_a_page_is_open(place, spacecraft, monkeypatch):
    """The count of received samples follows; a transition is shown at once with its cause."""
    received = [1000]
    spacecraft._answer = links_answer(received)
    monkeypatch.setattr(network_module, "POLL_S", 0.0)

    async def story(page, station):
        await page.until(lambda message: message["kind"] == "links" and message["rows"][0].get("received") == 1000)
        received[0] = 3000
        grown = await page.until(lambda message: message["kind"] == "links" and message["rows"][0].get("received") == 3000)
        station.hub.network.transition({"link": 1, "state": "failed", "cause": "STALE"})
        failed = await page.until(lambda message: message["kind"] == "links" and message["rows"][0]["state"] == "failed")
        return grown, failed

    grown, failed = visit(place, story)
    row = next(row for row in grown["rows"] if row["name"] == "ROBOT_STATE")
    assert (row["state"], row["lost"], row["period_us"]) == ("open", 2, 500)
    assert next(row for row in failed["rows"] if row["name"] == "ROBOT_STATE")["cause"] == "STALE"


def test_rate_and_age_of_a_link_are_computed_from_simulated_time():
    hub = hub_module.Hub("nowhere", lambda message: None)
    found = {"state": "open", "properties": {"period_us": 500}, "sent": 0, "received": 100, "lost": 0, "late": 0}
    hub.seconds = 10.0
    hub.network._rows = {"A": hub.network._row("A", found)}
    hub.seconds = 10.5
    hub.network._rows = {"A": hub.network._row("A", {**found, "received": 1100})}
    assert (hub.network._rows["A"]["rate"], hub.network._rows["A"]["heard"]) == (2000.0, 10.5)
    hub.seconds = 11.0
    row = hub.network._row("A", {**found, "received": 1100})
    assert (row["rate"], row["heard"]) == (0.0, 10.5)


def test_the_first_telemetry_ends_no_request(dictionary):
    """The time of the session begins with the first telemetry: the time before does not count as waiting of a
    request."""
    session = hub_module.WebSession(dictionary, source=3)
    waiting = session.wait_for(lambda: False, 10**9, "a report")
    next(waiting)
    session.advance(dictionary.epoch_ns)
    next(waiting)
    session.advance(dictionary.epoch_ns + 2 * 10**9)
    with pytest.raises(TimedOut):
        next(waiting)


def test_the_page_is_informed_that_other_device_classes_fly(place, spacecraft):
    (place / "latest" / "ground.classes").write_text("0x01\n", encoding="ascii")

    async def story(page, station):
        reported = await page.until(lambda message: message["kind"] == "mismatch")
        return reported["subsystem"], reported["words"]

    subsystem, words = visit(place, story)
    assert subsystem == "device classes" and words.startswith("the flight has device classes 0x01, ")


def test_the_page_is_informed_that_another_interface_flies(place, spacecraft):
    """Each subsystem is reported once, also to a page that connects later."""
    def other(packet):
        return answer(packet) + ([(MANIPULATOR, 129, 5, struct.pack(">BBBHQQII", 3, 0, 3, TELEPRESENCE, 7, 0, 0, 0), 1)] if packet.message == (17, 1) else [])

    spacecraft._answer = other

    async def story(page, station):
        await page.ask(do="command", text="ping JOYSTICK")
        reports = await page.until(lambda message: message["kind"] == "mismatch")
        return reports, [message for message in station.hub.snapshot() if message["kind"] == "mismatch"]

    reports, later = visit(place, story)
    assert later == [reports] and reports["subsystem"] == "MANIPULATOR" and "the dictionary has" in reports["words"]
