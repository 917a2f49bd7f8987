# SPDX-License-Identifier: Apache-2.0
"""XTCE 1.2 database of a mission, and the templates of event texts for Yamcs, from dictionary and catalogue.

The database has a space system for the headers, one for each service (ST03, ...) and one for each subsystem with its parameters,
housekeeping, events and functions. It uses extensions of Yamcs 5.13 to XTCE in three places: verifiers, lengths before octets in
commands, and aliases of parameters by id for TM[20,2]. Other readers can ignore these."""

import xml.etree.ElementTree as ET

import xtce_commands as commands
import xtce_reports as reports
import xtce_states as states
import xtce_types as xt

SEVERITIES = ("INFORMATIVE", "LOW", "MEDIUM", "HIGH")
USER = "YAMCS"


def _catalogue(dictionary, failures):
    """The catalogue with standard and private services, and the words for the values of its fields in this mission."""
    parameters, own = {}, {}
    standard, private = dictionary["catalogue"], dictionary["catalogue"]["private"]
    for subsystem in dictionary["subsystems"]:
        for failure in subsystem["failures"]:  # Several subsystems may use the same code.
            own.setdefault(failure["code"], []).append(f"{subsystem['name']}.{failure['name']}")
        parameters |= {one["parameter_id"]: f"{subsystem['name']}.{one['name']}" for one in subsystem["parameters"]}
    return {
        "kinds": standard["kinds"] | private["kinds"],
        "services": {int(number): service for number, service in (standard["services"] | private["services"]).items()},
        "words": _words(dictionary),
        "parameters": parameters,
        "layouts": {entry["code"]: name for name, entry in dictionary["types"].items()},
        "failures": failures | {code: " or ".join(names) for code, names in own.items()},
    }


def _words(dictionary):
    """Words for the numbers of a kind in this mission."""
    return {
        "apid": {subsystem["apid"]: subsystem["name"] for subsystem in dictionary["subsystems"]},
        "mode8": {mode["id"]: mode["name"] for mode in dictionary["modes"]},
        "link_id": {link["number"]: link["name"] for link in dictionary["links"]},
    }


def _source(dictionary):
    """Source id of this ground user."""
    return next((user["id"] for user in dictionary["users"] if user["name"] == USER), dictionary["users"][0]["id"])


def database(dictionary, failures):
    """(text of the XTCE file, rows of the event templates)."""
    catalogue = _catalogue(dictionary, failures)
    root = xt.System(dictionary["mission"], description=f"interface {dictionary['interface_hash']}")
    reports.headers(root, catalogue)
    services = {}
    for number, service in sorted(catalogue["services"].items()):
        services[number] = system = xt.System(f"ST{number:02}", root, service["name"])
        for message in service["messages"]:
            make = reports.report if message["direction"] == "TM" else commands.request
            make(system, catalogue, message)
    commands.base(root, services[1].path, _source(dictionary), catalogue)
    states.lost_packets(root, _source(dictionary))
    rows, systems = [], {}
    for subsystem in dictionary["subsystems"]:
        systems[subsystem["name"]] = system = xt.System(subsystem["name"], root)
        system.enumerations = subsystem["enumerations"]
        for parameter in subsystem["parameters"]:
            known = {parameter["name"]: parameter}
            reports.parameter_path(system, known, parameter["name"])
        reports.housekeeping(system, subsystem, reports.name_of(catalogue, 3, 25), services[3])
        rows += reports.events(system, dictionary, subsystem, catalogue, services[5], SEVERITIES)
        commands.functions(system, subsystem)
        commands.settings(system, subsystem)
        commands.management(system, subsystem, catalogue)
        states.of_subsystem(system, subsystem, catalogue, services[129])
    states.of_links(systems, dictionary, catalogue, services[130])
    for link in dictionary["links"]:
        commands.link_request(services[130], dictionary, link)
    tree = root.tree()
    tree.set("xmlns", xt.NAMESPACE)
    tree.set("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance")
    tree.set("xsi:schemaLocation", f"{xt.NAMESPACE} {xt.SCHEMA}")
    ET.indent(tree, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(tree, encoding="unicode") + "\n", rows
