# SPDX-License-Identifier: Apache-2.0
"""The generated documentation is complete, agrees with headers, descriptors and code, and has no broken
link."""

import json
import pathlib
import re
import struct
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test" / "lint"))

import check_layers

SCALARS = {"UINT8": "B", "UINT16": "H", "UINT32": "I", "UINT64": "Q", "INT8": "b", "INT16": "h", "INT32": "i", "INT64": "q", "FLOAT": "f", "DOUBLE": "d", "BOOL": "?"}


def make(out):
    """Run the generator as `make docs` does. Returns the finished process."""
    return subprocess.run(["/usr/bin/python3", ROOT / "gse" / "docs" / "make_docs.py", "--out", out], capture_output=True, text=True)


@pytest.fixture(scope="module")
def docs(tmp_path_factory):
    """Directory with the pages."""
    directory = tmp_path_factory.mktemp("docs") / "docs"
    done = make(directory)
    assert done.returncode == 0, done.stderr
    assert "no dead link" in done.stdout
    return directory


def page(docs, name):
    """Text of a page."""
    return (docs / name).read_text(encoding="utf-8")


def test_documentation_is_small_and_loads_nothing_from_outside(docs):
    assert sum(path.stat().st_size for path in docs.iterdir()) < 5e6
    for path in docs.glob("*.html"):
        text = path.read_text(encoding="utf-8")
        scripts = re.findall(r"<script[^>]*>", text)
        assert scripts == (['<script src="search-index.js">', '<script src="search.js">'] if path.name == "search.html" else []), path.name
        assert not re.search(r'<(?:img|link)[^>]*(?:src|href)="(?:https?:)?//', text), path.name


def test_links_have_targets(docs):
    """Independently of the generator's check: every relative link leads to a file, and every anchor is an
    id."""
    count = 0
    for path in docs.glob("*.html"):
        for link in re.findall(r'(?:href|src)="([^"]+)"', path.read_text(encoding="utf-8")):
            if re.match(r"[a-z]+:", link):
                continue
            target, _, place = link.partition("#")
            file = docs / (target or path.name)
            assert file.exists(), f"{path.name}: {link}"
            if place and file.suffix == ".html":
                assert f'id="{place}"' in file.read_text(encoding="utf-8"), f"{path.name}: {link}"
            count += 1
    assert count > 1000


