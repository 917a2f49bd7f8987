# SPDX-License-Identifier: Apache-2.0
"""Create the kernel and initial file system of the micro-VM in build/vm/: `vmlinux` and `initramfs.cpio`.

The kernel is from the package on which Debian's `linux-image-amd64` depends, fetched with apt-get, cached for other clones of the
user, unpacked in part and never installed. Needs the packages of the level `hil` in gse/setup/packages.txt. Without a network and
a cached package, or on a machine other than an amd64 Debian, it ends with a message that names the next step."""

import argparse
import contextlib
import lzma
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
DIRECTORY = ROOT / "build" / "vm"
DEPMOD = ["/sbin/depmod", "--basedir"]
PACKAGE = "linux-image-amd64"
XZ_MAGIC = b"\xfd7zXZ\x00"

# Modules that init.sh loads at boot, and modules that the guest can load later; each with its dependencies.
AT_BOOT = ["virtio_pci", "9pnet_virtio", "9p", "overlay", "can", "can-raw", "vcan", "vxcan", "tipc"]
ON_DEMAND = ["virtio_console", "can-gw", "can-bcm", "can-isotp", "can-dev", "kvaser_pci", "veth", "dummy", "sch_netem",
             "udp_tunnel", "ip6_udp_tunnel", "gcm", "ghash-generic", "ctr", "cmac"]
LISTINGS = ["modules.builtin", "modules.builtin.modinfo", "modules.order"]
# Files of the package that are unpacked.
UNPACKED = re.compile(r"\./(boot/vmlinuz-[^/]+|lib/modules/[^/]+/(modules\.(builtin|builtin\.modinfo|order)|"
                      r"kernel/(net|lib|crypto|fs/(9p|overlayfs|netfs|fscache)|drivers/(virtio|net/can|char))/.*\.ko|"
                      r"kernel/drivers/net/(veth|dummy)\.ko))$")


class Unavailable(Exception):
    """A part of the micro-VM is not available; the text names the next step."""


def kernel_package():
    """Name of the package with the kernel that PACKAGE points to now."""
    shown = subprocess.run(["apt-cache", "show", "--no-all-versions", PACKAGE], capture_output=True, text=True)
    found = re.search(r"^Depends:.*?\b(linux-image-[0-9][^ ,]*)", shown.stdout, re.MULTILINE)
    return found[1] if found else None


def update_lists():
    """Update the package lists, if this user may."""
    as_root = [] if os.geteuid() == 0 else ["sudo", "-n"]
    try:
        subprocess.run([*as_root, "apt-get", "update", "-qq"], stdin=subprocess.DEVNULL)
    except FileNotFoundError:
        pass


def cache():
    return pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "hirosco"


def keep(package, cached):
    """Move a package into the cache, whole or not at all; returns its path, unchanged if there is no place for a cache."""
    part = cached.with_suffix(f".{os.getpid()}")
    try:
        part.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(package, part)
        return part.replace(cached)
    except OSError:
        with contextlib.suppress(OSError):
            part.unlink()
        return package


def fetch(directory):
    """Path of the kernel's package: in the cache, or in the directory if there is no place for a cache. Without package lists, any
    cached kernel is used."""
    for last in (False, True):
        name = kernel_package()
        cached = sorted(cache().glob(f"{name or 'linux-image-*'}.deb"))
        if cached:
            return cached[-1]
        if name:
            print(f"setup: fetching {name} (70 MB, unpacked in part, not installed)", flush=True)
            got = subprocess.run(["apt-get", "-qq", "-o", "APT::Sandbox::User=root", "download", name], cwd=directory,
                                 capture_output=True, text=True)
            files = list(directory.glob("*.deb"))
            if got.returncode == 0 and files:
                return keep(files[0], cache() / f"{name}.deb")
        if not last:
            update_lists()
    reason = got.stderr.strip() if name else f"the package lists do not know {PACKAGE}"
    raise Unavailable(f"the kernel of the micro-VM cannot be fetched: {reason}\n"
                      "With a network and Debian's package lists (sudo apt-get update), run again: make build/setup/vm")


def unpack(package, directory):
    """Unpack the needed part of the package; returns (compressed kernel, version)."""
    with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", package], stdout=subprocess.PIPE) as tar:
        with tarfile.open(fileobj=tar.stdout, mode="r|") as archive:
            for member in archive:
                if UNPACKED.match(member.name):
                    archive.extract(member, directory)
    kernels = sorted((directory / "boot").glob("vmlinuz-*"))
    if not kernels:
        raise Unavailable(f"{package.name} contains no boot/vmlinuz; remove build/vm and run again: make build/setup/vm")
    return kernels[0], kernels[0].name.removeprefix("vmlinuz-")


