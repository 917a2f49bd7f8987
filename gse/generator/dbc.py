# SPDX-License-Identifier: Apache-2.0
"""CAN database (DBC) of a bus: every frame that flight software and devices exchange, from descriptors and data sheets.

Process data have the PDO mapping in the data sheet of each device, as changed by the settings of every configuration;
NMT, SYNC, TIME, emergencies, SDO and heartbeats are those of CiA 301. Physical values are in SI units.
"""

import re
from dataclasses import dataclass, field

import sheet
from sheet import AXIS_STEP, UNIT_POSITION, UNIT_VELOCITY
from source import read_number

PDO_OBJECTS = ((0x1400, 0x1600, "RPDO"), (0x1800, 0x1A00, "TPDO"))
PDOS_MAX = 4
PDO_INVALID = 1 << 31
IDENTIFIER_MASK = 0x7FF
CONSUMER_HEARTBEAT, SYNC_OVERFLOW = (0x1016, 1), (0x1019, 0)
SYNC_COB, EMCY_COB, SDO_REQUEST_COB, SDO_RESPONSE_COB = (0x1005, 0), (0x1014, 0), (0x1200, 1), (0x1200, 2)
PROFILE_FIRST, PROFILE_LAST = 0x6000, 0x9FFF
RATED_CURRENT_MA, RATED_TORQUE_MNM = 0x6075, 0x6076
POSITIONS = {0x6062, 0x6064, 0x6065, 0x607A, 0x60F4}
VELOCITIES = {0x606B, 0x606C, 0x60B1, 0x60FF}
TORQUES = {0x6071, 0x6072, 0x6074, 0x6077, 0x60B2, 0x60E0, 0x60E1}
CURRENTS = {0x6073, 0x6078}
TEMPERATURES = "temperature"  # Manufacturer objects whose name ends with this have the unit 0.1 degC (sim/devices/README.md).
SI_UNITS = {0x01: "m", 0x03: "s", 0x10: "rad", 0x41: "deg"}  # CiA 303-2
STATES = {0: "Boot up", 4: "Stopped", 5: "Operational", 127: "Pre operational"}
NMT_COMMANDS = {1: "Start", 2: "Stop", 128: "Enter pre operational", 129: "Reset node", 130: "Reset communication"}
CLIENT = {0: "Download segment", 1: "Initiate download", 2: "Initiate upload", 3: "Upload segment", 4: "Abort",
          5: "Block upload", 6: "Block download"}
SERVER = {0: "Upload segment", 1: "Download segment", 2: "Initiate upload", 3: "Initiate download", 4: "Abort",
          5: "Block download", 6: "Block upload"}
EMERGENCIES = {0x0000: "No error", 0x2310: "Over current", 0x3220: "Under voltage", 0x4210: "Over temperature device",
               0x4310: "Over temperature drive", 0x7305: "Position sensor", 0x8110: "CAN overrun", 0x8120: "Error passive",
               0x8130: "Heartbeat lost", 0x8140: "Recovered from bus off", 0x8240: "Unexpected SYNC length",
               0x8250: "RPDO deadline", 0x8311: "Excess torque", 0x8611: "Following error"}
NAME_MAX = 32
MASTER = "MASTER"


@dataclass
class Signal:
    """A signal, little-endian."""

    name: str
    start: int
    bits: int
    signed: bool = False
    factor: float = 1.0
    unit: str = ""
    words: dict = field(default_factory=dict)
    is_multiplexor: bool = False  # The value of this signal decides which multiplexed signals are present.
    when: tuple = ()  # Values of the multiplexor for which this signal is present; empty: always.
    is_real: bool = False  # A number of IEEE 754 with 32 or 64 bits.


@dataclass
class Message:
    """A message; configurations that use the same identifier must define the same message."""

    identifier: int
    name: str
    octets: int
    sender: str
    receivers: list
    signals: list
    is_fd: bool = False


@dataclass
class Node:
    """A device on the bus, in one configuration."""

    element: object
    name: str
    number: int
    sheet: sheet.Sheet
    values: dict  # (index, subindex) -> number, defaults overlaid with the settings


def databases(mission):
    """Text of the database of each bus of a mission, by the name of the bus."""
    buses = mission.element.first("Buses")
    return {bus.attributes["name"]: database(mission, bus) for bus in (buses.children if buses else [])}


