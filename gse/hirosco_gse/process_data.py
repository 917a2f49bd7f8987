# SPDX-License-Identifier: Apache-2.0
"""Process data of a device by its data sheet (EDS): the PDO and the place of each mapped object."""

from generator import sheet

PDOS = ((0x1800, 0x1A00), (0x1400, 0x1600))  # Communication and mapping parameters of the TPDOs, and of the RPDOs.
IDENTIFIER_MASK = 0x7FF
MAPPING_GROUPS = {0x1600 >> 9, 0x1A00 >> 9}  # Groups of 512 objects that contain mapping parameters.


def mapping_of(dictionary, bus, node):
    """{(index, subindex): number} of the settings of a device that change its mapping."""
    content = dictionary.content if dictionary else {"subsystems": []}
    devices = (device for subsystem in content["subsystems"] for configuration in subsystem["configurations"]
               for device in configuration["devices"])
    found = {}
    for device in devices:
        if any(end.get("bus") == bus and int(end.get("node", "0"), 0) == node for end in device["endnodes"]):
            for setting in device["settings"]:
                index, _, subindex = setting["object"].partition(":")
                if int(index, 16) >> 9 in MAPPING_GROUPS:
                    found[int(index, 16), int(subindex, 16)] = int(setting["value"], 0)
    return found


def layout(device, *objects, mapping=None):
    """(identifier less the node id, octets, offset and numpy type of each object) of the PDO of a sheet with these objects;
    None if there is no such PDO. `mapping`: objects of the mapping whose values differ from those of the sheet."""
    values = device.defaults(0) | (mapping or {})
    for parameters, mappings in PDOS:
        for number in range(4):
            places, octets = {}, 0
            for index, subindex, bits in sheet.mapped(values, mappings + number):
                entry, size = device.entries.get((index, subindex)), bits // 8
                is_signed = entry is not None and sheet.INTEGERS.get(entry.kind, (bits, False))[1]
                places[index] = (octets, f"{'i' if is_signed else 'u'}{size}")
                octets += size
            if all(each in places for each in objects):
                return values[parameters + number, 1] & IDENTIFIER_MASK, octets, [places[each] for each in objects]
    return None


def unit(device, kind):
    """Unit of positions [rad] of the first axis, or of its torques [Nm]: a thousandth of the rated torque in 0x6076 [mNm]."""
    values = device.defaults(0)
    found = sheet.units(values)[0] if kind == "position" else values.get((0x6076, 0), 0) * 1e-6
    if not found:
        raise sheet.SheetError(device.path, 0, f"no unit of {kind}s: expected " + ("0x60A8, or 0x608F and 0x6091" if kind == "position" else "a rated torque in 0x6076"))
    return found
