# SPDX-License-Identifier: Apache-2.0
"""Bursts of requests, faster than they can be answered: each ends exactly once, and no report is lost."""

import collections
import contextlib
import itertools
import signal
import threading

import flying
import pytest
from hirosco_gse import packets

REQUESTS = 4000  # Each has four reports, so the sequence count does not wrap.
SUPERVISOR, JOYSTICK = 1, 17
COMPLETED, UNROUTED, ALIVE = (1, 7), (1, 10), (17, 2)
ENDS = {(1, 2), (1, 4), (1, 8), COMPLETED, UNROUTED}
ENDLESS_S = 1_000_000


def _read_packets(link):
    """Yield the packets of a connection as they arrive."""
    octets = b""
    while True:
        received = link.recv(65536)
        if not received:
            return
        octets += received
        while len(octets) >= 6 and len(octets) >= (size := int.from_bytes(octets[4:6], "big") + 7):
            yield octets[:size]
            octets = octets[size:]


def _burst(link, apid):
    """Send pings without waiting for answers. Returns (message -> count, request -> final reports, sequence
    counts received)."""
    requests = b"".join(packets.build_tc(apid, number, 17, 1, source=1) for number in range(REQUESTS))
    threading.Thread(target=link.sendall, args=(requests,), daemon=True).start()
    messages, ends, sequence = collections.Counter(), collections.Counter(), set()
    # FIRM reports overtake other reports on the way to the ground.
    for packet in itertools.islice(_read_packets(link), 10 * REQUESTS):
        sender, message = int.from_bytes(packet[:2], "big") & 0x7FF, tuple(packet[7:9])
        if not sender:
            continue  # A time report does not have this header.
        messages[message] += 1
        if sender == apid:
            sequence.add(int.from_bytes(packet[2:4], "big") & 0x3FFF)
        if message in ENDS:
            ends[packet[21:25]] += 1
        if len(ends) == REQUESTS and messages[ALIVE] == messages[COMPLETED]:
            break
    return messages, ends, sequence


@pytest.mark.parametrize("apid", [SUPERVISOR, JOYSTICK])
def test_each_request_of_a_burst_ends_once(session_directory, apid):
    """Requests wait for room at their addressee; each is answered, and the sequence counts have no gap."""
    flight = flying.start(session_directory / f"burst-{apid}", "--scenario", "none", "--duration", ENDLESS_S, "--form", "image")
    try:
        with contextlib.closing(flying.connect(flight.port())) as link:
            link.settimeout(flying.MOMENT_S)
            messages, ends, sequence = _burst(link, apid)
    finally:
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    assert set(ends.values()) == {1}, "a request ended twice"
    assert messages[COMPLETED] == messages[ALIVE] == messages[(1, 1)] == messages[(1, 3)]
    assert messages[COMPLETED] == REQUESTS and messages[UNROUTED] == 0, "expected requests to wait in the connection, not to be refused"
    # A ground that is slow misses only housekeeping of the supervisor, which is in the packet log.
    if apid == JOYSTICK:
        assert len(sequence) == max(sequence) - min(sequence) + 1
