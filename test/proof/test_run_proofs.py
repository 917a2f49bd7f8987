# SPDX-License-Identifier: Apache-2.0
"""Statements of proofs, planted faults, reduced capacities, and the judgement of what CBMC prints. A program in the place
of CBMC answers, so that these tests take no time."""

import stat

import pytest
import run_proofs

SOURCE = "int limit = CAPACITY;\nint twice(int n)\n{\n    return n + n;\n}\n"
HEADER = "#define CAPACITY 128U\n"
STATEMENT = """// SPDX-License-Identifier: Apache-2.0
// Proves: the double of a number
//     is even.
// Bounds: every number.
// Replaced: nothing.
// Sources: a.c
// Options: --unwind 3
// Fault: a.c
//   - return n + n;
//   + return n + 1;
#include "a.h"
// Bounds: this is no line of the statement.
"""
REDUCED = STATEMENT.replace("// Fault:", "// Reduced: a.h\n//   - #define CAPACITY 128U\n//   + #define CAPACITY 2U\n// Fault:")
HOLDS = "** 0 of 12 failed (1 iterations)\nVERIFICATION SUCCESSFUL\n"
FOUND = "Violated property:\n  file a.c function twice line 4\n  the double is even\n  n % 2 == 0\n\nVERIFICATION FAILED\n"
REACHED = "[f.assertion.1] line 4 the double is even: FAILURE\n** 1 of 1 failed (2 iterations)\nVERIFICATION FAILED\n"
UNREACHED = REACHED + "[f.assertion.2] line 5 the half is small: SUCCESS\n"
UNWOUND = "Violated property:\n  file a.c function twice line 4\n  unwinding assertion loop 0\n\nVERIFICATION FAILED\n"
# Answers `reached` with -DPROOF_REACHED, `with_fault` if a directory of copies with a fault is given, else `without_fault`.
CHECKER = """#!/bin/sh
printf '%s\\n' "$@" >>log
for word; do case $word in -DPROOF_REACHED) cat reached; exit $(cat reached.code) ;; esac; done
for word; do case $word in -I*/fault*) cat with_fault; exit $(cat with_fault.code) ;; esac; done
cat without_fault; exit $(cat without_fault.code)
"""


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A tree with one source and one proof. Returns a function that writes the proof's statement and the checker's answers."""
    monkeypatch.setattr(run_proofs, "ROOT", tmp_path)
    monkeypatch.setattr(run_proofs, "HERE", tmp_path / "test/proof")
    monkeypatch.setattr(run_proofs, "OUT", tmp_path / "build/proofs")
    monkeypatch.setattr(run_proofs, "CBMC", tmp_path / "cbmc")
    loader = tmp_path / "cbmc/lib/ld-linux.so"
    loader.parent.mkdir(parents=True)
    loader.write_text(CHECKER)
    loader.chmod(loader.stat().st_mode | stat.S_IXUSR)
    (tmp_path / "a.c").write_text(SOURCE)
    (tmp_path / "a.h").write_text(HEADER)
    (tmp_path / "test/proof").mkdir(parents=True)
    for name in ("assertion.c", "run_proofs.py"):
        (tmp_path / "test/proof" / name).write_text("")

    def write(statement=STATEMENT, without=(HOLDS, 0), with_fault=(FOUND, 10), reached=(REACHED, 10)):
        for name, (text, code) in (("without_fault", without), ("with_fault", with_fault), ("reached", reached)):
            (tmp_path / name).write_text(text)
            (tmp_path / f"{name}.code").write_text(str(code))
        path = tmp_path / "test/proof/proof_a.c"
        path.write_text(statement)
        return run_proofs.Proof(path)

    return write


def test_a_statement_is_the_comment_at_the_beginning(tree):
    proof = tree()
    assert (proof.proves, proof.bounds, proof.sources, proof.options) == ("the double of a number is even.", "every number.", ["a.c"], ["--unwind", "3"])
    assert not proof.is_quick
    assert tree(STATEMENT.replace("// Fault:", "// Quick: yes\n// Fault:")).is_quick


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("// Bounds: every number.\n", "", "Bounds"),
        ("// Bounds:", "// Limits:", "Limits"),
        ("//   - return n + n;\n", "", "one line `- text`"),
        ("//   + return n + 1;\n", "//   + return 1;\n//   + return 2;\n", "at most one line"),
    ],
)
def test_a_wrong_statement_is_refused(tree, old, new, message):
    with pytest.raises(SystemExit, match=message):
        tree(STATEMENT.replace(old, new))


def test_a_proof_that_holds_and_finds_its_fault_passes(tree):
    findings, row = run_proofs.prove(tree())
    assert findings == []
    assert (row["checks"], row["found"]) == (12, ["the double is even"])


@pytest.mark.parametrize(
    "answers, message",
    [
        ({"without": ("[a.1] line 4 overflow on +: FAILURE\n** 1 of 12 failed (2 iterations)\n", 10)}, "does not hold (code 10): overflow on +"),
        ({"without": ("VERIFICATION SUCCESSFUL\n", 0)}, "does not hold (code 0)"),  # No property was checked.
        ({"without": (HOLDS + "no body for function 'f'\n", 0)}, "without a body, so without effect: f"),
        ({"without": ("out of memory\n", 6)}, "does not hold (code 6)"),
        ({"with_fault": (HOLDS, 0)}, "the fault planted in a.c is not found (code 0)"),
        ({"with_fault": (UNWOUND, 10)}, "the fault planted in a.c is not found (code 10)"),  # A bound is no finding.
        ({"with_fault": ("out of memory\n", 6)}, "the fault planted in a.c is not found (code 6)"),
        ({"reached": (UNREACHED, 10)}, "never reached with all conditions true (code 10): the half is small"),
        ({"reached": ("out of memory\n", 6)}, "never reached with all conditions true (code 6)"),
    ],
)
def test_a_proof_fails(tree, answers, message):
    findings, _ = run_proofs.prove(tree(**answers))
    assert len(findings) == 1
    assert message in findings[0]


def test_a_fault_is_planted_into_a_copy(tree, tmp_path):
    run_proofs.prove(tree())
    assert "return n + 1;" in (tmp_path / "build/proofs/proof_a/fault0/a.c").read_text()
    assert (tmp_path / "a.c").read_text() == SOURCE
    assert str(tmp_path / "build/proofs/proof_a/fault0/a.c") in (tmp_path / "log").read_text().splitlines()


def test_a_fault_must_be_there_once(tree):
    with pytest.raises(SystemExit, match="there 0 times, expected once"):
        run_proofs.prove(tree(STATEMENT.replace("- return n + n;", "- return n * 2;")))


def test_a_capacity_is_reduced_in_each_run(tree, tmp_path):
    findings, _ = run_proofs.prove(tree(REDUCED))
    assert findings == []
    for directory in ("copies", "fault0", "reached"):
        assert (tmp_path / f"build/proofs/proof_a/{directory}/a.h").read_text() == "#define CAPACITY 2U\n"
    assert (tmp_path / "a.h").read_text() == HEADER


def test_a_row_is_kept_while_nothing_changes(tree, tmp_path):
    proof = tree(REDUCED)
    before = proof.digest()
    assert before == proof.digest()
    for path, text in (("a.c", SOURCE + "\n"), ("a.h", HEADER + "\n"), ("test/proof/proof_a.c", REDUCED + "\n")):
        kept = (tmp_path / path).read_text()
        (tmp_path / path).write_text(text)
        assert proof.digest() != before, path
        (tmp_path / path).write_text(kept)


def test_a_proof_that_is_not_run_must_fit_the_sources(tree, tmp_path):
    (tmp_path / "a.c").write_text(SOURCE.replace("CAPACITY", "1"))
    assert tree(REDUCED).stale() == []
    (tmp_path / "a.h").write_text(HEADER + "extern const int limit;\n")
    assert tree(REDUCED).stale() == []
    text = REDUCED + "void proof(void);\nvoid proof(void)\n{\n    limit = 1;\n}\n"
    assert "does not compile any more" in tree(text).stale()[0]
    with pytest.raises(SystemExit, match="there 0 times, expected once"):
        tree(REDUCED.replace("- return n + n;", "- return n * 2;")).stale()


def test_each_proof_is_listed_with_its_run_time(tree, tmp_path):
    (tmp_path / "docs").mkdir()
    page = tmp_path / run_proofs.PAGE
    page.write_text("| doubles: `proof_a` | even | every number | 0.1 |\n")
    assert run_proofs.unlisted([tree()]) == []
    page.write_text("| doubles: `proof_ab` | even | every number | 0.1 |\n")
    assert run_proofs.unlisted([tree()]) == ["docs/assurance.md: no row with `proof_a` in the table of proofs"]


def test_a_checker_that_exceeds_the_time_limit_fails_the_proof(tree, tmp_path, monkeypatch):
    monkeypatch.setattr(run_proofs, "TIMEOUT_S", 1)
    (tmp_path / "cbmc/lib/ld-linux.so").write_text('#!/bin/sh\ncase "$*" in *PROOF_REACHED*) exit 6 ;; esac\nwhile :; do :; done\n')
    findings, _ = run_proofs.prove(tree())
    assert [finding.partition(" (code")[0] for finding in findings] == [
        "test/proof/proof_a.c: does not hold", "test/proof/proof_a.c: the fault planted in a.c is not found",
        "test/proof/proof_a.c: never reached with all conditions true"]  # fmt: skip
