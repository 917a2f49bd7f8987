# SPDX-License-Identifier: Apache-2.0
"""Read mission descriptors: from XML to a checked model, in which every name is resolved by the descriptors of the subsystems."""

import datetime
import os
import pathlib
import re
from dataclasses import dataclass, field

import subsystem as subsystem_descriptor
from source import BUS_NAME_MAX, METHODS, REST_STATES, SEVERITIES, STATES, canonical, fnv64, read, unique

# Elements of the file by (parent, element), with their attributes; `!` marks a required one (source.read).
TABLE = {
    ("", "Mission"): "name! epoch! power! timeReports",
    ("Mission", "Subsystems"): "",
    ("Subsystems", "Subsystem"): "name! id! executable! descriptor! autostart memoryKiB restarts restartPeriod recommission bootTime deviceDeadline hangAfter supervisorTimeout node",
    ("Subsystem", "Power"): "state! watts!",
    ("Mission", "Modes"): "",
    ("Modes", "Mode"): "name! id! initial fallback",
    ("Mission", "Users"): "",
    ("Users", "User"): "name! id!",
    ("Mission", "Permissions"): "",
    ("Permissions", "Allow"): "tc! select to! modes! states!",
    ("Mission", "Links"): "",
    ("Links", "Link"): "name! from! to!",
    ("Mission", "RecoveryPlans"): "",
    ("RecoveryPlans", "Plan"): "name! severity! subsystem event",
    ("Plan", "Action"): "do! target state mode after",
    ("Mission", "PacketLog"): "strategy ringRecords",
    ("Mission", "Buses"): "",
    ("Buses", "Bus"): "name! redundantTo bitRate! dataBitRate",
    ("Mission", "Transports"): "messages links",
    ("Mission", "Ground"): "address! port! key",
}
PORT_LINKS = 4  # CAPACITY_PORT_LINKS of base/capacities.h
SUBSYSTEM_LINKS = 8  # CAPACITY_SUBSYSTEM_LINKS of base/capacities.h
RING_RECORDS = 15000  # CAPACITY_RING_RECORDS
REDUNDANT_BUS = "a bus of the mission that is not redundant itself and has one redundant bus"
TIME_FORMATS = ("CUC", "CDS")
LOOPBACK, ANY = "127.0.0.1", "0.0.0.0"  # Clients of the ground port: programs on this machine only, or on any machine.
STRATEGIES = ("ASCII", "SQLITE", "POSTGRESQL", "RING")
EPOCH = re.compile(r"(\d{4})-(\d{2})-(\d{2})T(\d{2}):(\d{2}):(\d{2})\Z")
REQUESTABLE = tuple(STATES[number] for number in REST_STATES)


@dataclass
class Mission:
    """A whole mission."""

    element: object
    name: str
    epoch: str
    epoch_s: int
    subsystems: list = field(default_factory=list)  # of (element, Subsystem)
    names: list = field(default_factory=list)  # of the subsystems listed
    modes: list = field(default_factory=list)
    rules: list = field(default_factory=list)
    links: list = field(default_factory=list)
    bus_owners: dict = field(default_factory=dict)  # name of each bus -> the subsystem whose devices are on it
    interface_hash: int = 0
    configuration_hash: int = 0

    def subsystem(self, name):
        """Descriptor of a subsystem, or None."""
        return next((item for _, item in self.subsystems if item.name == name), None)


