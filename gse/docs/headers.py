# SPDX-License-Identifier: Apache-2.0
"""Read the project's headers: the contract at the beginning of a header, and the comment above each declaration.

All headers have one format: `///` comments, `// ---- title` between sections, one or several declarations
below a comment, followed by an empty line.
"""

import re
from dataclasses import dataclass, field

NAME = re.compile(
    r"^#define (\w+)|^} (\w+);|^typedef [^{]*?\(\*(\w+)\)|^typedef [^{(]* (\w+);|^struct (\w+) {|^[\w ]+[ *]+(\w+)\(|^extern [\w \*]+ (\w+)(?:\[|;)"
)


@dataclass
class Entry:
    """Declarations below one comment, or the title of a section."""

    line: int
    text: list = field(default_factory=list)  # lines of the comment
    code: list = field(default_factory=list)
    title: str = ""

    @property
    def names(self):
        found = [NAME.match(line) for line in self.code]
        return [next(name for name in match.groups() if name) for match in found if match]

    @property
    def is_private(self):
        """True for a struct whose comment declares its members private."""
        return bool(self.code) and "Private" in self.code[0] and "except" not in self.code[0]


@dataclass
class Header:
    """A header: its contract and its entries."""

    path: str
    contract: list
    entries: list


def comment_of(line):
    """Text of a `///` line, or None."""
    found = re.match(r"\s*/// ?(.*)$", line)
    return found[1].rstrip() if found else None


def end_of(lines, start):
    """Index after the declaration that begins at `start`."""
    at, depth = start, 0
    if lines[start].startswith("#"):
        while lines[at].endswith("\\"):
            at += 1
        return at + 1
    while at < len(lines):
        code = lines[at].split("//")[0]
        depth += code.count("{") - code.count("}")
        at += 1
        if depth == 0 and (code.rstrip().endswith(";") or code.rstrip() == "}"):
            return at
    return at


def read(path, name):
    lines = path.read_text(encoding="utf-8").splitlines()
    at = 1
    contract = []
    while at < len(lines) and comment_of(lines[at]) is not None:
        contract.append(comment_of(lines[at]))
        at += 1
    entries, entry = [], None
    while at < len(lines):
        line = lines[at]
        section = re.match(r"// -+ *(\S.*?) *-+$", line)
        if section:
            entries.append(Entry(at + 1, title=section[1]))
            entry = None
        elif comment_of(line) is not None and not line.startswith(" "):
            if entry is None or entry.code:
                entry = Entry(at + 1)
                entries.append(entry)
            entry.text.append(comment_of(line))
        elif not line.strip():
            entry = None
        elif re.match(r"#(ifndef|include|endif|if|undef|else)|//|#define \w+_H$", line):
            pass
        else:
            if entry is None:
                entry = Entry(at + 1)
                entries.append(entry)
            end = end_of(lines, at)
            entry.code += signature(lines[at:end])
            at = end - 1
        at += 1
    return Header(name, contract, [e for e in entries if e.code or e.title])


def signature(lines):
    """Lines of a declaration as the reference shows them: an inline function without its body."""
    if lines[0].startswith("static inline"):
        head = lines[: next((i for i, line in enumerate(lines) if line == "{"), len(lines))]
        return [*head[:-1], head[-1] + ";"]
    return lines
