# SPDX-License-Identifier: Apache-2.0
"""Make the kept corpus of fuzz targets from seeds (the project's own vectors), the present corpus, and inputs
found by runs; reduced to those that add coverage (-merge=1), the smallest first, up to SHARE for each
target."""

import binascii
import pathlib
import shutil
import struct
import subprocess
import sys

import run_fuzz

SHARE = 20 * 1024  # Octets.
SEEDS = pathlib.Path("build/fuzz/seeds")
LARGEST = {"subsystem_descriptor": 12000, "mission_descriptor": 6000, "eds": 4096, "world": 4096, "xml": 4096, "reload": 6000, "udp_carrier": 8192}
SUBSYSTEMS = (1, 2, 16, 17)
NONE = 0xFF


def record(kind, octets=b"", argument=0):
    return struct.pack(">BBH", kind, argument, len(octets)) + octets


def packet(apid, is_tc, service, subtype, data, user=1):
    """One packet as the ground or a member writes it."""
    head = struct.pack(">BBBHH", 0x2F if is_tc else 0x20, service, subtype, *((user, 0) if is_tc else (0, user)))
    body = (head[:5] if is_tc else head + bytes([0x1F]) + bytes(7)) + data
    first = (0x1800 if is_tc else 0x0800) | apid
    whole = struct.pack(">HHH", first, 0xC000, len(body) + 1) + body
    return whole + struct.pack(">H", binascii.crc_hqx(whole, 0xFFFF))


def name(text):
    return text.encode().ljust(8, b"\0")


ENDS = struct.pack(">HHHH", 16, 1, 17, 2)
PROPERTIES = struct.pack(">IIBIHBBI", 1, 16, 1, 500, 100, 2, 1, 5000)
# Requests of each service of a subsystem.
REQUESTS = [
    (17, 1, b""), (17, 3, b"\0\x01"),
    (129, 1, b"\x03"), (129, 3, b"\0\x01"), (129, 3, b"\0\x02"), (129, 1, b"\x04"), (129, 1, b"\x05"), (129, 1, b"\x06"),
    (129, 1, b"\0"), (129, 4, b""), (129, 6, b""),
    (3, 1, struct.pack(">HIBIB", 9, 10, 1, 0x02190001, 0)), (3, 3, b"\x01\0\x09"), (3, 5, b"\x01\0\x09"),
    (3, 6, b"\x01\0\x09"), (3, 9, b"\x01\0\x09"), (3, 27, b"\x01\0\x09"), (3, 29, struct.pack(">HIBI", 9, 1, 1, 0x02190007)),
    (3, 31, struct.pack(">BHI", 1, 9, 20)), (3, 33, b"\x01\0\x09"),
    (5, 5, b"\x01\0\x09"), (5, 6, b"\x01\0\x09"), (5, 7, b""),
    (8, 1, name("MOVE_TO") + b"\x02" + struct.pack(">HddHd", 1, 0.1, 0.1, 2, 1.0)), (8, 1, name("TARE") + b"\0"),
    (8, 1, name("RAISE") + b"\x01" + struct.pack(">HH", 1, 9)), (8, 1, name("STOP") + b"\0"),
    (20, 1, struct.pack(">BII", 2, 0x02190001, 0x02180000)), (20, 3, struct.pack(">BIdd", 1, 0x02190001, 0.2, -0.2)),
    (130, 1, b"\0"), (130, 3, struct.pack(">IH", 1, 1) + ENDS + PROPERTIES),
    (130, 6, struct.pack(">HI", 1, 1)), (130, 7, b"\0\x01\0"), (130, 8, b"\0"),
    (131, 1, b"\x01"), (131, 3, b"\x01"), (131, 5, b""), (131, 6, b"\0\x10"), (131, 7, b"\0\x10"), (131, 8, b""),
    (131, 10, b""),
]
REQUEST_ID = struct.pack(">HH", 0x1810, 0xC000)
FAILURE = struct.pack(">HHI", 0x0201, 1, 2)
REPORTS = [
    (1, 1, REQUEST_ID), (1, 2, REQUEST_ID + FAILURE), (1, 5, REQUEST_ID + b"\0\x02"), (1, 6, REQUEST_ID + b"\0\x02" + FAILURE),
    (1, 7, REQUEST_ID), (1, 8, REQUEST_ID + FAILURE), (5, 4, b"\0\x01\x11"), (5, 3, b"\0\x03" + bytes(17)),
    (5, 2, b"\0\x09"), (129, 2, struct.pack(">BBBHBHI", 3, 4, 0, 1, 0, 0, 9)),
    (129, 5, struct.pack(">BBBHQQII", 3, 2, 3, 2, 1, 2, 1, 9)),
    (129, 5, struct.pack(">BBBHQQII", 4, 0, 4, 2, 1, 2, 1, 9)),
    (130, 2, b"\0\x01\0\x01\0" + PROPERTIES), (130, 4, struct.pack(">IH", 1, 1) + PROPERTIES + b"\x02\x02ab"),
    (130, 5, struct.pack(">IBB", 1, 3, 4) + PROPERTIES),
    (130, 9, b"\0\x01\0\x01\x03" + ENDS + PROPERTIES + bytes(20)),
    (130, 10, b"\0\x01\x02\x03\0" + b"\x1F" + bytes(7)), (131, 2, b"\0\x01\0"), (131, 4, b"\0\x01" + bytes(8) + b"\0\0"),
]


