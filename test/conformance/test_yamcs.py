# SPDX-License-Identifier: Apache-2.0
"""Yamcs with a flying mission and the generated database: it reads the same values as the ground segment and
can command the mission.

Yamcs is also linked to a simulated spacecraft, which sends synthetic reports of every kind in the catalogue:
Yamcs must find the encoded values in the encoded order. For every request Yamcs makes the same octets as the
ground segment. This takes a minute, so the file is marked `long`."""

import base64
import contextlib
import datetime
import itertools
import json
import pathlib
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import urllib.request

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / part) for part in ("test/mission", "test/support", "gse/yamcs")]

import flying
import run as yamcs_run
from hirosco_gse import packets, sdls, telemetry, values
from hirosco_gse.dictionary import Dictionary
from message_values import Values
from tm_packets import build_tm
from yamcs_server import MISSION, TIMEOUT_S, Yamcs, plain, until

pytestmark = pytest.mark.long
APID, DISPLAY = 16, 4720  # The manipulator and its display structure.
PACKETS_OF_EACH = 5  # Number of packets of each structure that are compared.
TAI_1970_S, LEAP_S = 378_691_200, 37  # Seconds from 1958 to 1970; seconds by which UTC is behind TAI.
LATER_NS = 10**9 * 10**7  # Mission time of synthetic reports, after that of all reports of the flight.
DERIVED = re.compile(r"__[a-z]+\d*(_\d+)?\Z")  # Entries from which Yamcs only computes the position of other entries.
SERVICE = re.compile(r"/ST\d\d/")


@pytest.fixture(scope="module")
def place():
    above = ROOT / "build" / "test"
    above.mkdir(parents=True, exist_ok=True)
    directory = pathlib.Path(tempfile.mkdtemp(prefix="yamcs-", dir=above))
    yield directory
    shutil.rmtree(directory, ignore_errors=True)


@pytest.fixture(scope="module")
def flight(place):
    flight = flying.start(place / "flight", "--scenario", "none", "--duration", 1_000_000, "--time", "real")
    flight.port()
    for words in (("state", "MANIPULATOR", "PRE_OPERATIONAL"), ("config", "MANIPULATOR", "STAND_ALONE")):
        done = flying.gse(flight, *words, timeout=TIMEOUT_S)
        assert done.returncode == 0, done.stdout + done.stderr
    yield flight
    flight.process.send_signal(signal.SIGINT)
    flight.wait()


@pytest.fixture(scope="module")
def synthetic_link():
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server


@pytest.fixture(scope="module")
def yamcs(place, flight, synthetic_link):
    assert yamcs_run.LIBRARIES.is_dir(), "Yamcs is not installed: sh gse/setup/yamcs.sh"
    server = Yamcs(place / "yamcs", flight.port(), synthetic_link.getsockname()[1])
    try:
        until(server.has_started, "start of Yamcs")
        yield server
    finally:
        server.end()


@pytest.fixture(scope="module")
def dictionary():
    return Dictionary.load(ROOT / "build" / "generated" / f"{MISSION}.json")


def test_yamcs_loads_the_database_without_a_warning_and_links_up(yamcs):
    until(lambda: all(link["status"] == "OK" for link in yamcs.ask("links/mission")["links"]), "the links")
    words = [line for line in yamcs.log_text().splitlines() if re.match(r"(WARNING|SEVERE) ", line) and "xtce" in line.lower()]
    assert not words, words
    commands = yamcs.ask("mdb/mission/commands?limit=1&details=false")
    assert commands["totalSize"] > 240


