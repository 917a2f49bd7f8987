# SPDX-License-Identifier: Apache-2.0
"""The lints detect violations: each rule is broken once on purpose."""

import json
import os
import pathlib
import shlex
import subprocess

import check_coverage
import check_layers
import check_links
import check_mcdc
import check_misra
import check_symbols
import check_text
import check_worlds
import pytest


def layer_breaches(tmp_path, monkeypatch, path, text):
    file = tmp_path / path
    file.parent.mkdir(parents=True)
    file.write_text(text)
    rules = check_layers.read_rules(check_layers.ROOT / "test/lint/layers.txt")
    monkeypatch.setattr(check_layers, "ROOT", tmp_path)
    return list(check_layers.breaches(path, *rules))


@pytest.mark.parametrize(
    "path, include, allowed",
    [
        ("base/a.c", '"base/status.h"', True),
        ("base/a.c", '"pus/core/packet.h"', False),
        ("base/a.c", "<stdint.h>", True),
        ("base/a.c", "<stdio.h>", False),
        ("base/a.c", '"status.h"', False),
        ("base/a.c", '"base/../pus/core/packet.h"', False),
        ("fsw/framework/xml/a.c", "<expat.h>", True),
        ("fsw/framework/descriptor/a.c", "<expat.h>", False),
        ("fsw/framework/message/a.c", '"osal/include/osal/socket.h"', True),
        ("fsw/framework/message/a.c", '"osal/posix/socket.h"', False),
        ("fsw/framework/message/a.c", "<sys/socket.h>", False),
        ("osal/posix/a.c", "<sys/socket.h>", True),
        ("osal/posix/a.c", '"pus/core/packet.h"', False),
        ("pus/a.c", '"fsw/framework/subsystem/subsystem.h"', False),
        ("fsw/framework/subsystem/a.c", '"pus/core/packet.h"', True),
        ("fsw/framework/subsystem/a.c", '"fsw/canopen/master.h"', False),
        ("fsw/subsystems/one/a.c", '"fsw/subsystems/one/b.h"', True),
        ("fsw/subsystems/one/a.c", '"fsw/subsystems/two/b.h"', False),
        ("fsw/subsystems/one/a.c", '"fsw/supervisor/b.h"', False),
        ("fsw/subsystems/one/a.c", '"generated/one_descriptor.h"', True),
        ("fsw/supervisor/a.c", '"fsw/subsystems/one/b.h"', False),
        ("fsw/programs/a.c", '"fsw/subsystems/one/b.h"', True),
        ("launcher/a.c", "<sqlite3.h>", False),
        ("launcher/sqlite_writer.c", "<sqlite3.h>", True),
        ("sim/bus/a.c", '"base/status.h"', True),
        ("sim/bus/a.c", '"base/crc.h"', False),
        ("sim/bus/a.c", '"sim/plant/plant.h"', True),
        ("sim/bus/a.c", "<fsw/canopen/sdo_client.h>", False),
        ("sim/bus/a.c", "<linux/can.h>", True),
        ("fsw/elsewhere/a.c", '"base/status.h"', False),
        ("test/unit/pus/test_a.c", '"pus/core/packet.h"', True),
        ("test/unit/pus/test_a.c", '"unity.h"', True),
        ("test/unit/pus/test_a.c", '"test/support/assertion.h"', True),
        ("test/unit/pus/test_a.c", '"fsw/supervisor/b.h"', False),
        ("test/proof/pus/proof_a.c", '"pus/core/packet.c"', True),
        ("test/proof/pus/proof_a.c", '"test/proof/proof.h"', True),
        ("test/proof/pus/proof_a.c", '"fsw/supervisor/b.h"', False),
        ("test/proof/fsw/supervisor/proof_a.c", '"test/proof/pus/b.h"', True),
        ("test/proof/pus/proof_a.c", '"test/proof/fsw/supervisor/b.h"', False),
        ("pus/a.c", '"test/proof/pus/b.h"', False),
    ],
)
def test_an_include_that_its_layer_does_not_allow_is_found(tmp_path, monkeypatch, path, include, allowed):
    found = layer_breaches(tmp_path, monkeypatch, path, f"#include {include}\n")
    assert (not found) == allowed, found


