# SPDX-License-Identifier: Apache-2.0
"""The command line where its output cannot be written, with words that are no text, and with damaged files of the launcher."""

import contextlib
import errno
import io
import os
import struct
import sys

import pytest
from hirosco_gse import cli, files, live
from hirosco_gse.cli import main
from hirosco_gse.run_directory import Place
from hirosco_gse.session import LinkLost, Session
from hirosco_gse.shell import Shell
from hirosco_gse.spacecraft import Spacecraft as Client
from hirosco_gse.station import __main__ as station_main
from spacecraft import Spacecraft, success
from tm_packets import build_tm

MANIPULATOR = 16
PRINTING = (["permissions"], ["--help"], ["--version"], ["hk", "--help"], ["completion", "bash"])


@pytest.mark.parametrize("words", PRINTING)
def test_output_that_cannot_be_written_fails_with_the_reason(dictionary_path, monkeypatch, capsys, words):
    full = open("/dev/full", "w", encoding="utf-8")
    monkeypatch.setattr(sys, "stdout", full)
    assert main(["--dictionary", str(dictionary_path), *words]) == 1
    assert capsys.readouterr().err == "gse: cannot write the output: No space left on device; the rest of the output is lost\n"
    assert sys.stdout is not full, "Python would write the text again at exit, and change the exit code"
    with contextlib.suppress(OSError):
        full.close()


@pytest.mark.parametrize("words", PRINTING)
def test_a_reader_that_ends_early_is_no_failure(dictionary_path, monkeypatch, capsys, words):
    """As in `gse ... | head -1`."""
    reader, writer = os.pipe()
    os.close(reader)
    pipe = os.fdopen(writer, "w", encoding="utf-8")
    monkeypatch.setattr(sys, "stdout", pipe)
    assert main(["--dictionary", str(dictionary_path), *words]) == 0
    assert capsys.readouterr().err == "" and sys.stdout is not pipe
    with contextlib.suppress(BrokenPipeError):
        pipe.close()


def test_messages_that_cannot_be_written_keep_the_exit_code(monkeypatch):
    full = open("/dev/full", "w", encoding="utf-8")
    monkeypatch.setattr(sys, "stderr", full)
    assert main(["frobnicate"]) == 2 and sys.stderr is not full
    with contextlib.suppress(OSError):
        full.close()


def test_names_that_the_locale_does_not_have_are_printed_escaped(tmp_path, monkeypatch):
    octets = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(octets, encoding="ascii"))
    assert main(["key", "make", str(tmp_path / "k\u00e4y\udcff")]) == 0
    sys.stdout.flush()
    assert b"/k\\xe4y\\udcff: made" in octets.getvalue()


def test_a_name_that_begins_like_a_negative_number_is_used_as_it_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["key", "make", "-1"]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["-1", "-1.received", "-1.sent"]


def test_endless_lists_in_a_value_are_refused(dictionary_path, capsys):
    words = ["--port", "1", "--dictionary", str(dictionary_path), "tc", "SUPERVISOR", "11,4", "n=" + 100_000 * "["]
    assert main(words) == 2
    assert capsys.readouterr().err == "gse: n: found lists that are nested too deeply, expected a value\n"


def test_a_line_that_is_no_text_is_refused():
    with pytest.raises(live.LiveRefused, match="expected a line in UTF-8"):
        live.octets_of("hand \udcff")


@pytest.mark.parametrize(("words", "code"), [(["permissions"], 130), (["decode", "-"], 130), (["hk"], 0), (["gateway"], 0)])
def test_ctrl_c_before_the_result_is_no_success(monkeypatch, words, code):
    """Commands without an end of their own end with Ctrl-C."""

    def interrupted(arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "_run", interrupted)
    assert main(words) == code


