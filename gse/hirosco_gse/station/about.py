# SPDX-License-Identifier: Apache-2.0
"""The part of the dictionary of a mission that the page needs."""

from .. import commands, live
from ..dictionary import STATES, unit_of, words_of
from ..run_directory import scenario_of
from ..usage import CONSOLE


def _leaves(parameters, name):
    """Names of the leaves of a parameter, or of one field of it."""
    fields = next((item.get("fields") for item in parameters if item["name"] == name), None)
    return [f"{name}.{item['name']}" for item in fields] if fields else [name]


def _structure(parameters, item):
    """A housekeeping structure of a configuration for the page."""
    names = [reference["name"] if isinstance(reference, dict) else reference
             for group in [item["once"], *(part["parameters"] for part in item["repeated"])] for reference in group]
    return {"id": item["id"], "period_us": item["period_us"], "enabled": item["enabled"], "display": bool(item.get("display")),
            "leaves": [leaf for name in names for leaf in _leaves(parameters, name)]}


def hello(dictionary, flight, world, world_problem=None):
    """The mission of a flight as a message. flight: its run directory; `world` as lists, or None; `world_problem` says why its file cannot be read."""
    content = dictionary.content
    kept = ("mission", "modes", "links", "power_available_w", "interface_hash", "buses", "plans")
    return {
        "kind": "hello",
        "flight": flight,
        "scenario": scenario_of(flight),
        "epoch": dictionary.epoch_ns // 1_000_000_000,
        "states": STATES,
        **{key: content.get(key) for key in kept},
        "subsystems": [about(item) for item in content["subsystems"]],
        "verbs": {name: usage for name, (_, usage, _) in commands.VERBS.items()} | {name: CONSOLE[name][0] for name in live.VERBS},
        "world": world,
        "world_problem": world_problem,
    }


def _place_of(end):
    """The buses of an end node, or its type if it is on none."""
    return ", ".join(end[key] for key in ("bus", "redundantBus") if end.get(key)) or end["type"]


def _configuration(item, part):
    ends = [end for device in part.get("devices", []) for end in device["endnodes"]]
    return {
        "name": part["name"],
        "id": part["id"],
        "devices": [device["name"] for device in part.get("devices", [])],
        "nodes": {device["name"]: end["node"] for device in part.get("devices", []) for end in device["endnodes"] if "node" in end},
        "sampling_us": part.get("sampling_us", 0),
        "endnodes": {device["name"]: _place_of(device["endnodes"][0]) for device in part.get("devices", [])},
        "buses": sorted({end[key] for end in ends for key in ("bus", "redundantBus") if end.get(key)}),
        "structures": [_structure(item["parameters"], hk) for hk in part.get("housekeeping", [])],
    }


def about(item):
    """Part of the dictionary of a subsystem that the page needs."""
    parameters = []
    for parameter in item["parameters"]:
        for leaf in parameter.get("fields") or [parameter]:
            name = leaf["name"] if leaf is parameter else f"{parameter['name']}.{leaf['name']}"
            bounds = {key: leaf[key] for key in ("min", "max") if leaf.get(key) is not None}
            parameters.append({"name": name, "type": leaf["type"], "count": leaf.get("count", 1), "unit": unit_of(leaf),
                               "settable": bool(parameter.get("settable")) and leaf is parameter,
                               "words": None if "bits" in leaf else words_of(leaf, item.get("enumerations", {})), "bits": leaf.get("bits"),
                               "description": leaf.get("description", ""), **bounds})
    return {
        "name": item["name"],
        "apid": item["apid"],
        "infrastructure": bool(item.get("autostart")),
        "power_w": item.get("power_w"),
        "parameters": parameters,
        "functions": item.get("functions", []),
        "severities": {event["name"]: event["severity"] for event in item["events"]},
        "configurations": [_configuration(item, part) for part in item["configurations"]],
    }