def database(mission, bus):
    """Text of the database of one bus."""
    nodes = list(_nodes(mission, bus.attributes["name"]))
    names = _names(nodes)
    messages = _common(nodes, names)
    for unit in sorted({supply.unsigned("unit", 1, 127) for node in nodes for supply in node.element.all("Supply")}):
        names[unit] = f"POWER_UNIT_{unit:02X}"
        messages[0x200 + unit] = Message(0x200 + unit, f"{names[unit]}_PULSE", 3, MASTER, [names[unit]],
                                         [Signal("Line", 0, 16), Signal("Exponent", 16, 8)])
    for node in nodes:
        for message in _of_node(node, names[node.number], "dataBitRate" in bus.attributes):
            known = messages.setdefault(message.identifier, message)
            if known != message:
                node.element.fail(f"identifier {message.identifier:#05x} of bus {bus.attributes['name']} is "
                                  f"{message.name} here and {known.name} with another layout elsewhere")
    return _text(mission, bus, names, [messages[key] for key in sorted(messages)])


# ---- From descriptors and sheets to messages ----


def _nodes(mission, bus):
    """Every device on the bus in every configuration."""
    for _, subsystem in mission.subsystems:
        for configuration in subsystem.configurations:
            for device in configuration.devices:
                ends = [end for end in device.endnodes if end.text("type") == "CAN" and bus in (end.text("bus"), end.text("redundantBus"))]
                for end in ends[:1]:
                    number = end.unsigned("node", 1, 127)
                    loaded = _sheet_of(device)
                    _check_objects(device, loaded)
                    values = loaded.defaults(number)
                    values.update(_settings(device))
                    yield Node(device.element, device.name, number, loaded, values)


def _sheet_of(device):
    """Sheet of the device's class: a file of that name."""
    classes = sorted(path.stem for path in sheet.DIRECTORY.glob("*.eds"))
    if device.type not in classes:
        device.element.wrong("type", "a class with a data sheet: " + " ".join(classes))
    return sheet.load(sheet.DIRECTORY / f"{device.type}.eds")


def _check_objects(device, loaded):
    """Refuse a setting or quantity of an object that the device does not have; otherwise it would only be refused in flight."""
    for child in [*device.element.all("Setting"), *device.element.all("Quantity")]:
        index, _, subindex = child.text("object").partition(":")
        if (int(index, 16), int(subindex, 16)) not in loaded.entries:
            child.wrong("object", f"an object of {loaded.path.name}")


def _settings(device):
    values = {}
    for setting in device.settings:
        index, _, subindex = setting.text("object").partition(":")
        values[int(index, 16), int(subindex, 16)] = read_number(setting.text("value"), setting.text("type"))
    return values


def _names(nodes):
    """Names by node id. If another node already has a name, the id is appended."""
    names = {}
    for node in nodes:
        if node.number not in names:
            taken = node.name in names.values() or node.name == MASTER
            names[node.number] = f"{node.name}_{node.number:02X}" if taken else node.name
    return names


def _common(nodes, names):
    """Messages of the master: NMT, SYNC, TIME and its heartbeat."""
    everybody = [names[number] for number in sorted(names)]
    values = nodes[0].values if nodes else {}
    counter = [Signal("Counter", 0, 8)] if values.get(SYNC_OVERFLOW, 0) else []
    sync = values.get(SYNC_COB, 0x80) & IDENTIFIER_MASK
    listed = [
        Message(0x000, "NMT", 2, MASTER, everybody, [Signal("Command", 0, 8, words=NMT_COMMANDS), Signal("Node", 8, 8)]),
        Message(sync, "SYNC", len(counter), MASTER, everybody, counter),
        Message(0x100, "TIME", 6, MASTER, everybody,
                [Signal("Milliseconds", 0, 28, unit="ms"), Signal("Days", 32, 16, unit="d")]),
    ]
    for number in sorted({(node.values.get(CONSUMER_HEARTBEAT, 0) >> 16) & 0x7F for node in nodes} - {0}):
        listed.append(_heartbeat(MASTER, number, everybody))
    return {message.identifier: message for message in listed}


def _heartbeat(name, number, receivers):
    return Message(0x700 + number, f"{name}_HEARTBEAT", 1, name, receivers, [Signal("State", 0, 8, words=STATES)])


