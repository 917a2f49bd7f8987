# SPDX-License-Identifier: Apache-2.0
"""Device classes of flight software, from the data sheets (EDS) in descriptors/devices: identity, process data, units.

A class has the name of its file. Object 0x1000 contains its profile: CiA 402 (drives), 401 (input and output modules),
404 (measuring devices), or another number. Objects 0x60A8 and 0x60A9 define the units of an axis; without them the unit is an
increment of the encoder (0x608F) at the output of the gear (0x6091). Flight software reads the rated torque, 0x6076, from each device."""

import functools
import math

import sheet
from sheet import AXIS_STEP, SheetError
from source import FNV_START, fnv64

DEVICE_TYPE, VENDOR, PRODUCT = (0x1000, 0), (0x1018, 1), (0x1018, 2)
AXES_MAX, PDOS_MAX, ENTRIES_MAX, VALUES_MAX, EMERGENCIES_MAX = 8, 4, 8, 16, 32
CONTROLWORD, RATED_TORQUE, MAX_TORQUE, PERIOD = 0x6040, 0x6076, 0x6072, 0x60C2
POSITION_LIMITS, MAX_SPEED, TURN_PER_MINUTE = 0x607D, 0x6080, 2.0 * math.pi / 60.0
DECIMAL_DIGITS, ANALOGUE_INPUTS = 0x6132, {0x6130, 0x7130, 0x9130}  # CiA 404: value in 8, 16 and 32 bits.
PDO_INVALID, EXTENDED_IDENTIFIER, IDENTIFIER_MASK, EACH_SYNC = 1 << 31, 0x3FFFF800, 0x7FF, 1
PROFILE_FIRST, PROFILE_LAST, DATA_TYPES_END = 0x6000, 0x9FFF, 0x20
TORQUES = {0x6071, 0x6077, 0x60B2}
TRANSMITTED = {0x6041: "STATUSWORD", 0x6064: "POSITION", 0x606C: "VELOCITY", 0x6077: "TORQUE", 0x6078: "CURRENT"}
RECEIVED = {0x6040: "CONTROLWORD", 0x607A: "TARGET_POSITION", 0x60B2: "TORQUE_OFFSET", 0x6071: "TARGET_TORQUE",
            0x60FF: "TARGET_VELOCITY"}
READ, WRITTEN = ("ro", "rw", "rwr", "const"), ("rw", "wo", "rww")  # Access of objects of transmit and receive PDOs.
HEAD = """/* Device classes from the data sheets in descriptors/devices. Made by gse/generator; do not edit. */
#ifndef GENERATED_DEVICE_CLASSES_H
#define GENERATED_DEVICE_CLASSES_H
"""


