# SPDX-License-Identifier: Apache-2.0
"""The changes that `make mutants` makes, and the agreement of the list of equivalent mutants with the
sources."""

import pathlib
import subprocess
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import run_mutants


@pytest.mark.parametrize(
    "line, changes",
    [
        ("    if (a < b) {", ["    if (a <= b) {", "    if (!(a < b)) {"]),
        ("    x->count += 2U;", ["    x->count -= 2U;", "    x->count += 3U;", "    {}"]),
        ("    return STATUS_OK;", ["    return STATUS_IO;"]),
        ("    (void)close(descriptor); // a == b", ["    {}"]),
        ('    text_add(&text, "a < b");', ["    {}"]),
        ("    const int x = f();", []),
        ("    FSW_ASSERT(a < 2U);", []),
        ("static const int x = 2;", []),
    ],
)
def test_a_line_has_the_expected_changes(line, changes):
    assert [mutant.new for mutant in run_mutants.mutants_of_line("a.c", 1, line)] == changes


def test_a_seed_draws_the_same_and_another_one_differs():
    first = [str(mutant) for mutant in run_mutants.drawn("base/", 1)]
    assert first == [str(mutant) for mutant in run_mutants.drawn("base/", 1)]
    assert first != [str(mutant) for mutant in run_mutants.drawn("base/", 2)]
    assert len(set(first)) == len(first)


def test_one_line_can_be_drawn_alone():
    of_file = run_mutants.drawn("base/crc.c:", 1)
    line = of_file[0].number
    assert {mutant.path for mutant in of_file} == {"base/crc.c"}
    of_line = run_mutants.drawn(f"base/crc.c:{line}:", 1)
    assert sorted(map(str, of_line)) == sorted(str(mutant) for mutant in of_file if mutant.number == line)


def test_a_source_that_is_built_for_the_board_only_has_no_test_program_here():
    tests = run_mutants.Tests.__new__(run_mutants.Tests)
    tests.symbols, tests.called = {}, {}
    paths = {mutant.path for mutant in run_mutants.drawn("osal/freertos/", 1)}
    assert paths, "expected sources of the board among the places to be drawn"
    assert all(tests.of(path) == [] for path in paths)


def test_each_row_of_equivalent_txt_is_a_mutant_of_the_sources():
    for row in run_mutants.read_equivalent():
        assert any(mutant.row() == row for mutant in run_mutants.mutants_of(row[0])), row


def test_a_mutant_that_kills_its_process_group_ends_alone(tmp_path):
    code = "import run_mutants, pathlib, sys; run_mutants.ROOT = run_mutants.TREE = pathlib.Path(sys.argv[1]); " \
           "print([run_mutants.passes(['sh', '-c', command], 20) for command in ('kill -9 0', 'true')])"
    shown = subprocess.run([sys.executable, "-c", code, tmp_path], cwd=pathlib.Path(run_mutants.__file__).parent,
                           capture_output=True, text=True, start_new_session=True, check=False)
    assert shown.stdout == "[False, True]\n", shown


def test_a_tree_below_tmp_is_seen_and_the_rest_of_tmp_is_not(tmp_path):
    beside = tmp_path / "beside"
    tree = tmp_path / "tree" / "below"
    tree.mkdir(parents=True)
    beside.touch()
    program = ["sh", "-c", f"test ! -e {beside} && test $(pwd) = {tree} && echo seen >{tree}/answer"]
    subprocess.run([*run_mutants.alone(tmp_path / "tree", tree), *program], cwd=tree, check=True)
    assert (tree / "answer").read_text() == "seen\n" and beside.exists()


def test_a_row_of_equivalent_txt_without_a_reason_is_named(monkeypatch, tmp_path):
    rows = tmp_path / "equivalent.txt"
    rows.write_text("# Comment.\na.c | x = 1; | x = 2; | x is not read\na.c | y = 1; | y = 2;\n", encoding="utf-8")
    monkeypatch.setattr(run_mutants, "EQUIVALENT", rows)
    with pytest.raises(SystemExit, match=r"equivalent\.txt:3: found 'a\.c \| y = 1; \| y = 2;', expected "):
        run_mutants.read_equivalent()
