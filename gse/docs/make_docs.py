#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Generate the documentation as pages under build/docs: architecture with the layer graph, tutorial, API from the headers,
interface control documents from the descriptors, and a search in all of them. Exits with an error if a link has no target.
"""

import argparse
import html.parser
import os
import pathlib
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "gse" / "generator"))

import api
import icd
import layers
import mission as mission_descriptor
import search
from page import STYLE, from_markdown, shell
from source import DescriptorError

FIXED = {
    "docs/README.md": "index.html",
    "README.md": "overview.html",
    "CHANGELOG.md": "changelog.html",
    "CONTRIBUTING.md": "contributing.html",
    "SECURITY.md": "security.html",
    "docs/architecture.md": "architecture.html",
    "docs/decisions/README.md": "decisions.html",
}


def markdown_files():
    """Page of each Markdown file of the documentation, by the path of the file."""
    found = {ROOT / name: page for name, page in FIXED.items()}
    for path in sorted((ROOT / "docs").rglob("*.md")):
        prefix = "decision-" if path.parent.name == "decisions" else ""
        found.setdefault(path, f"{prefix}{path.stem}.html")
    for path in sorted([*ROOT.glob("gse/*.md"), *ROOT.glob("sim/*/*.md"), *ROOT.glob("test/**/README.md")]):
        found.setdefault(path, "-".join(path.relative_to(ROOT).with_suffix("").parts).lower() + ".html")
    return found


def prose_pages(out):
    """HTML of the Markdown files by file name. Copies their pictures to `out`."""
    sources = markdown_files()

    def rename(path):
        path = path / "README.md" if path.is_dir() else path
        if path in sources:
            return sources[path]
        if path.suffix in (".png", ".svg") and path.is_file():
            shutil.copyfile(path, out / path.name)
            return path.name
        return os.path.relpath(path, out) if path.exists() else None

    made = {}
    for path, page in sources.items():
        title, body, contents = from_markdown(path, rename)
        body = re.sub(r'src="([^"]+)"', lambda found, path=path: f'src="{rename((path.parent / found[1]).resolve())}"', body)
        if page == "architecture.html":
            graph = layers.section()
            body = body.replace("<h2", f"{graph}<h2", 1)
            contents.insert(0, (2, "layers", "Layers"))
        made[page] = shell(page, title, body, contents)
    return made


class Links(html.parser.HTMLParser):
    """Anchors and links of a page."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        """Collect the anchors and links of a tag."""
        for key, value in attributes:
            if key == "id":
                self.anchors.add(value)
            if (tag, key) in {("a", "href"), ("img", "src"), ("link", "href")} and value:
                self.links.append(value)


def dead_links(out):
    """A line of text for each link between the pages whose target does not exist."""
    pages = {path.name: Links(path.read_text(encoding="utf-8")) for path in sorted(out.glob("*.html"))}
    for name, page in pages.items():
        for link in page.links:
            if re.match(r"[a-z]+:", link):
                continue
            target, _, fragment = link.partition("#")
            file = out / (target or name)
            if not file.exists():
                yield f"{name}: {link} leads to no file"
            elif fragment and (target or name) in pages and fragment not in pages[target or name].anchors:
                yield f"{name}: {link} has an anchor that the page does not have"


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build" / "docs")
    out = parser.parse_args(arguments).out.resolve()
    if out.exists():
        shutil.rmtree(out)
    out.mkdir(parents=True)
    try:
        missions = [mission_descriptor.load(path) for path in sorted((ROOT / "descriptors" / "missions").glob("*.xml"))]
    except DescriptorError as error:
        print(error, file=sys.stderr)
        return 1
    pages = {**prose_pages(out), **api.pages(), **icd.pages(missions)}
    pages[search.FILE] = search.write(out, pages)
    (out / "style.css").write_text(STYLE.strip() + "\n", encoding="utf-8")
    for name, text in pages.items():
        (out / name).write_text(text, encoding="utf-8")
    dead = list(dead_links(out))
    if dead:
        print("\n".join(dead), file=sys.stderr)
        return 1
    size = sum(path.stat().st_size for path in out.iterdir())
    shown = out.relative_to(ROOT) if out.is_relative_to(ROOT) else out
    print(f"{len(pages)} pages, {size / 1e6:.1f} MB, no dead link: {shown}/index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
