# SPDX-License-Identifier: Apache-2.0
"""Text (code and constants) of the framework and of the packet services on x86-64, by library, compiled with -Os and
without tables for unwinding. Baseline of the sum: what it may be."""

import pathlib
import subprocess
import sys

FLAGS = "-std=c99 -D_POSIX_C_SOURCE=200809L -I. -Ibuild -Os -ffp-contract=off -fno-asynchronous-unwind-tables".split()
OUT = pathlib.Path("build/size")
ALLOWED = 90000


def text_of(source):
    """Octets of text of one source file."""
    target = OUT / f"{str(source).replace('/', '_')}.o"
    subprocess.run(["gcc", *FLAGS, "-c", str(source), "-o", str(target)], check=True)
    lines = subprocess.run(["size", str(target)], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    return int(lines[1].split()[0])


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    folders = [folder for folder in sorted(pathlib.Path("fsw/framework").iterdir()) if folder.is_dir()]
    total = 0
    for folder in [*folders, pathlib.Path("pus")]:
        octets = sum(text_of(source) for source in sorted(folder.glob("*.c")))
        total += octets
        print(f"BENCH text_{folder.name} {octets} octets -")
    print(f"BENCH text_framework_and_pus {total} octets {ALLOWED}")


if __name__ == "__main__":
    sys.exit(main())
