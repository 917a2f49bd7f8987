# SPDX-License-Identifier: Apache-2.0
"""Displays and command stacks of Yamcs: a table of the housekeeping of each subsystem, and the steps that bring a subsystem into operation
or all subsystems to OFFLINE. Names are those of the XTCE database."""

STATE = ("SUBSYSTEM_STATE", "SUBSYSTEM_PHASE", "SUBSYSTEM_CONFIGURATION")
RISE = ("SAFE_OPERATIONAL", "OPERATIONAL")


def displays(dictionary):
    """Content of parameter tables by file name."""
    made = {}
    for subsystem in dictionary["subsystems"]:
        known, names = {one["name"]: one for one in subsystem["parameters"]}, []
        for configuration in subsystem["configurations"]:
            for structure in configuration["housekeeping"]:
                for name in structure["once"]:
                    head, _, tail = name.partition(".")
                    fields = [tail] if tail else [one["name"] for one in known[head].get("fields", [])]
                    names += [f"{head}_{field}".replace(".", "_") for field in fields] or [head]
        ends = [f"LINK_{link['name']}_STATE" for link in dictionary["links"] if subsystem["name"] in (link["producer"], link["consumer"])]
        paths = [f"/{dictionary['mission']}/{subsystem['name']}/{name}" for name in dict.fromkeys([*STATE, *ends, *names])]
        made[f"{subsystem['name']}.par"] = {
            "$schema": "https://yamcs.org/schema/parameter-table.schema.json", "scroll": False, "parameters": paths,
        }
    return made


def _stack(steps):
    return {
        "$schema": "https://yamcs.org/schema/stack.schema.json", "steps": steps,
        "advancement": {"acknowledgment": "CommandComplete", "wait": 0},
    }


def _command(path, comment="", **arguments):
    listed = [{"name": name, "value": value} for name, value in arguments.items()]
    return {"type": "command", "name": path, "comment": comment, "arguments": listed}


def _links_of(dictionary, parts):
    """Links between configurations of different subsystems; `parts` has the configuration by subsystem. None if a required port has no link."""
    def has(subsystem, role, number):
        return subsystem in parts and any(port["id"] == number for port in parts[subsystem][role])

    found = [link for link in dictionary["links"] if has(link["producer"], "provides", link["producer_port"])
             and has(link["consumer"], "requires", link["consumer_port"])]
    fed = {(link["consumer"], link["consumer_port"]) for link in found}
    needed = {(name, port["id"]) for name, part in parts.items() for port in part["requires"] if port["required"]}
    return found if needed <= fed else None


def _together(dictionary, root, modes, members):
    """Stacks for configurations of the same name in several subsystems, between which links are opened."""
    made = {}
    for name in dict.fromkeys(one["name"] for subsystem in members for one in subsystem["configurations"]):
        parts = {subsystem["name"]: one for subsystem in members for one in subsystem["configurations"] if one["name"] == name}
        links = _links_of(dictionary, parts)
        if not links:
            continue
        each = [f"{root}/{subsystem}" for subsystem in parts]
        steps = [_command(f"{root}/ST131/MODE_SET", apid="SUPERVISOR", mode=mode) for mode in modes[:1]]
        steps += [_command(f"{path}/REQUEST_STATE", target="PRE_OPERATIONAL") for path in each]
        steps += [_command(f"{path}/SELECT_CONFIGURATION", configuration=name) for path in each]
        for link in links:
            steps.append(_command(f"{root}/ST130/LINK_REQUEST_{link['name']}"))
            steps.append(_command(f"{root}/ST130/LINK_OPEN", apid="SUPERVISOR", link=link["name"], epoch=0))
        steps += [_command(f"{path}/REQUEST_STATE", target=state) for state in RISE for path in each]
        made[f"ALL-{name}.ycs"] = _stack(steps)
    return made


def stacks(dictionary):
    """Content of command stacks by file name. A configuration that needs data of another subsystem has no stack of its own: the stack
    ALL-<configuration> brings all subsystems with a configuration of this name into operation and opens the links between them."""
    root = f"/{dictionary['mission']}"
    members = [one for one in dictionary["subsystems"] if not one["autostart"]]
    modes = [mode["name"] for mode in dictionary["modes"] if not mode["fallback"] and mode["id"]]
    made = {}
    for subsystem in members:
        path = f"{root}/{subsystem['name']}"
        for configuration in subsystem["configurations"]:
            if any(port["required"] for port in configuration["requires"]):
                continue
            steps = [_command(f"{root}/ST131/MODE_SET", apid="SUPERVISOR", mode=mode) for mode in modes[:1]]
            steps.append(_command(f"{path}/REQUEST_STATE", target="PRE_OPERATIONAL"))
            steps.append(_command(f"{path}/SELECT_CONFIGURATION", configuration=configuration["name"]))
            steps += [_command(f"{path}/REQUEST_STATE", target=state) for state in RISE]
            made[f"{subsystem['name']}-{configuration['name']}.ycs"] = _stack(steps)
    made |= _together(dictionary, root, modes, members)
    rest = [_command(f"{root}/{subsystem['name']}/REQUEST_STATE", target="OFFLINE") for subsystem in members]
    made["ALL-OFFLINE.ycs"] = _stack(rest)
    return made
