# SPDX-License-Identifier: Apache-2.0
"""Bounds of the figures of a scenario: the file <name>.bounds beside <name>.scn.

Each line is `<figure> <relation> <number>`, for example `joint1_error_rad <= 0.002`, or `left.joint1_error_rad <= 0.002` for the arm LEFT of
several; a line may end with a comment after #. A scenario without such a file has the bounds of the tables in figures.py, or none."""

import math
import pathlib
import re

from .run_directory import ROOT
from .values import quoted

RELATIONS = ("<", "<=", ">=")
ENDING = ".bounds"
FIGURE = re.compile(r"([a-z][a-z0-9_]*\.)?[a-z][a-z0-9_]*")


class BoundsError(ValueError):
    """A line that is not a bound, as file:line: value found, value expected."""


def path_of(scenario):
    """Path of the file of a scenario, which is given by its name or by the path of its file."""
    is_path = "/" in scenario or scenario.endswith(".scn")
    path = pathlib.Path(scenario if is_path else f"sim/scenarios/{scenario}.scn")
    return (path if path.is_absolute() else ROOT / path).with_suffix(ENDING)


def _bound(place, words):
    if len(words) != 3 or words[1] not in RELATIONS or not FIGURE.fullmatch(words[0]):
        raise BoundsError(f"{place}: found {quoted(' '.join(words))}, expected <figure> <relation> <number>, relation {', '.join(RELATIONS)}")
    try:
        number = float(words[2])
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BoundsError(f"{place}: found {quoted(words[2])}, expected a finite number")
    return words[1], number


def read(path):
    """Dict figure -> (relation, bound) of a file; empty if there is none. Raises BoundsError, or OSError if the file cannot be read."""
    try:
        lines = pathlib.Path(path).read_text(encoding="utf-8", errors="backslashreplace").splitlines()
    except (FileNotFoundError, NotADirectoryError):
        return {}
    found = {}
    for number, line in enumerate(lines, 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        bound = _bound(f"{path}:{number}", words)
        if words[0] in found:
            raise BoundsError(f"{path}:{number}: found {quoted(words[0])} again, expected one bound for each figure")
        found[words[0]] = bound
    return found


def of(facts):
    """Bounds of the scenario that a run with these facts has flown, as read() gives them."""
    scenario = str(facts.get("scenario") or "")
    return read(path_of(scenario)) if scenario else {}