def test_generator_finds_a_dead_link(docs, tmp_path):
    code = "import sys; sys.path.insert(0, sys.argv[1]); import make_docs, pathlib; print(list(make_docs.dead_links(pathlib.Path(sys.argv[2]))))"
    (tmp_path / "a.html").write_text('<a href="b.html">x</a><a href="#nowhere">y</a><a href="#here">z</a><p id="here">')
    done = subprocess.run(["/usr/bin/python3", "-c", code, ROOT / "gse" / "docs", tmp_path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "b.html leads to no file" in done.stdout and "#nowhere has an anchor that the page does not have" in done.stdout and "#here" not in done.stdout


PUS = sorted(f"pus_{directory.name}" for directory in (ROOT / "pus").iterdir() if directory.name not in ("catalogue", "tool"))


@pytest.mark.parametrize("library", ["osal_posix", "base", "fsw_framework_parameter", "fsw_framework_rtlink", "fsw_framework_subsystem", "fsw_canopen", "fsw_drives", *PUS])
def test_every_public_function_is_in_the_reference(docs, library):
    """The reference has every symbol of the libraries that a public header declares."""
    archive = ROOT / "build" / "lib" / f"lib{library}.a"
    if not archive.exists():
        pytest.skip(f"{archive.relative_to(ROOT)} is missing; `make` builds it")
    symbols = re.findall(r" T (\w+)$", subprocess.run(["nm", "-g", archive], capture_output=True, text=True, check=True).stdout, re.MULTILINE)
    reference = "".join(path.read_text(encoding="utf-8") for path in docs.glob("api-*.html"))
    directories = [ROOT / "osal" / "include" / "osal"] if library == "osal_posix" else [ROOT / library.replace("_framework_", "/framework/").replace("fsw_", "fsw/").replace("pus_", "pus/")]
    texts = "".join(path.read_text(encoding="utf-8") for directory in directories for path in directory.glob("*.h") if not path.stem.endswith("_internal"))
    declared = [symbol for symbol in symbols if re.search(rf"^[A-Za-z][^\n;]*\b{symbol}\(", texts, re.MULTILINE)]
    assert declared
    missing = [symbol for symbol in declared if f'id="{symbol}"' not in reference]
    assert not missing


def test_contracts_are_reported(docs):
    """The contract of a header, the fields of a struct and the statuses of a function are shown as they are
    written."""
    text = re.sub(r"<[^>]+>", "", page(docs, "api-subsystem.html"))
    for words in ("A specific subsystem is a table of callbacks", "Switch actuators on, without a jump of the motion", "STATUS_STALE (sample copied, but older than allowed)"):
        assert words in text


def searched(docs, question):
    """Addresses that the search finds, the best first. Its script is run by an interpreter without a
    browser."""
    code = docs.parent / "search-test.js"
    code.write_text(f"load({json.dumps(str(docs / 'search-index.js'))}); load({json.dumps(str(docs / 'search.js'))});\n"
                    f"searchFind(searchIndex, {json.dumps(question)}).forEach(function (found) {{ print(found.address); }});\n")
    return subprocess.run(["mujs", code], capture_output=True, text=True, check=True).stdout.splitlines()


@pytest.mark.parametrize("question, first", [
    ("osal_mutex_lock", "api-osal.html#osal_mutex_lock"),
    ("OSAL_MUTEX_LOCK", "api-osal.html#osal_mutex_lock"),
    ("recommissions a restarted", "decision-0034-"),
    ("disk full", "decision-0030-"),
    ("ten minutes gripper", "tutorial.html"),
    ("files of a run", "flying.html#files-of-a-run"),
])
def test_search_lists_the_expected_place_first(docs, question, first):
    assert searched(docs, question)[0].startswith(first)


def test_search_finds_the_places_that_have_all_words(docs):
    """Each result is an existing place; pages are found by their titles; a text that no page has is not found."""
    found = searched(docs, "supervisor")
    assert len(found) == len(set(found)) > 100
    for address in found:
        file, _, place = address.partition("#")
        assert (docs / file).exists() and (not place or f'id="{place}"' in page(docs, file)), address
    assert set(searched(docs, "supervisor osal")) < set(found)
    assert searched(docs, "osal supervisor") == searched(docs, "supervisor, osal")
    assert searched(docs, "supervisor quetzalcoatl") == searched(docs, "") == searched(docs, "?%&") == []
    for name in ("operations.html", "hil.html", "api-osal.html", "icd-rokviss.html", "pus-coverage.html"):
        title = re.search(r"<title>(.*) - hirosco</title>", page(docs, name))[1]
        assert any(address.startswith(name) for address in searched(docs, title)), name


def test_every_page_has_the_field_of_the_search(docs):
    for path in docs.glob("*.html"):
        assert '<form action="search.html"><input type="search" name="q"' in path.read_text(encoding="utf-8"), path.name


def test_layer_graph_is_that_of_the_code(docs):
    """Edges of the graph are includes that exist, and every include is covered by edges. The simulator's own edges and includes are not checked."""
    text = page(docs, "architecture.html")
    edges = set(re.findall(r"<title>([\w/]+)(?:&#45;|-)(?:&gt;|>)([\w/]+)</title>", text))
    assert len(edges) > 25
    sees = {}
    for home, other in edges:
        sees.setdefault(home, set()).add(other)

    def reached(start):
        waiting, done = [start], set()
        while waiting:
            at = waiting.pop()
            if at not in done:
                done.add(at)
                waiting += sees.get(at, ())
        return done

    layers, _ = check_layers.read_rules(ROOT / "test" / "lint" / "layers.txt")
    direct = set()
    for top in ("base", "osal", "pus", "fsw", "launcher"):
        for path in (ROOT / top).rglob("*.[ch]"):
            home = check_layers.first_match(layers, str(path.relative_to(ROOT)))[0]
            for name in re.findall(r'#include "([^"]+)"', path.read_text(encoding="utf-8")):
                other = check_layers.first_match(layers, name)[0]
                if other and other not in (home, "sim"):
                    direct.add((home, other))
                    assert other in reached(home), f"{path} of {home} includes {other}, which the graph does not show"
    assert all(edge in direct for edge in edges if not edge[0].startswith("sim/"))


def test_interface_control_document_agrees_with_the_dictionary(docs):
    """The document has the names of events and functions, the ids of parameters, and the offsets of structures that Python's struct computes."""
    content = json.loads((ROOT / "build" / "generated" / "rokviss.json").read_text(encoding="utf-8"))
    text = page(docs, "icd-rokviss.html")
    for subsystem in content["subsystems"]:
        for name in ("events", "functions"):
            for item in subsystem[name]:
                assert item["name"] in text
        for item in subsystem["parameters"]:
            assert f"0x{item['parameter_id']:08X}" in text
            place = f'id="{subsystem["name"].lower()}-{item["name"].lower()}"'
            rows = re.split(r"<tr[^>]*>", text[text.index(place) :])[1:]
            at = 0
            for row, field in zip(rows, item.get("fields", ())):
                cells = [re.sub(r"<[^>]+>", "", cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]
                size = struct.calcsize(f">{field['count']}{SCALARS[field['type']]}")
                assert (cells[0], int(cells[3]), int(cells[4])) == (field["name"], at, size)
                at += size
            if item.get("fields"):
                assert at == item["size"]


def test_a_descriptor_with_a_mistake_is_reported(tmp_path):
    """The generator ends with file, line, value and expected value, and leaves no incomplete result."""
    copy = tmp_path / "tree"
    copy.mkdir()
    for name in ("gse/docs", "gse/generator", "descriptors", "pus/catalogue", "pus/core/tailoring.h", "test/lint"):
        subprocess.run(["cp", "-r", "--parents", name, copy], cwd=ROOT, check=True)
    path = copy / "descriptors" / "subsystems" / "joystick.xml"
    path.write_text(path.read_text(encoding="utf-8").replace('node="0x21"', 'node="0x99"'), encoding="utf-8")
    done = subprocess.run(["/usr/bin/python3", copy / "gse" / "docs" / "make_docs.py"], capture_output=True, text=True)
    assert done.returncode == 1
    assert re.search(r'joystick.xml:\d+: node="0x99" of <Endnode>: expected', done.stderr)
    assert not (copy / "build" / "docs" / "index.html").exists()