def load(path):
    """Checked model of a mission and its subsystems. Raises DescriptorError."""
    root = read(path, TABLE, "Mission")
    mission = Mission(root, root.lower_identifier(), root.text("epoch"), _epoch(root))
    root.unsigned("power", 0, 1000000)
    root.word("timeReports", TIME_FORMATS)
    checks = {
        "Subsystems": _list_subsystems,
        "Modes": _modes,
        "Users": _users,
        "Permissions": _check_rules,
        "Links": _check_links,
        "RecoveryPlans": _check_plans,
        "PacketLog": _packet_log,
        "Buses": _buses,
        "Transports": _transports,
        "Ground": _ground,
    }
    for element in root.children:
        if element is not root.first(element.name):
            element.fail(f"a second <{element.name}>: expected one")
        checks[element.name](mission, element)
    for name in ("Subsystems", "Modes", "Permissions", "Ground"):
        if not root.first(name):
            root.fail(f"<Mission> has no <{name}>")
    for element in root.first("Subsystems").children:
        _load_subsystem(mission, path, element)
    for element in _children(root, "Links"):
        _resolve_link(mission, element)
    for rule in mission.rules:
        _resolve_rule(mission, rule)
    for element in _children(root, "RecoveryPlans"):
        _resolve_plan(mission, element)
    text = "".join(f"{s.name} {s.interface_hash:016x}\n" for _, s in mission.subsystems)
    mission.interface_hash = fnv64(text.encode())
    text = "".join(f"{s.name} {s.configuration_hash:016x}\n" for _, s in mission.subsystems)
    mission.configuration_hash = fnv64(text.encode(), fnv64(canonical(root).encode()))
    return mission


def _children(root, name):
    return root.first(name).children if root.first(name) else []


def _epoch(root):
    match = EPOCH.match(root.text("epoch"))
    try:
        moment = datetime.datetime(*(int(part) for part in match.groups())) if match else None
    except ValueError:
        moment = None
    if not moment or not 1958 <= moment.year <= 2093:
        root.wrong("epoch", "a TAI time like 2026-06-01T12:00:00, years 1958 to 2093")
    return int((moment - datetime.datetime(1958, 1, 1)).total_seconds())


def _list_subsystems(mission, container):
    for index, element in enumerate(container.children):
        element.identifier()
        element.unsigned("id", 1, 2046)
        element.lower_identifier("executable")
        element.flag("autostart")
        element.unsigned("memoryKiB", 0, 1 << 24)
        element.unsigned("restarts", 0, 100)
        element.time_us("restartPeriod", 1000, 3_600_000_000)
        element.flag("recommission")
        element.time_us("bootTime", 500, 60_000_000)
        element.time_us("deviceDeadline", 1000, 1_000_000)
        element.time_us("hangAfter", 1000, 60_000_000)
        element.time_us("supervisorTimeout", 100_000, 3_600_000_000)
        element.unsigned("node", 1, 2)
        for power in element.children:
            power.word("state", STATES)
            power.unsigned("watts", 0, 100000)
        unique(element.children, "state")
        unique(container.children[: index + 1], "name", "id")
        mission.names.append(element.attributes["name"])


def _modes(mission, container):
    for index, element in enumerate(container.children):
        flags = {name: element.flag(name) for name in ("initial", "fallback")}
        mission.modes.append({"name": element.identifier(), "id": element.unsigned("id", 0, 7), **flags})
        unique(container.children[: index + 1], "name", "id")
    if sum(mode["initial"] for mode in mission.modes) != 1:
        container.fail("exactly one <Mode> must have initial=\"true\"")
    fallbacks = sum(mode["fallback"] for mode in mission.modes)
    if fallbacks > 1 or (fallbacks == 0 and all(mode["id"] != 0 for mode in mission.modes)):
        container.fail("one <Mode> must have fallback=\"true\" or id 0")


def _users(_, container):
    for index, element in enumerate(container.children):
        element.identifier()
        element.unsigned("id", 1, 0x7FFF)
        unique(container.children[: index + 1], "name", "id")


def _buses(_, container):
    for index, element in enumerate(container.children):
        element.lower_identifier("name", BUS_NAME_MAX)
        if "redundantTo" in element.attributes:
            element.lower_identifier("redundantTo", BUS_NAME_MAX)
        element.unsigned("bitRate", 10000, 1000000)
        element.unsigned("dataBitRate", 10000, 8000000)
        unique(container.children[: index + 1], "name")
    single = {element.attributes["name"] for element in container.children if "redundantTo" not in element.attributes}
    for element in container.children:
        if "redundantTo" not in element.attributes:
            continue
        if element.attributes["redundantTo"] not in single:
            element.wrong("redundantTo", REDUNDANT_BUS)
        single.discard(element.attributes["redundantTo"])


def _packet_log(_, element):
    element.word("strategy", STRATEGIES)
    element.unsigned("ringRecords", 16, RING_RECORDS)


def _transports(_, element):
    element.word("messages", METHODS)
    element.word("links", METHODS)