@pytest.mark.parametrize("content", [b"99999\n", b"0\n", b"many", b"\xff\xfe", b"", b"\0"])
def test_a_damaged_port_is_named_and_no_other_flight_is_commanded(tmp_path, dictionary_path, capsys, content):
    for name in ("ground.port", "ground.mission", "ground.world", "live.port"):
        (tmp_path / name).write_bytes(content)
    with pytest.raises(LinkLost, match="ground.port: found '.*', expected a port from 1 to 65535; name the port of the flight with --port"):
        Place.of(tmp_path, dictionary=dictionary_path).check()
    assert main(["--run", str(tmp_path), "--dictionary", str(dictionary_path), "ping"]) == 3
    assert main(["--run", str(tmp_path), "pause"]) == 3
    assert "no live port" in capsys.readouterr().err


@pytest.fixture
def other(dictionary, dictionary_path):
    """Options of `gse` for a spacecraft that reports at each ping that another interface flies."""
    data = struct.pack(">BBBHQQII", 3, 0, 3, 1, 7, 0, 0, 0)
    craft = Spacecraft(lambda packet: success(packet, (17, 2, b"")) + [(MANIPULATOR, 129, 5, data, 0)] * 3, dictionary.epoch_ns)
    yield {"port": craft.port, "dictionary": dictionary_path}
    craft.close()


def test_the_shell_warns_once_of_another_interface(other, tmp_path):
    lines, shown = ["ping MANIPULATOR", "ping MANIPULATOR", "exit"], []
    with Client(tmp_path, timeout_s=600, **other) as craft:
        Shell(craft, lambda prompt: lines.pop(0), lambda text: shown.append(str(text))).run()
    assert sum("warning: MANIPULATOR flies interface 0x0000000000000007" in line for line in shown) == 1


def test_a_script_warns_once_of_another_interface(other, tmp_path, capsys):
    (tmp_path / "ping.scn").write_text("0 operator ping MANIPULATOR\n0 operator ping MANIPULATOR\n", encoding="utf-8")
    options = ["--port", str(other["port"]), "--dictionary", str(other["dictionary"])]
    assert main([*options, "script", str(tmp_path / "ping.scn")]) == 0
    assert capsys.readouterr().err.count("gse: warning: MANIPULATOR flies interface") == 1


def test_a_warning_ends_when_the_interface_of_the_dictionary_flies(dictionary):
    """The dictionary has the same interface again after `make` and a new start of the subsystem."""
    own = dictionary.subsystem("MANIPULATOR").interface_hash
    flown = Session(dictionary)
    for interface, count in ((own ^ 1, 1), (own, 0)):
        flown.feed(build_tm(MANIPULATOR, 0, 129, 5, struct.pack(">BBBHQQII", 3, 0, 3, 1, interface, 0, 0, 0)))
        assert len(flown.mismatches) == count


def test_a_file_on_a_full_disk_keeps_its_old_content(tmp_path):
    path = tmp_path / "run.mcap"
    path.write_bytes(b"old")
    (tmp_path / "run.mcap.part").symlink_to("/dev/full")
    with pytest.raises(OSError) as problem:
        files.write_whole(path, lambda stream: stream.write(b"new"))
    assert (problem.value.errno, problem.value.filename) == (errno.ENOSPC, str(path))
    assert path.read_bytes() == b"old" and [one.name for one in tmp_path.iterdir()] == ["run.mcap"]
    files.write_whole(path, lambda stream: stream.write(b"new"))
    assert path.read_bytes() == b"new"


def test_a_device_is_written_and_not_replaced(tmp_path):
    path = tmp_path / "null"
    path.symlink_to("/dev/null")
    files.write_whole(path, lambda stream: stream.write(b"new"))
    assert path.is_symlink()


def test_ctrl_c_leaves_no_part_of_a_file(tmp_path):
    def interrupted(stream):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        files.write_whole(tmp_path / "run.mcap", interrupted)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [["--http-port", "99999"], ["--http-port", "-1"], ["--http-port", "x"]])
def test_a_port_of_the_page_that_does_not_exist_is_refused(capsys, words):
    assert main(["replay", *words]) == 2 and "expected a port" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        station_main.main(words)
    assert "expected a port from 0 to 65535" in capsys.readouterr().err


def test_a_port_that_another_station_has_is_named():
    listener = station_main._listen(0)
    port = listener.getsockname()[1]
    with listener, pytest.raises(SystemExit, match=f"port {port} of this machine: Address already in use; is another station there"):
        station_main._listen(port)
