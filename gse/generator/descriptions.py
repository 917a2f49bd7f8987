# SPDX-License-Identifier: Apache-2.0
"""Read descriptions, quantities and warning limits of parameters, events and functions for the ground, from descriptors/descriptions.txt.

They are not in the descriptors, because a change of their text would change the hashes that the flight software
reports."""

import pathlib
import re

import common_words
import sheet
from source import STATES, DescriptorError, text_of

FILE = pathlib.Path(__file__).resolve().parents[2] / "descriptors" / "descriptions.txt"
LINE = re.compile(r"((?:(?:event|function) )?[A-Z0-9_.*]+) \| ([^|]+?) \| ([^|]+?)(?: \| (-?[0-9.]+))?\Z")
# Words of the quantities =strategy and =hand, in the order of their numbers.
STRATEGIES = ("ASCII", "SQLITE", "POSTGRESQL", "RING")
# The statusword 0x6041 of CiA 402: states as (mask, value, name), and names of the flags. Bits 8, 14 and 15 are
# manufacturer-specific; bits 12 and 13 depend on the mode of operation.
STATUSWORD = {
    "name": "statusword",
    "state_bits": 7,
    "states": [
        [0x4F, 0x00, "NOT_READY_TO_SWITCH_ON"], [0x4F, 0x40, "SWITCH_ON_DISABLED"], [0x6F, 0x21, "READY_TO_SWITCH_ON"], [0x6F, 0x23, "SWITCHED_ON"],
        [0x6F, 0x27, "OPERATION_ENABLED"], [0x6F, 0x07, "QUICK_STOP_ACTIVE"], [0x4F, 0x0F, "FAULT_REACTION_ACTIVE"], [0x4F, 0x08, "FAULT"],
    ],
    "flags": {"4": "VOLTAGE_ENABLED", "7": "WARNING", "8": "MANUFACTURER_BIT_8", "9": "REMOTE", "10": "TARGET_REACHED", "11": "INTERNAL_LIMIT_ACTIVE",
              "12": "MODE_BIT_12", "13": "MODE_BIT_13", "14": "MANUFACTURER_BIT_14", "15": "MANUFACTURER_BIT_15"},
}
BITS = {"=statusword": STATUSWORD}
# Emergency codes of CiA 301 and CiA 402 by name. Those of a manufacturer are in the data sheets of the devices.
EMERGENCIES = {
    0x0000: "NO_ERROR", 0x1000: "GENERIC_ERROR", 0x2310: "OVER_CURRENT", 0x3210: "OVER_VOLTAGE", 0x3220: "UNDER_VOLTAGE", 0x4210: "DEVICE_TEMPERATURE",
    0x4310: "DRIVE_TEMPERATURE", 0x7305: "POSITION_SENSOR", 0x8110: "CAN_OVERRUN", 0x8120: "ERROR_PASSIVE", 0x8130: "HEARTBEAT_LOST",
    0x8140: "RECOVERED_FROM_BUS_OFF", 0x8210: "PDO_LENGTH", 0x8240: "SYNC_LENGTH", 0x8250: "PROCESS_DATA_MISSING", 0x8311: "EXCESS_TORQUE",
    0x8611: "FOLLOWING_ERROR",
}
# Codes of BUS_WARNING with node 0: conditions of a bus, + 0x100 on channel B, + 0x1000 for each further bus of the subsystem.
BUS_CONDITIONS = ("ERROR_WARNING", "ERROR_PASSIVE", "BUS_OFF", "OVERRUN", "TRANSMIT_TIMEOUT", "RESTARTED", "MISSING")
HAND = ("LEADS", "NO_HAND", "RANGE", "SPEED", "SINGULAR")


