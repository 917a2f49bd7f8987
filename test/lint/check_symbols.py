# SPDX-License-Identifier: Apache-2.0
"""Check the object files of the flight software with nm: the functions they call and the data they keep.

No flight object calls an allocator, the printf family, longjmp or functions that would open Lua's sandbox;
outside osal/ none calls a function of the mathematical library whose last bit depends on the machine; outside
osal/, fsw/programs/ and launcher/ none keeps mutable data; each global symbol begins with a prefix of its library.
Arguments: object files below build/obj/. Prints each breach; exit code 1."""

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
# The memory functions of expat have no context argument; a thread-local pointer therefore gives them the arena during
# each call.
DEVIATIONS = {("fsw/framework/xml/xml_arena.c", "in_use")}
# Prefixes of the global symbols of each directory; a directory that is not listed has its own name as prefix.
PREFIXES = {
    "base": "crc16 crc32 fnv64 number octet pool quota resource status text value",
    "osal/common": "osal can lockstep",
    "osal/posix": "osal can lockstep socket object_name fsw_assertion",
    "pus/core": "pus packet schedule",
    "pus/private": "pus link",
    "pus/st03": "pus hk",
    "pus/st06": "pus memory",
    "pus/st12": "pus monitoring",
    "pus/st15": "pus st15",
    "pus/st18": "pus procedures",
    "pus/st19": "pus event_action",
    "pus/st21": "pus sequences",
    "pus/st23": "pus st23",
    "pus": "pus",
    "fsw/devices": "stream",
    "fsw/framework/dataflow": "flow",
    "fsw/procedures": "procedure",
    "fsw/programs": "compiled_descriptors component descriptor_files executive file ground_key loop_tasks record_store remote_endian run store_files subsystem_host",
    "fsw/supervisor/services": "spacecraft",
    "launcher": "launcher launch arguments descriptor_capacities descriptor_classes descriptor_model descriptor_writer eeprom_image guard return_budget run_summary target_link",
}
MUTABLE = re.compile(r"(\.data(?!\.rel\.ro)|\.bss|\.tdata|\.tbss|COM).*")


def symbols(objects):
    """(source path, symbol, section, whether it is global) of each line of nm; an undefined symbol has section *UND*."""
    listing = subprocess.run(["nm", "-A", "--format=sysv", *objects], capture_output=True, text=True, check=True)
    for line in listing.stdout.splitlines():
        fields = line.split("|")
        if len(fields) == 7:
            path, _, name = fields[0].strip().rpartition(":")
            yield path.replace("build/obj/", "").replace(".o", ".c"), name, fields[6].strip(), fields[2].strip().isupper()


def prefixes(path):
    """Prefixes of the global symbols of a source."""
    directory, _, file = path.rpartition("/")
    listed = PREFIXES.get(directory) or (PREFIXES["pus"] if directory.startswith("pus/") else directory.rpartition("/")[2])
    program = file.removesuffix("_program.c") if directory == "fsw/programs" and file.endswith("_program.c") else ""
    return [*listed.split(), *program.split()]


def is_misnamed(path, name, section, is_global):
    """True if a global symbol that this source defines has a prefix of another library."""
    if not is_global or section == "*UND*" or (name == "main" and path.endswith("_main.c")):
        return False
    return not any(name == prefix or name.startswith(prefix + "_") for prefix in prefixes(path))


def breach(path, name, section, is_global):
    """Description of a forbidden symbol, or None."""
    if is_misnamed(path, name, section, is_global):
        return f"{path}: {name} begins with none of the prefixes of its library: {' '.join(prefixes(path))}"
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
    print("\n".join(failures) or f"check: no allocator, printf, jump, mutable global or prefix of another library in {len(objects)} objects")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
