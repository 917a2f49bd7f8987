# SPDX-License-Identifier: Apache-2.0
"""State parameters of an XTCE database: state, phase, configuration and links of each subsystem, from its reports of the private
services, and the number of lost packets.

The containers are derived from the containers of the reports; they read the same octets of the packet again."""

import xtce_reports as reports
import xtce_types as xt
from xtce_types import element

MANAGEMENT, LINKS = 129, 130
TRANSITION, STATUS, LINK_TRANSITION = 2, 5, 10
OF_SUBSYSTEM = {  # Field of TM[129,2] or TM[129,5] -> description of the parameter.
    "state": "state of the subsystem", "phase": "phase of its state", "configuration": "selected configuration", "cause": "cause of its last change of state",
    "target": "state that was requested last",
}
NONE = {0: "NONE"}
LOST, LOST_ALARM = "lost_packets", 0  # Name of the parameter; Yamcs raises an alarm if it is greater.
ALL_USERS = 0  # Destination of reports without a request.
GAP_MAX = 1000  # A larger jump, or a counter that falls back, means that its subsystem was restarted.
# The algorithm in JavaScript that Yamcs runs for each report. It keeps the last counter of each type of report.
COUNT_LOST = """
if (!apid || !service || !subtype || !counter || !destination) return;
if (typeof counters_of_reports === 'undefined') { counters_of_reports = {}; packets_lost = 0; }
var number = counter.rawValue, user = destination.rawValue;
if (number > 0 && (user == %d || user == %d)) {
  var key = [apid.rawValue, service.rawValue, subtype.rawValue, user].join();
  var gap = key in counters_of_reports ? number - counters_of_reports[key] - 1 : 0;
  if (gap > 0 && gap < %d) packets_lost += gap;
  counters_of_reports[key] = number;
}
lost.value = packets_lost;
"""


def _positions(catalogue, service, subtype):
    """(field, its first octet in the packet) of a report whose fields have one size."""
    message = next(one for one in catalogue["services"][service]["messages"] if one["direction"] == "TM" and one["subtype"] == subtype)
    at = reports.TM_HEADER
    for field in message["fields"]:
        yield field, at
        at += reports.OCTETS[catalogue["kinds"][field["kind"]]["coding"]]


def _derived(system, base, catalogue, subtype, name, entries, restrictions):
    """Add a container for the report of one subsystem."""
    report = reports.name_of(catalogue, int(base.name.removeprefix("ST")), subtype)
    system.containers.append(reports.container(name, entries, f"{base.path}/{report}", restrictions))


def of_subsystem(system, subsystem, catalogue, base):
    """Parameters SUBSYSTEM_STATE and so on, from TM[129,2] and TM[129,5]."""
    configurations = NONE | {one["id"]: one["name"] for one in subsystem["configurations"]}
    for subtype in (TRANSITION, STATUS):
        entries = []
        for field, octet in _positions(catalogue, MANAGEMENT, subtype):
            if field["name"] not in OF_SUBSYSTEM:
                continue
            if field["name"] == "configuration":
                kind = system.type("Parameter", "configuration", lambda made: xt.enumeration("Parameter", made, configurations, 16))
            else:
                kind = reports.kind_type(base, "Parameter", catalogue, MANAGEMENT, field)
            path = system.parameter(f"SUBSYSTEM_{field['name'].upper()}", kind, OF_SUBSYSTEM[field["name"]])
            entries.append(reports.entry_at(path, octet))
        restrictions = [(f"{system.root.path}/apid", subsystem["apid"])]
        _derived(system, base, catalogue, subtype, f"{reports.name_of(catalogue, MANAGEMENT, subtype)}_OF_{subsystem['name']}", entries, restrictions)


def of_links(systems, dictionary, catalogue, base):
    """Parameters LINK_<name>_STATE of both ends of each link, from TM[130,10]."""
    positions = {field["name"]: (field, octet) for field, octet in _positions(catalogue, LINKS, LINK_TRANSITION)}
    for link in dictionary["links"]:
        for end in ("producer", "consumer"):
            system = systems[link[end]]
            entries = []
            for name, words in (("state", "state"), ("cause", "cause of the last change of state")):
                field, octet = positions[name]
                kind = reports.kind_type(base, "Parameter", catalogue, LINKS, field)
                path = system.parameter(f"LINK_{link['name']}_{name.upper()}", kind, f"{words} of the link {link['name']} at its {end}")
                entries.append(reports.entry_at(path, octet))
            restrictions = [(f"{system.root.path}/apid", link[f"{end}_apid"]), (f"{base.path}/tm{LINK_TRANSITION}_link", link["number"])]
            _derived(system, base, catalogue, LINK_TRANSITION, f"LINK_{link['name']}_OF_{link[end]}", entries, restrictions)


def lost_packets(root, source):
    """The parameter lost_packets: gaps in the message type counters of the reports to all ground users and to this user. Sequence counts
    cannot be used: a subsystem counts the packets to all users together, so one user sees gaps without a loss."""
    kind = root.type("Parameter", "lost_packets", lambda made: xt.integer("Parameter", made, 32, unit="packets", high=LOST_ALARM))
    path = root.parameter(LOST, kind, "packets of the spacecraft that did not arrive", data_source="derived")
    names = {"apid": "apid", "service": "service", "subtype": "subtype", "message_counter": "counter", "destination": "destination"}
    inputs = [element("InputParameterInstanceRef", parameterRef=f"{root.path}/{name}", inputName=own) for name, own in names.items()]
    outputs = element("OutputParameterRef", parameterRef=path, outputName="lost")
    root.algorithms.append(element(
        "CustomAlgorithm", element("AlgorithmText", COUNT_LOST % (ALL_USERS, source, GAP_MAX), language="JavaScript"),
        element("InputSet", *inputs), element("OutputSet", outputs),
        element("TriggerSet", element("OnParameterUpdateTrigger", parameterRef=f"{root.path}/destination")), name="count_lost_packets",
    ))
