# SPDX-License-Identifier: Apache-2.0
"""How Unity is fetched: pinned by its checksum, cached, whole or not at all. The package client is played by a script."""

import hashlib
import os
import pathlib
import re
import subprocess
import tarfile

import pytest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "gse" / "setup" / "unity.sh"
CLIENT = """#!/bin/sh
echo "$@" >>"$CALLS"
case "$*" in *update*) exit 0 ;; esac
[ -f "$ARCHIVE" ] && cp "$ARCHIVE" cjson_1.0.orig.tar.gz
"""


@pytest.fixture
def machine(tmp_path):
    """A machine with a package client, and an archive that the script is pinned to."""
    source = tmp_path / "cJSON-1.0" / "tests" / "unity"
    for name, text in (("src/unity.c", "int unity;\n"), ("docs/license.txt", "MIT\n"), ("examples/unity_config.h", "\n")):
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_text(text)
    with tarfile.open(tmp_path / "archive.tar.gz", "w:gz") as archive:
        archive.add(tmp_path / "cJSON-1.0", "cJSON-1.0")
    pinned = hashlib.sha256((tmp_path / "archive.tar.gz").read_bytes()).hexdigest()
    text, count = re.subn(r"(?m)^archive_sha256=[0-9a-f]{64}$", f"archive_sha256={pinned}", SCRIPT.read_text(encoding="utf-8"))
    assert count == 1, "the archive is pinned once"
    (tmp_path / "unity.sh").write_text(text)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "apt-get").write_text(CLIENT)
    (tmp_path / "bin" / "apt-get").chmod(0o755)
    return tmp_path


def fetch(machine, clone, archive="archive.tar.gz", cache="cache"):
    """Run the script in a clone; (finished process, calls of the package client so far)."""
    (machine / clone).mkdir(exist_ok=True)
    environment = {"PATH": f"{machine / 'bin'}:{os.environ['PATH']}", "XDG_CACHE_HOME": str(machine / cache), "HOME": str(machine),
                   "CALLS": str(machine / "calls"), "ARCHIVE": str(machine / archive)}
    done = subprocess.run(["sh", machine / "unity.sh"], cwd=machine / clone, env=environment, capture_output=True, text=True, check=False)
    calls = machine / "calls"
    return done, len(calls.read_text().splitlines()) if calls.exists() else 0


def installed(machine, clone):
    """Files of Unity in a clone."""
    place = machine / clone / "build" / "third_party" / "unity"
    return sorted(str(path.relative_to(place)) for path in place.rglob("*") if path.is_file())


WHOLE = ["examples/unity_config.h", "license.txt", "src/unity.c"]


def test_fetched_once_for_all_clones(machine):
    done, calls = fetch(machine, "one")
    assert (done.returncode, calls, installed(machine, "one")) == (0, 2, WHOLE), done.stderr
    assert [path.name for path in (machine / "one" / "build" / "third_party").iterdir()] == ["unity"]
    assert fetch(machine, "one")[1] == 2, "what is there is not fetched again"
    done, calls = fetch(machine, "two", archive="no network")
    assert (done.returncode, calls, installed(machine, "two")) == (0, 2, WHOLE), done.stderr


def test_damaged_cache_is_fetched_anew(machine):
    fetch(machine, "one")
    (cached,) = (machine / "cache" / "hirosco").iterdir()
    whole = cached.read_bytes()
    cached.write_bytes(whole[:-1])
    done, calls = fetch(machine, "two")
    assert (done.returncode, calls, installed(machine, "two")) == (0, 4, WHOLE), done.stderr
    assert cached.read_bytes() == whole


def test_another_archive_is_refused_and_not_cached(machine):
    (machine / "other.tar.gz").write_bytes((machine / "archive.tar.gz").read_bytes() + b"\0")
    done, _ = fetch(machine, "one", archive="other.tar.gz")
    assert done.returncode == 1 and "is not the pinned archive" in done.stderr
    assert installed(machine, "one") == [] and not (machine / "cache").exists()


def test_no_network_is_said(machine):
    done, _ = fetch(machine, "one", archive="no network")
    assert done.returncode == 1 and "cannot be fetched" in done.stderr
    assert installed(machine, "one") == []


def test_place_without_a_cache_serves_all_the_same(machine):
    (machine / "file").write_text("")
    done, _ = fetch(machine, "one", cache="file")
    assert (done.returncode, installed(machine, "one")) == (0, WHOLE), done.stderr
