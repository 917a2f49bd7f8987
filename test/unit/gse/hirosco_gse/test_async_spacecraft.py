# SPDX-License-Identifier: Apache-2.0
"""The asyncio form of the client class with a simulated spacecraft: the calls are those of the class that blocks, and several wait at once."""

import asyncio
import inspect
import struct

import pytest
from hirosco_gse import dictionary as dictionary_module
from hirosco_gse.async_spacecraft import AsyncSpacecraft
from hirosco_gse.command import UsageError
from hirosco_gse.session import LinkLost, Rejected, TimedOut
from hirosco_gse.spacecraft import Spacecraft
from spacecraft import Spacecraft as Simulated
from spacecraft import failure, success

OWN = {"connect", "close", "join", "is_connected", "run", "live", "step"}  # Methods that use a connection.


@pytest.fixture
def fly(dictionary_path, tmp_path):
    """fly(answer, story) -> result of the coroutine story(client, simulated spacecraft)."""
    made = []

    def run(answer, story, **options):
        simulated = Simulated(answer, dictionary_module.Dictionary.load(dictionary_path).epoch_ns)
        made.append(simulated)

        async def flying():
            async with AsyncSpacecraft(tmp_path, port=simulated.port, dictionary=dictionary_path, timeout_s=60, **options) as craft:
                return await story(craft, simulated)

        return asyncio.run(flying())

    yield run
    for one in made:
        one.close()


def test_only_methods_that_use_a_connection_are_implemented_again():
    public = {name for name, _ in inspect.getmembers(Spacecraft) if not name.startswith("_")}
    assert {name for name in vars(AsyncSpacecraft) if not name.startswith("_")} == OWN and public > OWN


def test_calls_have_the_results_of_the_form_that_blocks(fly):
    def answer(packet):
        if packet.message == (20, 1):
            return success(packet, (20, 2, packet.data + struct.pack(">2d", 30.0, 20.0)))
        if packet.message == (17, 1):
            return success(packet, (17, 2, b""))
        return success(packet)

    async def story(craft, simulated):
        assert craft.is_connected
        none = await craft.cmd("manipulator.move_to", position=[0.5, -0.25], duration=2)
        sent = await craft.send("MANIPULATOR.TARE")
        finished = await craft.finish(sent)
        rows = await craft.do("ping JOYSTICK")
        return none, finished is sent and finished.stages, rows, await craft.tc("JOYSTICK", 17, 1), simulated.received[0]

    none, stages, rows, pong, request = fly(answer, story, user=7, first_sequence=3)
    assert none is None and stages[-1] == 7 and pong["kind"] and "JOYSTICK" in rows[0]["text"]
    assert (request.user, request.sequence) == (7, 3) and request.data == b"MOVE_TO\0" + struct.pack(">BHddHd", 2, 1, 0.5, -0.25, 2, 2.0)


def test_several_calls_wait_at_once(fly):
    """The simulated spacecraft answers the first request only when the second has arrived."""
    waiting = []

    def answer(packet):
        waiting.append(packet)
        return [report for one in reversed(waiting) for report in success(one)] if len(waiting) == 2 else []

    async def story(craft, _):
        ended = []

        async def ending(name, call):
            await call
            ended.append(name)

        await asyncio.gather(ending("first", craft.cmd("MANIPULATOR.TARE")), ending("second", craft.set("MANIPULATOR.TORQUE_LIMIT", [1, 2])))
        return ended

    assert sorted(fly(answer, story)) == ["first", "second"]


def test_an_error_is_raised_where_the_call_is_awaited(fly):
    async def story(craft, _):
        with pytest.raises(Rejected, match="not permitted in mode NOMINAL while in state PRE_OPERATIONAL"):
            await craft.cmd("MANIPULATOR.TARE")
        with pytest.raises(TimedOut, match="the wanted value of MANIPULATOR.CUR_VALUES.POSITION.*not reported"):
            await craft.wait_value("MANIPULATOR.CUR_VALUES.POSITION", timeout_s=0.05)
        with pytest.raises(UsageError):
            craft.do("state MANIPULATOR")

    fly(lambda packet: failure(packet, 4, 0x0110, 1 << 8 | 3), story)  # PUS_FAILURE_PERMISSION, mode and state.


def test_calls_are_performed_after_one_was_cancelled(fly):
    waiting = []

    def answer(packet):
        waiting.append(packet)
        return success(packet) if len(waiting) > 1 else []

    async def story(craft, simulated):
        first = asyncio.create_task(craft.cmd("MANIPULATOR.TARE", timeout_s=60))
        while not simulated.received:
            await asyncio.sleep(0.01)
        first.cancel()
        with pytest.raises(asyncio.CancelledError):
            await first
        await craft.set("MANIPULATOR.TORQUE_LIMIT", [1, 2])
        return len(simulated.received)

    assert fly(answer, story) == 2


def test_a_lost_link_ends_the_calls_under_way_and_those_after_it(fly):
    async def story(craft, _):
        both = await asyncio.gather(craft.cmd("MANIPULATOR.TARE"), craft.wait_event("MANIPULATOR", "TARE_DONE", timeout_s=60), return_exceptions=True)
        assert not craft.is_connected
        with pytest.raises(LinkLost):
            await craft.listen(1)
        return both

    both = fly(lambda packet: None, story)
    assert all(isinstance(one, LinkLost) for one in both), both


def test_closing_ends_the_calls_under_way(fly):
    async def story(craft, _):
        waits = asyncio.create_task(craft.wait_state("MANIPULATOR", "OPERATIONAL", timeout_s=60))
        await asyncio.sleep(0)
        await craft.close()
        with pytest.raises(LinkLost, match="not connected"):
            await craft.listen(0)
        return (await asyncio.gather(waits, return_exceptions=True))[0]

    assert isinstance(fly(success, story), LinkLost)


def test_connecting_again_closes_the_earlier_connection(fly):
    async def story(craft, simulated):
        waits = asyncio.create_task(craft.wait_state("MANIPULATOR", "OPERATIONAL", timeout_s=60))
        await asyncio.sleep(0)
        earlier = craft._driver
        assert await craft.connect() is craft and craft.is_connected
        ended = await asyncio.gather(waits, return_exceptions=True)
        await craft.cmd("MANIPULATOR.TARE")
        return earlier.is_lost, earlier._link._writer.is_closing(), ended[0], len(simulated.received)

    lost, closing, ended, received = fly(success, story)
    assert lost and closing and isinstance(ended, LinkLost) and received == 1


def test_without_a_spacecraft_there_is_no_link(dictionary_path, tmp_path):
    async def story():
        with pytest.raises(LinkLost, match="no link to 127.0.0.1:1: Connection refused; .*make sim-run"):
            await AsyncSpacecraft(tmp_path, port=1, dictionary=dictionary_path).connect()
        with pytest.raises(TypeError, match="async with"), AsyncSpacecraft(tmp_path, port=1, dictionary=dictionary_path):
            pass

    asyncio.run(story())
