# SPDX-License-Identifier: Apache-2.0
"""Displays and command stacks of Yamcs: a table of the housekeeping of each subsystem, and the steps that bring a subsystem into operation
or the mission to rest. Names are those of the XTCE database."""

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
        paths = [f"/{dictionary['mission']}/{subsystem['name']}/{name}" for name in dict.fromkeys(names)]
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


def stacks(dictionary):
    """Content of command stacks by file name. A configuration that needs the data of another subsystem has none, because it is
    brought up together with that."""
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
    rest = [_command(f"{root}/{subsystem['name']}/REQUEST_STATE", target="OFFLINE") for subsystem in members]
    made["ALL-OFFLINE.ycs"] = _stack(rest)
    return made
