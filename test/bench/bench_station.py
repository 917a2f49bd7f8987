# SPDX-License-Identifier: Apache-2.0
"""The light station during flights in real time, with the page in Chromium.

    station_robot_moves      `make gse`, until the robot moves on the page, by the default scenario; baseline: 10 s
    station_picture          95 % of the housekeeping reports: from a packet's arrival at another client of the ground port
                             until the page has drawn the robot at its positions, less the period of the reports, during
                             which the page moves the robot there; baseline: 100 ms
    station_updates_dropped  housekeeping reports of all subsystems that the page has not received; baseline: 1
    station_memory           most resident memory of the station with CLIENTS clients, one of them the page; baseline: 60 MB
    station_processor        processor time of the station, as a share of one processor; baseline: 5 %
    station_hand             95 % of the movements of the pointer: from the page's event until another client of the live
                             port receives the first sample of the joystick on the bus after it; baseline: 5 ms
    replay_load              a recording of HOUR_S, from the request for the page until the robot is drawn; baseline: 3 s
    replay_seek              a jump in it, until the page is drawn; 95 % of them; baseline: 0.1 s

Baselines are the required values. The page draws without a graphics processor, on the processors that also fly. The load
of the machine is printed beside the values: other work delays every row but the dropped updates. The recording of an hour
is that of a flight of telepresence, repeated with noise on its numbers."""

import asyncio
import bisect
import contextlib
import os
import pathlib
import pickle
import re
import shutil
import signal
import statistics
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / directory) for directory in ("test/mission", "test/support", "gse")]

import failures
import flying
from aiohttp import ClientSession
from browsing import browsing, until
from hirosco_gse import packets
from hirosco_gse.dictionary import Dictionary
from long_recording import long_recording

DIRECTORY = ROOT / "runs" / "bench-station"
STARTS, CLIENTS, HOUR_S, SEEKS = 3, 5, 3600, 40
WATCHED_S, HAND_S, SETTLED_S = 60.0, 10.0, 3.0
MOVED_RAD = 0.02
KEPT_PACE = 0.95  # Simulated time by wall-clock time.
SCENARIO = ["0.0 hand rest", *flying.bring_up(0.2), "1.5 hand circle 0.15 0.5 1 600 1", "3600 operator shutdown"]
HOUSEKEEPING, SYNC = (3, 25), 0x080
# For each picture of the scene, record the report that it shows, whether the robot is at the positions of this report, and
# when the browser has painted the picture: the page places the labels when the picture is in the canvas, and the second frame
# after that begins when it is painted. For each report, record its time and when the page received it.
WATCH = """() => {
    const bench = window.bench = {taken: [], drawn: []};
    station.store.on("housekeeping", (report) => bench.taken.push([report.subsystem, report.structure, report.time, performance.now()]));
    const scene = station.scene, labels = scene.labels.bind(scene), render = scene.renderer.render.bind(scene.renderer);
    let shown = null;
    scene.renderer.render = (...words) => {
        const {time, positions} = scene.last ?? {};
        shown = [time, Boolean(positions?.every((value, n) => Math.abs(value - scene.drawn[n]) < 1e-5))];
        render(...words);
    };
    scene.labels = () => {
        const picture = shown;
        labels();
        if (picture) requestAnimationFrame(() => requestAnimationFrame(() => bench.drawn.push([...picture, performance.now()])));
    };
}"""
# Record each movement of the pointer and its age, and each line of the hand with the simulated time at which it acts. The
# browser reports a movement at once, and the same movement a second time before the next frame.
WATCH_HAND = """() => {
    const bench = window.bench, store = station.store, live = store.live.bind(store);
    Object.assign(bench, {moves: [], ages: [], lines: []});
    let noted = "";
    const note = (event) => {
        const position = `${event.clientX} ${event.clientY}`, now = performance.now();
        if (!event.buttons || position === noted) return; // A pointer that is not pressed does not move the hand.
        noted = position;
        bench.moves.push(now);
        bench.ages.push(now - event.timeStamp);
    };
    for (const kind of ["pointermove", "pointerrawupdate"]) window.addEventListener(kind, note, {capture: true});
    store.live = (line) => {
        const sent = performance.now(), answer = live(line);
        answer.then((told) => bench.lines.push([sent, told.time ?? null, performance.now()]));
        return answer;
    };
}"""
# Jump, and wait until a picture that was begun after the jump is painted. Returns the time that this takes [ms].
SEEK = """async (time) => {
    const {scene} = station, {labels} = scene, {render} = scene.renderer, began = performance.now();
    let isBegun = false;
    scene.renderer.render = (...words) => { isBegun = true; render.call(scene.renderer, ...words); };
    const shown = new Promise((done) => { scene.labels = () => { labels.call(scene); if (isBegun) done(); }; });
    station.replay.seek(time);
    await shown;
    scene.labels = labels;
    scene.renderer.render = render;
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    return performance.now() - began;
}"""


