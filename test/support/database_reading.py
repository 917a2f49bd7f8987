# SPDX-License-Identifier: Apache-2.0
"""Reports that space_packet_parser reads with the XTCE database, compared with the values that the ground
segment reads."""

import struct
import warnings

from hirosco_gse import packets, telemetry

MISSION_SERVICES = (129, 130, 131)
# Fields of the reports of these services: name in the ground segment -> name in the database.
PROPERTIES = {"layout_hash": "layout_hash", "octets": "layout_size", "byte_order": "byte_order", "period_us": "period",
              "tolerance_permille": "tolerance", "depth": "depth", "max_age_us": "max_age"}  # fmt: skip
STATES = {"state": "state", "phase": "phase", "configuration_id": "configuration", "cycle": "cycle"}
# Events with a number of another subsystem. The database enters this number and the values after it by their offsets in the packet;
# Flattened reads no entries with an offset, so only the values before are compared.
ABOUT_OTHERS = ("PLAN_STARTED", "PLAN_OVERRULED", "ADOPTION_DIFFERS")
OWN = {
    (129, 2): {**STATES, "previous": "previous", "code": "code"},
    (129, 5): {**STATES, "target": "target", "interface_hash": "interface_hash", "configuration_hash": "configuration_hash", "epoch": "epoch"},
    (130, 2): {},
    (130, 4): {**PROPERTIES, "transaction": "transaction", "link": "link"},
    (130, 5): {**PROPERTIES, "transaction": "transaction", "reason": "reason", "field": "field"},
    (130, 9): {},
    (130, 10): {"link": "link", "previous": "previous", "state": "state"},
    (131, 9): {},
}


def read(definition, octets):
    """Result of the library for a packet: raw and calibrated values by path."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # The checksum and fields of variable size remain unread.
        return definition.parse_bytes(octets)


def octets_of(time):
    """Octets of a CUC time, which the library reads as a number."""
    return time.raw_value.to_bytes(8, "big")


def short(found, name):
    """Value of the only parameter whose path ends with this name."""
    paths = [path for path in found if path.endswith(f"/{name}")]
    assert len(paths) == 1, (name, sorted(found))
    return found[paths[0]]


def flattened(name, value):
    """Scalars of a value of the ground segment, with the names of Flattened. A number whose bits have names has one for each of them."""
    if getattr(value, "members", None):
        value = value.members
    if isinstance(value, dict):
        return {key: one for member, inner in value.items() for key, one in flattened(f"{name}.{member}", inner).items()}
    if isinstance(value, list) and len(value) == 1:
        return flattened(name, value[0])
    if isinstance(value, list):
        return {key: one for index, inner in enumerate(value) for key, one in flattened(f"{name}[{index}]", inner).items()}
    return {name: value}


def check_header(found, packet, dictionary):
    names = ("apid", "sequence_count", "service", "subtype", "message_counter", "destination", "ccsds_type", "pus_version")
    values = (packet.apid, packet.sequence, packet.service, packet.subtype, packet.counter, packet.user, 0, 2)
    root = f"/{dictionary.mission}/"
    assert [found[root + name] for name in names] == list(values)
    assert packets.decode_time(octets_of(found[root + "time"])) == packet.time_ns


def _octets(structure):
    """Octets of a housekeeping structure."""
    return sum(p.size for p in structure.once) + sum(n * sum(p.size for p in ps) for n, ps in structure.repeated)


def _samples(structure, ours):
    """Values of the ground segment, with the names of the database's arrays of samples."""
    expected = {}
    for number, (repetitions, parameters) in enumerate(structure.repeated, 1):
        names = [parameter.name.replace(".", "_") for parameter in parameters]
        many = f"HK_{structure.id}_samples_{number}_{'_'.join(names)}_x{repetitions}"
        for sample in range(repetitions):
            for name, parameter in zip(names, parameters):
                expected |= flattened(f"{many}[{sample}].{name}", ours[parameter.name][sample])
    return expected


def check_housekeeping(found, packet, dictionary):
    """Check a structure of the descriptors; of a structure that was defined in flight, the database has only
    the id."""
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    (structure_id,) = struct.unpack_from(">H", packet.data)
    fitting = [one for one in subsystem.structures_of_id(structure_id) if 2 + _octets(one) == len(packet.data)]
    if not fitting or structure_id in subsystem.created:
        return False
    ours = fitting[0].decode(packet.data, 2)
    expected = _samples(fitting[0], ours)
    for parameter in fitting[0].once:
        value = ours[parameter.name]
        for name, one in value.items() if isinstance(value, dict) else [("", value)]:
            expected |= flattened(f"{parameter.name}_{name}".strip("_").replace(".", "_"), one)
    prefix = f"/{dictionary.mission}/{subsystem.name}/"
    theirs = {path.removeprefix(prefix): value for path, value in found.items() if path.startswith(prefix)}
    assert same(theirs, expected), (theirs, expected)
    return True


