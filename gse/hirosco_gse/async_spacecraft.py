# SPDX-License-Identifier: Apache-2.0
"""The client class of spacecraft.py for programs that must not block, with asyncio.

    from hirosco_gse.async_spacecraft import AsyncSpacecraft

    async with AsyncSpacecraft() as craft:                              # the flight in runs/latest
        await craft.do("state all PRE_OPERATIONAL")
        await asyncio.gather(craft.cmd("MANIPULATOR.TARE"), craft.wait_event("MANIPULATOR", "TARE_DONE"))

It has the calls of Spacecraft, with the same return values and exceptions. A call that waits must be awaited; any
number of calls may wait at the same time. Telemetry is received continuously. If the task of a call is cancelled, the
call ends, but the requests that it has sent continue on board. A call with wrong words raises its exception at once,
before it is awaited."""

import asyncio

from .async_link import AsyncDriver, AsyncLink
from .link import words_of
from .session import LinkLost
from .spacecraft import Spacecraft
from .station.world_port import WorldPort

CONNECT_PAUSE_S = 0.1  # Time between two attempts to connect.
POLL_S = 0.02  # Time between two requests for the simulated time.


class AsyncSpacecraft(Spacecraft):
    """One ground user of a flight, within one asyncio loop."""

    async def connect(self, timeout_s=0.0):
        """Open the connection, with attempts for timeout_s; returns self. An earlier connection is closed first, as by close(). Raises
        LinkLost."""
        await self.close()
        self.place.check()
        loop = asyncio.get_running_loop()
        end = loop.time() + timeout_s
        while True:
            if self._sender:
                self._sender.begin_anew()
            try:
                reader, writer = await asyncio.open_connection(self.place.host, self.place.port)
                break
            except OSError as error:
                if loop.time() >= end:
                    where = f"{self.place.host}:{self.place.port}"
                    raise LinkLost(f"no link to {where}: {words_of(error)}; is a mission running (make sim-run)?") from error
            await asyncio.sleep(CONNECT_PAUSE_S)
        self._driver = AsyncDriver(AsyncLink(reader, writer, self.session), self.dictionary.epoch_ns)
        return self

    @property
    def is_connected(self):
        """Whether there is a connection."""
        return self._driver is not None and not self._driver.is_lost

    def join(self, *_):
        """Not supported: stepped time needs the class Spacecraft."""
        raise NotImplementedError("stepped time needs the class Spacecraft, not AsyncSpacecraft")

    async def close(self):
        """Close the connection; calls under way end with LinkLost."""
        if self._world:
            self._world.close()
        driver, self._driver, self._world = self._driver, None, None
        if driver:
            await driver.close()

    async def __aenter__(self):
        return self if self._driver else await self.connect()

    async def __aexit__(self, *_):
        await self.close()

    def __enter__(self):
        raise TypeError("use `async with`")

    async def run(self, procedure):
        """Run a procedure of this session (session.py); returns its value."""
        if self._driver is None:
            raise LinkLost("not connected; call connect() or use `async with`")
        return await self._driver.run(procedure)

    async def live(self, *words):
        """Send a line to the live port (docs/live.md). Returns the simulated time [s] at which it acts. Raises
        LiveRefused, LinkLost."""
        return (await self._ask(" ".join(map(str, words))))[0]

    async def _ask(self, line):
        if self._world is None:
            self._world = WorldPort()
            self._world.move_to(self.place.run, "live")
        return await self._world.ask(line)

    async def step(self, seconds):
        """Let this simulated time pass; returns when simulated time stands still again."""
        began = await self.live("step", f"{seconds:.4f}")
        while not (await self._ask("time"))[1]:
            await asyncio.sleep(POLL_S)
        return began