def test_requests_complete_with_their_verifiers(yamcs):
    until(lambda: all(link["status"] == "OK" for link in yamcs.ask("links/mission")["links"]), "the links")
    for name, arguments in (
        ("ST17/PING", {"apid": "MANIPULATOR"}),
        ("ST20/PARAMETER_REPORT", {"apid": "MANIPULATOR", "n_groups": ["MANIPULATOR.DES_POSITION", "MANIPULATOR.TORQUE_LIMIT"]}),
        ("MANIPULATOR/SET_TORQUE_LIMIT", {"TORQUE_LIMIT": [1.25, 0.75]}),
        ("ST03/HK_REPORT_ONCE", {"apid": "SUPERVISOR", "n_groups": [1]}),
    ):
        history = yamcs.carried_out(name, **arguments)
        stages = [history.get(f"Verifier_{stage}_Status") for stage in ("Accepted", "Started", "Completed")]
        assert stages == ["OK", "OK", "OK"] and history["CommandComplete_Status"] == "OK", (name, {k: v for k, v in history.items() if "Message" in k})
    refused = yamcs.carried_out("ST03/HK_REPORT_ONCE", apid="SUPERVISOR", n_groups=[4711])
    assert refused["CommandComplete_Status"] == "NOK" and refused["Verifier_Started_Message"] == "UNKNOWN_ID", refused
    with pytest.raises(AssertionError, match="not in the range"):
        yamcs.command("MANIPULATOR/SET_DES_POSITION", DES_POSITION=[9.0, 0.0])
    parameter = f"processors/mission/realtime/parameters/{MISSION}/MANIPULATOR/TORQUE_LIMIT"
    yamcs.carried_out("ST20/PARAMETER_REPORT", apid="MANIPULATOR", n_groups=["MANIPULATOR.TORQUE_LIMIT"])
    until(lambda: plain(yamcs.ask(parameter).get("engValue")) == [1.25, 0.75], "the value that was set")
    # With this limit the manipulator would leave OPERATIONAL at once; later tests need it there.
    assert yamcs.carried_out("MANIPULATOR/SET_TORQUE_LIMIT", TORQUE_LIMIT=[38.0, 38.0])["CommandComplete_Status"] == "OK"


def test_the_missions_own_services_have_commands_with_words(yamcs):
    """States, modes, configurations, links and processes have names; a request that cannot be routed fails by
    TM[1,10]."""
    for name, arguments in (
        ("MANIPULATOR/SELECT_CONFIGURATION", {"configuration": "STAND_ALONE"}), ("JOYSTICK/REPORT_STATUS", {}),
        ("ST131/SUBSYSTEMS_REPORT", {"apid": "SUPERVISOR"}), ("ST131/NETWORKS_REPORT", {"apid": "SUPERVISOR"}),
        ("ST130/LINK_REPORT_STATUS", {"apid": "SUPERVISOR", "n_groups": []}),
    ):
        history = yamcs.carried_out(name, **arguments)
        assert history["CommandComplete_Status"] == "OK", (name, history)
    refused = yamcs.carried_out("ST130/LINK_OPEN", apid="SUPERVISOR", link="HAND_POSITION", epoch=0)
    assert refused["CommandComplete_Status"] == "NOK", refused
    with pytest.raises(AssertionError, match="FLYING"):
        yamcs.command("ST131/MODE_SET", apid="SUPERVISOR", mode="FLYING")
    stopped = yamcs.carried_out("ST131/PROCESS_STOP", apid="SUPERVISOR", process_of="JOYSTICK")
    assert stopped["CommandComplete_Status"] == "OK", stopped
    unroutable = yamcs.carried_out("ST17/PING", apid="JOYSTICK")
    assert unroutable["Verifier_Accepted_Message"] == "UNAVAILABLE" and unroutable["CommandComplete_Status"] == "NOK", unroutable
    assert any(packets.parse(base64.b64decode(one[3])).message == (1, 10) for one in yamcs.packets())
    started = yamcs.carried_out("ST131/PROCESS_START", apid="SUPERVISOR", process_of="JOYSTICK")
    assert started["CommandComplete_Status"] == "OK", started