def _ground(_, element):
    address = element.word("address", (LOOPBACK, ANY))
    element.unsigned("port", 1, 65535)
    key = element.text("key")
    if key == "":
        element.wrong("key", "the path of a file, or no such attribute")
    if key is not None and len(key.encode()) > 127:
        element.wrong("key", "at most 127 characters")
    if address == ANY and key is None:
        element.fail(f'<Ground address="{ANY}"> needs a key; only 127.0.0.1 needs none')


def _check_links(_, container):
    for index, element in enumerate(container.children):
        element.identifier()
        unique(container.children[: index + 1], "name")


def _needs_lists(mission, container):
    """Refuse elements in the wrong order: later elements of the file refer to earlier ones."""
    if not mission.names or not mission.modes:
        container.fail(f"expected <Subsystems> and <Modes>, not empty, before <{container.name}>")


def _check_rules(mission, container):
    _needs_lists(mission, container)
    modes = tuple(mode["name"] for mode in mission.modes)
    for element in container.children:
        service, subtype = _telecommand(element)
        target = element.word("to", (*mission.names, "*"))
        select = element.text("select", "*")
        if element.attributes["modes"] != "*":
            element.words("modes", modes)
        if element.attributes["states"] != "*":
            element.words("states", STATES)
        if select != "*":
            if service == 8 and subtype == 1:
                element.identifier("select", 8)
            elif service == 129 and subtype == 1:
                element.word("select", REQUESTABLE)
            elif service == 129 and subtype == 3:
                element.identifier("select")
                if target == "*":
                    element.wrong("select", "* if to is *, because each subsystem numbers its own configurations")
            elif service == 130:
                element.identifier("select")
            else:
                element.wrong("select", f"* for TC[{service},{subtype}]")
        mission.rules.append({"service": service, "subtype": subtype, "element": element})


def _telecommand(element):
    """Service and subtype of a telecommand; subtype 0 stands for all subtypes of the service."""
    matched = re.match(r"([0-9]{1,3}),([0-9]{1,3}|\*)\Z", element.attributes["tc"])
    numbers = [0 if word == "*" else int(word) or 256 for word in matched.groups()] if matched else [256]
    if max(numbers) > 255:
        element.wrong("tc", "service and subtype like 8,1, or 11,*")
    return numbers


def _check_plans(mission, container):
    _needs_lists(mission, container)
    for index, element in enumerate(container.children):
        element.identifier()
        element.word("severity", SEVERITIES)
        unique(container.children[: index + 1], "name")
        element.word("subsystem", mission.names)
        if "event" in element.attributes:
            element.identifier("event")
            if "subsystem" not in element.attributes:
                element.fail("<Plan> with an event needs a subsystem")
        for action in element.children:
            _check_action(mission, action)
        if not element.children:
            element.fail("<Plan> has no <Action>")


def _check_action(mission, action):
    kind = action.word("do", ("STATE", "MODE", "LOG"))
    needs = {"STATE": ("target", "state"), "MODE": ("mode",), "LOG": ()}[kind]
    for attribute in ("target", "state", "mode"):
        if (attribute in action.attributes) != (attribute in needs):
            verb = "needs" if attribute in needs else "cannot have"
            action.fail(f"<Action do=\"{kind}\"> {verb} attribute {attribute}")
    if kind == "STATE":
        action.word("target", (*mission.names, "SELF", "NETWORK"))
        action.word("state", REQUESTABLE)
    if kind == "MODE":
        action.word("mode", tuple(mode["name"] for mode in mission.modes))
    action.time_us("after", 0, 600000000)


def _take_bus(mission, subsystem, endnode, attribute):
    """Record which subsystem uses a bus. A bus has one master, because SYNC and NMT of a second one would act on its devices."""
    if endnode.text(attribute) is not None:
        owner = mission.bus_owners.setdefault(endnode.text(attribute), subsystem)
        if owner is not subsystem:
            endnode.wrong(attribute, f"a bus of its own, not that of {owner.name}")


