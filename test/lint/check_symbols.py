# SPDX-License-Identifier: Apache-2.0
"""Check the object files of the flight side with nm: the functions they call and the data they keep.

No flight object calls an allocator, the printf family, longjmp or functions that would open Lua's sandbox;
outside osal/ none calls a function of the mathematical library whose last bit depends on the machine; outside
osal/, fsw/programs/ and launcher/ none keeps mutable data. Arguments: object files below build/obj/. Prints
each breach; exit code 1."""

import re
import subprocess
import sys

ALLOCATORS = "malloc calloc realloc reallocarray free aligned_alloc posix_memalign strdup strndup getline asprintf"
PRINTERS = "printf fprintf sprintf snprintf dprintf vprintf vfprintf vsprintf vsnprintf vdprintf puts fputs putchar"
JUMPS = "setjmp _setjmp __sigsetjmp sigsetjmp longjmp _longjmp siglongjmp"
# Functions that would give a procedure memory of the heap, files, other code, or varying results.
OPENERS = "luaL_newstate luaL_openlibs luaL_loadfilex luaopen_io luaopen_os luaopen_package luaopen_debug luaopen_coroutine luaopen_utf8"
BANNED = set(f"{ALLOCATORS} {PRINTERS} {JUMPS} {OPENERS}".split())
INEXACT = re.compile(r"(a?(sin|cos|tan)h?|sincos|atan2|exp[2m1]*|log(10|2|1p)?|pow|hypot|cbrt|tgamma|lgamma|erfc?)[fl]?")
# expat's memory functions know no context, so the arena in use is named by a thread-local pointer around each call.
DEVIATIONS = {("fsw/framework/xml/xml_arena.c", "in_use")}
MUTABLE = re.compile(r"(\.data(?!\.rel\.ro)|\.bss|\.tdata|\.tbss|COM).*")


def symbols(objects):
    """(source path, symbol, section) of each line of nm; an undefined symbol has section *UND*."""
    listing = subprocess.run(["nm", "-A", "--format=sysv", *objects], capture_output=True, text=True, check=True)
    for line in listing.stdout.splitlines():
        fields = line.split("|")
        if len(fields) == 7:
            path, _, name = fields[0].strip().rpartition(":")
            yield path.replace("build/obj/", "").replace(".o", ".c"), name, fields[6].strip()


def breach(path, name, section):
    """Description of a forbidden symbol, or None."""
    if section == "*UND*" and name in BANNED:
        return f"{path}: calls {name}"
    if section == "*UND*" and INEXACT.fullmatch(name) and not path.startswith("osal/"):
        return f"{path}: calls {name}, whose result depends on the machine"
    if MUTABLE.fullmatch(section) and not path.startswith(("osal/", "fsw/programs/", "launcher/")) and (path, name) not in DEVIATIONS:
        return f"{path}: {name} is mutable data ({section})"
    return None


def main():
    objects = sys.argv[1:]
    failures = [text for text in (breach(*entry) for entry in symbols(objects)) if text] if objects else []
    print("\n".join(failures) if failures else f"check: no allocator, printf, jump or mutable global in {len(objects)} objects")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
