# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the ground segment's tests: the dictionary made from the descriptors, and a synthetic flight."""

import functools
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path[:0] = [str(ROOT / "gse"), str(ROOT / "test" / "support")]
sys.path.insert(0, str(pathlib.Path(__file__).parent))

import synthetic
from hirosco_gse import run_directory
from hirosco_gse.dictionary import Dictionary
from spacecraft import Spacecraft
from visiting import answer, begin


@pytest.fixture(scope="session")
def dictionary_path_of(tmp_path_factory):
    """A function that returns the path of the dictionary of a mission, newly made from the descriptors."""

    @functools.cache
    def make(name):
        out = tmp_path_factory.mktemp("generated")
        generator = ROOT / "gse" / "generator" / "generate.py"
        mission = ROOT / "descriptors" / "missions" / f"{name}.xml"
        subprocess.run([sys.executable, generator, "--mission", mission, "--out", out], check=True, cwd=ROOT)
        return out / f"{name}.json"

    return make


@pytest.fixture(scope="session")
def dictionary_path(dictionary_path_of):
    """Path of the dictionary of rokviss."""
    return dictionary_path_of("rokviss")


@pytest.fixture
def dictionary(dictionary_path):
    """The dictionary of rokviss, loaded."""
    return Dictionary.load(dictionary_path)


@pytest.fixture(scope="session")
def flight_directory(tmp_path_factory, dictionary_path):
    """Directory with the raw logs of a synthetic flight with known figures."""
    directory = tmp_path_factory.mktemp("flight")
    synthetic.write(directory, Dictionary.load(dictionary_path))
    return directory


@pytest.fixture
def spacecraft():
    """A simulated spacecraft that answers as `visiting.answer`."""
    made = Spacecraft(answer)
    yield made
    made.close()


@pytest.fixture
def place(tmp_path, spacecraft, dictionary_path, monkeypatch):
    """Directory of the flights, in which `latest` is a link to the flight `first`, and of the station's page."""
    monkeypatch.setattr(run_directory, "default_dictionary", lambda run: dictionary_path)
    begin(tmp_path, "first", spacecraft.port)
    (tmp_path / "page").mkdir()
    (tmp_path / "page" / "index.html").write_text("<title>page</title>")
    return tmp_path
