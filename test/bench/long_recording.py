# SPDX-License-Identifier: Apache-2.0
"""Makes a long recording of a short one (hirosco_gse/recording.py describes the form)."""

import gzip
import json
import struct

import numpy as np
from hirosco_gse import recording
from recorded import Reader

NOISE = 1e-6  # Deviation of numbers that are not integers between two repetitions, so that they compress like those of a flight.


def _later(rows, by_s):
    """Shift rows of the head, whose first value is their time, to a later time."""
    return [[row[0] + by_s, *row[1:]] for row in rows]


def _noisy(numbers, count):
    """Repeat the rows of a leaf (one named array of a table), with noise on numbers that are not integers."""
    found = np.concatenate([numbers] * count)
    known = found[np.isfinite(found)]
    if not len(known) or not (known % 1).any():
        return found
    return found + np.random.default_rng(1).normal(0, NOISE, found.shape)


def long_recording(octets, seconds):
    """Octets of a recording whose content is repeated until it lasts at least `seconds`."""
    read = Reader(octets)
    head, period = read.head, read.head["end"]
    count = int(np.ceil(seconds / period))
    starts = [period * n for n in range(count)]
    longer = {**head, "end": period * count}
    for name in ("states", "events", "modes", "links"):
        longer[name] = [row for by_s in starts for row in _later(head[name], by_s)]
    longer["phases"] = [[first + by_s, end + by_s, words] for by_s in starts for first, end, words in head["phases"]]
    longer["commands"] = [
        {**call, "time": call["time"] + by_s, "lights": _later(call["lights"], by_s)} for by_s in starts for call in head["commands"]
    ]
    described, parts = [], []
    for table in read.tables:
        times = np.concatenate([table["t"] + by_s for by_s in starts])
        per, part = recording.column(times)
        parts.append(part)
        leaves = []
        for name, rows in table["leaves"].items():
            columns = [recording.column(numbers) for numbers in np.atleast_2d(_noisy(rows, count).T)]
            leaves.append([name, [one for one, _ in columns]])
            parts += [part for _, part in columns]
        described.append({**{key: value for key, value in table.items() if key not in ("t", "leaves")}, "rows": len(times), "per": per, "leaves": leaves})
    text = json.dumps({**longer, "tables": described}, separators=(",", ":")).encode()
    return gzip.compress(b"".join([struct.pack("<I", len(text)), text, *parts]), 6, mtime=0)
