# SPDX-License-Identifier: Apache-2.0
"""Authenticated commanding in flight: only the holder of the key can command. Forged, replayed, changed,
truncated and reordered frames have no effect, whether they are sent before or after a restart of
communication or of the whole mission."""

import contextlib
import os
import random
import re
import signal
import socket
import subprocess
import sys
import threading

import flying
import pytest
from hirosco_gse import packets, sdls
from spacepackets.ecss import PusTc, PusTm

LIVE = ("--time", "real", "--scenario", "none")
SUCCESS, FAILED, USAGE, NO_LINK, TIMED_OUT = range(5)
OTHER_USER = 2
SUPERVISOR, COMMUNICATION = 1, 2
REASONS = ("NO_FRAME", "UNKNOWN_SPI", "FORGED", "REPLAYED", "BAD_PARTS", "NOT_KEPT")
SEED = 1


@pytest.fixture
def key(tmp_path):
    """A key with its marks, made by the command of the ground segment."""
    path = tmp_path / "ground.key"
    done = subprocess.run([sys.executable, flying.ROOT / "gse/gse", "key", "make", path], capture_output=True, text=True, check=True)
    assert path.read_text(encoding="ascii").strip() not in done.stdout
    return path


def _ping(count):
    return bytes(PusTc(service=17, subservice=1, apid=SUPERVISOR, seq_count=count, source_id=OTHER_USER, app_data=b"").pack())


def _pings(flight):
    """Sequence counts of the pings of the other user that reached the supervisor."""
    found = [packets.parse(raw) for _, direction, raw in flight.packets if direction == "TC"]
    return [packet.sequence for packet in found if packet.message == (17, 1) and packet.user == OTHER_USER]


def _counters(flight, key):
    """Counters of the parameter SECURITY of COMMUNICATION, read with the key. Expects that security is on."""
    done = flying.gse(flight, "--key", key, "get", "COMMUNICATION.SECURITY")
    assert done.returncode == SUCCESS, done
    assert "IS_ON: ON" in done.stdout, done
    return {name: int(value) for name, value in re.findall(r"\b([A-Z_]+): (\d+)", done.stdout)}


def _is_up(flight, key):
    return lambda: flying.gse(flight, "--key", key, "ping", "all").returncode == SUCCESS


def _throw(port, octets):
    """Send octets on a separate connection and wait until it is ended, or end it when everything was read.
    Returns the received octets."""
    received = b""
    with contextlib.suppress(ConnectionError), flying.connect(port) as stream:
        stream.sendall(octets)
        stream.shutdown(socket.SHUT_WR)
        while part := stream.recv(65536):
            received += part
    return received


class Tap:
    """A proxy between ground and spacecraft that records the uplink."""

    def __init__(self, port):
        self.uplinks = []  # Octets of each connection.
        self._target = port
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = self._server.getsockname()[1]
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        while True:
            try:
                client, _ = self._server.accept()
            except OSError:
                return
            craft = flying.connect(self._target)
            for source, sink in ((client, craft), (craft, client)):
                threading.Thread(target=self._carry, args=(source, sink, source is client), daemon=True).start()

    def _carry(self, source, sink, is_up):
        kept = bytearray()
        if is_up:
            self.uplinks.append(kept)
        with contextlib.suppress(OSError):
            while part := source.recv(65536):
                kept += part
                sink.sendall(part)
        for stream in (source, sink):
            with contextlib.suppress(OSError):
                stream.shutdown(socket.SHUT_RDWR)

    def close(self):
        self._server.close()


@pytest.mark.parametrize("form", ["processes", "image"])
def test_the_operator_of_a_scenario_has_the_key(directory, key, form):
    """Stepped time is not affected: two flights with the key and one without it have the same octets on the
    buses."""
    directory.mkdir()
    flights = [flying.fly(directory / str(i), "--scenario", "commissioning", "--form", form, *options)
               for i, options in enumerate((("--key", key), ("--key", key), ()))]
    for flight in flights:
        assert flight.code == 0, flight.transcript()
        assert flight.facts["reproducible"] is True
    for name in flying.BUS_LOGS:
        assert flights[0].octets(name) == flights[1].octets(name) == flights[2].octets(name)
    assert flights[0].octets("packets.log") == flights[1].octets("packets.log")
    secrets = {key.read_bytes().strip(), sdls.read_key(key)}
    for path in flights[0].directory.rglob("*"):
        assert not path.is_file() or not any(secret in path.read_bytes() for secret in secrets), f"{path} holds the key"