def requests(apid):
    return [packet(apid, True, *request) for request in REQUESTS]


def can(kind, identifier, *octets, argument=0):
    return record(kind, struct.pack(">H", identifier) + bytes(octets), argument)


def seeds_of_packets():
    yield from requests(16)
    yield from (packet(16, False, *report) for report in REPORTS)


def seeds_of_subsystem():
    all_states = [packet(16, True, 129, 1, bytes([state])) for state in (3, 4, 5, 6, 0)]
    select = packet(16, True, 129, 3, b"\0\x01")
    up = record(0, all_states[0], NONE) + record(0, select, 60) + record(0, all_states[1], 60) + record(0, all_states[2], 60)
    yield up
    for request in requests(16):
        yield record(0, request, 4)
        yield up + record(0, request, 40)


def seeds_of_supervisor():
    began = record(6, argument=50)
    heard = b"".join(record(1 + place, packet(apid, False, 129, 5, struct.pack(">BBBHQQII", 3, 2, 3, 2, 1, 2, 1, 9)), place)
                     for place, apid in ((0, 2), (1, 16), (2, 17)))
    for apid in SUBSYSTEMS:
        for request in requests(apid):
            yield began + heard + record(0, request, 0) + record(6, argument=2) + record(9, argument=1)
    for service, subtype, data in REPORTS:
        yield began + heard + record(1, packet(16, False, service, subtype, data), 1) + record(6, argument=10)


def seeds_of_canopen():
    life = record(1, argument=NONE) * 4
    goal = record(4, argument=1) + record(1, argument=40) + record(4, argument=2) + record(1, argument=40)
    yield life + goal
    for frame in [(0x091, 0x10, 0x23, 4, 0, 0, 0, 0, 0), (0x711, 0), (0x711, 5), (0x591, 0x80, 0, 0x10, 0, 0, 0, 2, 6),
                  (0x591, 0x43, 0, 0x10, 0, 1, 2, 3, 4), (0x191, 0x37, 2, 0, 0, 0, 0, 0, 0)]:
        yield record(1, argument=9) + can(0, *frame) + life + can(0, *frame) + goal
    for bits in (1, 2, 4, 8, 16):
        yield life + goal + record(3, argument=bits) + record(1, argument=NONE)


def seeds_of_device():
    start = can(0, 0, 1, 0x11) + record(3, argument=10)
    for frame in [(0x611, 0x40, 0, 0x10, 0, 0, 0, 0, 0), (0x611, 0x40, 8, 0x10, 0, 0, 0, 0, 0), (0x611, 0x60, 0, 0, 0, 0, 0, 0, 0),
                  (0x611, 0x2F, 0x60, 0x60, 0, 10, 0, 0, 0), (0x611, 0x2B, 0x17, 0x10, 0, 10, 0, 0, 0),
                  (0x611, 0x23, 0, 0x14, 1, 0x11, 2, 0, 0x80), (0x611, 0x21, 8, 0x10, 0, 4, 0, 0, 0), (0x080,),
                  (0x211, 0x0F, 0, 0, 0, 0, 0, 0, 0), (0x311, 6, 0, 0, 0, 0, 0, 0, 0), (0, 129, 0x11), (0, 2, 0x11)]:
        yield can(0, *frame) + record(3, argument=5) + start + can(0, *frame) + can(0, 0x080) + record(3, argument=5)
    yield start + record(4) + record(3, argument=50)


def seeds_of_messages():
    frame = struct.pack(">HBBHHIIII", 0x484D, 1, 0, 2, 1, 1, 1, 0, 0)
    yield record(0, frame + b"block") + record(3)
    yield (record(1, b"from a peer") + record(3)) * 20 + record(2, b"to a peer", 0) * 40 + record(3)
    yield record(1, b"a") + record(4) + record(1, b"b") + record(3) + record(2, b"c")


