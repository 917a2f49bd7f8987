# SPDX-License-Identifier: Apache-2.0
"""Completion with the dictionary, tested alone and in shells on a pseudo-terminal; help and examples of every
command."""

import json
import os
import re
import shutil
import subprocess

import named_dictionary
import pytest
from conftest import ROOT
from hirosco_gse import commands, completion, usage
from hirosco_gse.cli import main
from hirosco_gse.command import UsageError
from hirosco_gse.dictionary import Dictionary
from terminal import converse


@pytest.mark.parametrize(("line", "some"), [
    ("", {"ping ", "cmd ", "hand ", "completion "}),
    ("st", {"state ", "status ", "stop ", "step ", "store "}),
    ("state ", {"MANIPULATOR ", "all "}),
    ("state man", {"MANIPULATOR "}),
    ("state all P", {"PRE_OPERATIONAL "}),
    ("cmd MANIPULATOR.M", {"MANIPULATOR.MOVE_TO "}),
    ("cmd MANIPULATOR.MOVE_TO ", {"POSITION=", "DURATION="}),
    ("cmd manipulator.move_to position=1,2 ", {"DURATION="}),
    ("config JOYSTICK ", {"TELEPRESENCE "}),
    ("get MANIPULATOR.CUR_VALUES.P", {"MANIPULATOR.CUR_VALUES.POSITION "}),
    ("hk enable MANIPULATOR ", {"4711 ", "4712 ", "4720 "}),
    ("hk create MANIPULATOR 9000 100 LINK_AGE DES", {"DES_POSITION "}),
    ("hk -f JO", {"JOYSTICK "}),
    ("event disable MANIPULATOR T", {"TORQUE_LIMIT ", "TARE_DONE "}),
    ("link open ", {"HAND_POSITION ", "ROBOT_STATE "}),
    ("mode ", {"SAFE ", "NOMINAL "}),
    ("tc SUPERVISOR 11,2", {"11,2 ", "11,20 ", "11,22 "}),
    ("tc SUPERVISOR 11,4 ", {"sub_schedule_id=", "n="}),
    ("at +60 state MAN", {"MANIPULATOR "}),
    ("at +60 1.1 state MAN", {"MANIPULATOR "}),
    ("action add MANIPULATOR TORQUE_LIMIT cmd MANIPULATOR.S", {"MANIPULATOR.STOP "}),
    ("fault unplug robot ", {"JOINT1 ", "JOINT2 "}),
    ("fault unplug j", {"joystick ", "joystick-b "}),
    ("fault kill m", {"manipulator "}),
    ("re", {"reload ", "replay ", "resume ", "record "}),
    ("replay descr", {"descriptors/"}),
    ("--timeout 5 --json state all O", {"OFFLINE ", "OPERATIONAL "}),
    ("--t", {"--timeout "}),
])
def test_names_of_the_dictionary_complete_a_line(dictionary, line, some):
    words = line.split(" ")
    found = completion.complete(words, lambda options: dictionary)
    assert some <= set(found)
    assert all(one.upper().startswith(words[-1].upper()) for one in found)


@pytest.mark.parametrize("line", [
    "dance ", "state NOBODY X", "config NOBODY ", "cmd NOBODY.MOVE_TO ", "set MANIPULATOR.NOTHING ", "tc SUPERVISOR 99,99 ", "status more ",
    "ping MANIPULATOR more ", "cmd MANIPULATOR.MOVE_TO POSITION=", "--timeout ", "tc SUPERVISOR x,y ", "hk enable NOBODY ", "fault unplug nowhere ",
])
def test_completion_offers_no_word_where_no_name_of_the_dictionary_fits(dictionary, line):
    assert completion.complete(line.split(" "), lambda options: dictionary) == []


def test_only_settable_parameters_are_set(dictionary):
    found = completion.complete(["set", "MANIPULATOR."], lambda options: dictionary)
    assert "MANIPULATOR.TORQUE_LIMIT " in found and "MANIPULATOR.CUR_VALUES " not in found


