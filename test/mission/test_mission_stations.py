# SPDX-License-Identifier: Apache-2.0
"""Several stations at one flight of a mission that is not the default one: each gets its own verifications,
all show the same telemetry, and a station that stops or dies does not disturb the flight."""

import asyncio
import contextlib
import re
import signal
import subprocess

import flying
import pytest
from aiohttp import ClientSession, ClientWSTimeout
from hirosco_gse.dictionary import Dictionary
from hirosco_gse.session import Rejected
from hirosco_gse.spacecraft import Spacecraft

STATIONS = 2
INTERLEAVED = 20
CLOSING = ClientWSTimeout(ws_close=0.5)  # A station that was stopped does not answer.
SCENARIO = ("0.1 operator state UR5E PRE_OPERATIONAL", "0.2 operator config UR5E POSITION", "3600 operator shutdown")


@pytest.fixture(scope="module")
def flight(session_directory):
    subprocess.run(["make", "-s", "build/station/page/index.html"], cwd=flying.ROOT, check=True)
    scenario = session_directory / "stations.scn"
    flying.write_scenario(scenario, *SCENARIO)
    flight = flying.start(session_directory / "stations", "--mission", "ur5e", "--time", "real", "--scenario", scenario)
    flight.port()
    yield flight
    flight.abandon()


class Station:
    """A station process beside the flight."""

    def __init__(self, flight):
        words = [flying.ROOT / "build" / "venv" / "bin" / "python", "-m", "hirosco_gse.station", "--run", flight.directory, "--http-port", "0"]
        self.process = subprocess.Popen(words, cwd=flying.ROOT, stdout=subprocess.PIPE, text=True)
        self.address = re.search(r"http://127\.0\.0\.1:\d+", self.process.stdout.readline()).group()

    def close(self):
        """End the process, whatever it is doing."""
        with contextlib.suppress(ProcessLookupError):
            self.process.kill()
        self.process.wait(flying.MOMENT_S)
        self.process.stdout.close()


@pytest.fixture(scope="module")
def stations(flight):
    found = [Station(flight) for _ in range(STATIONS)]
    yield found
    for station in found:
        station.close()


def ask(address, commands, at_end=lambda: None):
    """Messages of a station: the greeting, then for each command the answer and the message about its end. at_end() is called while the
    page is open."""

    async def run():
        messages = []
        async with ClientSession() as session, session.ws_connect(f"{address}/ws", headers={"Origin": address}, timeout=CLOSING) as socket:

            async def until(condition):
                while True:
                    message = await socket.receive_json(timeout=flying.MOMENT_S)
                    if condition(message):
                        messages.append(message)
                        return message

            await until(lambda message: message["kind"] == "hello")
            for text in commands:
                await socket.send_json({"do": "command", "text": text, "id": 1, "display": True})
                number = (await until(lambda message: message.get("id") == 1)).get("command")
                await until(lambda message, number=number: message["kind"] == "command" and message["number"] == number and message["over"])
            at_end()
        return messages

    return asyncio.run(asyncio.wait_for(run(), 4 * flying.MOMENT_S))


def test_stations_command_a_mission_that_is_not_the_default_one(stations):
    """Both stations command at once, each as another user, and a refusal has its reason."""
    users = set()
    for station in stations:
        hello, _, done, _, refused = ask(station.address, ["ping UR5E", "state UR5E OPERATIONAL"])
        users.add(hello["user"]["name"])
        assert hello["mission"] == "ur5e" and hello["user"]["is_own"]
        assert done["lights"] == ["done", "done", "none", "done"] and "words" not in done
        assert "failed" in refused["lights"] and refused["code"] and not refused["unknown"]
    # The users are not always WEB and WEB_2: a station that is left from an earlier flight at this port may still use one of them.
    assert len(users) == STATIONS and all(name.startswith("WEB") for name in users)


def test_two_connections_of_one_user_get_their_own_verifications(flight):
    """Requests of both connections are in progress at the same time; each session receives all reports about
    its own requests and none about those of the other."""
    dictionary = Dictionary.load(flying.ROOT / "build" / "generated" / "ur5e.json")
    with Spacecraft(flight.directory, first_sequence=0) as one, Spacecraft(flight.directory, first_sequence=5000) as other:
        heard = {one: [], other: []}
        for craft, reports in heard.items():
            craft.session.listeners.append(lambda packet, _, reports=reports: packet.service == 1 and reports.append(packet))
        assert one.session.source == other.session.source
        sent = {one: [], other: []}
        for _ in range(INTERLEAVED):
            for craft in (one, other):
                sent[craft].append(craft.send_request(craft.plan("ping UR5E").requests[0]))
        for craft, verifications in sent.items():
            for verification in verifications:
                craft.finish(verification)
                assert verification.stages == [1, 3, 7]
            own = {verification.request_id for verification in verifications}
            assert {packet.data[:4] for packet in heard[craft] if packet.apid == dictionary.subsystem("UR5E").apid} == own
        with pytest.raises(Rejected):
            other.do("state UR5E OPERATIONAL")
        one.do("ping UR5E")


def is_enabled(craft, structure):
    """Whether a housekeeping structure of UR5E is enabled on board."""
    return next(row["enabled"] for reply in craft.do(f"tc UR5E 3,33 n=[{structure}]") for row in reply.get("rows", ()))


@pytest.mark.parametrize("stop", [signal.SIGSTOP, signal.SIGKILL])
def test_a_station_that_stops_or_dies_does_not_disturb_the_flight(flight, stop):
    """The page is open, and has enabled a housekeeping structure. The flight continues, other clients lose no packet, and another
    station can command. When the first one is dead, another one disables the structure."""
    station = Station(flight)
    structure = min(Dictionary.load(flying.ROOT / "build" / "generated" / "ur5e.json").subsystem("UR5E").configuration("POSITION").structures)
    with contextlib.closing(station), Spacecraft(flight.directory) as craft:
        before = craft.get("COMMUNICATION.COUNTERS.TM_DROPPED"), craft.session.now_ns
        ask(station.address, [f"hk enable UR5E {structure}"], lambda: station.process.send_signal(stop))
        for _ in range(3):
            craft.do("ping all")
        assert craft.get("COMMUNICATION.COUNTERS.TM_DROPPED") == before[0]
        assert craft.session.now_ns > before[1] and not craft.session.malformed
        assert stop == signal.SIGKILL or is_enabled(craft, structure)
    again = Station(flight)
    with contextlib.closing(again):
        assert ask(again.address, ["ping UR5E"])[-1]["lights"][-1] == "done"
        with Spacecraft(flight.directory) as craft:
            flying.wait_until(lambda: not is_enabled(craft, structure), "the structure is disabled")
    assert flight.process.poll() is None