def seeds_of_streams():
    yield b"\x01" + record(0, b"\0\5hello\0\0\0\2a") + record(2) + record(0, b"b") + record(2) + record(1, b"answer") + record(5)
    yield b"\x11" + record(0, b"\5\0hello\xff\xff") + record(2) + record(3) + record(2) + record(1, b"lost") + record(0, b"x")
    yield b"\x02" + record(0, b"\xc0ab\xdb\xdc\xdb\xdd\xc0\xdbx\xc0") + record(2) + record(4, argument=1) + record(1, b"\xc0\xdb")
    yield b"\x03" + record(0, b"line\r\nnext\n" + b"long" * 20 + b"\n") + record(2) + record(1, b"line") + record(1, b"a\nb")
    yield b"\0" + record(0, b"octets" * 60) + record(4, argument=0) + record(1, b"o" * 60) * 4 + record(2) + record(4, argument=9)


def seeds_of_datagrams():
    for sender in (2, 3):
        data = struct.pack(">HBBHHIIII", 0x484D, 1, 0, sender, 1, 1, 1, 0, 0) + b"block"
        yield record(sender - 2, data) + record(3) + record(4, b"to a peer", sender - 2) + record(5) + record(2, data)
    long = struct.pack(">HBBHHIIII", 0x484D, 1, 0, 2, 1, 1, 1, 0, 0) + bytes(1000)
    yield record(0, long) * 9 + record(3) + record(0) + record(0, bytes(4200)) + record(4, b"a") * 40


def seeds_of_reload():
    document = pathlib.Path("descriptors/subsystems/manipulator.xml").read_bytes()
    parts = document[document.index(b"  <Configuration "):document.rindex(b"</Subsystem>")].split(b"  </Configuration>")
    both = [part + b"  </Configuration>\n" for part in parts[:2]]
    yield from (*both, b"".join(both), b"")


def seeds_of_links():
    head = struct.pack(">HBBHHIIQ", 0x5254, 1, 5, 3, 0, 2, 1, 500000)
    crc = __import__("zlib").crc32(head + bytes(16))
    yield record(1, head + bytes(16) + struct.pack(">I", crc), 15)
    yield record(0, head + bytes(16), 15)


def seeds_of_archive():
    for number, body in ((1, packet(16, True, 17, 1, b"")), (2, packet(16, False, 1, 1, REQUEST_ID)), (1, b"")):
        spool = struct.pack(">QQB", number, 1000, 0) + body
        yield record(0, struct.pack(">I", len(spool)) + spool)
        yield record(1, b"%d 1.000000500 TM %s\n" % (number, body.hex().encode()))


def seeds_of_ground():
    ping = packet(16, True, 17, 1, b"")
    yield record(0, ping) + record(1, ping[:9]) + record(6, b"report", 2) + record(1, ping[9:]) + record(7)
    yield record(5, argument=2) + record(0, ping * 3) + record(4) + record(8, argument=5) + record(6, bytes(99), 1) + record(7)


def seeds_of_sdls():
    """Content that the target seals: session, count, segment header, content. An unchanged frame must be refused."""
    def sealed(session, count, part, kind=1, connection=0):
        return record(kind, bytes([session, count, part]) + b"content", connection)

    yield sealed(1, 0, 0xC0) + sealed(1, 1, 0x40) + sealed(1, 2, 0x00) + sealed(1, 3, 0x80) + sealed(1, 3, 0x80)
    yield sealed(1, 0, 0xC0) + sealed(2, 0, 0xC0, 1, 1) + sealed(1, 1, 0xC0) + sealed(1, 0, 0xC0, 3) + sealed(3, 0, 0xC0, 3) + sealed(4, 0, 0xC0, 5)
    yield sealed(1, 0, 0xC0, 9) + sealed(1, 0, 0xC0, 17) + sealed(1, 0, 0xC0) + record(1, bytes([1, 1, 0x40]) + bytes(988))
    yield record(0, struct.pack(">HHBBHIII", 0x2001, 36, 0, 0xC0, 1, 0, 1, 0) + bytes(17)) + record(0, packet(16, True, 17, 1, b""))


def seeds_of_socketcand():
    begun = record(0, b"< open robot >< rawmode >")
    yield begun + record(0, b"< send 123 2 a b >") + record(3, argument=10) + can(2, 0x321, 1, 2, 3) + record(3, argument=9)
    yield record(1, b"< echo >< open robot >< send 18FF0001 0 >") + record(1, b"< rawmode >") + begun + record(4)


def seeds_of_cosimulation():
    join = record(0, b"join operator 40001\n")
    yield join + record(0, b"done 500000 12 40001\n") + record(0, b"done never 0 0\n") + record(0, b"leave\n") + record(1, b"join x")


