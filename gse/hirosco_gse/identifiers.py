# SPDX-License-Identifier: Apache-2.0
"""Names of what the numbers in event reports identify: devices, events, configurations, parameters, links, users and CANopen objects.

The dictionary defines the kind of each number (`kind`). A number whose name is not known stays a number."""

from .values import Named, Word


def _device(kind):
    def find(number, owner, _, present):
        if not owner:
            return None
        configuration = next((one for one in owner.configurations.values() if one.id == present.get(owner.apid)), None)
        known = configuration.identifiers.get(kind, {}) if configuration else {}
        return known.get(number) or owner.identifiers.get(kind, {}).get(number)

    return find


def _event(number, owner, *_):
    event = owner.event_of_id(number) if owner else None
    return event.name if event else None


def _configuration(number, owner, *_):
    found = [item.name for item in owner.configurations.values() if item.id == number] if owner else []
    return found[0] if found else None


def _parameter(number, _, dictionary, __):
    owner = dictionary.subsystem_of_apid(number >> 21)  # The upper 11 bits of a parameter id are the APID.
    parameter = owner.parameter_of_id(number) if owner else None
    return f"{owner.name}.{parameter.name}" if parameter else None


def _link(number, _, dictionary, __):
    return next((link.name for link in dictionary.links if link.number == number), None)


def _user(number, _, dictionary, __):
    return next((user["name"] for user in dictionary.content.get("users", ()) if user["id"] == number), None)


# Kind of a number -> its name by (number, subsystem that it concerns, dictionary, APID -> present configuration id), and the form of the number
# beside the name. Devices of several configurations may have the same number: the present configuration says which of them it is.
NAMES = {
    "CANopen node": (_device("CANopen node"), "0x{:02X}"),
    "device": (_device("device"), "{}"),
    "event id": (_event, "{}"),
    "configuration id": (_configuration, "{}"),
    "parameter id": (_parameter, "0x{:08X}"),
    "link id": (_link, "{}"),
    "user": (_user, "{}"),
}


def _named(kind, number, owner, dictionary, present):
    if kind == "CANopen object":
        text = f"0x{number >> 8:04X}:{number & 0xFF:02X}"  # index and subindex
        return Named(number, text, text)
    if kind not in NAMES or isinstance(number, Word):
        return number
    find, form = NAMES[kind]
    name = find(number, owner, dictionary, present)
    return number if name is None else Named(number, name, f"{name} ({form.format(number)})")


def named(found, event, subsystem, dictionary, present=None):
    """Values of an event report (name -> list of numbers) with a values.Named for each number that has a name. If the report has a value APID,
    the other values concern that subsystem, otherwise `subsystem`, which has sent the report. BY_EVENT is an event of BY_APID. present: APID ->
    present configuration id."""
    kinds = {item.name: getattr(item, "kind", "") for item in event.parameters}

    def owner(name):
        about = next((one for one in (f"{name.rpartition('_')[0]}_APID", "APID") if one in found), None)
        return dictionary.subsystem_of_apid(int(found[about][0])) if about else subsystem

    return {name: [_named(kinds[name], number, owner(name), dictionary, present or {}) for number in value] if kinds.get(name) else value for name, value in found.items()}


def device_of(found):
    """Name of the device that the values of an event report, as `named` returns them, are about; None without such a device or name."""
    name = "NODE" if "NODE" in found else "DEVICE"
    number = found.get(name, (None,))[0]
    is_device = isinstance(number, Named) and (name != "NODE" or number != 0)  # Node 0 is the controller of the subsystem.
    return number.word if is_device else None