def load(path=FILE):
    """Read the descriptions: (quantity, description, warning) by name."""
    found = {}
    for number, line in enumerate(text_of(path).splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        matched = LINE.match(line)
        if not matched or matched[1] in found:
            raise DescriptorError(path, number, f"'{line}': expected a new `NAME | quantity | description | warning`")
        found[matched[1]] = (matched[2], matched[3], float(matched[4]) if matched[4] else None)
    return found


def _add(item, line, words):
    """Add quantity or kind, words, description and warning limit of a line to an item of the dictionary. No effect if `line` is None."""
    if line is None:
        return
    quantity, item["description"], warning = line
    if quantity in BITS:
        item["bits"] = BITS[quantity]
    elif quantity in words:
        item["words"] = words[quantity]
    elif quantity != "-" and not item.get("unit") and "enumeration" not in item:
        item["kind" if quantity.startswith("#") else "quantity"] = quantity.removeprefix("#")
    if warning is not None:
        item["warning"] = warning


def _occasions(subsystem, lines, words, kind, members):
    """Add descriptions to events or functions, and to their values or arguments."""
    for one in subsystem[f"{kind}s"]:
        places = (f"{subsystem['name']}.{one['name']}", one["name"])
        line = next((lines[f"{kind} {place}"] for place in places if f"{kind} {place}" in lines), None)
        one["description"] = line[1] if line else ""
        for value in one[members]:
            if isinstance(value, dict):
                names = [f"{kind} {place}.{value['name']}" for place in (*places, "*")]
                _add(value, next((lines[name] for name in names if name in lines), None), words)


def emergencies(subsystem, directory=sheet.DIRECTORY):
    """Names of the emergency codes of a subsystem's devices: those of CiA, and those of the data sheets, which take precedence. Devices may
    use a code for different things."""
    own = {}
    types = {device["type"] for configuration in subsystem["configurations"] for device in configuration["devices"]}
    for place in sorted(directory / f"{name}.eds" for name in types):
        for code, _, text in sheet.load(place).emergencies if place.exists() else ():
            word = re.sub(r"[^A-Z0-9]+", "_", sheet.ascii_of(text).upper()).strip("_") or f"CODE_{code:04X}"
            own.setdefault(code, []).append(word)
    return EMERGENCIES | {code: "_OR_".join(dict.fromkeys(names)) for code, names in own.items()}


def bus_conditions(subsystem):
    """Names of the conditions of the subsystem's buses."""
    ends = [[end for device in one["devices"] for end in device["endnodes"]] for one in subsystem["configurations"]]
    buses = max((len({end["bus"] for end in part if "bus" in end}) for part in ends), default=0)
    channels = 1 + any("redundantBus" in end for part in ends for end in part)
    return {0x1000 * bus + 0x100 * channel + code: name + (f"_OF_BUS_{bus + 1}" if buses > 1 else "") + ("_ON_CHANNEL_B" if channel else "")
            for bus in range(buses) for channel in range(channels) for code, name in enumerate(BUS_CONDITIONS, 1)}


def describe(dictionary, lines):
    """Add descriptions, quantities and warning limits to parameters or their fields, to events and to functions. Returns the dictionary."""
    words = {
        "=state": dict(enumerate(STATES)), "=mode": {mode["id"]: mode["name"] for mode in dictionary["modes"]},
        "=strategy": dict(enumerate(STRATEGIES)), "=switch": {0: "OFF", 1: "ON"}, "=hand": dict(enumerate(HAND)),
        "=apid": {subsystem["apid"]: subsystem["name"] for subsystem in dictionary["subsystems"]}, "=channel": {0: "A", 1: "B"},
        "=answer": {0: "NO", 1: "YES"}, **common_words.by_quantity(),
    }
    words = {quantity: {"name": quantity[1:], "numbers": numbers} for quantity, numbers in words.items()}
    for subsystem in dictionary["subsystems"]:
        codes = emergencies(subsystem)
        words["=emergency"] = {"name": f"emergency_{subsystem['name']}", "numbers": codes}
        words["=bus"] = {"name": f"bus_{subsystem['name']}", "numbers": codes | bus_conditions(subsystem)}
        for parameter in subsystem["parameters"]:
            for leaf in parameter.get("fields", [parameter]):
                name = parameter["name"] if leaf is parameter else f"{parameter['name']}.{leaf['name']}"
                _add(leaf, lines.get(f"{subsystem['name']}.{name}") or lines.get(name), words)
        _occasions(subsystem, lines, words, "event", "parameters")
        _occasions(subsystem, lines, words, "function", "arguments")
    return dictionary