def _load_subsystem(mission, path, element):
    place = os.path.normpath(path.parent / element.attributes["descriptor"])
    if not os.path.exists(place):
        element.fail(f'descriptor="{element.attributes["descriptor"]}" of <Subsystem>: expected a file, found none')
    loaded = subsystem_descriptor.load(pathlib.Path(place))
    if loaded.name != element.attributes["name"] or loaded.apid != element.unsigned("id", 1, 2046):
        element.fail(f"{element.attributes['name']}: expected name and id {loaded.name} {loaded.apid} as in its descriptor")
    buses = mission.element.first("Buses")
    known = {bus.attributes["name"]: bus.text("redundantTo") for bus in buses.children} if buses else {}
    for configuration in loaded.configurations:
        for device in configuration.devices:
            for endnode in device.endnodes:
                if endnode.text("bus") is not None and endnode.text("bus") not in known:
                    endnode.wrong("bus", "a bus of the mission")
                _take_bus(mission, loaded, endnode, "bus")
                if endnode.text("redundantBus") is not None and known.get(endnode.text("redundantBus")) != endnode.text("bus"):
                    endnode.wrong("redundantBus", "a bus of the mission that is redundantTo its bus")
                _take_bus(mission, loaded, endnode, "redundantBus")
    mission.subsystems.append((element, loaded))


def _resolve_rule(mission, rule):
    element = rule["element"]
    select, to = element.text("select", "*"), element.attributes["to"]
    targets = [item for _, item in mission.subsystems if to in ("*", item.name)]
    kind = (rule["service"], rule["subtype"])
    if select == "*":
        return
    if kind == (8, 1) and not any(select == item.name for target in targets for item in target.functions):
        element.wrong("select", f"a function of {to}")
    if kind == (129, 3) and not targets[0].configuration(select):
        element.wrong("select", f"a configuration of {to}")
    if rule["service"] == 130 and not any(select == link["name"] for link in mission.links):
        element.wrong("select", "a link of the mission")


def _resolve_plan(mission, element):
    if "event" not in element.attributes:
        return
    events = mission.subsystem(element.text("subsystem")).events
    event = next((item for item in events if item.name == element.text("event")), None)
    if not event or event.severity != element.attributes["severity"]:
        element.wrong("event", f"an event of severity {element.attributes['severity']} of that subsystem")


def _check_room(mission, element, producer, consumer):
    """Check the number of links of both ports: a reader has one link, a writer at most PORT_LINKS."""
    if producer is consumer:
        element.wrong("to", "a port of another subsystem")
    if any(link["to"] == element.attributes["to"] for link in mission.links):
        element.wrong("to", "a port that no other link leads to")
    if sum(link["from"] == element.attributes["from"] for link in mission.links) >= PORT_LINKS:
        element.wrong("from", f"a port with at most {PORT_LINKS} links")


def _resolve_link(mission, element):
    ends = []
    for attribute, provided in (("from", True), ("to", False)):
        name, _, port_name = element.attributes[attribute].partition(".")
        ports = mission.subsystem(name).ports() if mission.subsystem(name) else []
        port = next((p for p in ports if p.name == port_name), None)
        if not port or port.provided != provided:
            element.wrong(attribute, f"SUBSYSTEM.PORT, a {'provided' if provided else 'required'} port")
        ends.append((mission.subsystem(name), port))
    (producer, output), (consumer, needed) = ends
    if output.layout_hash != needed.layout_hash:
        element.fail(f"{element.attributes['from']} and {element.attributes['to']}: expected two ports with the same layout")
    if not set(output.methods) & set(needed.methods):
        element.fail(f"{element.attributes['from']} and {element.attributes['to']}: expected two ports that share a transfer method")
    _check_room(mission, element, producer, consumer)
    for end in (producer, consumer):
        if sum(end.name in (link["producer"], link["consumer"]) for link in mission.links) == SUBSYSTEM_LINKS:
            element.fail(f"too many links of {end.name}, at most {SUBSYSTEM_LINKS}")
    mission.links.append(
        {
            "name": element.attributes["name"],
            "number": len(mission.links) + 1,
            "from": element.attributes["from"],
            "to": element.attributes["to"],
            "producer": producer.name,
            "producer_apid": producer.apid,
            "producer_port": output.id,
            "consumer": consumer.name,
            "consumer_apid": consumer.apid,
            "consumer_port": needed.id,
            "required": needed.required,
        }
    )