def _of_node(node, name, is_fd):
    values = node.values
    words = EMERGENCIES | {code: text for code, _, text in node.sheet.emergencies}
    yield Message(values.get(EMCY_COB, 0x80 + node.number) & IDENTIFIER_MASK, f"{name}_EMCY", 8, name, [MASTER],
                  [Signal("Code", 0, 16, words=words), Signal("ErrorRegister", 16, 8), Signal("Axis", 24, 8),
                   Signal("Detail", 32, 32, signed=True)])
    yield Message(values.get(SDO_RESPONSE_COB, 0x580 + node.number), f"{name}_SDO_RESPONSE", 8, name, [MASTER],
                  _sdo(SERVER, segment=0, toggles=(0, 1)))
    yield Message(values.get(SDO_REQUEST_COB, 0x600 + node.number), f"{name}_SDO_REQUEST", 8, MASTER, [name],
                  _sdo(CLIENT, segment=0, toggles=(0, 3)))
    yield _heartbeat(name, node.number, [MASTER])
    for parameter, mapping, kind in PDO_OBJECTS:
        for number in range(PDOS_MAX):
            if (parameter + number, 1) in values:
                yield _process_data(node, name, is_fd, (parameter + number, mapping + number, f"{kind}{number + 1}"))


def _sdo(commands, segment, toggles):
    """Signals of an SDO: the command of a frame decides which of them it contains."""
    objects = tuple(number for number in commands if number not in (0, *toggles))
    return [
        Signal("Command", 5, 3, words=commands, is_multiplexor=True),
        Signal("Size", 0, 4, when=objects),
        Signal("Last", 0, 1, when=(segment,)),
        Signal("Unused", 1, 3, when=(segment,)),
        Signal("Toggle", 4, 1, when=toggles),
        Signal("Segment", 8, 56, when=(segment,)),
        Signal("Index", 8, 16, when=objects),
        Signal("Subindex", 24, 8, when=objects),
        Signal("Data", 32, 32, when=objects),
    ]


