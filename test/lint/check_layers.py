# SPDX-License-Identifier: Apache-2.0
"""Check every include of C sources and C tests against test/lint/layers.txt, that no cycle of includes joins top directories, and that
the directories of tests mirror those of the sources.

Prints each breach; exit code 1."""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
MIRROR = re.compile(r"^test/(unit|contract|proof)/")
INCLUDE = re.compile(r'^\s*#\s*include\s+(["<])([^">]+)[">]', re.MULTILINE)
TEST_HEADERS = {"unity.h"}
TOPS = {"base", "osal", "pus", "fsw", "launcher", "sim", "test", "generated"}


def read_rules(path):
    """The two tables of layers.txt as lists of (compiled pattern of the layer, includes that it may have)."""
    layers, headers = [], []
    for line in path.read_text().splitlines():
        rule = re.fullmatch(r"\s*(\S+)\s*([:<])\s*(.*)", line.split("#")[0])
        if rule:
            pattern = re.compile("(" + re.escape(rule[1]).replace(r"\*", "[^/]*") + ")(/|$)")
            (layers if rule[2] == ":" else headers).append((pattern, rule[3].split()))
    return layers, headers


def first_match(rules, path):
    for pattern, allowed in rules:
        found = pattern.match(path)
        if found:
            return found[1], allowed
    return None, []


def is_under(name, places):
    return ".." not in name and any(name == place or name.startswith(place + "/") for place in places)


def breaches(path, layers, headers):
    """Includes of one file (path from the root) that its layer does not allow, as texts."""
    is_test = path.startswith("test/")
    directory, _, file = path.rpartition("/")
    place = MIRROR.sub("", directory) + "/" + file
    home, sees = first_match(layers, place)
    system = ["*"] if is_test else first_match(headers, place)[1]
    parent = directory.rpartition("/")[0]  # The fixtures of a directory are also linked to the tests of its subdirectories.
    extra = [directory, parent + "/fixtures", "test/support", "test/proof/proof.h"] if is_test else []
    for line in INCLUDE.finditer((ROOT / path).read_text()):
        kind, name = line.groups()
        if kind == "<":
            allowed = ("*" in system or name in system) and name.split("/")[0] not in TOPS
        elif home is None:
            allowed = False
        else:
            # A test may include the headers of the tests of those layers that it may include.
            layer = MIRROR.sub("", name) if is_test else name
            allowed = (is_under(layer, [home, *sees]) or is_under(name, extra)
                       or (is_test and (name in TEST_HEADERS or name.rpartition("/")[0] == parent)))
        if not allowed:
            number = (ROOT / path).read_text()[: line.start(2)].count("\n") + 1
            included = line[0].split("include")[1].strip()
            yield f"{path}:{number}: {home or 'no layer'} may not include {included}; rules: test/lint/layers.txt"


def unmirrored(files):
    """Directories of C tests that mirror no directory of sources, and directories of sources without a C test, as texts. The tests of the
    contracts of the operating system layer are for all directories of osal/."""
    directories = {path.rpartition("/")[0] for path in files}
    sources = {directory for directory in directories if not directory.startswith("test/")}
    tests = {directory: MIRROR.sub("", directory) for directory in directories if MIRROR.match(directory)}
    for directory, place in sorted(tests.items()):
        if not place.endswith("/fixtures") and not any(is_under(source, [place]) for source in sources):
            yield f"{directory}: its path mirrors no directory of sources"
    for directory in sorted({path.rpartition("/")[0] for path in files if path.endswith(".c")} & sources):
        if not any(is_under(directory, [place]) for place in tests.values()):
            yield f"{directory}: no C test has its path under test/unit/"


def top_includes(files, read):
    """Top directories of flight code and simulator and those that each includes: {directory: {other: file:line}}."""
    graph = {}
    for path in files:
        top, text = path.split("/")[0], read(path)
        for line in INCLUDE.finditer(text):
            other = line[2].split("/")[0]
            if line[1] == '"' and "/" in line[2] and other not in (top, "generated"):
                number = text[: line.start(2)].count("\n") + 1
                graph.setdefault(top, {}).setdefault(other, f"{path}:{number}")
    return graph


def cycle(graph):
    """Texts of the includes that close a cycle between top directories, or an empty list."""
    def way(start, goal, passed):
        for other, place in sorted(graph.get(start, {}).items()):
            step = [f"{place}: {start}/ includes {other}/, which closes a cycle between top directories"]
            if other == goal:
                return step
            if other not in passed:
                rest = way(other, goal, passed | {other})
                if rest:
                    return step + rest
        return []

    return next((found for found in (way(top, top, {top}) for top in sorted(graph)) if found), [])


def main():
    layers, headers = read_rules(ROOT / "test/lint/layers.txt")
    tops = ("base", "osal", "pus", "fsw", "launcher", "sim", "test/unit", "test/contract", "test/proof", "test/bench", "test/fuzz")
    files = [str(p.relative_to(ROOT)) for top in tops for p in sorted((ROOT / top).rglob("*.[ch]"))]
    failures = [text for path in files for text in breaches(path, layers, headers)]
    sources = [path for path in files if not path.startswith("test/")]
    failures += unmirrored(files)
    failures += cycle(top_includes(sources, lambda path: (ROOT / path).read_text()))
    print("\n".join(failures) if failures else f"check: layers respected by {len(files)} files")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