TREE = {
    "base/a.h": "#include <stdint.h>\n",
    "osal/include/osal/a.h": '#include "base/a.h"\n',
    "pus/core/a.c": '#include "base/a.h"\n#include "osal/include/osal/a.h"\n#include "generated/pus/a.h"\n#include "pus/core/b.h"\n',
    "fsw/x/a.c": '\n#include "pus/core/a.h"\n',
    "launcher/a.c": '#include "fsw/x/a.h"\n#include "sim/a.h"\n',
    "sim/a.h": '#include "base/a.h"\n',
}


@pytest.mark.parametrize(
    "path, include, places",
    [
        (None, None, []),
        ("pus/core/c.c", '"fsw/x/a.h"', ["fsw/x/a.c:2", "pus/core/c.c:1"]),
        ("base/b.c", '"osal/include/osal/a.h"', ["base/b.c:1", "osal/include/osal/a.h:1"]),
        ("sim/b.c", '"launcher/a.h"', ["launcher/a.c:2", "sim/b.c:1"]),
        ("base/b.c", '"sim/a.h"', ["base/b.c:1", "sim/a.h:1"]),
    ],
)
def test_a_cycle_of_includes_between_top_directories_is_found(path, include, places):
    """Two directories that include each other, or several in a ring, are reported with each include that closes
    the ring."""
    tree = {**TREE, **({path: f"#include {include}\n"} if path else {})}
    found = check_layers.cycle(check_layers.top_includes(sorted(tree), tree.get))
    assert sorted(text.split(": ")[0] for text in found) == sorted(places)


def test_cycle_over_three_directories_is_found():
    tree = {**TREE, "base/b.c": '#include "pus/core/a.h"\n'}
    assert check_layers.cycle(check_layers.top_includes(sorted(tree), tree.get))


@pytest.mark.parametrize(
    "path, complaint",
    [
        ("test/unit/pus/st99/test_a.c", "test/unit/pus/st99: its path mirrors no directory"),
        ("test/contract/net/test_a.c", "test/contract/net: its path mirrors no directory"),
        ("test/proof/pus/coer/proof_a.c", "test/proof/pus/coer: its path mirrors no directory"),
        ("fsw/y/a.c", "fsw/y: no C test has its path under"),
        ("fsw/y/a.h", None),
        ("fsw/x/y/a.c", None),
        ("test/unit/pus/fixtures/a.c", None),
        ("test/mission/a.c", None),
    ],
)
def test_directories_of_tests_that_mirror_no_sources_are_found(path, complaint):
    tree = ["pus/core/a.c", "fsw/x/a.c", "osal/common/a.c", "osal/posix/a.c", "test/unit/pus/core/test_a.c", "test/unit/fsw/x/test_a.c",
            "test/contract/osal/test_a.c", "test/unit/osal/posix/test_a.c"]
    assert list(check_layers.unmirrored(tree)) == []
    found = list(check_layers.unmirrored([*tree, path]))
    assert (not found) if complaint is None else complaint in found[0], found


@pytest.mark.parametrize(
    "source, place, complaint",
    [
        ("void* malloc(unsigned long); void* pus_f(void) { return malloc(8); }", "pus/a.c", "calls malloc"),
        ("int printf(const char*, ...); void pus_f(int x) { printf(\"%d\", x); }", "pus/a.c", "calls printf"),
        ("double sin(double); double canopen_f(double x) { return sin(x); }", "fsw/canopen/a.c", "calls sin"),
        ("double sqrt(double); double canopen_f(double x) { return sqrt(x); }", "fsw/canopen/a.c", None),
        ("static int n; int canopen_f(void) { return n++; }", "fsw/canopen/a.c", "mutable data"),
        ("static int n = 1; int canopen_f(void) { return n++; }", "fsw/canopen/a.c", "mutable data"),
        ("static int n; int run_f(void) { return n++; }", "fsw/programs/a.c", None),
        ("static const char* const t[] = {\"a\"}; const char* canopen_f(int i) { return t[i]; }", "fsw/canopen/a.c", None),
        ("int pus_f(int i) { return i + 1; }", "pus/a.c", None),
        ("int f(void) { return 1; }", "pus/st03/a.c", "f begins with none of the prefixes of its library: pus hk"),
        ("const int descriptor_n = 1;", "fsw/programs/a.c", "descriptor_n begins with none"),
        ("int arm_f(void) { return 1; }", "fsw/subsystems/leg/a.c", "arm_f begins with none"),
        ("int canopenf(void) { return 1; }", "fsw/canopen/a.c", "canopenf begins with none"),
        ("int main(void) { return 1; }", "fsw/programs/leg_program.c", "main begins with none"),
        ("int main(void) { return 1; }", "fsw/programs/leg_main.c", None),
        ("int leg_open(void) { return 1; }", "fsw/programs/leg_program.c", None),
        ("int hk_f(void) { return 1; }", "pus/st03/a.c", None),
        ("static int f(int i) { return i; } int leg_f(int i) { return f(i); }", "fsw/subsystems/leg/a.c", None),
        ("void f(void); void canopen_f(void) { f(); }", "fsw/canopen/a.c", None),
    ],
)
def test_a_forbidden_symbol_is_found(tmp_path, source, place, complaint):
    (tmp_path / "a.c").write_text(source)
    built = tmp_path / "a.o"
    subprocess.run(["gcc", "-O2", "-c", tmp_path / "a.c", "-o", built], check=True, stderr=subprocess.DEVNULL)
    found = [text for _, *symbol in check_symbols.symbols([built]) if (text := check_symbols.breach(place, *symbol))]
    assert (len(found) == 0) if complaint is None else any(complaint in text for text in found), found


