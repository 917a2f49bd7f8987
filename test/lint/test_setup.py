# SPDX-License-Identifier: Apache-2.0
"""The setup caches fetched files for other clones and names everything that it cannot get. Unity is pinned by
its checksum and installed completely or not at all. In these tests a script replaces the package client, a
directory replaces the index of Python packages, and a local server replaces the registry of npm."""

import base64
import hashlib
import http.server
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import tarfile
import threading
import zipfile

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SETUP = ROOT / "gse" / "setup"
SCRIPT = SETUP / "unity.sh"
CLIENT = """#!/bin/sh
echo "$@" >>"$CALLS"
case "$*" in *update*) exit 0 ;; esac
[ -f "$ARCHIVE" ] && cp "$ARCHIVE" cjson_1.0.orig.tar.gz
"""


@pytest.fixture
def machine(tmp_path):
    """A machine with a package client, and an archive with the checksum that the script requires."""
    source = tmp_path / "cJSON-1.0" / "tests" / "unity"
    for name, text in (("src/unity.c", "int unity;\n"), ("docs/license.txt", "MIT\n"), ("examples/unity_config.h", "\n")):
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_text(text)
    with tarfile.open(tmp_path / "archive.tar.gz", "w:gz") as archive:
        archive.add(tmp_path / "cJSON-1.0", "cJSON-1.0")
    pinned = hashlib.sha256((tmp_path / "archive.tar.gz").read_bytes()).hexdigest()
    text, count = re.subn(r"(?m)^archive_sha256=[0-9a-f]{64}$", f"archive_sha256={pinned}", SCRIPT.read_text(encoding="utf-8"))
    assert count == 1, "expected the archive to be pinned once"
    (tmp_path / "unity.sh").write_text(text)
    shutil.copy(SETUP / "debian_source.sh", tmp_path)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "apt-get").write_text(CLIENT)
    (tmp_path / "bin" / "apt-get").chmod(0o755)
    return tmp_path


def fetch(machine, clone, archive="archive.tar.gz", cache="cache"):
    """Run the script in a clone. Returns (finished process, calls of the package client so far)."""
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


def test_unity_is_fetched_once_for_all_clones(machine):
    done, calls = fetch(machine, "one")
    assert (done.returncode, calls, installed(machine, "one")) == (0, 2, WHOLE), done.stderr
    assert [path.name for path in (machine / "one" / "build" / "third_party").iterdir()] == ["unity"]
    assert fetch(machine, "one")[1] == 2, "expected no second fetch of an existing file"
    done, calls = fetch(machine, "two", archive="no network")
    assert (done.returncode, calls, installed(machine, "two")) == (0, 2, WHOLE), done.stderr


def test_a_damaged_cache_is_fetched_again(machine):
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


def test_a_missing_network_is_reported(machine):
    done, _ = fetch(machine, "one", archive="no network")
    assert done.returncode == 1 and "cannot be fetched" in done.stderr
    assert installed(machine, "one") == []


def test_unity_is_installed_without_a_place_for_a_cache(machine):
    (machine / "file").write_text("")
    done, _ = fetch(machine, "one", cache="file")
    assert (done.returncode, installed(machine, "one")) == (0, WHOLE), done.stderr


