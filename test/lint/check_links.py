# SPDX-License-Identifier: Apache-2.0
"""Check the links of all *.md files and of the generated documentation: files and anchors must exist, and so
must files of the project whose paths are in backticks. Each page must be reached from docs/README.md, and the
list of decisions must contain their titles. Nothing is fetched. Prints each failure; exit code 1."""

import functools
import html.parser
import os
import pathlib
import re
import sys
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIPPED = {".git", "build", "runs", "__pycache__", ".pytest_cache", ".ruff_cache"}
FENCE = re.compile(r"^(```|~~~).*?^\1[^\n]*$", re.MULTILINE | re.DOTALL)
INLINE_CODE = re.compile(r"`[^`\n]*`")
LINK = re.compile(r"!?\[[^\]\n]*\]\(\s*<?([^)>\s]+)>?(?:\s+\"[^\"]*\")?\s*\)|^\[[^\]\n]+\]:\s*(\S+)", re.MULTILINE)
HEADING = re.compile(r"^#{1,6}\s+(.+?)\s*#*$", re.MULTILINE)
NAMED_PATH = re.compile(r"`((?:base|osal|pus|fsw|launcher|sim|gse|test|docs|descriptors)/[\w./-]*\w\.(?:c|h|py|md|xml|xsd|eds|txt|sh|scn))`")


def blanked(pattern, text):
    """The text with all matches replaced by blanks, so that line numbers stay."""
    return pattern.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def anchors_of_markdown(text):
    """Anchors as the hosting sites make them: lower case, no punctuation, dashes; repeated ones are numbered."""
    seen, anchors = {}, set()
    for heading in HEADING.findall(blanked(FENCE, text)):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        anchor = re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-")
        count = seen.get(anchor, 0)
        seen[anchor] = count + 1
        anchors.add(f"{anchor}-{count}" if count else anchor)
    return anchors | set(re.findall(r"<a\s+(?:id|name)=\"([^\"]+)\"", text))


class Page(html.parser.HTMLParser):
    """Anchors and links of one page of HTML."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        names = dict(attrs)
        self.anchors |= {names[key] for key in ("id", "name") if names.get(key)}
        for key in ("href", "src"):
            if names.get(key):
                self.links.append((self.getpos()[0], names[key]))


@functools.lru_cache(maxsize=None)
def anchors_of(path):
    """Anchors of a file; cached, because many links lead to one file."""
    text = path.read_text(errors="replace")
    if path.suffix == ".md":
        return anchors_of_markdown(text)
    return Page(text).anchors if path.suffix == ".html" else set()


def links_of(path):
    """(line, target) of each link in a file."""
    text = path.read_text(errors="replace")
    if path.suffix == ".html":
        return Page(text).links
    plain = blanked(INLINE_CODE, blanked(FENCE, text))
    return [(plain.count("\n", 0, found.start(found.lastindex)) + 1, found[found.lastindex])
            for found in LINK.finditer(plain)]


def why_dead(path, target):
    """Reason why a link of a file is broken; None if it is not."""
    parts = urllib.parse.urlsplit(target)
    if parts.scheme or parts.netloc:
        return None
    name = urllib.parse.unquote(parts.path)
    aim = (path.parent / name) if name else path
    if not aim.exists():
        return "no such file"
    fragment = urllib.parse.unquote(parts.fragment)
    if fragment and aim.suffix in {".md", ".html"} and fragment not in anchors_of(aim):
        return "no such anchor"
    return None


def dead_links(path, root):
    """Descriptions of the broken links of a file."""
    shown = path.relative_to(root)
    for line, target in links_of(path):
        wrong = why_dead(path, target)
        if wrong:
            yield f"{shown}:{line}: {wrong}: {target}"
    if path.suffix == ".md":
        text = path.read_text()
        for found in NAMED_PATH.finditer(blanked(FENCE, text)):
            if not (root / found[1]).exists():
                yield f"{shown}:{text.count(chr(10), 0, found.start()) + 1}: no such file: {found[1]}"


def unreached(root, clicks=2):
    """Pages that the index does not reach within this many clicks, as texts."""
    seen = {(root / "docs/README.md").resolve()}
    edge = set(seen)
    for _ in range(clicks):
        edge = {(path.parent / urllib.parse.urlsplit(target).path).resolve() for path in edge if path.suffix == ".md" and path.is_file()
                for _, target in links_of(path)} - seen
        seen |= edge
    for path in documents(root):
        if path.suffix == ".md" and not path.is_relative_to(root / ".github") and path.resolve() not in seen:
            yield f"{path.relative_to(root)}:1: not reached from docs/README.md in {clicks} clicks"


def mistitled(root):
    """Decisions that the list of decisions does not contain with their titles, as texts."""
    listed = (root / "docs/decisions/README.md").read_text()
    for path in sorted((root / "docs/decisions").glob("[0-9]*.md")):
        line = f"- [{path.read_text().splitlines()[0].removeprefix('# ')}]({path.name})"
        if not path.name.startswith("0000") and line not in listed.splitlines():
            yield f"docs/decisions/README.md:1: no such line: {line}"


def documents(root):
    for directory, directories, names in os.walk(root):
        directories[:] = sorted(set(directories) - SKIPPED)
        yield from (pathlib.Path(directory, name) for name in sorted(names) if name.endswith(".md"))
    yield from sorted((root / "build/docs").rglob("*.html"))


def main():
    files = list(documents(ROOT))
    failures = [text for path in files for text in dead_links(path, ROOT)] + [*unreached(ROOT), *mistitled(ROOT)]
    print("\n".join(failures) if failures else f"check: no dead link in {len(files)} documents")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
