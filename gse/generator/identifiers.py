# SPDX-License-Identifier: Apache-2.0
"""Event reports contain numbers that identify devices, events, parameters, links or users. This module gives their names for Yamcs and
Wireshark. A number of an event or a configuration may have another name in another subsystem, and that of a device in another configuration:
`subject_of` and `is_ambiguous` say so. A table of names that cannot distinguish them has all names of such a number, joined by "or"."""

SUBJECT = "APID"  # Name of the value with the APID of the subsystem that the other values of an event are about.


def devices(configurations):
    """Names of the devices of a subsystem by kind of number: by CANopen node (0: the controller of the subsystem itself), and by their number in
    a configuration, from 0. A number that stands for several devices has all their names."""
    found = {"CANopen node": {}, "device": {}}
    for configuration in configurations:
        for number, device in enumerate(configuration["devices"]):
            found["device"].setdefault(number, []).append(device["name"])
            for end in device["endnodes"]:
                if "node" in end:
                    found["CANopen node"].setdefault(int(end["node"], 0), []).append(device["name"])
    if found["CANopen node"]:
        found["CANopen node"][0] = ["CONTROLLER"]
    return {kind: {number: _joined(names) for number, names in sorted(numbers.items())} for kind, numbers in found.items()}


def _joined(names):
    return " or ".join(dict.fromkeys(names))


def _ids(subsystems, members):
    """Names of all events or configurations of subsystems by id; subsystems may use the same id for different things."""
    found = {}
    for subsystem in subsystems:
        for one in subsystem[members]:
            found.setdefault(one["id"], []).append(one["name"])
    return {number: _joined(names) for number, names in sorted(found.items())}


def is_ambiguous(numbers):
    """Whether a number of a table stands for several things."""
    return any(" or " in name for name in numbers.values())


def subject_of(item, event):
    """`item`, a value of `event`, may identify an event or a configuration of some subsystem. Returns the name of the value of `event` that has
    the APID of this subsystem: BY_APID for the item BY_EVENT, otherwise APID. None if `item` identifies neither, or if there is no such value."""
    names = {one["name"] for one in event["parameters"] if isinstance(one, dict)}
    if item.get("kind") not in ("event id", "configuration id"):
        return None
    return next((name for name in (f"{item['name'].rpartition('_')[0]}_{SUBJECT}", SUBJECT) if name in names), None)


class Identifiers:
    """Words for the identifying numbers in the event reports of a subsystem."""

    def __init__(self, dictionary, subsystem):
        self.dictionary, self.subsystem = dictionary, subsystem

    def _names(self, kind, is_about_others):
        """(name of the table, number -> name) of a kind of number; None if numbers of this kind have no names. is_about_others: the
        event is about another subsystem, so its numbers of events and configurations may be those of any subsystem."""
        own = self.subsystem["name"]
        subsystems, whose = (self.dictionary["subsystems"], "mission") if is_about_others else ([self.subsystem], own)
        if kind in self.subsystem["identifiers"]:
            return f"{kind.replace(' ', '_')}_{own}", {int(number): name for number, name in self.subsystem["identifiers"][kind].items()}
        if kind in ("event id", "configuration id"):
            return f"{kind.replace(' ', '_')}_{whose}", _ids(subsystems, kind.replace(" id", "s"))
        listed = {
            "parameter id": lambda: {p["parameter_id"]: f"{s['name']}.{p['name']}" for s in self.dictionary["subsystems"] for p in s["parameters"]},
            "link id": lambda: {link["number"]: link["name"] for link in self.dictionary["links"]},
            "user": lambda: {user["id"]: user["name"] for user in self.dictionary["users"]},
        }
        return (kind.replace(" ", "_"), listed[kind]()) if kind in listed else None

    def worded(self, item, event):
        """A value of an event with `words`, if its kind has names; other values as they are."""
        values = {one["name"] for one in event["parameters"] if isinstance(one, dict)}
        found = self._names(item.get("kind"), SUBJECT in values)
        return item | {"words": {"name": found[0], "numbers": found[1]}} if found and found[1] else item