def test_stacks_and_displays_exist_and_the_steps_of_a_stack_complete(yamcs):
    """They are in the buckets that Yamcs' pages show; the database has each parameter of a display and each
    command of a stack."""
    shown = {name: {one["name"] for one in yamcs.ask(f"storage/buckets/{name}/objects")["objects"]} for name in ("displays", "stacks")}
    assert shown["displays"] == {"SUPERVISOR.par", "COMMUNICATION.par", "JOYSTICK.par", "MANIPULATOR.par"}
    pages = [yamcs.ask(f"mdb/mission/parameters?limit=1000&details=false&pos={start}") for start in range(0, 5000, 1000)]
    known = {one["qualifiedName"] for page in pages for one in page.get("parameters", [])}
    for name in shown["displays"]:
        assert set(yamcs.ask(f"storage/buckets/displays/objects/{name}")["parameters"]) <= known
    assert "JOYSTICK-STAND_ALONE.ycs" in shown["stacks"]
    for step in yamcs.ask("storage/buckets/stacks/objects/JOYSTICK-STAND_ALONE.ycs")["steps"]:
        arguments = {one["name"]: one["value"] for one in step["arguments"]}
        history = yamcs.carried_out(step["name"].removeprefix(f"/{MISSION}/"), **arguments)
        assert history["CommandComplete_Status"] == "OK", (step, history)
    state = f"processors/mission/realtime/parameters/{MISSION}/JOYSTICK/CUR_VALUES_STATE"
    until(lambda: plain(yamcs.ask(state).get("engValue")) == "OPERATIONAL", "the state in words")
    yamcs.carried_out("ST03/HK_REPORT_ONCE", apid="SUPERVISOR", n_groups=[1])
    malformed = f"processors/mission/realtime/parameters/{MISSION}/SUPERVISOR/COUNTERS_TM_MALFORMED"
    until(lambda: yamcs.ask(malformed).get("monitoringResult") == "IN_LIMITS", "a value that was compared with its warning limit")
    for target in ("SAFE_OPERATIONAL", "PRE_OPERATIONAL", "OFFLINE"):
        assert yamcs.carried_out("JOYSTICK/REQUEST_STATE", target=target)["CommandComplete_Status"] == "OK"


def test_another_ground_user_leaves_no_gap_and_finishes_no_command_of_yamcs(yamcs, flight):
    for _ in range(3):
        done = flying.gse(flight, "ping", "all", timeout=TIMEOUT_S)
        assert done.returncode == 0, done.stderr
        history = yamcs.carried_out("ST17/PING", apid="SUPERVISOR")
        assert history["CommandComplete_Status"] == "OK", history
    warned = [one for one in yamcs.ask("archive/mission/events?limit=1000").get("events", []) if "JUMP" in one.get("type", "") + one["message"]]
    assert not warned and "SEQ_COUNT_JUMP" not in yamcs.log_text()
    # Tests after this one connect as the user of Yamcs, too; answers to them are not sent to this Yamcs, which counts them as lost.
    assert value_of(yamcs, "lost_packets") == 0


def test_the_database_of_yamcs_is_compared_with_the_flying_mission(flight, dictionary, monkeypatch, tmp_path):
    assert yamcs_run.compare(MISSION, flight.port(), TIMEOUT_S) == [f"the mission flies the interface of the database, {dictionary.interface_hash}"]
    content = json.loads((ROOT / "build" / "generated" / f"{MISSION}.json").read_text(encoding="utf-8"))
    content["subsystems"][0]["interface_hash"] = content["interface_hash"] = "0x00000000000000AA"
    (tmp_path / f"{MISSION}.json").write_text(json.dumps(content), encoding="utf-8")
    for name in (f"{MISSION}.xtce.xml", f"{MISSION}.events.json"):
        shutil.copy2(ROOT / "build" / "generated" / name, tmp_path)
    monkeypatch.setattr(yamcs_run, "GENERATED", tmp_path)
    reported = yamcs_run.compare(MISSION, flight.port(), TIMEOUT_S)
    assert len(reported) == 3 and all("run make" in line for line in reported[:2])
    assert re.fullmatch(r"\w+ flies interface 0x\w{16}, the database has 0x00000000000000AA: .*", reported[2])


def test_yamcs_commands_a_mission_with_a_key_through_the_gateway(place, synthetic_link):
    key = place / "ground.key"
    sdls.make_key(key)
    flight = flying.start(place / "secured", "--scenario", "none", "--duration", 1_000_000, "--form", "image", "--key", key)
    words = ("--key", str(key), "gateway", "--listen", str(flying.free_port()))
    gateway = subprocess.Popen([*flying.gse_words(flight), *words], stdout=subprocess.PIPE, text=True)
    port = int(re.search(r"packets at 127\.0\.0\.1:(\d+)", gateway.stdout.readline())[1])
    server = Yamcs(place / "yamcs-secured", port, synthetic_link.getsockname()[1])
    try:
        until(server.has_started, "start of Yamcs")
        until(lambda: all(link["status"] == "OK" for link in server.ask("links/mission")["links"]), "the links")
        history = server.carried_out("ST17/PING", apid="MANIPULATOR")
        assert history["CommandComplete_Status"] == "OK", history
    finally:
        server.end()
        gateway.send_signal(signal.SIGINT)
        gateway.wait(TIMEOUT_S)
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    assert flight.code == 0, flight.transcript()