def publish(index, name, version):
    """Put a wheel of one empty module into a directory that serves as a package index."""
    project = index / name.replace("_", "-")
    project.mkdir(parents=True, exist_ok=True)
    wheel = project / f"{name}-{version}-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        information = f"{name}-{version}.dist-info"
        archive.writestr(f"{name}.py", "")
        archive.writestr(f"{information}/METADATA", f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
        archive.writestr(f"{information}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        archive.writestr(f"{information}/RECORD", "")
    (project / "index.html").write_text("".join(f'<a href="{path.name}">{path.name}</a>' for path in project.glob("*.whl")))


@pytest.fixture(scope="module")
def fresh_venv(tmp_path_factory):
    """An environment with pip only, which tests copy because making one takes seconds."""
    place = tmp_path_factory.mktemp("fresh") / "venv"
    subprocess.run(["/usr/bin/python3", "-m", "venv", place], check=True)
    return place


@pytest.fixture
def index(tmp_path):
    publish(tmp_path / "index", "one_part", "1.0")
    publish(tmp_path / "index", "other", "2.0")
    (tmp_path / "list.txt").write_text("# A comment.\none-part==1.0\nother==2.0\n")
    return tmp_path


def clone(place, fresh_venv):
    (place / "build" / "setup").mkdir(parents=True)
    shutil.copytree(fresh_venv, place / "build" / "venv", symlinks=True)
    return place


def environment_of(place, cache="cache", index="index"):
    """Environment of a script: the index is a directory; without the directory there is no network."""
    return {"PATH": f"{place / 'bin'}:{os.environ['PATH']}", "XDG_CACHE_HOME": str(place / cache), "HOME": str(place), "CALLS": str(place / "calls"),
            "ARCHIVE": str(place / "archive"), "PIP_INDEX_URL": f"file://{place / index}", "PIP_CONFIG_FILE": "/dev/null"}


def install(place, where, **how):
    done = subprocess.run(["sh", SETUP / "python.sh", place / "list.txt"], cwd=where, env=environment_of(place, **how), capture_output=True,
                          text=True, check=False)
    modules = {path.stem for path in where.glob("build/venv/lib/*/site-packages/*.py")} & {"one_part", "other"}
    return done, modules


def test_python_packages_are_fetched_once_for_all_clones(index, fresh_venv):
    done, modules = install(index, clone(index / "a", fresh_venv))
    assert (done.returncode, modules) == (0, {"one_part", "other"}), done.stderr
    assert sorted(path.name for path in (index / "cache" / "hirosco" / "wheels").iterdir()) == [
        "one_part-1.0-py3-none-any.whl", "other-2.0-py3-none-any.whl"]
    done, modules = install(index, clone(index / "b", fresh_venv), index="no network")
    assert (done.returncode, modules) == (0, {"one_part", "other"}), done.stderr
    assert (index / "b" / "build" / "venv" / "bin" / "gse").stat().st_mode & 0o111


@pytest.mark.long
def test_installed_packages_are_cached_too_and_need_no_network(index, fresh_venv):
    place = clone(index / "a", fresh_venv)
    install(index, place)
    shutil.rmtree(index / "cache")
    done, modules = install(index, place, index="no network")
    assert (done.returncode, modules, done.stderr) == (0, {"one_part", "other"}, "")
    assert install(index, place)[0].returncode == 0
    done, modules = install(index, clone(index / "b", fresh_venv), index="no network")
    assert (done.returncode, modules) == (0, {"one_part", "other"}), done.stderr


@pytest.mark.long
def test_python_packages_that_cannot_be_fetched_are_named(index, fresh_venv):
    place = clone(index / "a", fresh_venv)
    done, modules = install(index, place, index="no network")
    assert (done.returncode, modules) == (1, set())
    assert re.findall(r"(?m)^    (\S+)$", done.stderr) == ["one-part==1.0", "other==2.0"]
    install(index, place)
    (index / "list.txt").write_text("one-part==1.0\nother==3.0\n")
    for where in (place, clone(index / "b", fresh_venv)):  # one-part is in the first clone, and in the cache for the second.
        done, _ = install(index, where, index="no network")
        assert done.returncode == 1 and re.findall(r"(?m)^    (\S+)$", done.stderr) == ["other==3.0"]
    publish(index / "index", "other", "3.0")
    assert install(index, place)[0].returncode == 0
    assert list(place.glob("build/venv/lib/*/site-packages/other-3.0.dist-info"))


@pytest.mark.long
def test_a_damaged_wheel_is_fetched_again(index, fresh_venv):
    install(index, clone(index / "a", fresh_venv))
    (cached,) = (index / "cache" / "hirosco" / "wheels").glob("other*")
    whole = cached.read_bytes()
    cached.write_bytes(whole[:-30])
    done, modules = install(index, clone(index / "b", fresh_venv))
    assert (done.returncode, modules, cached.read_bytes()) == (0, {"one_part", "other"}, whole), done.stderr


def test_python_packages_are_installed_without_a_place_for_a_cache(index, fresh_venv):
    (index / "file").write_text("")
    done, modules = install(index, clone(index / "a", fresh_venv), cache="file")
    assert (done.returncode, modules) == (0, {"one_part", "other"}), done.stderr


class Registry(http.server.BaseHTTPRequestHandler):
    """A server of npm packages. It answers the paths in `served`; every other request fails with status 503."""

    served, asked = {}, []

    def do_GET(self):
        self.asked.append(self.path)
        content = self.served.get(self.path)
        self.send_response(503 if content is None else 200)
        self.send_header("Content-Length", str(len(content or b"")))
        self.end_headers()
        self.wfile.write(content or b"")

    def log_message(self, *words):
        pass


def npm_package(name):
    """(archive, checksum) of a package of one empty module."""
    octets = io.BytesIO()
    with tarfile.open(fileobj=octets, mode="w:gz") as archive:
        for path, text in (("package/package.json", json.dumps({"name": name, "version": "1.0.0"})), ("package/index.js", "")):
            entry = tarfile.TarInfo(path)
            entry.size = len(text)
            archive.addfile(entry, io.BytesIO(text.encode()))
    return octets.getvalue(), "sha512-" + base64.b64encode(hashlib.sha512(octets.getvalue()).digest()).decode()


@pytest.fixture
def registry(tmp_path):
    """A server with two packages, and a lock file that names them and one for another operating system."""
    Registry.served, Registry.asked = {}, []
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Registry)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"http://127.0.0.1:{server.server_port}"
    packages = {"": {"name": "page", "dependencies": {"one": "1.0.0", "two": "1.0.0"}, "optionalDependencies": {"three": "1.0.0"}}}
    for name in ("one", "two", "three"):
        archive, checksum = npm_package(name)
        about = {"name": name, "version": "1.0.0", "dist": {"tarball": f"{address}/{name}.tgz", "integrity": checksum}}
        Registry.served[f"/{name}"] = json.dumps({"name": name, "dist-tags": {"latest": "1.0.0"}, "versions": {"1.0.0": about}}).encode()
        Registry.served[f"/{name}.tgz"] = archive
        packages[f"node_modules/{name}"] = {"version": "1.0.0", "integrity": checksum}
    packages["node_modules/three"] |= {"optional": True, "os": ["plan9"]}
    (tmp_path / "package.json").write_text(json.dumps(packages[""]))
    (tmp_path / "package-lock.json").write_text(json.dumps({"name": "page", "lockfileVersion": 3, "requires": True, "packages": packages}))
    yield tmp_path, address
    server.shutdown()
    server.server_close()


def install_page(registry, clone):
    """Install the packages of the page in a clone. Returns (finished process, names of the installed
    packages)."""
    place, address = registry
    (place / clone / "gse" / "page").mkdir(parents=True, exist_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copy(place / name, place / clone / "gse" / "page" / name)
    environment = {"PATH": os.environ["PATH"], "HOME": str(place), "XDG_CACHE_HOME": str(place / "cache"), "NPM_CONFIG_REGISTRY": address}
    done = subprocess.run(["sh", SETUP / "station.sh"], cwd=place / clone, env=environment, capture_output=True, text=True, check=False)
    return done, sorted(path.name for path in (place / clone / "build" / "station" / "node_modules").glob("[a-z]*"))


def cached_page(registry):
    (archive,) = (registry[0] / "cache" / "hirosco").iterdir()
    return archive


def test_packages_of_the_page_are_fetched_once_for_all_clones(registry):
    done, names = install_page(registry, "a")
    assert (done.returncode, names) == (0, ["one", "two"]), done.stderr
    asked = len(Registry.asked)
    Registry.served = {}
    for clone in "ba":
        done, names = install_page(registry, clone)
        assert (done.returncode, names, done.stderr, len(Registry.asked)) == (0, ["one", "two"], "", asked)


def test_packages_of_the_page_that_cannot_be_fetched_are_named_at_once(registry):
    whole = Registry.served.pop("/two.tgz")
    done, names = install_page(registry, "a")
    assert (done.returncode, names) == (1, []) and "is there a network?" in done.stderr
    assert re.findall(r"(?m)^    (\S+)$", done.stderr) == ["one==1.0.0", "two==1.0.0"]
    assert Registry.asked.count("/two.tgz") == 1, "expected one attempt to fetch"
    Registry.served["/two.tgz"] = whole
    done, names = install_page(registry, "a")
    assert (done.returncode, names) == (0, ["one", "two"]), done.stderr


def test_a_damaged_archive_of_the_page_is_fetched_again(registry):
    install_page(registry, "a")
    archive = cached_page(registry)
    whole = archive.read_bytes()
    archive.write_bytes(whole[:-9])
    done, names = install_page(registry, "b")
    assert (done.returncode, names) == (0, ["one", "two"]), done.stderr
    # Times in the new archive may change its size by a few octets; the damaged one was 9 octets shorter.
    assert len(cached_page(registry).read_bytes()) >= len(whole) - 8


def test_an_archive_is_not_used_for_another_lock_file(registry):
    install_page(registry, "a")
    lock = registry[0] / "package-lock.json"
    lock.write_text(lock.read_text() + "\n")
    Registry.served = {}
    shutil.rmtree(registry[0] / ".npm", ignore_errors=True)  # The cache of npm itself.
    assert install_page(registry, "b")[0].returncode == 1


def script(path, text):
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


def test_everything_missing_is_reported_at_once(index, fresh_venv):
    """Packages of the machine, of Python, and Unity are missing: the setup does not stop at the first one and
    leaves no stamp."""
    place = clone(index / "a", fresh_venv)
    shutil.copytree(ROOT / "gse" / "setup", place / "gse" / "setup")
    (place / "test").mkdir()
    for directory in ("gse", "test"):
        shutil.copy(index / "list.txt", place / directory / "requirements.txt")
    script(index / "bin" / "dpkg-query", '[ "$4" = libcmocka-dev ] || echo installed')
    script(index / "bin" / "apt-get", "exit 100")
    script(index / "bin" / "sudo", 'shift; exec "$@"')
    done = subprocess.run(["sh", "gse/setup/setup.sh", "pytest"], cwd=place, env=environment_of(index, index="no network"), capture_output=True,
                          text=True, check=False)
    assert done.returncode == 1
    for said in ("install --no-install-recommends -y libcmocka-dev \n", "    other==2.0\n", "which contains Unity, cannot be fetched", "make setup"):
        assert said in done.stderr, done.stderr
    assert not {"build", "run", "unit", "pytest"} & {path.name for path in (place / "build" / "setup").iterdir()}


@pytest.mark.parametrize("installed, asked, said", [
    ("15:12.2.rel1-1", None, None),
    ("15:13.2.rel1-2", None, "setup: gcc-arm-none-eabi has version 15:13.2.rel1-2, 15:12.2.rel1* is pinned: measured figures may differ"),
    (None, "install --no-install-recommends -y gcc-arm-none-eabi=15:12.2.rel1* \n", None)])
def test_pinned_debian_packages_are_installed_by_version_and_others_are_named(tmp_path, installed, asked, said):
    """The versions of kernel, compiler, C library and emulator of a board are pinned. Of the installed packages, the setup prints those
    with another version."""
    shutil.copytree(SETUP, tmp_path / "gse" / "setup")
    fetches = ("unity.sh", "expat_source.sh", "freertos.sh", "littlefs.sh")
    for name in fetches:
        (tmp_path / "gse/setup" / name).write_text("exit 0\n")
    script(tmp_path / "bin" / "dpkg-query", f'''case "$4" in gcc-arm-none-eabi) echo "{f'installed {installed}' if installed else ''}" ;;
        libnewlib-arm-none-eabi) echo 'installed 3.3.0-1' ;; qemu-system-arm) echo 'installed 1:7.2+x' ;; *) echo 'installed 1' ;; esac''')
    script(tmp_path / "bin" / "apt-get", "exit 100")
    script(tmp_path / "bin" / "sudo", 'shift; exec "$@"')
    environment = dict(os.environ, PATH=f"{tmp_path / 'bin'}:{os.environ['PATH']}")
    done = subprocess.run(["sh", "gse/setup/setup.sh", "rtos"], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == (1 if asked else 0), done.stderr
    assert [line for line in done.stderr.splitlines() if "pinned" in line] == ([said] if said else [])
    assert (asked or "") in done.stderr


EXPAT = ["usr/include/expat.h", "usr/include/expat_external.h", "usr/include/s390x-linux-gnu/expat_config.h",
         "usr/share/doc/libexpat1-dev/copyright", "usr/lib/s390x-linux-gnu/libexpat.a"]


def test_s390x_expat_is_fetched_once_for_all_clones(tmp_path):
    for name in EXPAT:
        (tmp_path / "package" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "package" / name).write_text(name)
    (tmp_path / "package" / "DEBIAN").mkdir()
    (tmp_path / "package" / "DEBIAN" / "control").write_text(
        "Package: libexpat1-dev\nVersion: 1\nArchitecture: s390x\nMaintainer: a <a@example.org>\nDescription: a\n")
    subprocess.run(["dpkg-deb", "--build", tmp_path / "package", tmp_path / "archive"], check=True, stdout=subprocess.DEVNULL)
    script(tmp_path / "bin" / "apt-get", 'case "$*" in *download*) cp "$ARCHIVE" libexpat1-dev_1_s390x.deb ;; esac')

    def fetch_expat(where):
        (tmp_path / where).mkdir()
        done = subprocess.run(["sh", SETUP / "expat_s390x.sh"], cwd=tmp_path / where, env=environment_of(tmp_path), capture_output=True,
                              text=True, check=False)
        return done, (tmp_path / where / "build" / "third_party" / "expat-s390x" / "lib" / "libexpat.a").exists()

    done, is_there = fetch_expat("a")
    assert (done.returncode, is_there) == (0, True), done.stderr
    cached = tmp_path / "cache" / "hirosco" / "libexpat1-dev_s390x.deb"
    cached.write_bytes(cached.read_bytes()[:200])
    done, is_there = fetch_expat("b")
    assert (done.returncode, is_there) == (0, True), "expected a damaged package to be fetched again: " + done.stderr
    (tmp_path / "archive").unlink()
    done, is_there = fetch_expat("c")
    assert (done.returncode, is_there) == (0, True), done.stderr
    cached.unlink()
    done, is_there = fetch_expat("d")
    assert (done.returncode, is_there) == (1, False) and "libexpat1-dev of s390x cannot be fetched" in done.stderr