def test_the_top_directory_has_only_the_directories_of_the_project_and_files_that_tools_expect_there():
    """A program that runs in the top directory may leave files there, which `git add` would take."""
    listed = subprocess.run(["git", "ls-files", "--others", "--cached", "--exclude-standard"], cwd=check_layers.ROOT, capture_output=True, text=True, check=True).stdout
    directories = {path.partition("/")[0] for path in listed.splitlines() if "/" in path}
    files = {path for path in listed.splitlines() if "/" not in path}
    assert directories == {".ci", ".github", "base", "descriptors", "docs", "fsw", "gse", "launcher", "mk", "osal", "pus", "sim", "test"}
    assert files == {".clang-format", ".clang-tidy", ".editorconfig", ".git-blame-ignore-revs", ".gitignore", ".prettierrc", "CHANGELOG.md",
                     "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "Makefile", "README.md", "SECURITY.md"}


def test_a_prefix_belongs_to_one_library():
    """The prefix of a symbol shows its library; only the services of PUS share a prefix. The ports of the operating system layer and what
    they have in common are one library."""
    owners = {}
    for top in ("base", "osal", "pus", "fsw", "launcher"):
        for directory in sorted({source.parent for source in (check_layers.ROOT / top).rglob("*.c")}):
            place = str(directory.relative_to(check_layers.ROOT))
            for prefix in check_symbols.prefixes(f"{place}/any.c"):
                owners.setdefault(prefix, set()).add("osal" if top == "osal" else place)
    assert {prefix: places for prefix, places in owners.items() if len(places) > 1 and prefix != "pus"} == {}


def text_breaches(tmp_path, monkeypatch, name, text):
    (tmp_path / name).write_text(text)
    words, phrases = check_text.read_words()
    monkeypatch.setattr(check_text, "ROOT", tmp_path)
    return list(check_text.breaches(pathlib.Path(name), words, phrases))


LICENCE = "// SPDX-License-Identifier: Apache-2.0\n"


@pytest.mark.parametrize(
    "text, complaint",
    [
        (LICENCE + "int f(void);\n", None),
        ("int f(void);\n", "no licence line"),
        (LICENCE + "// TO" + "DO later\n", "does not belong here"),
        (LICENCE + "int f(void)\n{\n" + "    ;\n" * 58 + "}\n", None),
        (LICENCE + "int f(void)\n{\n" + "    ;\n" * 59 + "}\n", "function of 61 lines"),
        (LICENCE + "\n" * 599, None),
        (LICENCE + "\n" * 600, "601 lines"),
        (LICENCE + "/// Context    One task.\n/// Time       O(1),\n///            or O(n).\n", None),
        (LICENCE + "/// It is called at the given time. Time is pushed in.\n", None),
        (LICENCE + "/// Context    One task. Time: O(1).\n", "label 'Time' in the middle"),
        (LICENCE + "/// A ring. Ownership  The caller provides it.\n", "label 'Ownership' in the middle"),
        (LICENCE + "/// Context    One task. Time O(1).\n", "label 'Time' in the middle"),
        (LICENCE + "/// Context    One task, that\n/// of the caller.\n", "not indented"),
    ],
)
def test_a_text_that_breaks_a_rule_is_found(tmp_path, monkeypatch, text, complaint):
    found = text_breaches(tmp_path, monkeypatch, "a.c", text)
    assert (not found) if complaint is None else any(complaint in line for line in found), found


@pytest.mark.parametrize(
    "name, line, complaint",
    [
        ("sim/a.c", "// Nobody takes it.", "'Nobody' in a text"),
        ("sim/a.c", "    return 0; ///< It waits for ever.", "'for ever' in a text"),
        ("sim/a.c", "    return nobody;", None),
        ("test/a.c", "// Nobody takes it.", "'Nobody' in a text"),
        ("sim/a.c", "    say(\"nobody\");", "'nobody' in a text"),
        ("test/a.c", "    say(\"/nowhere\");", None),
        ("gse/a.js", "draw(); // Nobody takes it.", "'Nobody' in a text"),
        ("gse/a.py", "nobody = 1  #" " Nobody takes it.", "'Nobody' in a text"),
        ("gse/a.py", "def a():\n    \"\"\"One step.\n\n    Nobody takes it.\"\"\"", "a.py:5: 'Nobody' in a text"),
        ("gse/a.py", "nobody = 'nobody'", None),
        ("docs/a.md", "Nobody takes it.", "'Nobody' in a text"),
        ("sim/a.c", "// " + "x" * 107, None),
        ("sim/a.c", "// " + "x" * 108, "beyond column 110"),
        ("sim/a.c", "// ---- One step, again ----", None),
        ("test/a.c", "// ---- Non-blocking calls ----", None),
        ("test/a.c", "// --- One step", "a banner is written"),
        ("sim/a.c", "// ---- one step ----", "a banner is written"),
        ("sim/a.c", "int a;\n\n// One step.\n\nint b;", "a banner is written"),
        ("sim/a.c", "int a;\n\n// One step.\nint b;", None),
        ("sim/a.c", "// ---- One step -----------------", "a banner is written"),
        ("sim/a.c", "// " + "-" * 60, "a banner is written"),
        ("sim/a.c", "    // " "// The next step.", "begins with one mark"),
        ("gse/a.js", "// " "// The next step.", "begins with one mark"),
        ("gse/a.py", "# " "# The next step.", "begins with one mark"),
    ],
)
def test_forbidden_phrases_and_wide_comments_are_found(tmp_path, monkeypatch, name, line, complaint):
    (tmp_path / name).parent.mkdir()
    licence = LICENCE.replace("//", "#") if name.endswith(".py") else LICENCE
    found = text_breaches(tmp_path, monkeypatch, name, licence + line + "\n")
    assert (not found) if complaint is None else any(complaint in text for text in found), found


@pytest.mark.parametrize(
    "line, complaint",
    [
        ("static void a_wheel_turns(void)", None),
        ("static void test_wheel(void)", "test_wheel: name a test by the condition"),
        ("static void test_wheel(void** state)", "test_wheel: name a test by the condition"),
        ("static void test_wheel(unsigned id);", None),
        ("    f(a, sizeof a);", None),
        ("    f(a, sizeof(a_t));", None),
        ("    f(a, sizeof(char));", None),
        ("    f(a, sizeof(struct stat));", None),
        ("    f(a, sizeof(a));", "write `sizeof a`"),
        ("    f(a, sizeof(a) - 1U);", "write `sizeof a`"),
        ("    f(a, sizeof(*a->b));", "write `sizeof *a->b`"),
        ("    f(a, sizeof(a[0]));", "write `sizeof a[0]`"),
        ("    f(a, sizeof(\"a\"));", "write `sizeof \"a\"`"),
        ("    f(a, sizeof((const uint8_t[]){1U}));", None),
        ("#define COUNT(a) (sizeof(a) / sizeof((a)[0]))", None),
        ("#define COUNT(a) \\\n    (sizeof(a) / sizeof((a)[0]))", None),
    ],
)
def test_a_prefix_test_and_parentheses_of_sizeof_are_found(tmp_path, monkeypatch, line, complaint):
    found = text_breaches(tmp_path, monkeypatch, "a.c", LICENCE + line + "\n")
    assert (not found) if complaint is None else any(complaint in text for text in found), found


@pytest.mark.parametrize("name", ["Makefile", "mk/a.mk"])
@pytest.mark.parametrize("columns, complaint", [(120, None), (121, "121 columns, 120 allowed")])
def test_lines_of_makefiles_are_short(tmp_path, monkeypatch, name, columns, complaint):
    (tmp_path / "mk").mkdir()
    found = text_breaches(tmp_path, monkeypatch, name, "a" * columns + "\n")
    assert (not found) if complaint is None else any(complaint in line for line in found), found


@pytest.mark.parametrize("columns, complaint", [(110, None), (111, "111 columns, 110 allowed")])
def test_lines_of_the_page_are_short(tmp_path, monkeypatch, columns, complaint):
    found = text_breaches(tmp_path, monkeypatch, "a.js", "a" * columns + "\n")
    assert (not found) if complaint is None else any(complaint in line for line in found), found


@pytest.mark.parametrize("lines, complaint", [(600, None), (601, "601 lines, 600 allowed")])
def test_files_of_the_page_are_short(tmp_path, monkeypatch, lines, complaint):
    found = text_breaches(tmp_path, monkeypatch, "a.js", "a\n" * lines)
    assert (not found) if complaint is None else any(complaint in line for line in found), found


@pytest.mark.parametrize("lines, complaint", [(15, None), (16, "contract of 16 lines")])
def test_contracts_are_short(tmp_path, monkeypatch, lines, complaint):
    text = LICENCE + "/// A line.\n" * lines + "#ifndef A_H\n"
    found = text_breaches(tmp_path, monkeypatch, "a.h", text)
    assert (not found) if complaint is None else any(complaint in line for line in found), found


@pytest.mark.parametrize("lines, complaint", [(60, None), (61, "61 lines, 60 allowed")])
def test_the_first_page_is_short(tmp_path, monkeypatch, lines, complaint):
    found = text_breaches(tmp_path, monkeypatch, "README.md", "A line.\n" * lines)
    assert (not found) if complaint is None else any(complaint in line for line in found), found


def test_long_python_functions_are_found(tmp_path, monkeypatch):
    text = "# SPDX-License-Identifier: Apache-2.0\ndef f():\n" + "    pass\n" * 60
    assert any("function of 61 lines" in line for line in text_breaches(tmp_path, monkeypatch, "a.py", text))


DEVIATIONS = """
| D-15.5 | everywhere | more than one return | refusals leave first |
| D-7.1 | `osal/posix` | octal | modes |
| D-8.6 | `fsw/programs/*_main.c`, `pus/tool/*_main.c` | mains | programs |
| D-1.2 | by hand: `osal` | atomics | none in C99 |
| F-returnDanglingLifetime | `pus/a.c` | a pointer | none |
"""


@pytest.mark.parametrize(
    "finding, is_open",
    [
        ("pus/b.c:3: misra-c2012-15.5 text", False),
        ("pus/b.c:3: misra-c2012-7.1 text", True),
        ("osal/posix/b.c:3: misra-c2012-7.1 text", False),
        ("osal/posixer/b.c:3: misra-c2012-7.1 text", True),
        ("fsw/programs/arm_main.c:3: misra-c2012-8.6 text", False),
        ("fsw/programs/arm.c:3: misra-c2012-8.6 text", True),
        ("pus/a.c:3: returnDanglingLifetime text", False),
        ("pus/b.c:3: nullPointer text", True),
        ("base/b.c:3: nullPointer text", True),
        ("launcher/b.c:3: nullPointer text", True),
        ("build/generated/a.h:3: misra-c2012-7.1 text", True),
        ("sim/a.c:3: nullPointer text", False),
        ("/usr/include/a.h:3: misra-c2012-7.1 text", False),
    ],
)
def test_a_finding_is_accepted_if_a_deviation_covers_it(finding, is_open):
    found, unused = check_misra.judge([finding], check_misra.read_deviations(DEVIATIONS))
    assert (found == [finding]) == is_open
    assert 5 not in unused, "a rule checked by hand needs no finding"
    assert len(unused) == (3 if finding.startswith(("pus/b.c:3: misra-c2012-15.5", "osal/posix/", "fsw/programs/arm_", "pus/a.c"))
                           else 4)


def test_rules_about_the_whole_program_are_not_applied_to_a_part():
    finding = "pus/b.c:3: misra-c2012-8.7 text"
    assert check_misra.judge([finding], [], True)[0] == [finding]
    assert check_misra.judge([finding], [], False)[0] == []


@pytest.mark.parametrize(
    ("changed", "looked_at"),
    [
        (["a.c"], ["a.c"]),
        (["a.h"], ["a.c"]),
        (["a.h", "b.c"], ["b.c"]),
        (["c.h"], ["b.c"]),
        (["none.h", "a.md"], []),
        (["d.c", "a.h", "a.c"], ["d.c", "a.c"]),
    ],
)
def test_misra_checks_changed_files_and_their_includers(changed, looked_at):
    texts = {"b.c": '#include "a.h"\n#include "c.h"\n', "a.c": '#include "a.h"\n', "d.c": '#include "c.h"\n'}
    assert check_misra.affected(list(texts), changed, texts.get) == looked_at


@pytest.mark.parametrize(
    "text, complaint",
    [
        ("[there](other.md)", None),
        ("[there](other.md#a-heading-of-two-words)", None),
        ("[there](other.md#a-heading-of-two-words-1)", None),
        ("[there](other.md#elsewhere)", "no such anchor: other.md#elsewhere"),
        ("[there](page.html#spot)", None),
        ("[there](page.html#stain)", "no such anchor"),
        ("[gone](gone.md)", "a.md:3: no such file: gone.md"),
        ("![gone](gone.png)", "no such file"),
        ("[here](#title)", None),
        ("[here](#nowhere)", "no such anchor"),
        ("[far](https://example.org/gone)", None),
        ("```\n[code](gone.md)\n```", None),
        ("`[code](gone.md)`", None),
        ("see `docs/a.md`", None),
        ("see `docs/gone.md`", "no such file: docs/gone.md"),
    ],
)
def test_a_broken_link_is_found(tmp_path, text, complaint):
    docs = tmp_path / "docs"
    docs.mkdir()
    (docs / "a.md").write_text(f"# Title\n\n{text}\n")
    (docs / "other.md").write_text("# A heading, of *two* words\n\n# A heading of two words\n")
    (docs / "page.html").write_text('<h1 id="spot">x</h1>')
    found = list(check_links.dead_links(docs / "a.md", tmp_path))
    assert (not found) if complaint is None else any(complaint in line for line in found), found


def test_pages_are_reached_from_the_index(tmp_path):
    """A page is reached by two clicks; three are too many, and a page without a link is reported."""
    decisions = tmp_path / "docs" / "decisions"
    decisions.mkdir(parents=True)
    (tmp_path / "docs" / "README.md").write_text("[one](one.md) [list](decisions/README.md)\n")
    (tmp_path / "docs" / "one.md").write_text("# One\n\n[two](two.md#two)\n")
    (tmp_path / "docs" / "two.md").write_text("# Two\n\n[three](three.md)\n")
    (tmp_path / "docs" / "three.md").write_text("# Three\n")
    (tmp_path / "docs" / "alone.md").write_text("# Alone\n")
    (decisions / "README.md").write_text("- [0001 First](0001-a.md)\n- [0002 Old](0002-b.md)\n")
    (decisions / "0001-a.md").write_text("# 0001 First\n")
    (decisions / "0002-b.md").write_text("# 0002 Second\n")
    assert [line.partition(":")[0] for line in check_links.unreached(tmp_path)] == ["docs/alone.md", "docs/three.md"]
    assert list(check_links.mistitled(tmp_path)) == ["docs/decisions/README.md:1: no such line: - [0002 Second](0002-b.md)"]


def coverage_report(*lines):
    """A report of gcovr about one file with these lines (number, runs, counts of the branches)."""
    return {"files": [{"file": "pus/a.c", "lines": [
        {"line_number": number, "count": runs, "branches": [{"count": count} for count in counts]}
        for number, runs, counts in lines]}]}


def measured(exclusions, *lines):
    rows = [check_coverage.Exclusion(number, text) for number, text in enumerate(exclusions, 1)]
    source = ["if (a) {", "    return b ? c : d;", "}"]
    return check_coverage.measure(coverage_report(*lines), lambda _: source, rows)["pus"], rows


@pytest.mark.parametrize(
    "exclusions, figures, is_used",
    [
        ([], (50.0, 50.0), []),
        (["pus/a.c | if (a) { | 1 | a is always true"], (66.6, 50.0), [True]),
        (["pus/a.c | return b ? c : d; | 1 | b is never false", "pus/a.c | if (a) { | 1 | so"], (100.0, 50.0), [True, True]),
        (["pus/a.c | if (a) { | 2 | more than is open"], (50.0, 50.0), [False]),
        (["pus/a.c | if (z) { | 1 | a line that is gone"], (50.0, 50.0), [False]),
        (["pus/b.c | if (a) { | 1 | another file"], (50.0, 50.0), [False]),
    ],
)
def test_an_exclusion_excludes_the_stated_branches_only(exclusions, figures, is_used):
    library, rows = measured(exclusions, (1, 3, [3, 0]), (2, 0, [2, 0]))
    assert library.figures() == figures
    assert [row.is_used for row in rows] == is_used


def test_an_exclusion_names_one_line():
    _, rows = measured(["pus/a.c | } | 1 | so", "pus/a.c | if (a) { | 1 | so"], (1, 3, [3, 0]))
    assert [row.matches for row in rows] == [1, 1]
    twice = ["if (a) {", "}", "if (a) {"]
    rows = [check_coverage.Exclusion(1, "pus/a.c | if (a) { | 1 | so")]
    check_coverage.measure(coverage_report((1, 3, [3, 0])), lambda _: twice, rows)
    assert rows[0].matches == 2


def test_an_exclusion_needs_a_reason():
    with pytest.raises(SystemExit):
        check_coverage.Exclusion(1, "pus/a.c | if (a) { | 1 | ")


WORLD = """<World name="lab" step="1ms" gravity="0 0 0"><Robot name="arm" urdf="arm.urdf" base="fixed"/>
<Drive name="ELBOW" joint="arm.bend" type="t" bus="can-1" node="0x2A" eds="motor.eds"/>
<Latch name="HOOK" a="arm.claw" b="arm.claw" distance="1" angle="1" speed="1"/><Gyro name="SPIN" on="arm.claw"/>
<ValveBox name="BOX"><Valve name="NOZZLE"/></ValveBox></World>"""


@pytest.mark.parametrize(
    "line, finds",
    [
        ('bus = "can-1";', True),
        ('path = "/motor.eds";', True),
        ('usage = "give can-1=shm:x";', True),
        ('joint = find("bend");', True),
        ('device = "ELBOW";', True),
        ('latch = "HOOK";', True),
        ('sensor = "SPIN";', True),
        ('valve = "NOZZLE";', True),
        ('link = "claw";', True),
        ("id = 0x2aU;", True),
        ("lab_parameters = 1;", True),
        ("// as in lab", True),
        ("bend = arm; // \"can-1\"", False),
        ('text = "an arm and its label";', False),
        ("id = 0x12AU + 0x2A1U + 42U;", False),
    ],
)
def test_names_of_worlds_in_the_simulator_are_found(tmp_path, line, finds):
    worlds, sources = tmp_path / "descriptors" / "worlds", tmp_path / "sim" / "app"
    worlds.mkdir(parents=True)
    sources.mkdir(parents=True)
    (worlds / "lab.xml").write_text(WORLD)
    (worlds / "arm.urdf").write_text('<robot name="a"><link name="claw"/><joint name="bend"/></robot>')
    (sources / "x.c").write_text(f"\n{line}\n")
    found = list(check_worlds.breaches(tmp_path, {}))
    assert [text.split(": ")[0] for text in found] == (["sim/app/x.c:2"] if finds else [])
    stale = list(check_worlds.breaches(tmp_path, {("sim/app/x.c", "elsewhere"): "reason"}))
    assert stale[-1].startswith("sim/app/x.c: exemption 'elsewhere'") and len(stale) == len(found) + 1


@pytest.mark.parametrize(
    "mark, findings",
    [
        ([50.0, 100.0, False], 0),
        ([51.0, 100.0, False], 1),
        ([51.0, 100.0, True], 2),
        ([50.0, 100.0, True], 1),
    ],
)
def test_coverage_below_a_mark_and_open_branches_of_a_complete_library_are_found(mark, findings):
    library, _ = measured([], (1, 3, [3, 0]))
    assert len(list(check_coverage.compare({"pus": library}, {"pus": mark}))) == findings


def test_a_library_without_marks_is_a_finding():
    findings = list(check_coverage.compare({"pus": check_coverage.Library(), "fsw/new": check_coverage.Library()}, {"pus": [100, 100, True]}))
    assert len(findings) == 1 and "fsw/new has no marks" in findings[0]


def test_marks_are_raised_and_never_lowered(tmp_path):
    marks = tmp_path / "coverage.txt"
    marks.write_text("# head\n\npus  40 40  complete\n")
    library, _ = measured([], (1, 3, [3, 0]))
    check_coverage.write_marks(marks, {"pus": library}, check_coverage.read_marks(marks))
    assert check_coverage.read_marks(marks) == {"pus": [49.0, 100.0, True]}
    worse, _ = measured([], (1, 0, [0, 0]))
    check_coverage.write_marks(marks, {"pus": worse}, check_coverage.read_marks(marks))
    assert check_coverage.read_marks(marks) == {"pus": [49.0, 100.0, True]}
    assert marks.read_text().startswith("# head\n")


def test_compile_commands_name_every_source_and_compile():
    """Editors need each C file once, with a command that a compiler accepts."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    subprocess.run(["make", "-s", "compile-commands"], cwd=check_layers.ROOT, env=environment, check=True)
    entries = json.loads((check_layers.ROOT / "build" / "compile_commands.json").read_text(encoding="utf-8"))
    files = [entry["file"] for entry in entries]
    assert len(files) == len(set(files)) > 500
    assert all((check_layers.ROOT / name).is_file() for name in files)
    assert {str(path.relative_to(check_layers.ROOT)) for path in (check_layers.ROOT / "pus").rglob("*.c")} < set(files)
    for name in ("base/crc.c", "launcher/hirosco_main.c", "test/unit/base/test_crc.c"):
        entry = next(entry for entry in entries if entry["file"] == name)
        subprocess.run([*shlex.split(entry["command"]), "-fsyntax-only"], cwd=entry["directory"], check=True)


# ---- Conditions (MC/DC) ----


def decisions(*shown):
    """What llvm-cov exports of one decision: place, counts, kinds, and for each condition whether it decided alone."""
    return {"mcdc_records": [[3, 5, 3, 30, 0, 0, 6, 0, [], list(shown)]]}


LINES = ["", "", "    if (is_open && is_fresh) {"]


def test_a_condition_that_never_decides_alone_is_found():
    found = check_mcdc.decisions_of(decisions(True, False))
    shown, total, findings = check_mcdc.compare("fsw/a.c", found, LINES, [])
    assert (shown, total) == (1, 2)
    assert findings == ["fsw/a.c:3: no test shows that condition 2 of 2 acts alone: if (is_open && is_fresh) {"]


def test_a_condition_that_decides_alone_in_one_copy_of_a_function_is_shown():
    record = {"mcdc_records": decisions(True, False)["mcdc_records"] + decisions(False, True)["mcdc_records"]}
    assert check_mcdc.compare("fsw/a.c", check_mcdc.decisions_of(record), LINES, []) == (2, 2, [])


def test_an_excluded_condition_needs_a_reason_and_must_exist():
    paths, exclusions = check_mcdc.read_list(["# text", "fsw/a.c", "fsw/a.c | if (is_open && is_fresh) { | 2 | it is always fresh here"])
    assert paths == ["fsw/a.c"]
    assert check_mcdc.compare("fsw/a.c", check_mcdc.decisions_of(decisions(True, False)), LINES, exclusions) == (1, 1, [])
    assert exclusions[0].is_used
    _, exclusions = check_mcdc.read_list(["fsw/a.c | if (is_open && is_fresh) { | 2 | it is always fresh here"])
    check_mcdc.compare("fsw/a.c", check_mcdc.decisions_of(decisions(True, True)), LINES, exclusions)
    assert not exclusions[0].is_used
    with pytest.raises(SystemExit, match="expected path"):
        check_mcdc.read_list(["fsw/a.c | if (is_open && is_fresh) { | 2 |"])


@pytest.mark.parametrize("records, code, message", [(decisions(True, True), 0, "each condition is shown"), ({}, 1, "of a.c no decision was recorded")])
def test_a_source_without_recorded_decisions_is_found(tmp_path, monkeypatch, capsys, records, code, message):
    (tmp_path / "a.c").write_text("\n".join(LINES))
    (tmp_path / "list").write_text("a.c\n")
    for name, value in (("ROOT", tmp_path), ("LIST", tmp_path / "list"), ("PROFILES", tmp_path / "profiles"), ("run_test", lambda test: ""),
                        ("export", lambda tests: [{"filename": "a.c", **records}])):
        monkeypatch.setattr(check_mcdc, name, value)
    monkeypatch.setattr("sys.argv", ["check_mcdc.py", "test_a.c"])
    assert check_mcdc.main() == code
    assert message in capsys.readouterr().out


def test_an_assertion_is_no_decision():
    assert check_mcdc.compare("fsw/a.c", check_mcdc.decisions_of(decisions(False, False)), ["", "", "FSW_ASSERT(a && b);"], []) == (0, 0, [])