def test_words_of_enumerations_are_values(dictionary_path):
    named = Dictionary(named_dictionary.named(json.loads(dictionary_path.read_text(encoding="utf-8"))))
    assert completion.complete(["cmd", "MANIPULATOR.MOVE_TO", "DURATION="], lambda o: named) == ["DURATION=SLOW", "DURATION=QUICK"]
    assert completion.complete(["set", "MANIPULATOR.CHOICE", "SLOW,q"], lambda o: named) == ["SLOW,QUICK"]
    enabled = completion.complete(["tc", "SUPERVISOR", "11,22", ""], lambda o: named)
    assert enabled == ["n="]


def test_paths_are_completed_from_files(dictionary, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    (tmp_path / "rest.scn").touch()
    assert completion.complete(["script", "r"], lambda options: dictionary) == ["rest.scn ", "runs/"]
    assert completion.complete(["--run", "r"], lambda options: dictionary) == ["rest.scn ", "runs/"]


@pytest.mark.parametrize(("shell", "options", "begin"), [
    ("bash", ["--norc", "-i"], 'PS1="ready> "; bind "set enable-bracketed-paste off"; eval "$(gse completion bash)"; echo set""up\n'),
    ("zsh", ["-f", "-i"], 'PS1="ready> "; autoload -U compinit; compinit -u -D; eval "$(gse completion zsh)"; echo set""up\n'),
])
def test_a_shell_completes_at_tab(shell, options, begin, dictionary_path, tmp_path):
    """The shell completes a state, then a function with an argument that contains `=`, at which bash splits words."""
    if not shutil.which(shell):
        pytest.skip(f"{shell} is not installed")
    (tmp_path / "gse").write_text(
        f'#!/bin/sh\nif [ "$1" = complete ]; then shift 2; exec {ROOT}/gse/gse complete -- --dictionary {dictionary_path} "$@"; fi\n'
        f'if [ "$1" = completion ]; then exec {ROOT}/gse/gse "$@"; fi\necho "given: $*"\n', encoding="utf-8")
    (tmp_path / "gse").chmod(0o755)
    environment = {"PATH": f"{tmp_path}:{os.environ['PATH']}", "TERM": "dumb", "HOME": str(tmp_path)}
    converse([shell, *options], environment, [
        ("", begin),
        ("setup", "gse state manip\t"),
        ("MANIPULATOR ", "pre\t"),
        ("PRE_OPERATIONAL ", "\n"),
        ("given: state MANIPULATOR PRE_OPERATIONAL", "gse cmd MANIPULATOR.M\t"),
        ("TO ", "DU\t"),
        ("ION=", "2 POS\t"),
        ("ION=", "0,0\n"),
        ("given: cmd MANIPULATOR.MOVE_TO DURATION=2 POSITION=0,0", "exit\n"),
    ], size=(24, 200))


def test_every_command_has_help_with_an_example_that_is_accepted(dictionary, capsys):
    for verb in usage.table():
        assert main([verb, "--help"]) == 0
        shown = capsys.readouterr().out
        assert shown.startswith(f"usage: gse {verb}") and "example: " in shown
        words = usage.EXAMPLES[verb].split()
        if verb in commands.VERBS:
            try:
                assert commands.plan(words[1:], dictionary).text
            except UsageError as problem:
                pytest.fail(f"{verb}: {problem}")
    assert set(usage.EXAMPLES) == set(usage.table())


def test_the_verbs_of_fault_and_hand_are_those_of_the_simulator():
    tables = {"fault": r'\[FAULT_\w+\]\s*= \{"([\w-]+)"', "hand": r'^    \{"([a-z_]+)",'}
    for verb, (path, pattern) in {"fault": ("sim/app/faults.c", tables["fault"]), "hand": ("sim/operator/hand.c", tables["hand"])}.items():
        known = set(re.findall(pattern, (ROOT / path).read_text(encoding="utf-8"), re.MULTILINE))
        assert known == {word for form in usage.forms(verb) for word in form[1].split("|")}


def test_a_call_without_a_command_and_an_unknown_shell_are_refused(capsys):
    assert main([]) == 2
    assert capsys.readouterr().err == "gse: no command; gse --help lists them\n"
    assert subprocess.run([ROOT / "gse/gse", "completion", "fish"], capture_output=True, check=False).returncode == 2


def test_a_group_that_is_no_list_is_refused_with_a_message(dictionary_path, capsys):
    assert main(["--dictionary", str(dictionary_path), "tc", "SUPERVISOR", "11,22", "n=5"]) == 2
    assert "'5' is not a list of groups in JSON" in capsys.readouterr().err
