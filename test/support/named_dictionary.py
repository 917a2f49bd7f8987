# SPDX-License-Identifier: Apache-2.0
"""The dictionary of rokviss with names for numbers and for failures of MANIPULATOR, which its descriptor does
not define."""

PACE = {"SLOW": 3, "QUICK": 4}
CHOICE_ID = 16 << 21 | 25 << 16 | 99


def named(content):
    """Change a dictionary as read from its file: MOVE_TO's DURATION, a parameter CHOICE that can be set, a member of COUNTERS, and
    an event PACED have the enumeration PACE."""
    arm = next(one for one in content["subsystems"] if one["name"] == "MANIPULATOR")
    arm["enumerations"] = {"PACE": PACE}
    arm["failures"] = [{"name": "TOO_FAR", "code": 0x8001, "detail": "JOINT"}, {"name": "TOO_FAST", "code": 0x8002, "detail": ""}]
    move = next(one for one in arm["functions"] if one["name"] == "MOVE_TO")
    move["arguments"][1] |= {"type": "UINT16", "enumeration": "PACE", "unit": "", "min": 3, "max": 4}
    pace = {"name": "CHOICE", "type": "UINT16", "count": 2, "unit": "", "enumeration": "PACE"}
    arm["parameters"].append(pace | {"parameter_id": CHOICE_ID, "settable": True, "size": 4})
    counters = next(one for one in arm["parameters"] if one["name"] == "COUNTERS")
    counters["fields"][0] |= {"enumeration": "PACE"}
    arm["events"].append({"name": "PACED", "id": 99, "severity": "LOW", "parameters": [pace | {"name": "PACE", "count": 1, "type": "INT8"}]})
    return content
