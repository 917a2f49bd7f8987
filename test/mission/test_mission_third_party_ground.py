# SPDX-License-Identifier: Apache-2.0
"""Ground clients that take no part in simulated time: they are served, they do not change the flight, and the
run reports them."""

import contextlib
import signal
import socket
import struct
import threading

import flying
import pytest
from spacepackets.ecss import PusTc, PusTm, check_pus_crc

OPTIONS = ("--scenario", "telepresence", "--form", "processes")
UNTIL_ENDED = ("--scenario", "none", "--duration", "100000", "--form", "processes")
OTHER_USER = 2
SUPERVISOR = 1
COMMUNICATION = 2


def _ping(apid, count=0):
    """TC[17,1], encoded by spacepackets."""
    return PusTc(service=17, subservice=1, apid=apid, seq_count=count, source_id=OTHER_USER, app_data=b"").pack()


def _packets(stream):
    """Yield the octets of complete packets from a connection until it ends."""
    buffer = b""
    while True:
        try:
            part = stream.recv(65536)
        except OSError:
            return
        if not part:
            return
        buffer += part
        while len(buffer) >= 6 and len(buffer) >= (size := struct.unpack(">H", buffer[4:6])[0] + 7):
            yield buffer[:size]
            buffer = buffer[size:]


def _end(flight):
    """End a flight as Ctrl-C does."""
    flight.process.send_signal(signal.SIGINT)
    flight.wait()
    assert flight.code == 0, flight.transcript()


@pytest.fixture(scope="module")
def quiet(shared_flights):
    """The same flight without a third-party client."""
    return shared_flights.flight()


def test_telecommand_of_a_third_party_client_is_served_and_reported(directory):
    """TC[17,1] gets its reports on the connection that has sent it; the run succeeds and reports that it is
    not reproducible."""
    flight = flying.start(directory, *UNTIL_ENDED)
    stream = flying.connect(flight.port())
    stream.settimeout(flying.MOMENT_S)
    stream.sendall(_ping(16))
    answers = []
    for raw in _packets(stream):
        assert check_pus_crc(raw)
        report = PusTm.unpack(raw, timestamp_len=8)
        assert report.pus_tm_sec_header.dest_id in (0, OTHER_USER), "this user received a verification report of another user"
        if report.pus_tm_sec_header.dest_id == OTHER_USER:
            answers.append((report.service, report.subservice))
        if len(answers) == 4:
            break
    assert answers == [(1, 1), (1, 3), (17, 2), (1, 7)]
    stream.close()
    _end(flight)
    assert flight.facts["reproducible"] is False
    asked = [raw for _, direction, raw in flight.packets if direction == "TC" and raw[9:11] == struct.pack(">H", OTHER_USER)]
    assert len(asked) == 1, "expected the telecommand once in the packet log"
    flying.assert_clean(flight)


def _of_others(flight):
    """Packets of the members in the packet log; without those of `communication`, which reports its clients,
    and of the supervisor."""
    return [(t, raw) for t, direction, raw in flight.packets if direction == "TM" and int.from_bytes(raw[:2], "big") & 0x7FF in (16, 17)]


def test_listeners_do_not_change_the_flight(directory, quiet):
    """One client reads everything, another reads nothing: members and buses have the same octets as in the
    flight without clients."""
    flight = flying.start(directory, *OPTIONS)
    reader, sleeper = flying.connect(flight.port()), flying.connect(flight.port())
    sleeper.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
    received = []
    thread = threading.Thread(target=lambda: received.extend(_packets(reader)))
    thread.start()
    flight.wait()
    thread.join(flying.MOMENT_S)
    assert flight.code == 0, flight.transcript()
    assert flight.facts["reproducible"] is False, "expected not reproducible: the packet log contains the times of the connections"
    for name in flying.BUS_LOGS:
        assert flight.octets(name) == quiet.octets(name), name
    assert _of_others(flight) == _of_others(quiet)
    log = {raw for _, direction, raw in flight.packets if direction == "TM"}
    assert len(received) > 100
    assert set(received) <= log, "expected no packet that is not in the log"
    events = {raw for raw in log if raw[7] == 5 and raw[8] > 1 and raw[11:13] == bytes(2)}
    assert len(events) >= 5
    assert events <= set(received), "expected every event of the log"
    sleeper.close()


@pytest.mark.parametrize("rubbish", [b"\x00" * 64, b"\xff" * 512, bytes(range(256)) * 64, b"GET / HTTP/1.0\r\n\r\n", _ping(16)[:-1] + b"\x00"], ids=("noughts", "ones", "all", "http", "crc"))
def test_invalid_octets_are_ignored(directory, rubbish):
    """The flight continues whatever octets its ground port receives."""
    flight = flying.start(directory, "--scenario", "commissioning")
    stream = flying.connect(flight.port())
    with contextlib.suppress(OSError):
        stream.sendall(rubbish)
    flight.wait()
    stream.close()
    assert flight.code == 0, flight.transcript()
    flying.assert_clean(flight)


def test_request_with_a_wrong_crc_is_refused(directory):
    """The supervisor sends TM[1,2] with the id of the request to the sender of the request."""
    flight = flying.start(directory, *UNTIL_ENDED)
    stream = flying.connect(flight.port())
    stream.settimeout(flying.MOMENT_S)
    request = bytearray(_ping(16))
    request[-1] ^= 0xFF
    stream.sendall(bytes(request))
    found = None
    for raw in _packets(stream):
        if raw[7:9] == b"\x01\x02":
            found = raw
            break
    assert found is not None
    assert int.from_bytes(found[:2], "big") & 0x7FF == SUPERVISOR
    assert found[21:25] == bytes(request[:4])
    stream.close()
    _end(flight)


def test_the_operator_is_served_beside_eight_idle_clients(directory):
    """The clients connect at the beginning of the flight; as a rule they have all slots before the operator connects."""
    flight = flying.start(directory, "--scenario", "commissioning")
    streams = [flying.connect(flight.port()) for _ in range(8)]
    flight.wait()
    assert flight.code == 0, flight.transcript()
    connected = [raw for _, _, raw in flight.packets if raw[7:9] == b"\x05\x01" and raw[1] == COMMUNICATION and raw[21:23] == b"\x00\x01"]
    assert len(connected) == 9, "expected connections of the eight clients and the operator"
    for stream in streams:
        stream.close()