def share(values, part):
    """The value that `part` of the values do not exceed."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(part * len(ordered)))]


def spread(name, values, unit):
    print(f"  {name}: least {min(values):.3g}, p50 {share(values, 0.5):.3g}, p95 {share(values, 0.95):.3g}, max {max(values):.3g} {unit} (n={len(values)}); "
          f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors", flush=True)


class Station:
    """`make gse` with options, and the process of the station in it."""

    def __init__(self, *options):
        shutil.rmtree(DIRECTORY, ignore_errors=True)
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
        words = ["make", "--no-print-directory", "gse", "HTTP=0", f"OUT={DIRECTORY}", *options]
        self.began = time.monotonic()
        self._make = subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment, start_new_session=True)
        self.address = None
        for line in self._make.stdout:
            if found := re.search(r"http://127\.0\.0\.1:\d+/", line):
                self.address = found.group()
                break
        assert self.address, "make gse has printed no address"

    @property
    def pid(self):
        """Process of the station."""
        return next(pid for pid, line in flying.command_lines() if b"-m hirosco_gse.station" in line and line.startswith(b"build/venv") and str(DIRECTORY).encode() in line)

    def close(self):
        """End the station and its flight as Ctrl-C does."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._make.pid, signal.SIGINT)
        self._make.communicate(timeout=flying.MOMENT_S)
        shutil.rmtree(DIRECTORY, ignore_errors=True)


class Listener:
    """Receives what a port of the flight sends, with the times of arrival on the machine's clock (arrivals.py)."""

    def __init__(self, port, greeting=""):
        words = [sys.executable, pathlib.Path(__file__).with_name("arrivals.py"), str(port), greeting]
        self._receiver = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        assert self._receiver.stdout.readline(), f"nothing answers at port {port}"

    def close(self):
        """End. Returns all octets, and a function that gives the time of arrival of the octet at an offset."""
        parts = pickle.loads(self._receiver.communicate()[0])
        ends, end = [], 0
        for at, octets in parts:
            end += len(octets)
            ends.append((end, at))
        return b"".join(octets for _, octets in parts), lambda offset: ends[bisect.bisect_right(ends, (offset, float("inf")))][1]


class Clients:
    """WebSocket clients of a station that read everything, in a thread of their own."""

    def __init__(self, address, count):
        self._loop = asyncio.new_event_loop()
        self._task = self._loop.create_task(self._all(address, count))
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        with contextlib.suppress(asyncio.CancelledError):
            self._loop.run_until_complete(self._task)

    @staticmethod
    async def _all(address, count):
        async def one(session):
            async with session.ws_connect(f"{address}ws", headers={"Origin": address.rstrip("/")}) as client:
                async for _ in client:
                    pass

        async with ClientSession() as session:
            await asyncio.gather(*(one(session) for _ in range(count)))

    def close(self):
        self._loop.call_soon_threadsafe(self._task.cancel)
        self._thread.join()
        self._loop.close()


def offset_of(page):
    """Clock of the page [ms] minus the machine's clock [ms]."""
    found = []
    for _ in range(100):
        before = time.monotonic()
        page_ms = page.evaluate("performance.now()")
        after = time.monotonic()
        found.append((after - before, page_ms - (before + after) * 500))
    return min(found)[1]


def robot_moves(browser):
    """Seconds from `make gse` until the robot moves on the page."""
    station = Station()
    try:
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(station.address)
        until(page, "station.scene.joints?.length > 0 && !(window.first = [...station.scene.joints]).some(Number.isNaN)")
        until(page, f"station.scene.joints.some((joint, n) => Math.abs(joint - window.first[n]) > {MOVED_RAD})")
        taken = time.monotonic() - station.began
        page.close()
    finally:
        station.close()
    return taken


def reports_of(listener, epoch_ns):
    """Dict (APID, structure, time of the packet in us) -> its arrival [ms on the machine's clock]."""
    octets, arrival = listener.close()
    found, at = {}, 0
    while at + 6 <= len(octets):
        size = int.from_bytes(octets[at + 4 : at + 6], "big") + 7
        raw = octets[at : at + size]
        if len(raw) == size:
            packet = packets.parse(raw)
            if packet.message == HOUSEKEEPING:
                found[packet.apid, int.from_bytes(packet.data[:2], "big"), round((packet.time_ns - epoch_ns) / 1e3)] = arrival(at + size - 1) * 1e3
        at += size
    return found


