# SPDX-License-Identifier: Apache-2.0
"""For tests of the station: a simulated spacecraft, a running station, and a page that receives its
messages."""

import asyncio
import json
import struct
from contextlib import asynccontextmanager

from aiohttp import ClientSession, web
from hirosco_gse.station.server import Station
from spacecraft import failure, success

TIMEOUT_S = 600.0
MANIPULATOR, JOYSTICK = 16, 17
TELEPRESENCE = 2


def status(state, configuration):
    """Data of TM[129,5]; the interface hash is not compared here."""
    return struct.pack(">BBBHQQII", state, 0, state, configuration, 0, 0, 0, 0)


def answer(packet):
    """Perform every request except TC[129,1], which fails because of the state; with each answer of MANIPULATOR to a
    ping, report that it is in PRE_OPERATIONAL with a configuration."""
    if packet.message == (17, 1):
        reports = [(MANIPULATOR, 129, 5, status(3, TELEPRESENCE), 1)] if packet.apid == MANIPULATOR else []
        return success(packet, (17, 2, b"")) + reports
    if packet.message == (129, 1):
        return failure(packet, 4, 0x0204, 0x0305)  # PUS_FAILURE_STATE.
    if packet.message == (131, 8):
        return success(packet, (131, 9, struct.pack(">H", 0)))
    return success(packet)


def begin(place, name, port, world=""):
    """Begin a flight, perhaps with a world of its own: its run directory becomes the latest."""
    (place / name).mkdir()
    (place / name / "ground.world").write_text(world)
    (place / name / "ground.port").write_text(f"{port}\n")
    (place / "new").symlink_to(name)
    (place / "new").rename(place / "latest")


@asynccontextmanager
async def station_of(place, **options):
    """Run a station; yields (station, address)."""
    station = Station(place / "latest", place / "page", **options)
    runner = web.AppRunner(station.application("127.0.0.1:0"))
    await runner.setup()
    site = web.TCPSite(runner, "127.0.0.1", 0)
    await site.start()
    host = "127.0.0.1:%d" % runner.addresses[0][1]
    station._host = host
    try:
        yield station, f"http://{host}"
    finally:
        await runner.cleanup()


class Page:
    """The messages that a browser has received."""

    def __init__(self, socket):
        self.socket, self.heard = socket, []

    async def until(self, condition):
        """The first message after the last call that fulfils the condition."""
        while True:
            message = json.loads((await self.socket.receive(TIMEOUT_S)).data)
            self.heard.append(message)
            if condition(message):
                return message

    async def ask(self, **order):
        await self.socket.send_json({**order, "id": 7})
        return await self.until(lambda message: message.get("id") == 7)


def visit(place, story, **options):
    """Run `story(page, station)` with an open page."""

    async def run():
        async with station_of(place, **options) as (station, address), ClientSession() as session:
            async with session.ws_connect(f"{address}/ws", headers={"Origin": address}) as socket:
                page = Page(socket)
                await page.until(lambda message: message["kind"] == "link" and message["is_live"])
                return await story(page, station)

    # Messages that no test awaits arrive all the time, so a wait for one message has no limit of its own.
    return asyncio.run(asyncio.wait_for(run(), 2 * TIMEOUT_S))
