# SPDX-License-Identifier: Apache-2.0
"""Determine which states can be requested of a subsystem now. The page only shows this; the spacecraft decides about each request."""

from ..dictionary import STATES

OFFLINE, PRE, SAFE, OPERATIONAL, ERROR = 0, 3, 4, 5, 6

LEGAL = {  # docs/states.md, "Requests"
    0: (PRE,),
    1: (OFFLINE, ERROR),
    2: (OFFLINE, ERROR),
    3: (OFFLINE, SAFE, ERROR),
    4: (OFFLINE, PRE, OPERATIONAL, ERROR),
    5: (OFFLINE, PRE, SAFE, ERROR),
    6: (OFFLINE,),
    7: (OFFLINE, ERROR),
    8: (OFFLINE, ERROR),
    9: (OFFLINE, ERROR),
}


def _is_permitted(dictionary, subsystem, state, target, mode):
    for rule in dictionary.permissions:
        is_of_target = (rule["service"], rule["subtype"]) == (129, 1) and rule["select"] in ("*", STATES[target])
        if is_of_target and rule["to"] in ("*", subsystem.name) and mode in rule["modes"] and STATES[state] in rule["states"]:
            return True
    return False


def _closed_link(session, subsystem, open_links):
    """Name of a required link of the present configuration that is not open, or None."""
    configuration = session.configurations.get(subsystem.apid)
    ports = next((item.requires for item in subsystem.configurations.values() if item.id == configuration), ())
    for link in session.dictionary.links:
        is_needed = link.consumer == subsystem.apid and any(port.id == link.consumer_port for port in ports)
        if is_needed and link.name not in open_links:
            return link.name
    return None


def _operational_partner(session, subsystem, open_links):
    for link in session.dictionary.links:
        if link.name in open_links and subsystem.apid in (link.producer, link.consumer):
            other = link.producer if link.consumer == subsystem.apid else link.consumer
            if session.states.get(other) == STATES[OPERATIONAL]:
                return session.dictionary.name_of_apid(other)
    return None


def _barrier(session, subsystem, state, target, open_links):
    """Why the spacecraft would refuse a target that the state machine permits, in words; None if it would not."""
    is_up = target in (PRE, SAFE, OPERATIONAL) and target > state
    mode = session.mode
    if is_up and mode and not _is_permitted(session.dictionary, subsystem, state, target, mode):
        return f"not permitted in mode {mode}"
    if target == SAFE and is_up and not session.configurations.get(subsystem.apid):
        return "no configuration is selected"
    if target in (SAFE, OPERATIONAL) and is_up:
        link = _closed_link(session, subsystem, open_links)
        return f"link {link} is not open" if link else None
    if target in (OFFLINE, PRE) and state in (SAFE, OPERATIONAL):
        partner = _operational_partner(session, subsystem, open_links)
        return f"{partner} is still OPERATIONAL" if partner else None
    return None


def targets(session, subsystem, open_links):
    """Dict target number -> None if it can be requested, or the reason in words. Illegal targets are not in it."""
    name = session.states.get(subsystem.apid)
    if name not in STATES or subsystem.is_infrastructure:
        return {}
    state = STATES.index(name)
    return {target: _barrier(session, subsystem, state, target, open_links) for target in LEGAL[state]}