def check_event(found, packet, dictionary):
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    event = subsystem.event_of_id(int.from_bytes(packet.data[:2], "big"))
    if event is None:
        return False
    assert short(found, "event_definition_id") == event.id
    last = [path for path in found if path.endswith("/LAST_EVENT")]
    assert not last or len(last) == 1 and found[last[0]] == event.name and found[last[0]].raw_value == event.id, last
    expected, own_fields = {}, {one.name for one in event.parameters if not hasattr(one, "parameter_id")}
    texts = {one.name for one in event.parameters if getattr(one, "kind", "") == "character"}
    for name, value in event.decode(packet.data, 2).items():
        own = f"{event.name}_{name}" if name in own_fields else name
        expected |= {own: bytes(value).decode("ascii")} if name in texts else flattened(own, value)
    prefix = f"/{dictionary.mission}/{subsystem.name}/"
    theirs = {path.removeprefix(prefix): value for path, value in found.items() if path.startswith(prefix)}
    if event.name in ABOUT_OTHERS:
        expected = dict(list(expected.items())[: max(1, len(theirs))])
    assert same(theirs, expected), (theirs, expected)
    return True


def same(theirs, ours):
    """Equal names and values; NaN equals itself."""
    return theirs.keys() == ours.keys() and all(theirs[k] == ours[k] or theirs[k] != theirs[k] and ours[k] != ours[k] for k in ours)


def check_verification(found, packet, dictionary):
    ours = dictionary.catalogue.decode(packet)
    word = ours["request_id"]
    assert (short(found, "request_apid"), short(found, "request_sequence_count")) == (word >> 16 & 0x7FF, word & 0x3FFF)
    if "failure_code" in ours:
        assert short(found, "failure_code").raw_value == ours["failure_code"]
        theirs = struct.pack(">HI", short(found, "failure_data.instruction"), short(found, "failure_data.detail"))
        assert theirs.hex() == ours["failure_data"]
    if "step_id" in ours:
        assert short(found, "step_id") == ours["step_id"]
    return True


def check_field(found, name, coding, ours, dictionary):
    """One field of any report."""
    if coding == "cds":
        day, ms, us = (short(found, f"{name}.{part}") for part in ("day", "ms", "us"))
        assert ((day * 86_400_000 + ms) * 1000 + us) * 1000 - dictionary.epoch_ns == ours * 1e9
        return
    theirs = short(found, name)
    if coding == "time":
        time_ns = packets.decode_time(octets_of(theirs))
        assert ours == ((time_ns - dictionary.epoch_ns) / 1e9 if time_ns else None)
    elif coding == "id":
        assert dictionary.catalogue.parameter_id(ours) == theirs
    elif coding == "name":
        assert theirs.rstrip("\0") == ours
    elif isinstance(theirs, bytes):
        assert theirs.hex() == ours
    else:
        assert ours in (theirs, theirs.raw_value)


def check_report(found, packet, dictionary):
    """Check all fields before the first one that varies in number, kind or presence."""
    catalogue = dictionary.catalogue
    entry, ours = catalogue.find("TM", packet.service, packet.subtype), catalogue.decode(packet)
    for field in entry["fields"]:
        name = f"tm{packet.subtype}_" + field.get("repeat", field.get("name", ""))
        if "repeat" in field:
            assert short(found, name) == len(ours[field["repeat"]])
            return True
        if "choice" in field or field["kind"] == "value" and packet.message != (2, 12):
            return True
        coding = catalogue.kinds[field["kind"]]["coding"] if field["kind"] in catalogue.kinds else "rest"
        check_field(found, name, coding, ours[field["name"]], dictionary)
    return True


def check_own(found, packet, dictionary):
    """Compare a report of the mission's own services: its values, and the number of its rows."""
    ours = telemetry.decode(packet, dictionary)
    ours |= ours.get("properties", {}) | ours.get("supported", {})
    for name, theirs in OWN[packet.message].items():
        value = short(found, f"tm{packet.subtype}_{theirs}")
        own = int(ours[name], 0) if str(ours[name]).startswith("0x") else ours[name]
        assert own in (value, value.raw_value), (packet.message, name, own, value)
    if "rows" in ours:
        assert short(found, f"tm{packet.subtype}_n") == len(ours["rows"])
    return True


def check(definition, packet, dictionary):
    """Compare what the library and the ground segment read. Returns false if only the header could be
    compared."""
    try:
        found = read(definition, packet.raw)
    except UnicodeDecodeError as error:
        raise AssertionError(packet.raw.hex()) from error
    check_header(found, packet, dictionary)
    if packet.service in MISSION_SERVICES:
        return packet.message in OWN and check_own(found, packet, dictionary)
    if packet.message in ((3, 25), (3, 26)):
        name = "hk_structure_id" if packet.subtype == 25 else "diag_structure_id"
        assert short(found, f"tm{packet.subtype}_{name}") == int.from_bytes(packet.data[:2], "big")
        return packet.subtype == 25 and check_housekeeping(found, packet, dictionary)
    if packet.service == 5 and packet.subtype <= 4:
        return check_event(found, packet, dictionary)
    if packet.service == 1:
        return check_verification(found, packet, dictionary)
    if packet.message == (5, 8):
        assert short(found, "n") == int.from_bytes(packet.data[:2], "big")
        return True
    return check_report(found, packet, dictionary)
