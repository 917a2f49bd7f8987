# SPDX-License-Identifier: Apache-2.0
"""Dictionary of a mission for the ground: everything that has a name, with its ids, layouts and limits."""

import device_class
import identifiers
from services import flown
from source import LAYOUT_STRUCT, STATES, TYPES


def dictionary(mission):
    """Dictionary as plain lists and dicts, in the order of the descriptors."""
    element = mission.element
    ground, log, transports = element.first("Ground"), element.first("PacketLog"), element.first("Transports")
    return {
        "mission": mission.name,
        "interface_hash": f"0x{mission.interface_hash:016X}",
        "configuration_hash": f"0x{mission.configuration_hash:016X}",
        "device_classes_hash": f"0x{device_class.sheets_hash():016X}",
        "epoch": mission.epoch_s,  # TAI seconds since 1958-01-01
        "epoch_tai": mission.epoch,
        "states": list(STATES),
        "types": {name: {"code": code, "size": size, "format": letter} for name, (code, size, letter, _) in TYPES.items()},
        "power_available_w": element.unsigned("power", 0, 1000000),
        "modes": mission.modes,
        "users": [
            {"name": user.text("name"), "id": user.unsigned("id", 1, 0x7FFF)} for user in _children(element, "Users")
        ],
        "subsystems": [_subsystem(listed, loaded) for listed, loaded in mission.subsystems],
        "permissions": [_rule(mission, rule) for rule in mission.rules],
        "links": mission.links,
        "plans": [{**plan.attributes, "actions": [action.attributes for action in plan.children]}
                  for plan in _children(element, "RecoveryPlans")],
        "buses": [
            {
                "name": bus.text("name"),
                "bit_rate": bus.unsigned("bitRate", 10000, 1000000),
                "data_bit_rate": bus.unsigned("dataBitRate", 10000, 8000000, 0),
            }
            for bus in _children(element, "Buses")
        ],
        "packet_log": log.text("strategy", "ASCII") if log else "ASCII",
        "messages": transports.text("messages", "UDP") if transports else "UDP",
        "link_method": transports.text("links", "SHARED_MEMORY") if transports else "SHARED_MEMORY",
        "ground": {"address": ground.text("address"), "port": ground.unsigned("port", 1, 65535)},
    }


def _children(element, name):
    container = element.first(name)
    return container.children if container else []


def _value(item):
    entry = {"name": item.name, "type": item.type, "count": item.count, "unit": item.unit}
    return {**entry, "enumeration": item.enumeration.name} if item.enumeration else entry


def _field(item):
    return {**_value(item), "id": item.id, "min": item.min, "max": item.max, "init": item.init}


def _parameter(parameter):
    entry = {
        "name": parameter.name,
        "number": parameter.number,
        "parameter_id": parameter.id,
        "layout": parameter.layout,
        "settable": parameter.settable,
        "size": parameter.size,
    }
    if parameter.layout == LAYOUT_STRUCT:
        return {**entry, "type": "STRUCT", "count": 1, "unit": "", "fields": [_field(item) for item in parameter.fields]}
    item = _field(parameter.fields[0])
    del item["id"]
    return {**item, **entry}


def _port(port):
    return {
        "name": port.name,
        "id": port.id,
        "layout": [_value(item) for item in port.fields],
        "layout_hash": port.layout_hash,
        "octets": port.size,
        "required": port.required,
        "period_us": port.period_us,
        "stale_us": port.stale_us,
        "methods": port.methods,
    }


def _configuration(configuration):
    return {
        "name": configuration.name,
        "id": configuration.id,
        "priority": configuration.priority,
        "sampling_us": configuration.sampling_us,
        "initial": [{"parameter": name, "field": field, "value": value} for (name, field), value in configuration.initial.items()],
        "loops": [
            {"name": loop.name, "sampling_us": loop.sampling_us, "priority": loop.priority, "services": loop.services}
            for loop in configuration.loops
        ],
        "housekeeping": [
            {
                "id": structure.id,
                "loop": structure.loop,
                "period_us": structure.interval * configuration.sampling_of(structure),
                "interval": structure.interval,
                "enabled": structure.enabled,
                "display": structure.display,
                "once": [parameter.name for parameter in structure.once],
                "repeated": [
                    {"nrep": nrep, "parameters": [parameter.name for parameter in parameters]}
                    for nrep, parameters in structure.repeated
                ],
            }
            for structure in configuration.structures
        ],
        "provides": [_port(port) for port in configuration.ports if port.provided],
        "requires": [_port(port) for port in configuration.ports if not port.provided],
        "devices": [
            {
                "name": device.name,
                "type": device.type,
                "settings": [setting.attributes for setting in device.settings],
                "endnodes": [endnode.attributes for endnode in device.endnodes],
            }
            for device in configuration.devices
        ],
    }


def _event(event):
    own = [_value(item) for item in event.fields]
    return {
        "name": event.name,
        "id": event.id,
        "severity": event.severity,
        "parameters": own or [parameter.name for parameter in event.references],
    }


def _subsystem(listed, loaded):
    configurations = [_configuration(configuration) for configuration in loaded.configurations]
    return {
        "name": loaded.name,
        "apid": loaded.apid,
        "interface_hash": f"0x{loaded.interface_hash:016X}",
        "configuration_hash": f"0x{loaded.configuration_hash:016X}",
        "executable": listed.text("executable"),
        "autostart": listed.flag("autostart"),
        "power_w": {power.text("state"): power.unsigned("watts", 0, 100000) for power in listed.children},
        "enumerations": {enumeration.name: enumeration.numbers for enumeration in loaded.enumerations},
        "failures": [{"name": failure.name, "code": failure.code, "detail": failure.detail} for failure in loaded.failures],
        "parameters": [_parameter(parameter) for parameter in loaded.parameters],
        "events": [_event(event) for event in loaded.events],
        "functions": [
            {
                "name": function.name,
                "id": function.id,
                "arguments": [_field(item) for item in function.arguments],
                "states": function.states,
                "configurations": function.configurations,
                "critical": function.is_critical,
            }
            for function in loaded.functions
        ],
        "services": flown(loaded.services, loaded.apid),
        "configurations": configurations,
        "identifiers": identifiers.devices(configurations),
    }


def _rule(mission, rule):
    element = rule["element"]
    modes, states = element.attributes["modes"], element.attributes["states"]
    return {
        "service": rule["service"],
        "subtype": rule["subtype"],
        "select": element.text("select", "*"),
        "to": element.attributes["to"],
        "modes": [mode["name"] for mode in mission.modes] if modes == "*" else modes.split(" "),
        "states": list(STATES) if states == "*" else states.split(" "),
        "line": element.line,
    }