def test_restarted_communication_uses_the_key_again(directory, key):
    """Communication is killed twice and suspended once. The operator's link opens again each time, as a new
    session of the key, in both forms; the octets are the same as without a key, except for the counters of
    communication."""
    directory.mkdir()
    pings = [f"{at + i * 0.01:.3f} operator ping MANIPULATOR" for at in (0.5, 1.2, 2.2, 3.2) for i in range(10)]
    faults = ["1.0 fault kill communication", "2.0 fault kill communication", "3.0 fault hang communication"]
    lines = sorted(pings + faults, key=lambda line: float(line.split()[0]))
    path = flying.write_scenario(directory / "again.scn", "0.0 hand rest", "0.1 operator state MANIPULATOR PRE_OPERATIONAL", *lines,
                                 "4.0 operator get COMMUNICATION.SECURITY", "4.1 operator shutdown")
    flights = {}
    for name, options in {"image": ("--form", "image", "--key", key), "processes": ("--key", key), "open": ("--form", "image")}.items():
        flight = flights[name] = flying.fly(directory / name, "--scenario", path, *options)
        assert flight.facts["reproducible"], flight.transcript()
        assert "FAILED" not in flight.console, flight.transcript()
        assert flight.console.count("MANIPULATOR is alive") == len(pings), flight.transcript()
        flying.assert_clean(flight)
    assert flights["image"].octets("packets.log") == flights["processes"].octets("packets.log")
    for bus in flying.BUS_LOGS:
        assert flights["image"].octets(bus) == flights["processes"].octets(bus) == flights["open"].octets(bus)
    security = re.search(r"SECURITY=?[^\n]*", flights["image"].console).group(0)
    assert "IS_ON: ON" in security and all(f"{reason}: 0" in security for reason in REASONS), security


def test_only_the_holder_of_the_key_commands(directory, key):
    """Commanding through the gateway is also possible, which secures the packets of programs without keys."""
    flight = flying.start(directory, *LIVE, "--key", key)
    try:
        flying.wait_until(_is_up(flight, key), "answers of all components")
        assert flying.gse(flight, "ping", "SUPERVISOR").returncode in (NO_LINK, TIMED_OUT), "expected no answer without the key"
        before = _counters(flight, key)
        assert before["NO_FRAME"] == 1
        with contextlib.ExitStack() as idle:
            for _ in range(8):  # More clients than the ground port has slots.
                idle.enter_context(flying.connect(flight.port()))
                assert flying.gse(flight, "--key", key, "ping", "SUPERVISOR").returncode == SUCCESS, "expected an answer"
        with _gateway(flight, key) as port, flying.connect(port) as stream:
            stream.sendall(_ping(7)[:5])
            stream.sendall(_ping(7)[5:] + _ping(8))
            assert _answers(stream, 8) == [(1, 1), (1, 3), (17, 2), (1, 7)] * 2
        assert flying.gse(flight, "--key", key, "shutdown").returncode == SUCCESS
        flight.wait()
        assert flight.code == 0, flight.transcript()
        assert _pings(flight) == [7, 8]
        flying.assert_clean(flight)
    finally:
        flight.abandon()


def _answers(stream, count):
    stream.settimeout(flying.MOMENT_S)
    splitter, found = packets.Splitter(), []
    while len(found) < count:
        for raw in splitter.feed(stream.recv(65536)):
            report = PusTm.unpack(raw, timestamp_len=8)
            if report.pus_tm_sec_header.dest_id == OTHER_USER:
                found.append((report.service, report.subservice))
    return found


@contextlib.contextmanager
def _gateway(flight, key):
    words = [sys.executable, flying.ROOT / "gse/gse", "--port", str(flight.port()), "--key", key, "gateway", "--listen", str(flying.free_port())]
    process = subprocess.Popen(list(map(str, words)), stdout=subprocess.PIPE, text=True)
    try:
        yield int(re.search(r"packets at 127\.0\.0\.1:(\d+)", process.stdout.readline()).group(1))
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(flying.MOMENT_S)


def _hostile(rng, tape, key):
    """One attack as octets for a separate connection: at most three frames, because the third refused frame
    ends the connection."""
    genuine = rng.choice(tape)
    kind = rng.randrange(6)
    if kind == 0:  # Replay of a complete connection, or of what follows its first frame, whose length less 1 is in octets 2 and 3.
        return genuine[rng.choice((0, genuine[3] + 1 + 256 * (genuine[2] & 3))) :]
    if kind == 1:  # Another key.
        cipher = sdls._cipher(rng.randbytes(32))
        return b"".join(sdls.frame(cipher, 10**6, count, sdls.WHOLE, _ping(99)) for count in range(3))
    octets = bytearray(genuine)
    if kind == 2:  # Flipped bits, with the session number of the recording (octets 12 to 15) or with a new one.
        for _ in range(rng.randrange(1, 5)):
            octets[rng.randrange(len(octets))] ^= 1 << rng.randrange(8)
        octets[12:16] = rng.choice((bytes(octets[12:16]), (10**6).to_bytes(4, "big")))
    elif kind == 3:  # Truncated.
        del octets[rng.randrange(1, len(octets)) :]
    elif kind == 4:  # Packets without protection, or no frame at all.
        return rng.choice((_ping(99), rng.randbytes(rng.randrange(1, 2000))))
    else:  # With the key, but in the wrong order.
        cipher = sdls._cipher(sdls.read_key(key))
        return b"".join(sdls.frame(cipher, 10**6, count, sdls.WHOLE, _ping(99)) for count in (1, 2, rng.randrange(3, 2**32)))
    return bytes(octets)


