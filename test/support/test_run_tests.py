# SPDX-License-Identifier: Apache-2.0
"""The test runner counts the results of the runners below it, and never counts a broken program as a
success."""

import os
import pathlib
import subprocess

import pytest
import run_tests

ROOT = pathlib.Path(__file__).resolve().parents[2]


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
def test_the_cases_of_a_runner_are_counted_by_its_closing_lines(output, code, expected):
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


def test_a_program_of_a_board_is_run_by_its_emulator():
    assert run_tests.command_of("build/test/unit/base/test_crc") == ["build/test/unit/base/test_crc"]
    words = run_tests.command_of("build/mps2-an500/test/unit/base/test_crc")
    assert words[0] == "qemu-system-arm" and words[words.index("-machine") + 1] == "mps2-an500"
    assert words[words.index("-kernel") + 1] == os.path.abspath("build/mps2-an500/test/unit/base/test_crc")
    assert "shift=5,sleep=off" in words  # The board's time counts instructions and does not depend on this machine.


def test_a_program_that_computes_without_end_fails(tmp_path, monkeypatch):
    program = tmp_path / "computes"
    program.write_text("#!/bin/sh\necho begun\nwhile :; do :; done\n")
    program.chmod(0o755)
    monkeypatch.setattr(run_tests, "PROCESSOR_SECONDS_ALLOWED", 1)
    _, count, output, _ = run_tests.run_program(str(program))
    assert count.failed == 1 and "begun" in output and "exit code -" in output


@pytest.mark.parametrize(
    "words, said",
    [
        (("help", "ONLYX=pus"), "ONLYX=pus: there is no such option; there are: ALL "),
        (("sim-run", "SEEED=2"), "SEEED=2: there is no such option"),
        (("fuzz", "ONLY=nothing"), "ONLY=nothing: no fuzz target has this in its name; there are: "),
        (("coverage", "ONLY=nothing"), "ONLY=nothing: no C unit test has this in its path"),
        (("test-hil", "TEST_ENVIRONMENT=moon"), "TEST_ENVIRONMENT=moon: expected vm or kernel"),
        (("test-hil", "ONLY=nothing"), "no test in test/hil has 'nothing' in its path"),
    ],
)
def test_make_refuses_unknown_variables(words, said):
    """Otherwise make would ignore a misspelled variable, and the call would count as a success."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith("MAKE")}
    done = subprocess.run(["make", "--dry-run", *words], cwd=ROOT, env=kept, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert said in done.stderr


def test_make_knows_every_option_that_its_help_names():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    known = makefile.partition("\nOPTIONS := ")[2].partition("\nifeq")[0].split()
    helped = "\n".join(line for line in makefile.splitlines() if line.startswith("## "))
    named = {word.partition("=")[0] for word in helped.split() if word.partition("=")[1] and word.partition("=")[0].isupper()}
    assert len(named) > 20 and named <= set(known)


def program(directory, name, text):
    path = directory / name
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return str(path)


def test_a_program_is_shown_when_it_ends_although_the_one_before_still_runs(tmp_path, capsys):
    """The first program waits until the second has ended; in the order of the list, no result would be shown
    until then."""
    # Process id of the second program. The process exists until the runner has noticed its end.
    pid = tmp_path / "pid"
    first = program(tmp_path, "first", f"until [ -s {pid} ]; do sleep 0.05; done; while kill -0 $(cat {pid}) 2>/dev/null; do sleep 0.05; done; sleep 1")
    second = program(tmp_path, "second", f"echo $$ >{pid}")
    total, times, counts = run_tests.run_programs([first, second], jobs=2)
    shown = [line.split()[:2] for line in capsys.readouterr().out.splitlines()]
    assert shown == [["[1/2]", second], ["[2/2]", first]]
    assert total.passed == 2 and sorted(name for _, name in times) == [first, second]
    assert {name: count.passed for name, count in counts.items()} == {first: 1, second: 1}


@pytest.mark.parametrize("lost, failures", [(0, 0), (1, 1), (-1, 0)])
def test_a_contract_that_has_no_result_on_the_board_any_more_is_a_failure(capsys, lost, failures):
    expected = run_tests.CONTRACTS_ON_BOARD
    counts = {"build/mps2-an500/test/contract/osal/test_file": run_tests.Count(passed=9, skipped=2),
              "build/mps2-an500/test/contract/osal/test_task": run_tests.Count(passed=expected - 9 - lost, skipped=lost),
              "build/mps2-an500/test/unit/base/test_crc": run_tests.Count(passed=50),
              "build/test/contract/osal/test_task": run_tests.Count(passed=50)}
    assert run_tests.judge_contracts(counts) == failures
    assert f"contracts with a result on the board: {expected - lost}, expected {expected}" in capsys.readouterr().out


def test_the_slowest_ten_are_shown_slowest_first(capsys):
    run_tests.print_slowest("C tests", [(float(seconds), f"t{seconds}") for seconds in range(11)])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "slowest C tests:"
    assert [line.split() for line in lines[1:]] == [[f"{seconds}.00", "s", f"t{seconds}"] for seconds in range(10, 0, -1)]
    run_tests.print_slowest("tests in Python", [])
    assert capsys.readouterr().out == ""


def test_a_report_of_pytest_gives_count_and_times(tmp_path):
    report = tmp_path / "pytest.xml"
    report.write_text('<testsuites><testsuite tests="4" failures="1" errors="1" skipped="1"><testcase classname="a.b" name="c" time="1.5"/>'
                      '</testsuite></testsuites>')
    count, times = run_tests.read_report(report)
    assert (count.passed, count.failed, count.skipped) == (1, 2, 1)
    assert times == [(1.5, "a.b::c")]


@pytest.mark.parametrize(
    "only, levels, programs",
    [
        ("unit/base", "rtos unit", False),
        ("contract/osal/test_mutex", "clang rtos unit", False),
        ("unit/gse", "pytest unit", False),
        ("test_fuzz", "pytest unit", False),
        ("conformance", "pytest test unit", True),
        ("test_nodes", "pytest test unit vm", True),
        ("test_remote_endian", "pytest s390x test unit vm", True),
        ("no such test", "unit", False),
        ("", "clang pytest rtos s390x test unit vm", True),
    ],
)
def test_make_installs_and_builds_only_the_needs_of_the_selected_tests(only, levels, programs):
    kept = {key: value for key, value in os.environ.items() if not key.startswith("MAKE")}
    words = ["make", "--print-data-base", "--dry-run", "help", f"ONLY={only}"]
    known = subprocess.run(words, cwd=ROOT, env=kept, capture_output=True, text=True, check=True).stdout
    value = dict(line.split(" := ", 1) for line in known.splitlines() if " := " in line)
    has_board = (ROOT / "osal/freertos/startup.c").exists()
    assert sorted(value["TEST_SETUP"].split()) == [level for level in levels.split() if level != "rtos" or has_board]
    assert value.get("NEEDS_PROGRAMS", "").split() == ["programs", "random-flight"] * programs
