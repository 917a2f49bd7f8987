# SPDX-License-Identifier: Apache-2.0
"""docs/pus-coverage.md out of what the conformance tests have seen."""

HEAD = """# Coverage of the standard's messages

Made by `make pus-coverage` from the catalogue of messages and a flight of the conformance suite (`test/conformance/pus`); a test
fails when it is not true any more. A request is done when one of it completed in flight and its answer, if it has one, was
decoded by the ground; a report when one was received and decoded. Refused: malformed requests of that kind, made from the catalogue,
which were all rejected. Confidence: how sure the layout is (docs/decisions tells what was chosen where it is not high).

"""


def _row(entry, seen, refused):
    tests = ", ".join(sorted(seen)) or "-"
    number = f"{entry['service']},{entry['subtype']}"
    done = "yes" if seen else "no"
    return f"| {number} | {entry['direction']} | {entry['name']} | {entry['confidence']} | {done} | {tests} | {refused or ''} |"


def render(catalogue, notes):
    """The page."""
    rows, done = [], 0
    for entry in catalogue.all():
        message = entry["service"], entry["subtype"]
        seen = (notes.requests if entry["direction"] == "TC" else notes.reports).get(message, set())
        done += bool(seen)
        rows.append(_row(entry, sorted(seen)[:3], notes.hostile.get(message, 0)))
    total = len(rows)
    head = f"**{done} of {total} messages done.** {sum(notes.hostile.values())} malformed requests, none of them accepted.\n\n"
    table = "| message | | name | confidence | done | seen by | refused |\n|---|---|---|---|---|---|---|\n"
    return HEAD + head + table + "\n".join(rows) + "\n"