def seeds_of_text():
    words = ["127.0.0.1:10015", "0 255 7", "0x10 65535", "4294967295 -1", "18446744073709551615", "-128 127", "-32768",
             "-2147483648", "-9223372036854775808", "1.5 -0.25e-3", "3.14159265358979 1e22", "true false 1 0"]
    yield from (bytes([choice]) + text.encode() for choice, text in enumerate([*words[1:], words[0]]))


def seeds_of_procedures():
    yield from (bytes([1, piece, piece]) for piece in range(50))
    yield b"\0for i = 1, 9 do step(i) local v = get(i) or 0 send(16, 17, 1, string.pack('>I2', i + v), true) end"
    yield b"\0local t = {} for k, v in pairs({a = 1, b = 2}) do t[#t + 1] = k .. v end table.sort(t) event(#table.concat(t, ','))"
    yield b"\0local s = ('key = value'):gsub('(%w+) = (%w+)', '%2 = %1') if s:match('^v') then wait(0.5) end error('x')"


def seeds_of_dump():
    both = [packet(16, True, 17, 1, b""), packet(16, False, 5, 1, b"\0\x09")]
    for style in (0, 4, 8):
        yield bytes([1 + style]) + b"\n".join(one.hex().encode() for one in both)
        yield bytes([2 + style]) + b"0.000500000 TC " + both[0].hex().encode() + b"\n1.5 TM " + both[1].hex().encode()
        yield bytes([3 + style]) + both[0] + both[1]


def seeds_of_records():
    """Fields of each type, in both byte orders, with and without a checksum."""
    types = bytes(range(10))
    yield from (bytes([flags | 9]) + types + bytes(range(42 + (2 if flags & 0x80 else 0))) for flags in (0, 0x40, 0x80, 0xC0))
    yield from (bytes([0, kind]) + bytes([0xFF]) * size for kind, size in enumerate((1, 2, 4, 8, 1, 2, 4, 8, 4, 8)))


def files(*patterns):
    for pattern in patterns:
        yield from (path.read_bytes() for path in sorted(pathlib.Path().glob(pattern)))


VECTORS = {
    "canopen": seeds_of_canopen, "communication": seeds_of_ground, "device": seeds_of_device, "cosimulation": seeds_of_cosimulation,
    "eds": lambda: files("descriptors/devices/*.eds"), "flow_stream": seeds_of_streams, "link_frame": seeds_of_links, "message": seeds_of_messages,
    "mission_descriptor": lambda: files("descriptors/missions/*.xml"), "packet": seeds_of_packets,
    "packet_archive": seeds_of_archive, "procedures": seeds_of_procedures, "pusdump": seeds_of_dump, "reload": seeds_of_reload,
    "sdls": seeds_of_sdls, "scenario": lambda: files("sim/scenarios/*.scn"), "socketcand": seeds_of_socketcand, "stream_record": seeds_of_records,
    "subsystem": seeds_of_subsystem, "subsystem_descriptor": lambda: files("descriptors/subsystems/*.xml"),
    "supervisor": seeds_of_supervisor, "text": seeds_of_text, "udp_carrier": seeds_of_datagrams,
    "world": lambda: files("descriptors/worlds/*"), "xml": lambda: files("descriptors/*/*.xml"),
}


def write_seeds(target):
    directory = SEEDS / target
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir(parents=True)
    for place, seed in enumerate(VECTORS[target]()):
        (directory / f"seed-{place:03}").write_bytes(seed)
    return directory


def merge(target):
    """Keep the inputs that add coverage; of those, the smallest, up to this target's share."""
    merged = pathlib.Path("build/fuzz/merged", target)
    shutil.rmtree(merged, ignore_errors=True)
    merged.mkdir(parents=True)
    sources = [write_seeds(target), pathlib.Path("build/fuzz/corpus", target), run_fuzz.HERE / "corpus" / target]
    largest = LARGEST.get(target, 2048)
    subprocess.run([str(run_fuzz.BUILT / target), "-merge=1", f"-max_len={largest}", "-timeout=10", str(merged),
                    *(str(directory) for directory in sources if directory.is_dir())], check=True, stderr=subprocess.DEVNULL,
                   stdout=subprocess.DEVNULL)
    return merged


def keep(target):
    directory = run_fuzz.HERE / "corpus" / target
    merged = merge(target)
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir(parents=True)
    size = 0
    for path in sorted(merged.iterdir(), key=lambda path: (path.stat().st_size, path.name)):
        size += path.stat().st_size
        if size > SHARE:
            break
        shutil.copyfile(path, directory / path.name[:12])
    print(f"{target:22} {len(list(directory.iterdir()))} of {len(list(merged.iterdir()))} inputs, {min(size, SHARE)} octets")


def main():
    for target in sys.argv[1:] or sorted(VECTORS):
        keep(target)


if __name__ == "__main__":
    main()
