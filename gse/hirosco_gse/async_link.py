# SPDX-License-Identifier: Apache-2.0
"""Connections to the spacecraft with asyncio, which do not block. The station (station/hub.py) and AsyncSpacecraft use them."""

import asyncio

from .link import CLOSED, WallClock, words_of
from .session import LinkLost


class AsyncLink:
    """A connection that passes received octets to a session, and sends the octets that the session has queued."""

    def __init__(self, reader, writer, session):
        self._reader, self._writer, self.session = reader, writer, session

    @property
    def address(self):
        """(host, port) of the spacecraft."""
        return self._writer.get_extra_info("peername")[:2]

    def flush(self):
        """Send the queued octets."""
        if self.session.outbox:
            self._writer.write(bytes(self.session.outbox))
            self.session.outbox.clear()

    async def receive(self, arrived):
        """Take telemetry until the spacecraft closes the connection; call arrived() after each part. Raises OSError."""
        while octets := await self._reader.read(65536):
            self.session.feed(octets)
            arrived()

    def close(self):
        """Close the connection."""
        self._writer.close()

    def abort(self):
        """End the connection at once, as if it had failed."""
        self._writer.transport.abort()


class _Running:
    """A procedure under way (a generator, see session.py), the future of its value, and the timer of its next wake time."""

    def __init__(self, procedure, future):
        self.procedure, self.future, self.timer = procedure, future, None


class AsyncDriver(WallClock):
    """Runs any number of procedures of one session concurrently in wall-clock time: each is resumed whenever telemetry has arrived, and at its own
    wake times."""

    def __init__(self, link, epoch_ns=None):
        super().__init__(link.session, epoch_ns)
        self._link, self._running, self._lost = link, [], None
        self._receiver = asyncio.get_running_loop().create_task(self._receive())

    @property
    def is_lost(self):
        """Whether the connection has ended."""
        return self._lost is not None

    async def run(self, procedure):
        """Run a procedure to its end and return its value. Raises LinkLost if the connection has ended or ends, and what the procedure
        raises. If the task is cancelled, the procedure is closed; requests that it has sent stay under way on board."""
        if self._lost:
            raise LinkLost(str(self._lost))
        one = _Running(procedure, asyncio.get_running_loop().create_future())
        self._running.append(one)
        try:
            self._resume(one)
            return await one.future
        finally:
            self._end(one)
            procedure.close()

    def _end(self, one):
        if one in self._running:
            self._running.remove(one)
        if one.timer:
            one.timer.cancel()

    def _resume(self, one):
        """Resume a procedure that has not ended."""
        if one.future.done():
            return
        if one.timer:
            one.timer.cancel()
            one.timer = None
        wake = self._step(one, lambda: self.resume(one.procedure))
        self._link.flush()
        if wake is not None and not one.future.done():
            one.timer = asyncio.get_running_loop().call_later(self.seconds_until(wake), self._resume, one)

    @staticmethod
    def _step(one, step):
        """Perform a step of a procedure and return its result. When the procedure ends, its future gets the value or
        the exception."""
        try:
            return step()
        except StopIteration as end:
            one.future.set_result(end.value)
        except Exception as problem:  # The exception is raised where the value is awaited.
            one.future.set_exception(problem)
        return None

    def _resume_all(self):
        for one in list(self._running):
            self._resume(one)

    async def _receive(self):
        """Follow the connection. When it ends, LinkLost is raised in each procedure, because it may expect the end of the link."""
        try:
            await self._link.receive(self._resume_all)
            self._lost = LinkLost(CLOSED)
        except OSError as error:
            self._lost = LinkLost(f"link lost: {words_of(error)}")
        for one in list(self._running):
            if not one.future.done():
                self._step(one, lambda one=one: one.procedure.throw(LinkLost(str(self._lost))))
            if not one.future.done():
                one.future.set_exception(LinkLost(str(self._lost)))

    async def close(self):
        """Close the connection. The callers of run() get LinkLost; their procedures are closed."""
        self._link.close()
        self._receiver.cancel()
        await asyncio.gather(self._receiver, return_exceptions=True)
        self._lost = self._lost or LinkLost("the connection was closed")
        for one in self._running:
            if not one.future.done():
                one.future.set_exception(LinkLost(str(self._lost)))