def _process_data(node, name, is_fd, place):
    parameter, mapping, kind = place
    signals, position = [], 0
    for index, subindex, bits in sheet.mapped(node.values, mapping):
        if index >= 0x20:  # Smaller numbers are data types, which only fill a gap in the mapping.
            signal = _mapped(node, index, subindex, position, bits)
            if any(signal.name == other.name for other in signals):
                number = f"{index:04X}Sub{subindex:X}"
                signal.name = signal.name[: NAME_MAX - len(number)] + number
            signals.append(signal)
        position += bits
    if position % 8 or position > 512:
        node.element.fail(f"{kind} of {name} has {position} bits: expected whole octets, at most 64")
    sender, receiver = (name, MASTER) if kind.startswith("T") else (MASTER, name)
    identifier = node.values[(parameter, 1)] & IDENTIFIER_MASK
    return Message(identifier, f"{name}_{kind}", position // 8, sender, [receiver], signals, is_fd)


def _mapped(node, index, subindex, start, bits):
    entry = node.sheet.entries.get((index, subindex))
    if entry is None:
        node.element.fail(f"{node.name} maps {index:#06x}:{subindex:02x}: expected an object of {node.sheet.path.name}")
    width, signed, is_real = sheet.type_of(entry.kind)
    if width not in (0, bits):
        node.element.fail(f"{node.name} maps {bits} bits of {index:#06x}:{subindex:02x}: expected {width}, the length of the object")
    is_temperature = index < PROFILE_FIRST and entry.name.lower().endswith(TEMPERATURES)
    factor, unit = (0.1, "degC") if is_temperature else _scale(node.values, index)
    if is_real:
        factor, unit = 1.0, ""
    return Signal(_identifier(entry.name, index, subindex), start, bits, signed, factor, unit, is_real=is_real)


def _scale(values, index):
    """Factor and unit of an object, from the unit objects of the device."""
    if not PROFILE_FIRST <= index <= PROFILE_LAST:
        return 1.0, ""
    axis = (index - PROFILE_FIRST) // AXIS_STEP * AXIS_STEP
    of_first = index - axis
    for number, objects, code, unit in ((0, POSITIONS, UNIT_POSITION, "rad"), (1, VELOCITIES, UNIT_VELOCITY, "rad/s")):
        if of_first in objects:
            factor = sheet.units(values, axis // AXIS_STEP)[number]
            return _si(values.get((code + axis, 0), 0)) if factor is None else (factor, unit)
    for objects, rated, unit in ((TORQUES, RATED_TORQUE_MNM, "Nm"), (CURRENTS, RATED_CURRENT_MA, "A")):
        if of_first in objects and (rated + axis, 0) in values:
            return values[(rated + axis, 0)] / 1_000_000, unit  # The object is in per mille of the rated value, which is in mA or mNm.
    return 1.0, ""


def _si(code):
    """Factor and unit of a unit object: prefix, numerator and denominator in its upper octets."""
    unit, per = SI_UNITS.get(code >> 16 & 0xFF, ""), SI_UNITS.get(code >> 8 & 0xFF)
    return sheet.prefix(code), f"{unit}/{per}" if per else unit


def _identifier(name, index, subindex):
    """Signal name of an object: PositionActualValueAxis2 for "Position actual value axis 2". It begins with a letter."""
    words = re.findall(r"[A-Za-z0-9]+", sheet.ascii_of(name)) or [f"{index:04X}Sub{subindex:X}"]
    found = "".join(word[0].upper() + word[1:] for word in words)
    return (f"Object{found}" if found[0].isdigit() else found)[:NAME_MAX]


# ---- Text of the file ----


def _text(mission, bus, names, messages):
    nodes = [MASTER, *(names[number] for number in sorted(names))]
    lines = ['VERSION ""', "", "NS_ :", "\tBA_", "\tBA_DEF_", "\tBA_DEF_DEF_", "\tCM_", "\tSG_MUL_VAL_", "\tVAL_", "",
             "BS_:", "", "BU_: " + " ".join(nodes), ""]
    for message in messages:
        lines += [f"BO_ {message.identifier} {message.name}: {message.octets} {message.sender}",
                  *(_signal(signal, message.receivers) for signal in message.signals), ""]
    about = (f"mission {mission.name}, bus {bus.attributes['name']}; interface 0x{mission.interface_hash:016X}, "
             f"configuration 0x{mission.configuration_hash:016X}; made from the descriptors")
    lines += [f'CM_ "{about}";', *_attributes(bus, messages), *_words(messages), *_reals(messages), *_selections(messages)]
    return "\n".join(lines) + "\n"


def _attributes(bus, messages):
    formats = ",".join(f'"{name}"' for name in _FRAME_FORMATS)
    return ['BA_DEF_ "BusType" STRING ;', 'BA_DEF_ "Baudrate" INT 0 8000000;',
            f'BA_DEF_ BO_ "VFrameFormat" ENUM {formats};',
            'BA_DEF_DEF_ "BusType" "CAN";', 'BA_DEF_DEF_ "Baudrate" 1000000;', 'BA_DEF_DEF_ "VFrameFormat" "StandardCAN";',
            f'BA_ "BusType" "{"CAN FD" if "dataBitRate" in bus.attributes else "CAN"}";',
            f'BA_ "Baudrate" {bus.unsigned("bitRate", 10000, 1000000)};',
            *(f'BA_ "VFrameFormat" BO_ {message.identifier} {_FRAME_FORMATS.index("StandardCAN_FD")};'
              for message in messages if message.is_fd)]


def _words(messages):
    """Words for values of signals."""
    return [f"VAL_ {message.identifier} {signal.name} "
            + " ".join(f'{value} "{_quoted(word)}"' for value, word in sorted(signal.words.items())) + " ;"
            for message in messages for signal in message.signals if signal.words]


def _reals(messages):
    """Lines of the signals that are numbers of IEEE 754: 1 for 32 bits, 2 for 64 bits."""
    return [f"SIG_VALTYPE_ {message.identifier} {signal.name} : {signal.bits // 32};"
            for message in messages for signal in message.signals if signal.is_real]


def _quoted(word):
    """A word inside of double quotes, in ASCII."""
    return sheet.ascii_of(word).replace("\\", "/").replace('"', "'")


def _selections(messages):
    """Lines with the values of the multiplexor for which each multiplexed signal is present."""
    lines = []
    for message in messages:
        multiplexor = next((signal.name for signal in message.signals if signal.is_multiplexor), None)
        lines += [f"SG_MUL_VAL_ {message.identifier} {signal.name} {multiplexor} "
                  + ", ".join(f"{value}-{value}" for value in signal.when) + ";"
                  for signal in message.signals if signal.when]
    return lines


_FRAME_FORMATS = ("StandardCAN", "ExtendedCAN", *(f"reserved{number}" for number in range(2, 14)), "StandardCAN_FD",
                  "ExtendedCAN_FD")


def _signal(signal, receivers):
    selection = " M" if signal.is_multiplexor else f" m{signal.when[0]}" if signal.when else ""
    sign = "-" if signal.signed else "+"
    return (f" SG_ {signal.name}{selection} : {signal.start}|{signal.bits}@1{sign} ({signal.factor:.12g},0) [0|0] "
            f'"{signal.unit}" {",".join(receivers) or "Vector__XXX"}')