class _Class:
    """The device class of one data sheet, and its row of the table. `slots` are the objects in PDOs that are not words of an axis."""

    def __init__(self, loaded):
        self.sheet = loaded
        self.place = None  # Object that is being checked; a refusal names its line.
        self.values = loaded.defaults(0)
        self.profile = self._number(DEVICE_TYPE) & 0xFFFF
        self.slots = []
        self.axes = 0
        while self.profile == 402 and (CONTROLWORD + self.axes * AXIS_STEP, 0) in loaded.entries:
            self.axes += 1
        if self.axes > AXES_MAX:
            self.fail(f"{self.axes} axes: expected at most {AXES_MAX}")
        if self.profile == 402 and self.axes == 0:
            self.fail("0x1000 states CiA 402: expected a controlword, 0x6040")
        self.units = [self._units(axis) for axis in range(self.axes)]
        self.transmit = self._pdos(0x1800, 0x1A00, TRANSMITTED)
        self.receive = self._pdos(0x1400, 0x1600, RECEIVED)
        self.objects = list(self._mappable())
        if len(loaded.emergencies) > EMERGENCIES_MAX:
            self.fail(f"{len(loaded.emergencies)} lines EMCY in [Comments]: expected at most {EMERGENCIES_MAX}")
        self.hash = fnv64(loaded.path.read_bytes())

    def fail(self, reason):
        entry = self.sheet.entries.get(self.place)
        raise SheetError(self.sheet.path, entry.line if entry else 0, reason)

    def _number(self, key):
        if key not in self.values:
            self.place = key
            self.fail(f"{key[0]:#06x}:{key[1]:02x}: expected a default, which identifies the class")
        if self.sheet.entries[key].kind not in sheet.INTEGERS or not 0 <= self.values[key] <= 0xFFFFFFFF:
            self.place = key
            self.fail(f"{key[0]:#06x}:{key[1]:02x}: expected an unsigned number of at most 32 bits as its default")
        return self.values[key]

    def _units(self, axis):
        position, velocity = sheet.units(self.values, axis)
        if position is None or velocity is None:
            self.fail(f"units of axis {axis + 1}: expected angles in 0x60A8 and 0x60A9, or 0x608F and 0x6091")
        rated = (RATED_TORQUE + axis * AXIS_STEP, 0) in self.values
        return position, velocity, rated

    def _octets(self, index, subindex):
        return sheet.INTEGERS.get(self.sheet.entries[index, subindex].kind, (32, False))[0] // 8

    def _axis_row(self, axis):
        """Initializer of canopen_profile_axis_t."""
        position, velocity, rated = self.units[axis]
        offset = axis * AXIS_STEP
        low, high = (self.values.get((POSITION_LIMITS + offset, sub), 0) for sub in (1, 2))
        low, high = (low, high) if low < high else (0, 0)
        motor, shaft = (self.values.get((sheet.GEAR + offset, sub), 1) for sub in (1, 2))
        speed = self.values.get((MAX_SPEED + offset, 0), 0)
        if speed != 0 and (motor <= 0 or shaft <= 0):
            self.place = (sheet.GEAR + offset, 1 if motor <= 0 else 2)
            self.fail(f"{sheet.GEAR + offset:#06x}: expected revolutions of more than 0, because the limit {MAX_SPEED + offset:#06x} is a speed of the motor")
        speed = speed * TURN_PER_MINUTE * shaft / motor if speed != 0 else 0.0
        period, exponent = (self.values.get((PERIOD + offset, sub), default) for sub, default in ((1, 0), (2, -3)))  # CiA 402: ms.
        made_of = sheet.made_of(self.values, axis)
        units = ", ".join(f"{{{index:#06x}U, {sub}U, {self._octets(index, sub)}U, {self.values[index, sub]:#x}U}}" for index, sub in made_of)
        return (f"{{.position_rad = {position!r}, .velocity_rad_s = {velocity!r}, .has_torque = {str(rated).lower()}, "
                f".low_rad = {low * position!r}, .high_rad = {high * position!r}, .speed_rad_s = {speed!r}, "
                f".period = {period}U, .period_exponent = {exponent}, "
                f".unit_count = {len(made_of)}U, .units = {{{units}}}}}")

    def _pdos(self, parameters, mappings, words):
        pdos = []
        while (parameters + len(pdos), 1) in self.sheet.entries:
            pdos.append(self._pdo(parameters + len(pdos), mappings + len(pdos), words))
        self.place = None
        if len(pdos) > PDOS_MAX:
            self.fail(f"{len(pdos)} PDOs from {parameters:#06x}: expected at most {PDOS_MAX}")
        return pdos

    def _pdo(self, parameter, mapping, words):
        identifier = self._number((parameter, 1))
        self.place = (parameter, 1)
        if "$NODEID" not in self.sheet.entries[parameter, 1].default.upper():
            self.fail(f"{parameter:#06x}:01: expected $NODEID in its default")
        if identifier & EXTENDED_IDENTIFIER:
            self.fail(f"{parameter:#06x}:01: expected an identifier of 11 bits, which the frames of this project have")
        entries = []
        for number, entry in enumerate(sheet.mapped(self.values, mapping), 1):
            self.place = (mapping, number)
            entries.append(self._entry(*entry, words))
        self.place = (mapping, 0)
        if len(entries) > ENTRIES_MAX or sum(entry[2] for entry in entries) > 8:
            self.fail(f"{mapping:#06x}: expected at most 8 octets")
        is_each_sync = self.values.get((parameter, 2), 255) == EACH_SYNC
        return identifier & IDENTIFIER_MASK, not identifier & PDO_INVALID, is_each_sync, entries

    def _entry(self, index, subindex, bits, words):
        """(index, subindex, octets, word, number) of a mapped object; number: axis of the word, or number of the value."""
        if bits % 8 or not 0 < bits <= 32:
            self.fail(f"{bits} bits of {index:#06x}:{subindex:02x} in a PDO: expected 8, 16, 24 or 32")
        if index < DATA_TYPES_END:  # A data type as mapped object only fills a gap.
            return index, subindex, bits // 8, "PADDING", 0
        entry = self.sheet.entries.get((index, subindex))
        if entry is None:
            self.fail(f"{index:#06x}:{subindex:02x} in a PDO: expected an object of the sheet")
        signed, is_real = self._type(entry, f"{index:#06x}:{subindex:02x}", bits)
        axis, first = divmod(index - PROFILE_FIRST, AXIS_STEP)
        first += PROFILE_FIRST
        if PROFILE_FIRST <= index <= PROFILE_LAST and axis < self.axes and first in words and subindex == 0:
            if is_real:
                self.fail(f"{index:#06x}:{subindex:02x} in a PDO has DataType={entry.kind:#06x}: expected an integer, as CiA 402 has it")
            if first in TORQUES and not self.units[axis][2]:
                self.fail(f"torque {index:#06x} in a PDO: expected the rated torque, 0x6076")
            return index, subindex, bits // 8, words[first], axis
        slot = (index, subindex, bits // 8, signed, is_real, self._scale(index, subindex, is_real))
        if slot not in self.slots:
            self.slots.append(slot)
        if len(self.slots) > VALUES_MAX:
            self.fail(f"too many values in PDOs, at most {VALUES_MAX}")
        return index, subindex, bits // 8, "VALUE", self.slots.index(slot)

    def _type(self, entry, name, bits):
        """(signed, real) of the object of an entry with this length."""
        width, signed, is_real = sheet.type_of(entry.kind)
        if not width:
            self.fail(f"{name} in a PDO has DataType={entry.kind:#06x}: expected an integer or REAL32")
        if width not in (1, bits):
            self.fail(f"{bits} bits of {name} in a PDO: expected {width}, as its DataType={entry.kind:#06x}")
        return signed, is_real

    def _is_usable(self, first, is_real, axis):
        """True if flight software can use an object of an axis: words are integers, and torques need the rated torque."""
        is_word = first in TRANSMITTED or first in RECEIVED
        return not (is_real and is_word) and (first not in TORQUES or self.units[axis][2])

    def _mappable(self):
        """Objects that the sheet allows in PDOs: (index, subindex, octets, words in both directions, axis, signed, real, scale)."""
        for (index, subindex), entry in sorted(self.sheet.entries.items()):
            bits, signed, is_real = sheet.type_of(entry.kind)
            if not entry.is_mappable or bits not in (8, 16, 24, 32):
                continue
            axis, first = divmod(index - PROFILE_FIRST, AXIS_STEP)
            first += PROFILE_FIRST
            is_of_axis = PROFILE_FIRST <= index <= PROFILE_LAST and axis < self.axes and subindex == 0
            if is_of_axis and not self._is_usable(first, is_real, axis):
                continue
            transmit, receive = (words.get(first, "VALUE") if is_of_axis else "VALUE" for words in (TRANSMITTED, RECEIVED))
            transmit = transmit if entry.access in READ else "PADDING"
            is_commanded = receive != "VALUE" or not is_of_axis  # Flight software has no command for other objects of an axis.
            receive = receive if entry.access in WRITTEN and is_commanded else "PADDING"
            yield index, subindex, bits // 8, transmit, receive, axis if is_of_axis else 0, signed, is_real, self._scale(index, subindex, is_real)

    def _scale(self, index, subindex, is_real):
        """Scale of a value. CiA 404 defines the number of decimal digits of an analogue input, if it is an integer."""
        if is_real:
            return 1.0
        digits = self.values.get((DECIMAL_DIGITS, subindex), 0) if self.profile == 404 and index in ANALOGUE_INPUTS else 0
        return float(f"1e{-digits}")

    def row(self):
        """Initializer of canopen_device_profile_t."""
        lines = [f'.type = "{self.sheet.path.stem}", .sheet_hash = {self.hash:#018x}ULL, .profile = {self.profile}U,',
                 f".device_type = {self._number(DEVICE_TYPE):#010x}U, .vendor_id = {self._number(VENDOR):#010x}U, "
                 f".product_code = {self._number(PRODUCT):#010x}U,", f".axis_count = {self.axes}U,"]
        if self.units:
            lines.append(f".axes = {{{', '.join(map(self._axis_row, range(self.axes)))}}},")
        lines.append(f".value_count = {len(self.slots)}U,")
        if self.slots:
            slots = ", ".join(f"{{{index:#06x}U, {subindex}U, {octets}U, {str(signed).lower()}, {str(is_real).lower()}, {scale!r}}}"
                              for index, subindex, octets, signed, is_real, scale in self.slots)
            lines.append(f".values = {{{slots}}},")
        for name, pdos in (("transmit", self.transmit), ("receive", self.receive)):
            lines.append(f".{name}_count = {len(pdos)}U,")
            if pdos:
                lines.append(f".{name} = {{{', '.join(map(_pdo_row, pdos))}}},")
        lines.append(f".object_count = {len(self.objects)}U,")
        if self.objects:
            objects = ", ".join(f"{{{index:#06x}U, {subindex}U, {octets}U, PROFILE_{transmit}, PROFILE_{receive}, {axis}U, {str(signed).lower()}, "
                                f"{str(is_real).lower()}, {scale!r}}}" for index, subindex, octets, transmit, receive, axis, signed, is_real, scale in self.objects)
            lines.append(f".objects = (const canopen_profile_object_t[]){{{objects}}},")
        lines.append(f".emergency_count = {len(self.sheet.emergencies)}U,")
        if self.sheet.emergencies:
            listed = ", ".join(f"{{{code:#06x}U, EMERGENCY_{severity}}}" for code, severity, _ in self.sheet.emergencies)
            lines.append(f".emergencies = (const canopen_emergency_code_t[]){{{listed}}},")
        return lines


def _pdo_row(pdo):
    base, is_valid, is_each_sync, entries = pdo
    rows = ", ".join(f"{{{index:#06x}U, {subindex}U, {octets}U, PROFILE_{word}, {number}U}}" for index, subindex, octets, word, number in entries)
    listed = f", .entries = {{{rows}}}" if entries else ""
    return (f"{{.cob_base = {base:#05x}U, .is_valid = {str(is_valid).lower()}, .is_each_sync = {str(is_each_sync).lower()}, "
            f".entry_count = {len(entries)}U{listed}}}")


def _classes(directory):
    return [_Class(sheet.load(path)) for path in sorted(directory.glob("*.eds"), key=lambda path: path.stem)]


def _hash(classes):
    """Hash of all data sheets, computed over their lines "class hash"."""
    return fnv64("".join(f"{each.sheet.path.stem} {each.hash:016x}\n" for each in classes).encode(), FNV_START)


@functools.cache
def sheets_hash(directory=sheet.DIRECTORY):
    """Hash of all data sheets, which flight software contains as DEVICE_CLASSES_HASH."""
    return _hash(_classes(directory))


def header(directory=sheet.DIRECTORY):
    """Text of the header: each class as a macro, and the list of all of them."""
    classes = _classes(directory)
    axes = max((each.axes for each in classes), default=1) or 1
    lines = [HEAD, f"#define DEVICE_CLASSES_AXES_MAX {axes}U", f"#define DEVICE_CLASSES_HASH {_hash(classes):#018x}ULL",
             f'#define DEVICE_CLASSES_NAMES "{" ".join(each.sheet.path.stem for each in classes)}"',
             f"#define DEVICE_CLASSES_COUNT {len(classes)}U"]
    lines += [f"#define DEVICE_CLASS_{number} {{{' '.join(each.row())}}}" for number, each in enumerate(classes)]
    listed = ", ".join(f"DEVICE_CLASS_{number}" for number in range(len(classes)))
    return "\n".join([*lines, f"#define DEVICE_CLASSES {listed}", "#endif", ""])
