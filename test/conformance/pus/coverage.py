# SPDX-License-Identifier: Apache-2.0
"""Makes docs/pus-coverage.md from the results of the conformance tests."""

HEAD = """# Coverage of the standard's messages

`make pus-coverage` generates this page from the catalogue of messages and a flight of the conformance suite
(`test/conformance/pus`); a test fails if the page is no longer true. A request is done if it completed in flight and the ground
decoded its answer, if it has one; a report is done if the ground received and decoded it. The column "seen by" names at most three of
the tests that used the message. The column "refused" is the number of malformed requests of that kind, derived from the catalogue; all
of them were rejected. Confidence is the certainty of the layout (docs/decisions describes the choice if it is not high).

"""


def _row(entry, seen, refused):
    tests = ", ".join(sorted(seen)) or "-"
    number = f"{entry['service']},{entry['subtype']}"
    done = "yes" if seen else "no"
    return f"| {number} | {entry['direction']} | {entry['name']} | {entry['confidence']} | {done} | {tests} | {refused or ''} |"


def render(catalogue, notes):
    """The text of the page."""
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