def _attack(flight, key, tape, rng, times):
    for _ in range(times):
        _throw(flight.port(), _hostile(rng, tape, key))
    for octets in tape:
        _throw(flight.port(), octets)


def test_attackers_are_refused_over_restarts(directory, key):
    """The octets of a recorded link have no effect: neither at once, nor after communication has died, nor in
    the next flight."""
    directory.mkdir()
    rng, tape = random.Random(SEED), []
    for number in range(2):
        flight = flying.start(directory / str(number), *LIVE, "--key", key)
        try:
            flying.wait_until(_is_up(flight, key), "answers of all components")
            if tape:
                _attack(flight, key, tape, rng, 20)
            tap = Tap(flight.port())
            with contextlib.closing(tap), _gateway_through(tap, key) as port, flying.connect(port) as stream:
                stream.sendall(_ping(1) + _ping(2))
                assert len(_answers(stream, 8)) == 8
            tape += [bytes(octets) for octets in tap.uplinks if octets]
            assert len(tape) == number + 1
            _attack(flight, key, tape, rng, 100)
            reports = _counters(flight, key)
            assert reports["FORGED"] > 10 and reports["REPLAYED"] > 10 and reports["NO_FRAME"] > 10
            _revive(flight)
            flying.wait_until(_is_up(flight, key), "communication is back")
            _attack(flight, key, tape, rng, 20)
            assert _counters(flight, key)["REPLAYED"] >= len(tape)
            assert flying.gse(flight, "--key", key, "shutdown").returncode == SUCCESS
            flight.wait()
            assert _pings(flight) == [1, 2], "expected the pings of the operator, each once"
            events = [packets.parse(raw) for _, direction, raw in flight.packets if direction == "TM" and raw[7] == 5]
            reports = [packet for packet in events if packet.apid == COMMUNICATION and packet.data[:2] == b"\0\x14"]
            assert reports, "TC_NOT_AUTHENTIC"
        finally:
            flight.abandon()


def _revive(flight):
    """Kill communication, and wait for its next life."""
    before = flight.children()["communication"]
    os.kill(before, signal.SIGKILL)
    flying.wait_until(lambda: flight.children().get("communication", before) != before, "another life of communication")


def test_a_mark_that_is_lost_in_flight_closes_the_link(directory, key):
    """Telemetry continues and reports the loss; when the mark is back, commanding works again."""
    flight = flying.start(directory, *LIVE, "--key", key)
    mark, away = key.with_name("ground.key.received"), key.with_name("away")
    try:
        flying.wait_until(_is_up(flight, key), "answers of all components")
        mark.rename(away)
        _revive(flight)
        with flying.connect(flight.port()) as listener:
            listener.settimeout(flying.MOMENT_S)
            done = flying.gse(flight, "--key", key, "--timeout", "2", "ping", "SUPERVISOR")
            assert done.returncode in (NO_LINK, TIMED_OUT), done
            _wait_for_event(listener, b"\0\x15")  # TC_NOT_KEPT
        assert not mark.exists()
        away.rename(mark)
        _revive(flight)
        flying.wait_until(_is_up(flight, key), "commanding is back")
        assert flying.gse(flight, "--key", key, "shutdown").returncode == SUCCESS
        flight.wait()
        assert "ground.key.received: the mark of the key is missing" in flight.console
    finally:
        flight.abandon()


def _wait_for_event(stream, number):
    splitter = packets.Splitter()
    while True:
        octets = stream.recv(65536)
        assert octets, "the spacecraft has closed the connection"
        for packet in map(packets.parse, splitter.feed(octets)):
            if packet.service == 5 and packet.apid == COMMUNICATION and packet.data[:2] == number:
                return


@contextlib.contextmanager
def _gateway_through(tap, key):
    class Way:  # Replaces a flight; _gateway calls only port().
        @staticmethod
        def port():
            return tap.port

    with _gateway(Way, key) as port:
        yield port


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda path: path.chmod(0o640), "chmod 600"),
        (lambda path: path.unlink(), "gse key make"),
        (lambda path: path.write_text("not a key", encoding="ascii"), "expected 32 octets or 64 hexadecimal digits"),
        (lambda path: path.with_name("ground.key.received").unlink(), "gse key make"),
        (lambda path: path.with_name("ground.key.received").write_bytes(bytes(544)), "damaged, or of another key"),
    ],
)
def test_a_key_that_cannot_be_used_stops_the_run(directory, key, spoil, words):
    spoil(key)
    done = flying.refuse("run", "--out", directory, "--key", key)
    assert done.returncode == 1
    assert str(key) in done.stdout + done.stderr
    assert words in done.stdout + done.stderr
    assert not (directory / "run.json").exists()
