# SPDX-License-Identifier: Apache-2.0
"""The search of the documentation: an index of all pages, and a page whose script (search.js) searches the index. Neither needs a
server or a network: the index is a script in the directory of the pages.
"""

import html
import html.parser
import json
import pathlib
import re

from page import shell

FILE = "search.html"
SCRIPT = pathlib.Path(__file__).with_name("search.js")
HEADINGS = ("h1", "h2", "h3")
SKIPPED = (("api.html", "names"),)  # This section only repeats the names of all entries.
EXCERPT = 100  # Characters of a section that a result shows.
USE = """<h1>Search</h1>
<form action="search.html"><input type="search" name="q" id="q" size="40" autofocus> <button>Search</button></form>
<p class="sub">All pages, decisions, headers and interface control documents. A result has every word that you type; the beginning of a
word is enough (<code>recommis</code>). Upper and lower case are the same, and <code>osal_mutex_lock</code>, <code>TC[11,4]</code> or
<code>0x0109</code> can be typed as they are. Sections that have the words in their title come first. The field at the top of each page
leads here.</p>
<div id="results"></div><noscript><p>The search needs JavaScript in the browser.</p></noscript>
<script src="search-index.js"></script><script src="search.js"></script>"""


class Sections(html.parser.HTMLParser):
    """Sections of a page's main part: [anchor, title, text]. Each element with an id begins one."""

    def __init__(self, text):
        super().__init__()
        self.found, self.is_heading = [["", "", ""]], False
        self.feed(text.partition("<main>")[2].partition("</main>")[0])

    def handle_starttag(self, tag, attributes):
        """Begin a section at an element with an id; its title is the text of the heading, or the id of another element."""
        anchor = dict(attributes).get("id")
        if anchor:
            self.found.append([anchor, "" if tag in HEADINGS else anchor, ""])
        self.is_heading = self.is_heading or tag in HEADINGS
        self.found[-1][2] += " "

    def handle_endtag(self, tag):
        """After the end of a heading, collect the text of the section."""
        self.is_heading = self.is_heading and tag not in HEADINGS

    def handle_data(self, data):
        """Append text to the section or to its heading."""
        self.found[-1][1 if self.is_heading else 2] += data


def words_of(text):
    """Set of the words of a text, split as search.js splits a query: runs of letters and digits, in lower case."""
    return set(re.findall(r"[a-z0-9]+", text.lower()))


def index_of(pages):
    """Pages [file, title], sections [number of the page, anchor, title, excerpt], and for each word the numbers of the sections that contain it."""
    files, sections, words = [], [], {}
    for page, text in pages.items():
        files.append([page, html.unescape(re.search(r"<title>(.*?) - hirosco</title>", text)[1])])
        for anchor, title, body in Sections(text).found:
            if not (title or body.strip()) or (page, anchor) in SKIPPED:
                continue
            body = " ".join(body.split())
            for word in words_of(f"{title} {body}"):
                words.setdefault(word, []).append(len(sections))
            sections.append([len(files) - 1, anchor, " ".join(title.split()), body[:EXCERPT]])
    return {"pages": files, "sections": sections, "words": words}


def write(out, pages):
    """Write the files of the search; returns the text of its page."""
    index = json.dumps(index_of(pages), separators=(",", ":"), ensure_ascii=False, sort_keys=True)
    (out / "search-index.js").write_text(f"var searchIndex={index};\n", encoding="utf-8")
    (out / "search.js").write_text(SCRIPT.read_text(encoding="utf-8"), encoding="utf-8")
    return shell(FILE, "Search", USE)