def test_yamcs_starts_ends_and_starts_again_in_one_directory(place, flight):
    """The command of `make yamcs` starts it, with mission and port of the run directory; a second instance in the directory is refused."""
    words = [sys.executable, ROOT / "gse/yamcs/run.py", "--run", flight.directory, "--out", place / "twice", "--http-port"]
    for _ in range(2):
        server = subprocess.Popen([*words, str(flying.free_port())], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            reported = ""
            while "Yamcs started" not in reported:
                assert (line := server.stdout.readline()), reported
                reported += line
            assert f"mission {MISSION}, ground port 127.0.0.1:{flight.port()}" in reported and "the mission flies the interface of the database" in reported
            second = subprocess.run([*words, "1"], capture_output=True, text=True, check=False)
            assert second.returncode == 1 and "another Yamcs runs in" in second.stderr
        finally:
            server.send_signal(signal.SIGINT)
            server.communicate()
        assert server.returncode == 0


# ---- synthetic reports ----


def leaves(value):
    """Scalars of a value in order; a number that has a word is replaced by the word."""
    if getattr(value, "members", None):
        return leaves(value.members)
    if isinstance(value, values.Word):
        return [value.word]
    if isinstance(value, (dict, list)):
        return list(itertools.chain.from_iterable(leaves(one) for one in (value.values() if isinstance(value, dict) else value)))
    return [value]


class Expected:
    """Raw values of a report of the catalogue in the order of the packet, as Yamcs should find them."""

    def __init__(self, dictionary, entry):
        self.dictionary, self.catalogue, self.entry = dictionary, dictionary.catalogue, entry

    def fields(self, fields, given):
        found = []
        for field in fields:
            if "repeat" in field:
                groups = given[field["repeat"]]
                found.append(len(groups))
                for group in groups:
                    found += self.fields(field["fields"], group)
            elif "choice" in field:
                number = self.catalogue.number_of(self.entry["service"], field["choice"], given[field["choice"]])
                found += self.fields(field["cases"][str(number)], given)
            else:
                found += self.value(field, given[field["name"]])
        return found

    def value(self, field, value):
        """Raw values of one field."""
        if field["kind"] == "value":
            return leaves(value)
        kind = self.catalogue.kinds[field["kind"]]
        coding, service = kind["coding"], self.entry["service"]
        if field["kind"] == "request_id32":
            return [value >> 29, value >> 28 & 1, value >> 27 & 1, value >> 16 & 0x7FF, value >> 14 & 3, value & 0x3FFF]
        if field["kind"] == "failure_detail":
            octets = bytes.fromhex(value)
            return [int.from_bytes(octets[:2], "big"), int.from_bytes(octets[2:], "big")]
        if coding in ("u8", "u16", "u32", "u64"):
            return [self.catalogue.number_of(service, field["name"], value)]
        if coding == "id":
            return [self.catalogue.parameter_id(value)]
        if coding == "time":
            return [int.from_bytes(packets.encode_time(self.dictionary.epoch_ns + round(value * 10**9)), "big")]
        if coding in ("reltime", "position"):
            return [round(value * 2 ** {"reltime": 24, "position": 16}[coding])]
        if coding == "cds":
            ms, us = divmod(self.dictionary.epoch_ns // 1000 + round(value * 10**6), 1000)
            return [ms // 86_400_000, ms % 86_400_000, us]
        if coding == "packet":
            return [value[12:-2]]  # The octets between the length and the last octet.
        return [value]


def seen(extracted):
    """Raw values that Yamcs has found, without the DERIVED entries."""
    found = []
    for path, raw, _ in extracted:
        if (SERVICE.search(path) and not DERIVED.search(path)) or (path.count("/") == 3 and not SERVICE.search(path)):
            found += leaves(raw)
    return found


def made_up(dictionary):
    """(message, values, packet) of every kind of report, several of each."""
    count = itertools.count()
    for entry in dictionary.catalogue.all("TM"):
        message = entry["service"], entry["subtype"]
        if message in ((3, 25), (3, 26), (2, 12)) or message[0] == 5 and message[1] <= 4:
            continue  # Reports whose layout is in descriptors are in the flight; some layouts are known on board only.
        for seed in range(4):
            if message == (20, 2):
                names = ("MANIPULATOR.DES_POSITION", "MANIPULATOR.TORQUE_LIMIT")
                given = {"n": [{"parameter_id": name, "parameter_value": [0.25 * seed, -1.5]} for name in names]}
            else:
                given = Values(dictionary.catalogue, seed).group(entry, entry["fields"])
            number = next(count)
            data = dictionary.catalogue.encode("TM", *message, given)
            stamp = dictionary.epoch_ns + LATER_NS + number * 10**9
            yield message, given, build_tm(99, number, *message, data, 2, stamp, number)


@pytest.fixture(scope="module")
def synthetic(yamcs, synthetic_link):
    """The connection of Yamcs to the simulated spacecraft."""
    with contextlib.closing(synthetic_link.accept()[0]) as connection:
        yield connection


def test_synthetic_reports_have_the_values_that_were_encoded(yamcs, synthetic, dictionary):
    made = {raw: (message, given) for message, given, raw in made_up(dictionary)}
    synthetic.sendall(b"".join(made))
    # Wait until Yamcs has all packets of `made`; `kept` are then all packets that it has.
    kept = until(lambda: [one for one in yamcs.packets() if base64.b64decode(one[3]) in made][len(made) - 1 :] and yamcs.packets(), "all")
    wrong, compared = [], set()
    for name, stamp, sequence, octets in kept:
        message, given = made.get(base64.b64decode(octets), (None, None))
        if message is None:
            continue
        entry = dictionary.catalogue.find("TM", *message)
        assert name.endswith(f"/{entry['identifier']}"), name
        expected, theirs = Expected(dictionary, entry).fields(entry["fields"], given), seen(yamcs.extract(name, stamp, sequence))
        compared.add(message)
        if expected != theirs:
            wrong.append(f"TM{list(message)} {given}\n  expected {expected}\n  found    {theirs}")
    assert len(compared) == len({message for message, _ in made.values()})
    assert not wrong, f"{len(wrong)} wrong\n" + "\n".join(wrong[:10])


def value_of(yamcs, name):
    """The present value of a parameter; None if it has none."""
    return plain(yamcs.ask(f"processors/mission/realtime/parameters/{MISSION}/{name}").get("engValue"))


def test_a_stack_opens_links_and_brings_telepresence_up(yamcs, flight):
    """The stack is ALL-TELEPRESENCE; states, phases, configurations and links of both subsystems are separate
    parameters."""
    # A link must be opened within 5 s of its request, and Yamcs may be slow here.
    slowed = flying.gse(flight, "--run", flight.directory, "speed", "0.2")
    assert slowed.returncode == 0, slowed.stderr
    for step in yamcs.ask("storage/buckets/stacks/objects/ALL-TELEPRESENCE.ycs")["steps"]:
        arguments = {one["name"]: one["value"] for one in step["arguments"]}
        history = yamcs.carried_out(step["name"].removeprefix(f"/{MISSION}/"), **arguments)
        assert history["CommandComplete_Status"] == "OK", (step, history)
    for name in ("JOYSTICK", "MANIPULATOR"):
        until(lambda: value_of(yamcs, f"{name}/SUBSYSTEM_STATE") == "OPERATIONAL", "the state")
        assert value_of(yamcs, f"{name}/SUBSYSTEM_CONFIGURATION") == "TELEPRESENCE" and value_of(yamcs, f"{name}/SUBSYSTEM_CAUSE") == "request"
        until(lambda: value_of(yamcs, f"{name}/SUBSYSTEM_TARGET") == "OPERATIONAL", "a status report")
        for link in ("HAND_POSITION", "ROBOT_STATE"):
            assert value_of(yamcs, f"{name}/LINK_{link}_STATE") == "open"
    assert flying.gse(flight, "--run", flight.directory, "speed", "1").returncode == 0
    assert value_of(yamcs, "SUPERVISOR/SUBSYSTEM_STATE") == "OPERATIONAL"


def near_enough(theirs, ours):
    return theirs == ours or (isinstance(ours, float) and theirs == pytest.approx(ours, rel=1e-6, abs=1e-12))


def test_housekeeping_of_all_subsystems_has_the_values_of_the_packet_log(yamcs, dictionary, flight):
    """Calibrated values and words equal those that the ground segment reads in the log on board. Yamcs enables a display structure."""
    for verb in ("ENABLE", "DISABLE"):
        assert yamcs.carried_out(f"ST03/HK_{verb}", apid="MANIPULATOR", n_groups=[DISPLAY])["CommandComplete_Status"] == "OK"
        until(lambda: any(f"/HK_{DISPLAY}" in one[0] for one in yamcs.packets()), "a report of the display structure")
    until(lambda: {1, 2, 16, 17} <= {packets.parse(base64.b64decode(one[3])).apid for one in yamcs.packets() if "/HK_" in one[0]}, "housekeeping")
    newest = yamcs.packets()
    logged = {line.split()[-1] for line in (flight.directory / "packets.ascii").read_text(encoding="ascii").splitlines() if line.strip()}
    present = {one.apid: one.configuration("TELEPRESENCE").id for one in dictionary.members}
    compared = {}
    for name, stamp, sequence, octets in newest:
        packet = packets.parse(base64.b64decode(octets))
        decoded = telemetry.decode(packet, dictionary, present)
        key = packet.apid, decoded.get("structure"), len(packet.raw)
        if packet.message != (3, 25) or compared.get(key, 0) >= PACKETS_OF_EACH:
            continue
        assert packet.raw.hex() in logged, f"{name} at {stamp} is not in the packet log"
        extracted = [value for path, _, value in yamcs.extract(name, stamp, sequence) if path.count("/") == 3 and not SERVICE.search(path)]
        theirs, ours = leaves(extracted), leaves(decoded["values"])
        assert len(theirs) == len(ours) and all(map(near_enough, theirs, ours)), (name, theirs, ours)
        compared[key] = compared.get(key, 0) + 1
    assert {(1, 1), (2, 1), (APID, DISPLAY), (17, 4711)} <= {key[:2] for key in compared} and sum(compared.values()) >= 4 * PACKETS_OF_EACH


def test_a_gap_is_reported(yamcs, synthetic, dictionary):
    """Several users leave gaps in the sequence counts, but none in the message type counters, by which losses are counted."""
    before = value_of(yamcs, "lost_packets")
    data = dictionary.catalogue.encode("TM", 17, 2, {})
    for number, counter in enumerate((7, 8, 12)):
        synthetic.sendall(build_tm(99, 5000 + number, 17, 2, data, 0, dictionary.epoch_ns + LATER_NS + (9000 + number) * 10**9, counter))
    until(lambda: value_of(yamcs, "lost_packets") == before + 3, "the loss")


def test_a_violated_limit_raises_an_alarm(yamcs, synthetic, dictionary):
    supervisor = dictionary.subsystem("SUPERVISOR")
    structure = supervisor.structures_of_id(1)[0]
    octets = b""
    for parameter in structure.once:
        for item in parameter.fields or (parameter,):
            octets += bytes(item.size - 1) + bytes([5 if item.name == "TM_MALFORMED" else 0])
    stamp = dictionary.epoch_ns + LATER_NS + 9900 * 10**9
    synthetic.sendall(build_tm(1, 9, 3, 25, (1).to_bytes(2, "big") + octets, 0, stamp, 1))
    path = f"processors/mission/realtime/parameters/{MISSION}/SUPERVISOR/COUNTERS_TM_MALFORMED"
    until(lambda: yamcs.ask(path).get("monitoringResult") == "WARNING", "the warning")
    alarms = [one["id"]["name"] for one in yamcs.ask("processors/mission/realtime/alarms").get("alarms", [])]
    assert alarms.count("COUNTERS_TM_MALFORMED") == 1, alarms


def test_the_view_of_the_station_is_a_part_of_its_page(yamcs):
    with urllib.request.urlopen(f"http://127.0.0.1:{yamcs.port}/api/storage/buckets/view/objects/view.js", timeout=TIMEOUT_S) as answer:
        text = answer.read().decode()
    assert 'customElements.define("hirosco-view"' in text and f'frame.src = "{yamcs_run.STATION}"' in text
    with urllib.request.urlopen(f"http://127.0.0.1:{yamcs.port}/", timeout=TIMEOUT_S) as answer:
        assert "/api/storage/buckets/view/objects/view.js" in answer.read().decode()


def events_of(yamcs, word):
    """Events whose message contains this word, the newest first."""
    return yamcs.ask(f"archive/mission/events?limit=1000&q={word}").get("events", [])


def test_events_are_reported(yamcs, flight):
    """Another ground connects while Yamcs listens: Yamcs may not receive an event of the time before."""
    until(lambda: all(link["status"] == "OK" for link in yamcs.ask("links/mission")["links"]), "the links")
    before = len(events_of(yamcs, "GROUND_CONNECTED"))
    assert (done := flying.gse(flight, "ping", "COMMUNICATION", timeout=TIMEOUT_S)).returncode == 0, done.stderr
    until(lambda: len(events_of(yamcs, "GROUND_CONNECTED")) > before, "the event of the other connection")
    assert {one["type"] for one in events_of(yamcs, "GROUND_CONNECTED")} == {"GROUND_CONNECTED"}


def test_an_event_names_what_its_numbers_mean(yamcs, synthetic, dictionary):
    """The message of an event shows an identifying number with its name, and without a name as UNDEF or as the number alone."""
    stamp = dictionary.epoch_ns + LATER_NS + 9990 * 10**9
    for number, (apid, severity, event, octets, words) in enumerate((
        (APID, 2, "DEVICE_REFUSED", struct.pack(">BBII", 0x11, 4, 0x200102, 7), "node JOINT1 (17) reason VALUE object 0x200102 detail 7"),
        (APID, 4, "DEVICE_LOST", b"\x7f", "node UNDEF (127)"),
        (1, 1, "PLAN_STARTED", struct.pack(">HH", 17, 1), "apid JOYSTICK event DEVICE_LOST (1)"),
        (1, 1, "PLAN_STARTED", struct.pack(">HH", 2, 1), "apid COMMUNICATION event GROUND_CONNECTED (1)"),
        (1, 1, "PLAN_STARTED", struct.pack(">HH", 77, 2), "apid UNDEF event 2 (2)"),
        (1, 1, "PLAN_OVERRULED", struct.pack(">HHHH", 16, 1, 77, 999), "apid MANIPULATOR event DEVICE_LOST (1) by_apid UNDEF by_event 999 (999)"),
        (1, 1, "PROCEDURE_OBSERVED", struct.pack(">8sBHI45s", b"SWEEP", 8, 3, 7, b"half way"), "procedure SWEEP what STEP step 3 detail 7 text half way"),
        (1, 1, "NETWORK_SHUT_DOWN", struct.pack(">HH", 16, 17), "network MANIPULATOR apid JOYSTICK"),
    )):
        subsystem = dictionary.subsystem_of_apid(apid)
        data = struct.pack(">H", subsystem.event(event).id) + octets
        synthetic.sendall(build_tm(apid, 9000 + number, 5, severity, data, 0, stamp + number * 10**9, number))
        wanted = f"{subsystem.name} {event} {words}"
        until(lambda: wanted in [one["message"] for one in events_of(yamcs, event) if one["type"] == event], wanted)


# ---- requests ----


class KnownValues(Values):
    """Values that the commands accept: at least one group; for a parameter id, the name of a parameter of two real numbers,
    and for the value of that parameter, two such numbers."""

    def group(self, entry, fields):
        found = super().group(entry, fields)
        for field in fields:
            if "repeat" in field and not found[field["repeat"]]:
                found[field["repeat"]] = [self.group(entry, field["fields"])]
        return found

    def value(self, entry, field):
        kind = self.catalogue.kinds.get(field["kind"], {"coding": None})
        if kind["coding"] == "id":
            self.layouts[field["name"]] = "REALS"
            return "MANIPULATOR.TORQUE_LIMIT"
        if field["kind"] == "value" and self.layouts.get(field["of"]) == "REALS":
            return [1.5, -2.0]
        if field["kind"] in ("bool8", "apid"):
            return {"bool8": 1, "apid": APID}[field["kind"]]
        return super().value(entry, field)


class Command:
    """Name and arguments of the generated command for values of a request of the catalogue."""

    def __init__(self, catalogue, entry, given):
        self.catalogue, self.entry, self.found = catalogue, entry, {"apid": "MANIPULATOR"}
        self.name = f"ST{entry['service']:02}/{entry['identifier']}"
        self.given = self.fields(entry["fields"], given)

    def fields(self, fields, given):
        """Fill in the arguments of these fields. Returns the values that the command can have."""
        selectors, kept = {field["choice"] for field in fields if "choice" in field}, dict(given)
        for field in fields:
            if "choice" in field:
                word = str(given[field["choice"]])
                self.name += "_" + re.sub(r"[^A-Za-z0-9]", "_", word).upper()
                number = self.catalogue.number_of(self.entry["service"], field["choice"], word)
                kept |= self.fields(field["cases"][str(number)], {k: v for k, v in given.items() if k in names(field["cases"][str(number)])})
            elif "repeat" in field and has_one_group(field["fields"]):
                kept[field["repeat"]] = [self.fields(field["fields"], given[field["repeat"]][0])]
            elif "repeat" in field:
                self.put(f"{field['repeat']}_groups", self.groups(field["fields"], given[field["repeat"]]))
            elif field["name"] not in selectors:
                self.put(field["name"], self.value(field, given))
        return kept

    def put(self, name, value):
        """Add an argument under a name that is not used yet."""
        word, number = name, 2
        while word in self.found or word in ("ack", "service", "subtype", "source"):
            word, number = f"{name}_{number}", number + 1
        self.found[word] = value

    def groups(self, fields, groups):
        """Elements of an array."""
        made = []
        for group in groups:
            members = {}
            for one in fields:
                if "repeat" in one:
                    members[one["repeat"]] = len(group[one["repeat"]])
                    members[f"{one['repeat']}_groups"] = self.groups(one["fields"], group[one["repeat"]])
                else:
                    members[one["name"]] = self.value(one, group)
            made.append(members if len(members) > 1 else next(iter(members.values())))
        return made

    def value(self, field, given):
        """A value in the form that Yamcs accepts."""
        value = given[field["name"]]
        if field["kind"] == "value" and not isinstance(value, str):
            kind = "DOUBLE" if isinstance(value, list) else given[field["of"]]
            return values.encode(kind, value if isinstance(value, list) else [value]).hex()
        if field["kind"] in ("bool8", "apid"):
            return {"bool8": bool(value), "apid": "MANIPULATOR"}[field["kind"]]
        coding = self.catalogue.kinds.get(field["kind"], {}).get("coding")
        if coding in ("reltime", "position"):
            return round(value * 2 ** {"reltime": 24, "position": 16}[coding])
        if coding == "time":
            since_1970_s = self.catalogue.dictionary.epoch_ns / 1e9 + value - TAI_1970_S - LEAP_S
            return datetime.datetime.fromtimestamp(since_1970_s, datetime.UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        return value


def names(fields):
    """Names of the fields of a group and of its counts."""
    return {field.get("name", field.get("repeat")) for field in fields}


def has_one_group(fields):
    """True if a command can have only one group of these fields."""
    return any(
        "choice" in one or one.get("kind") == "value" or has_one_group(one.get("fields", [])) for one in fields
    )


def near(value):
    """A decoded value with real numbers rounded to the millisecond, because Yamcs stores times so."""
    if isinstance(value, dict):
        return {name: near(one) for name, one in value.items()}
    if isinstance(value, list):
        return [near(one) for one in value]
    return round(value, 3) if isinstance(value, float) else value


def read_back(dictionary, message, octets):
    """A request as the ground segment reads it."""
    return near(dictionary.catalogue.decode(packets.Packet("TC", 16, 0, *message, 2, octets, b"")))


def test_yamcs_encodes_every_request_as_the_ground_segment_does(yamcs, dictionary):
    wrong, made = [], 0
    for entry in dictionary.catalogue.all("TC"):
        message = entry["service"], entry["subtype"]
        for seed in range(2):
            command = Command(dictionary.catalogue, entry, KnownValues(dictionary.catalogue, seed).group(entry, entry["fields"]))
            ours = dictionary.catalogue.encode("TC", *message, command.given)
            try:
                answer = yamcs.command(command.name, dry=True, **command.found)
            except AssertionError as error:
                wrong.append(f"TC{list(message)}: {error}"[:400])
                continue
            theirs = base64.b64decode(answer["unprocessedBinary"])
            assert theirs[7:9] == bytes(message)
            made += 1
            if theirs[11:] != ours and read_back(dictionary, message, theirs[11:]) != read_back(dictionary, message, ours):
                wrong.append(f"TC{list(message)} {command.found}\n  expected {ours.hex()}\n  found    {theirs[11:].hex()}")
    assert not wrong, f"{len(wrong)} of {len(wrong) + made} wrong\n" + "\n".join(wrong[:25])
