# SPDX-License-Identifier: Apache-2.0
"""The glossary: alphabetical, one line for each term, with a source; each term is used elsewhere in the tree."""

import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
GLOSSARY = ROOT / "docs" / "glossary.md"
ROWS = [[cell.strip() for cell in line.strip("|").split("|")] for line in GLOSSARY.read_text(encoding="utf-8").splitlines() if line.startswith("| ")][1:]
# A source is a document with a clause or section, or the field of engineering in which the term is common.
SOURCE = re.compile(
    r"PUS \d+\.\d+|CCSDS \d+\.\d-B|CiA 30[16]|CiA 402|ECSS-E-ST-50-15C|paper (\d|figure \d)|POSIX: |Linux: |"
    r"(operating systems|databases|distributed systems|simulation|networks|data structures|design patterns|component models|"
    r"control rooms|control theory|robotics|software testing): |"
    r"fault injection|signal processing|UML state machines|ours"
)


def key(term):
    """Key of the alphabetical order: letters and digits only."""
    return re.sub(r"[^a-z0-9]", "", term.lower())


def test_terms_are_in_alphabetical_order_and_unique():
    terms = [row[0] for row in ROWS]
    assert len(terms) > 60
    assert terms == sorted(terms, key=key)
    assert len({key(term) for term in terms}) == len(terms)


def everything():
    """The text of the tree without the glossary, in lower case, with single spaces between words."""
    names = ("base", "osal", "pus", "fsw", "launcher", "sim", "gse", "descriptors", "docs", "README.md", "CONTRIBUTING.md")
    files = [path for name in names for path in ([ROOT / name] if (ROOT / name).is_file() else sorted((ROOT / name).rglob("*.*")))]
    texts = [path.read_text(encoding="utf-8").lower() for path in files
             if path.suffix in (".c", ".h", ".py", ".md", ".xml", ".scn") and path.name not in (GLOSSARY.name, "moved-files.md")]
    return re.sub(r"[\s_/*-]+", " ", "\n".join(texts))


def is_used(term, text):
    """True if the term is in the text, with any ending of a plural or a verb."""
    return re.search(rf"\b{re.sub('[ _-]', ' ', term.lower())}(s|es|ed)?\b", text) is not None


def test_terms_are_used():
    text = everything()
    assert [row[0] for row in ROWS if not is_used(row[0], text)] == [], "used nowhere else: remove the line, or use the term"
    assert not is_used("quetzalcoatl", text)


def test_each_library_of_the_flight_software_is_a_term_or_is_named_with_one():
    """A reader who sees a directory finds its name in the glossary. Single subsystems have their name from a mission, XML is no term of ours."""
    names = {path.name for path in [*(ROOT / "fsw").iterdir(), *(ROOT / "fsw/framework").iterdir()] if path.is_dir()} - {"xml"}
    known = " ".join(f"{term} {' '.join(re.findall('`([^`]*)`', meaning))}" for term, meaning, _ in ROWS).lower()
    assert [name for name in sorted(names) if not re.search(rf"\b{name.removesuffix('s')}", known)] == []


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_each_term_has_a_meaning_and_a_source(row):
    _, meaning, source = row
    assert meaning and SOURCE.match(source), source