def uncompressed(kernel):
    """The kernel as an ELF file, which boots several seconds sooner under emulation; unchanged if it is not compressed with xz."""
    octets = kernel.read_bytes()
    at = octets.find(XZ_MAGIC)
    while at >= 0:
        try:
            image = lzma.LZMADecompressor().decompress(octets[at:])
            if image.startswith(b"\x7fELF"):
                return image
        except lzma.LZMAError:
            pass  # These octets equal the magic number by chance.
        at = octets.find(XZ_MAGIC, at + 1)
    return octets


def dependencies(modules, wanted):
    """Paths of the wanted modules and of their dependencies, without those built into the kernel."""
    subprocess.run([*DEPMOD, modules.parents[2], modules.name], check=True)
    needs, path_of = {}, {}
    for line in (modules / "modules.dep").read_text().splitlines():
        path, _, others = line.partition(":")
        needs[path] = others.split()
        path_of[pathlib.Path(path).stem.replace("-", "_")] = path
    built_in = {pathlib.Path(line).stem.replace("-", "_") for line in (modules / "modules.builtin").read_text().split()}
    paths = set()
    for name in (name.replace("-", "_") for name in wanted):
        if name in built_in:
            continue
        if name not in path_of:
            raise Unavailable(f"the kernel {modules.name} has no module {name}, which the micro-VM needs: make the newest {PACKAGE} available to "
                              "apt-get, then run: rm -rf build/vm && make build/setup/vm")
        paths |= {path_of[name], *needs[path_of[name]]}  # modules.dep lists the whole chain
    return sorted(paths)


def make_initramfs(modules, target, at_boot=AT_BOOT):
    """Write the initial file system: busybox, init.sh, the modules. `at_boot`: the modules that init.sh loads."""
    busybox = shutil.which("busybox", path="/usr/bin:/bin")
    if not busybox:
        raise Unavailable("there is no busybox; install the package busybox-static, then run again: make build/setup/vm")
    with tempfile.TemporaryDirectory(dir=target.parent) as name:
        tree = pathlib.Path(name)
        kept = tree / "lib" / "modules" / modules.name
        for directory in ("bin", "sbin", "proc", "sys", "dev", "control", "host", "over", "guest"):
            (tree / directory).mkdir()
        shutil.copy(busybox, tree / "bin" / "busybox")
        for applet in subprocess.run([busybox, "--list"], capture_output=True, text=True, check=True).stdout.split():
            if applet != "busybox":
                (tree / "bin" / applet).symlink_to("busybox")
        (tree / "sbin" / "modprobe").symlink_to("/bin/busybox")  # The kernel calls it for modules that are loaded on demand.
        for path in dependencies(modules, [*at_boot, *ON_DEMAND]):
            (kept / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(modules / path, kept / path)
        for listing in LISTINGS:
            shutil.copy(modules / listing, kept)
        subprocess.run([*DEPMOD, tree, modules.name], check=True)
        (tree / "modules-at-boot").write_text(" ".join(at_boot))
        shutil.copy(pathlib.Path(__file__).parent / "init.sh", tree / "init")
        (tree / "init").chmod(0o755)
        names = "\0".join(sorted(str(path.relative_to(tree)) for path in tree.rglob("*")))
        with open(target, "wb") as archive:
            subprocess.run(["cpio", "--null", "--create", "--format=newc", "--owner=0:0", "--quiet"], cwd=tree,
                           input=names.encode(), stdout=archive, check=True)


def prepare(directory=DIRECTORY):
    """Create kernel, modules and initial file system in the directory; the kernel is fetched once."""
    machine = os.uname().machine
    if machine != "x86_64":
        raise Unavailable(f"the micro-VM runs the programs of this machine on a kernel for amd64; this machine is {machine}")
    directory.mkdir(parents=True, exist_ok=True)
    if not (directory / "vmlinux").is_file():
        with tempfile.TemporaryDirectory(dir=directory) as name:
            work = pathlib.Path(name)
            kernel, version = unpack(fetch(work), work)
            modules = work / "lib" / "modules" / version
            make_initramfs(modules, work / "initramfs.cpio")  # Missing modules of this kernel are reported before anything is kept.
            shutil.rmtree(directory / "lib", ignore_errors=True)
            for path in dependencies(modules, [*AT_BOOT, *ON_DEMAND]):
                kept = directory / "lib" / "modules" / version / path
                kept.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(modules / path, kept)
            for listing in LISTINGS:
                shutil.copy(modules / listing, directory / "lib" / "modules" / version)
            (work / "vmlinux").write_bytes(uncompressed(kernel))
            (work / "vmlinux").rename(directory / "vmlinux")
    make_initramfs(modules_of(directory), directory / "initramfs.cpio")


def modules_of(directory):
    """The directory with the modules of the prepared kernel."""
    return next((directory / "lib" / "modules").iterdir())


def main():
    argparse.ArgumentParser(description=__doc__).parse_args()
    try:
        prepare()
    except Unavailable as reason:
        print(f"setup: {reason}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