def lateness(reports, drawn, source, offset_ms):
    """For each report of the structure that moves the robot: time until the robot is drawn at its positions, less the period [ms]."""
    of_source = sorted((time_us, at) for (apid, structure, time_us), at in reports.items() if (apid, structure) == source)
    period_ms = statistics.median(late - early for (early, _), (late, _) in zip(of_source, of_source[1:])) / 1e3
    found, index = [], 0
    for time_us, at in of_source:
        while index < len(drawn) and not (drawn[index][0] * 1e6 > time_us + 1 or drawn[index][1] and drawn[index][0] * 1e6 > time_us - 1):
            index += 1
        if index == len(drawn):
            break
        found.append(drawn[index][2] - offset_ms - at - period_ms)
    return found, period_ms


def processor_s(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(pid):
    return int(re.search(r"VmHWM:\s+(\d+) kB", pathlib.Path(f"/proc/{pid}/status").read_text(encoding="ascii"))[1]) * 1024 / 1e6


def telemetry(page, station):
    """Measure pictures, losses and the station for WATCHED_S."""
    dictionary = Dictionary.load(ROOT / "build" / "generated" / "rokviss.json")
    listener = Listener(int((DIRECTORY / "ground.port").read_text(encoding="ascii")))
    page.evaluate(WATCH)
    clients = Clients(station.address, CLIENTS - 1)
    time.sleep(SETTLED_S)
    used_s, began = processor_s(station.pid), time.monotonic()
    page.evaluate("window.bench.began = station.store.time")
    time.sleep(WATCHED_S)
    used_s, flown_s = processor_s(station.pid) - used_s, time.monotonic() - began
    first_s, last_s = page.evaluate("[window.bench.began, station.store.time]")
    time.sleep(SETTLED_S)
    memory = memory_mb(station.pid)
    clients.close()
    offset_ms = offset_of(page)
    measured = page.evaluate("window.bench")
    reports = {key: at for key, at in reports_of(listener, dictionary.epoch_ns).items() if first_s * 1e6 < key[2] < last_s * 1e6}
    apids = {name: subsystem.apid for name, subsystem in dictionary.subsystems.items()}
    taken = {(apids[name], structure, round(seconds * 1e6)): at for name, structure, seconds, at in measured["taken"]}
    structures = {key[:2] for key in reports if key[0] == apids["MANIPULATOR"]}
    source = max(structures, key=lambda one: sum(key[:2] == one for key in reports))
    late, period_ms = lateness(reports, measured["drawn"], source, offset_ms)
    spread("packet to the page's store", [taken[key] - offset_ms - at for key, at in reports.items() if key in taken], "ms")
    spread(f"packet to picture less the period of {period_ms:.0f} ms", late, "ms")
    pictures, pace = len(measured["drawn"]) / (flown_s + 2 * SETTLED_S), (last_s - first_s) / flown_s
    print(f"  {len(reports)} reports, {pictures:.1f} pictures a second, {pace:.3f} x real time")
    if pace < KEPT_PACE:
        print("  other load slows the flight, so these times are not those of the station; repeat the run without other load")
    print(f"BENCH station_picture {share(late, 0.95):.1f} ms 100")
    print(f"BENCH station_updates_dropped {len(reports.keys() - taken.keys())} reports 1")
    print(f"BENCH station_memory {memory:.1f} MB 60")
    print(f"BENCH station_processor {100 * used_s / flown_s:.2f} % 5", flush=True)


def samples_of(listener):
    """[(simulated time of the SYNC [s], arrival of the first process data after it [ms])] of a listener at the live port."""
    octets, arrival = listener.close()
    found, sync = [], None
    for line in re.finditer(rb"^frame \((\d+\.\d+)\) \w+ ([0-9A-F]+)#", octets, re.MULTILINE):
        identifier = int(line[2], 16)
        if identifier == SYNC:
            sync = float(line[1])
        elif sync is not None and identifier >> 7 in (3, 5, 7, 9):
            found.append((sync, arrival(line.end()) * 1e3))
            sync = None
    return found


def hand(page):
    """Measure movements of the pointer until their sample on the bus."""
    page.evaluate(WATCH_HAND)
    page.click("#work-Operate")
    page.click("button:has-text('Take the hand'):not(:disabled)")
    box = page.locator(".field").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    listener = Listener(int((DIRECTORY / "live.port").read_text(encoding="ascii")), "name bench\nframes joystick on\n")
    page.mouse.move(x, y)
    page.mouse.down()
    end, step = time.monotonic() + HAND_S, 0
    while time.monotonic() < end:
        step += 1
        page.mouse.move(x + step * 7 % 23, y + step * 5 % 19)
    page.mouse.up()
    page.keyboard.press("Escape")
    offset_ms = offset_of(page)
    measured = page.evaluate("window.bench")
    samples = samples_of(listener)
    delays, acked, line, sample = [], [], 0, 0
    lines = [entry for entry in measured["lines"] if entry[1] is not None]
    for at in measured["moves"]:
        while line < len(lines) and lines[line][0] < at:
            line += 1
        if line == len(lines):
            break
        while sample < len(samples) and samples[sample][0] < lines[line][1]:
            sample += 1
        if sample == len(samples):
            break
        delays.append(samples[sample][1] + offset_ms - at)
        acked.append(lines[line][2] - lines[line][0])
    spread("movement of the pointer, until the page's event", measured["ages"], "ms")
    spread("line of the hand, until the page has its answer", acked, "ms")
    spread("movement of the pointer, until its sample on the bus", delays, "ms")
    print(f"BENCH station_hand {share(delays, 0.95):.2f} ms 5", flush=True)


def during_a_flight(browser):
    """Rows of telemetry and hand, from one flight."""
    scenario = flying.write_scenario(ROOT / "runs" / "bench-station.scn", *SCENARIO)
    station = Station(f"SCENARIO={scenario}")
    try:
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(station.address)
        until(page, "station.store.states.get('JOYSTICK')?.state === 'OPERATIONAL' && Boolean(station.scene.last)")
        telemetry(page, station)
        hand(page)
        page.close()
    finally:
        station.close()
        scenario.unlink()


def replay(browser):
    """Rows of the replay of an hour."""
    directory, recording = ROOT / "runs" / "bench-replay", ROOT / "runs" / "bench-replay.recording"
    shutil.rmtree(directory, ignore_errors=True)
    flown = flying.fly(directory, "--scenario", "telepresence", "--form", "image")
    assert flown.code == 0, flown.transcript()
    began = time.monotonic()
    made = subprocess.run([sys.executable, "-m", "hirosco_gse.recording", directory], cwd=ROOT, stdout=subprocess.PIPE, check=True, env={**os.environ, "PYTHONPATH": "gse"})
    print(f"  recording of {flown.facts['simulated_s']:.0f} s made in {time.monotonic() - began:.1f} s", flush=True)
    recording.write_bytes(long_recording(made.stdout, HOUR_S))
    print(f"  recording of an hour: {recording.stat().st_size / 1e6:.1f} MB", flush=True)
    station = Station(f"REPLAY={recording}")
    loads, seeks = [], []
    try:
        for _ in range(STARTS):
            page = browser.new_page(viewport={"width": 1440, "height": 900})
            began = time.monotonic()
            page.goto(f"{station.address}?replay")
            until(page, "Boolean(window.station?.replay?.film && station.scene.drawn && (!station.scene.pictures || station.scene.pictures.image))")
            page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
            loads.append(time.monotonic() - began)
            assert page.evaluate("station.replay.end") >= HOUR_S
            seeks += [page.evaluate(SEEK, HOUR_S * (n * 0.381966 % 1)) / 1e3 for n in range(SEEKS)]
            page.close()
    finally:
        station.close()
        recording.unlink()
        shutil.rmtree(directory)
    spread("load of an hour", loads, "s")
    spread("seek in an hour", seeks, "s")
    print(f"BENCH replay_load {statistics.median(loads):.2f} s 3")
    print(f"BENCH replay_seek {share(seeks, 0.95):.3f} s 0.1", flush=True)


def main():
    """Measure everything, or the parts whose names are given, and print the BENCH lines."""
    subprocess.run(["make", "-s", "--no-print-directory", "build/setup/station", "all", "build/station/page/index.html"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    wanted = sys.argv[1:] or ["start", "flight", "replay"]
    with browsing() as browser:
        if "start" in wanted:
            taken = [robot_moves(browser) for _ in range(STARTS)]
            spread("make gse to a moving robot", taken, "s")
            print(f"BENCH station_robot_moves {statistics.median(taken):.2f} s 10", flush=True)
        if "flight" in wanted:
            during_a_flight(browser)
        if "replay" in wanted:
            replay(browser)


if __name__ == "__main__":
    failures.run(main)
