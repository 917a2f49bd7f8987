# SPDX-License-Identifier: Apache-2.0
"""The four verification lights of a command."""

LIGHTS = ("accepted", "started", "step", "completed")
_LIGHT_OF = {1: (0, "done"), 2: (0, "failed"), 10: (0, "failed"), 3: (1, "done"), 4: (1, "failed"),
             5: (2, "done"), 6: (2, "failed"), 7: (3, "done"), 8: (3, "failed")}


def lights_of(verifications):
    """States of the four verification lights of a command: done, failed, waiting, none (not reported), empty (not reached)."""
    cells = ["empty"] * len(LIGHTS)
    for verification in verifications:
        for subtype in verification.stages:
            number, light = _LIGHT_OF[subtype]
            if cells[number] != "failed":
                cells[number] = light
    if "failed" in cells:
        return cells
    if verifications and all(verification.is_finished for verification in verifications):
        return [cell if cell == "done" else "none" for cell in cells]
    for number in (0, 1, 3):
        if cells[number] == "empty":
            cells[number] = "waiting"
            break
    return cells
