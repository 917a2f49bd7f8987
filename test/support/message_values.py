# SPDX-License-Identifier: Apache-2.0
"""Values for any message of the catalogue, drawn from a seed."""

import random

from hirosco_gse import packets

LAYOUT = {"UINT8": 0, "UINT16": 1, "DOUBLE": 9}


class Values:
    """Random values of any message."""

    def __init__(self, catalogue, seed):
        self.catalogue, self.random = catalogue, random.Random(seed)
        self.layouts = {}

    def group(self, entry, fields):
        found = {}
        for field in fields:
            if "repeat" in field:
                # The value of such a field extends to the end, so there is at most one group.
                is_open = "argument_id" in str(field)
                groups = 1 if is_open else self.random.randrange(field["least"], 4)
                found[field["repeat"]] = [self.group(entry, field["fields"]) for _ in range(groups)]
            elif "choice" in field:
                cases = sorted(field["cases"])
                selected = self.random.choice(cases)
                word = self.catalogue.words(entry["service"], field["choice"]).get(int(selected), int(selected))
                found[field["choice"]] = word
                found |= self.group(entry, field["cases"][selected])
            elif "values" in field:
                found["values"] = "0102"
            else:
                found[field["name"]] = self.value(entry, field)
        return found

    def value(self, entry, field):
        if field["kind"] in ("value", "auxiliary"):
            layout = self.layouts.get(field.get("of"))
            return {None: "0a0b", "UINT8": 200, "UINT16": 60000, "DOUBLE": -0.125}[layout]
        kind = self.catalogue.kinds[field["kind"]]
        coding, name = kind["coding"], field["name"]
        if coding == "id":
            self.layouts[name] = self.random.choice(sorted(LAYOUT))
            return f"0x{99 << 21 | LAYOUT[self.layouts[name]] << 16 | 7:08X}"
        if coding == "layout":
            self.layouts[name] = self.random.choice(sorted(LAYOUT))
            return self.layouts[name]
        words = self.catalogue.words(entry["service"], name)
        if words:
            return self.random.choice(sorted(words.values()))
        request = packets.build_tc(16, 3, 17, 1).hex()
        simple = {"u8": 200, "u16": 60000, "u32": 4000000000, "u64": 1 << 60, "f64": 0.5, "time": 12.5, "reltime": -3.25}
        simple |= {"cds": 86400.25, "position": -1.5, "name": "ALPHA", "text": "/a/b", "packet": request, "rest": "aabb"}
        if coding == "bits":
            return (1 << kind["size"]) - 1
        if coding == "octets":
            return "5a" * kind.get("size", 3)
        return simple[coding]
