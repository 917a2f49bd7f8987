# SPDX-License-Identifier: Apache-2.0
"""The test runner counts what the runners under it say, and never takes a broken program for a good one."""

import pytest
import run_tests


@pytest.mark.parametrize(
    "output, code, expected",
    [
        ("a.c:1:x:PASS\n\n---\n12 Tests 0 Failures 2 Ignored \nOK\n", 0, (10, 0, 2)),
        ("3 Tests 1 Failures 0 Ignored \nFAIL\n", 1, (2, 1, 0)),
        ("[==========] 4 test(s) run.\n[  PASSED  ] 4 test(s).\n", 0, (4, 0, 0)),
        ("[  PASSED  ] 2 test(s).\n[  FAILED  ] 1 test(s), listed below:\n[  FAILED  ] x\n\n 1 FAILED TEST(S)\n", 1, (2, 1, 0)),
        ("[  PASSED  ] 1 test(s).\n[  SKIPPED ] 1 test(s), listed below:\n", 0, (1, 0, 1)),
        ("[  PASSED  ] 1 test(s).\n[  PASSED  ] 2 test(s).\n", 0, (3, 0, 0)),
        ("12 Tests 0 Failures 0 Ignored \nOK\n==1==ERROR: LeakSanitizer\n", 23, (12, 1, 0)),
        ("", -11, (0, 1, 0)),
        ("", 0, (1, 0, 0)),
    ],
)
def test_count(output, code, expected):
    count = run_tests.count_cases(output, code)
    assert (count.passed, count.failed, count.skipped) == expected


def test_a_program_that_was_not_built_fails(tmp_path):
    _, count, output, _ = run_tests.run_program(str(tmp_path / "absent"))
    assert (count.passed, count.failed) == (0, 1) and "did not build" in output


def test_a_program_that_hangs_fails(tmp_path, monkeypatch):
    program = tmp_path / "hangs"
    program.write_text("#!/bin/sh\necho begun\nexec sleep 60\n")
    program.chmod(0o755)
    monkeypatch.setattr(run_tests, "SECONDS_ALLOWED", 5)
    _, count, output, _ = run_tests.run_program(str(program))
    assert count.failed == 1 and "begun" in output and "ended after" in output


def test_a_program_that_computes_for_ever_fails(tmp_path, monkeypatch):
    program = tmp_path / "computes"
    program.write_text("#!/bin/sh\necho begun\nwhile :; do :; done\n")
    program.chmod(0o755)
    monkeypatch.setattr(run_tests, "PROCESSOR_SECONDS_ALLOWED", 1)
    _, count, output, _ = run_tests.run_program(str(program))
    assert count.failed == 1 and "begun" in output and "exit code -" in output
