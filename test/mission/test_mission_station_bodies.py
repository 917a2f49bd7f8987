# SPDX-License-Identifier: Apache-2.0
"""The page of the station beside a satellite that flies freely: its base, a reaction wheel and the thrusters, of which the mission has no
telemetry, are moved by the simulator's truth, and the page says so."""

import contextlib
import shutil
import struct
import subprocess

import flying
import pressing
import pytest
import test_mission_station as station
from browsing import LIMIT_MS, SHIFTS, WATCH_SHIFTS
from hirosco_gse import run as runs

WORLDS = flying.ROOT / "descriptors" / "worlds"
WHEEL = '<Wheel name="WHEEL1" on="satellite.body" axis="0 0 1" momentum="12" torque="0.2" start="{start}" bus="platform" node="0x44" eds="wheel.eds"/>'
SCENARIO = """
0.2 operator state ACTUATORS PRE_OPERATIONAL
0.6 operator config ACTUATORS NOMINAL
0.8 operator state ACTUATORS SAFE_OPERATIONAL
1.0 operator state ACTUATORS OPERATIONAL
1.5 operator set ACTUATORS.OUTPUT 3,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0
3600 operator shutdown
"""
# Place of the base in the scene, angle and share of momentum of the wheel, and the thrusters that fire.
SEEN = """(() => { const { bodies, actuators } = window.station.scene; return [
    bodies[0].arm.node.matrix.elements.slice(12, 15), actuators.wheels[0].angle, actuators.wheels[0].share,
    actuators.thrusters.filter((one) => one.plume.visible).map((one) => one.name)]; })()"""
# Texts that extend beyond their cell of the head of a report, and charts that extend beyond the column of the robot.
COVERED = """[...document.querySelectorAll('header .cell, main')].flatMap((cell) => [...cell.querySelectorAll('h1, header span, strong, station-strips')].filter((node) =>
    node.getBoundingClientRect().right > cell.getBoundingClientRect().right + 1 || node.getBoundingClientRect().bottom > cell.getBoundingClientRect().bottom + 1))
    .map((node) => node.textContent)"""

# The camera shows an arm of three joints that extends along -y, on a base that is fixed or `free`: places of its base and its tip on the
# screen, from -1 to 1.
FRAMED = """(free) => {
    const { scene, store } = window.station;
    const pose = (y) => [1, 0, 0, 0, 0, 1, 0, y, 0, 0, 1, 0.3, 0, 0, 0, 1];
    const joints = [0, -0.6, -0.6].map((y, n) => ({ name: `j${n}`, kind: "revolute", parent: `l${n}`, child: `l${n + 1}`, axis: [1, 0, 0], pose: pose(y), lower: -1, upper: 1 }));
    const robot = { name: "arm", root: "l0", free, start: {}, links: { l0: [], l1: [], l2: [], l3: [] }, joints };
    const empty = Object.entries(store.hello.world).map(([name, value]) => [name, Array.isArray(value) ? [] : {}]);
    store.take({ ...store.hello, kind: "hello", world: { ...Object.fromEntries(empty), robots: [robot] } });
    scene.view("Iso");
    scene.camera.lookAt(scene.target);
    scene.camera.updateMatrixWorld();
    return [[0, 0, 0], [0, -1.2, 0.9]].map((at) => { const { x, y } = scene.target.clone().set(...at).project(scene.camera); return [x, y]; });
}"""

# Words of the scene of a mission without a robot, the boxes that it shows, the lines of its charts, their title, whether the charts have its
# room, and the words of the charts when the user has removed all lines.
EMPTY = """(() => {
    const { store } = window.station, empty = Object.entries(store.hello.world).map(([name, value]) => [name, Array.isArray(value) ? [] : {}]);
    store.take({ ...store.hello, kind: "hello", world: Object.fromEntries(empty) });
    const strips = document.querySelector("station-strips");
    strips.title_.textContent = "";
    strips.draw();
    const lines = strips.strips.flatMap(({ about }) => about.lines.map((line) => line.title)), scene = document.querySelector("station-scene");
    const seen = [scene.innerText.trim(), [...scene.querySelectorAll(".hud")].filter((node) => node.offsetWidth).length, lines, strips.title_.textContent,
        scene.clientHeight < 0.2 * strips.clientHeight];
    for (const line of [...store.charted.values()]) store.tell("chart", line);
    store.tell("state", {});
    return [...seen, strips.querySelector(".strips").innerText];
})()"""

# Send a harmless command that is ready, and a critical one before the station has checked it; with a key that is held, and in a hidden tab.
# Returns the commands that the page has sent.
HASTY = """async () => {
    const { form } = document.querySelector("station-work"), { store } = window.station, ask = store.ask.bind(store), sent = [];
    const isReady = () => new Promise((done) => { const look = () => (form.isFit ? done() : setTimeout(look, 10)); look(); });
    const press = (more) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", ctrlKey: true, bubbles: true, ...more }));
    store.ask = (order) => (order.do === "command" ? (sent.push(order.text), Promise.resolve({ refused: "by the test" })) : ask(order));
    form.again("ping ACTUATORS");
    await isReady();
    form.tick();
    press();
    press({ repeat: true });
    form.again("state ACTUATORS SAFE_OPERATIONAL");
    press();
    form.again("ping SUPERVISOR");
    await isReady();
    form.node.parentElement.hidden = true;
    press();
    form.node.parentElement.hidden = false;
    delete store.ask;
    return sent;
}"""
FOCUSED = "document.activeElement.getAttribute('aria-label') ?? document.activeElement.textContent"


@pytest.fixture(scope="module")
def flight(session_directory):
    subprocess.run(["make", "-s", "build/station/page/index.html"], cwd=flying.ROOT, check=True)
    directory = session_directory / "bodies"
    directory.mkdir()
    shutil.copy(WORLDS / "satellite.urdf", directory)
    world = directory / "actuators.xml"
    text = (WORLDS / "actuators.xml").read_text(encoding="utf-8")
    world.write_text(text.replace("</World>", f"{WHEEL.format(start=-11.4)}</World>"), encoding="utf-8")
    scenario = directory / "push.scn"
    scenario.write_text(SCENARIO, encoding="utf-8")
    flight = flying.start(directory / "out", "--mission", "actuators", "--world", world, "--time", "real", "--scenario", scenario)
    flight.port()
    yield flight
    flight.abandon()


@pytest.fixture(scope="module")
def browser():
    with station.browsing() as browser:
        yield browser


@pytest.fixture(scope="module")
def page(flight, browser):
    with station.serving("--run", flight.directory) as address:
        page = station.opened(browser, address, "window.station.store.states.get('ACTUATORS')?.state === 'OPERATIONAL' && window.station.scene.truth?.last", color_scheme="dark")
        yield page
        assert not page.faults


def test_base_wheel_and_thrusters_move_by_the_truth_and_are_marked(page, session_directory):
    station.until(page, "window.station.scene.actuators.thrusters.some((one) => one.plume.visible)")
    station.until(page, "window.station.scene.bodies[0].arm.node.matrix.elements[12] > 0.02")
    before = page.evaluate(SEEN)
    station.until(page, f"window.station.scene.bodies[0].arm.node.matrix.elements[12] > {before[0][0]} + 0.02")
    station.until(page, f"window.station.scene.actuators.wheels[0].angle < {before[1]}")
    after = page.evaluate(SEEN)
    assert after[3] == ["PUSH1", "PUSH2"]
    assert after[1] < before[1] and after[2] == pytest.approx(-0.95, abs=0.01)  # The wheel turns backwards, with 11.4 of 12 Nms.
    mark = page.locator("station-scene .lacking")
    assert mark.inner_text() == "base, wheels, thrusters: simulator’s truth" and "partly" in mark.get_attribute("class")
    assert not page.evaluate("window.station.scene.classList.contains('truth')")
    page.evaluate("window.station.scene.describe()")
    reported = page.get_attribute("station-scene canvas", "aria-label")
    assert "WHEEL1 -95 %" in reported and "thrusters PUSH1, PUSH2 fire" in reported
    page.screenshot(path=str(session_directory / "bodies.png"))


def test_a_base_moves_by_telemetry_if_a_report_has_its_pose(page):
    """No mission of this project reports the pose of a base, so the test passes the page a report that a subsystem could send."""
    page.evaluate("""window.station.store.take({ kind: "housekeeping", subsystem: "ACTUATORS", structure: 7, time: window.station.store.time,
        values: { "ORBIT.BASE_POSITION": [5, 6, 7], "ORBIT.BASE_ATTITUDE": [1, 0, 0, 0] } })""")
    station.until(page, "window.station.scene.bodies[0].arm.node.matrix.elements[13] === 6")
    assert page.evaluate(SEEN)[0] == pytest.approx([5, 6, 7])
    page.evaluate("window.station.scene.tellLacking()")
    assert page.locator("station-scene .lacking").inner_text() == "wheels, thrusters: simulator’s truth"


def test_all_bodies_show_the_truth_if_the_user_selects_it(page):
    page.click("station-scene button:text-is('Truth')")
    page.wait_for_selector("station-scene.truth")
    station.until(page, "window.station.scene.bodies[0].arm.node.matrix.elements[13] < 1")
    assert page.locator("station-scene .lacking").is_hidden()
    page.click("station-scene button:has-text('Telemetry')")
    page.wait_for_selector("station-scene:not(.truth)")


def test_a_mission_without_joystick_and_power_shows_neither(page, flight):
    """The housekeeping takes the whole tab, and the key that takes the hand does nothing."""
    page.click("#work-Operate")
    page.locator("station-work .readings td:has-text('NOT_READY_TO_SWITCH_ON') >> nth=0").wait_for()  # The longest word, of axes without a drive.
    cut = page.evaluate(station.CUT)
    page.set_viewport_size({"width": 1024, "height": 768})
    cut += page.evaluate(station.CUT)
    page.set_viewport_size({"width": 1440, "height": 900})
    assert cut == []
    assert [page.locator(name).is_visible() for name in (".hand", "button:has-text('Take the hand')", ".power-cell")] == [False] * 3
    page.keyboard.press("h")
    assert page.evaluate("document.querySelector('station-work').hand.aim") is None and "hand" not in flight.read("live.scn")


def test_packets_are_counted_for_each_subsystem(page):
    """Counts and rates; a lost packet is marked. The sum in the tab agrees with its table."""
    page.click("#log-Packets")
    page.wait_for_selector("station-log tr:has-text('ACTUATORS')")
    station.until(page, "Number(document.querySelector('#log-Packets').textContent.split(' ')[1]) > 20")
    read = """(() => { const { packets } = document.querySelector("station-log"), { store } = window.station, { counts } = store;
        const cells = () => [...packets.body.rows].find((row) => row.textContent.startsWith("ACTUATORS")).innerText.split("\t").map((word) => word.trim());
        packets.draw();
        const before = [packets.sum("received"), packets.total.textContent, cells()];
        store.counts = { ...counts, ACTUATORS: { ...counts.ACTUATORS, lost: 3 } }; packets.draw();
        const lost = [cells()[3], packets.body.querySelectorAll("[aria-label='packets were lost']").length];
        store.counts = counts; packets.draw();
        return [...before, ...lost, packets.body.querySelectorAll("[aria-label='packets were lost']").length];
    })()"""
    total, words, cells, lost, marked, left = page.evaluate(read)
    assert words.startswith(f"{total} packets received, 0 lost") and cells[3] == "0" and [lost, marked, left] == ["3", 1, 0]
    station.until(page, "[...document.querySelector('station-log').packets.rows.get('ACTUATORS').rate.textContent].length > 2")
    page.click("#log-Events")


def test_a_body_without_joints_has_neither_tip_nor_force_and_its_mission_charts_telemetry(page):
    """Telemetry does not contain the place of the body, so a chart of it would be empty. The page charts the display structure, which it has enabled."""
    shown = "[...document.querySelectorAll('station-scene .hud.bl .name, station-scene .hud.br .hint')].filter((node) => node.offsetWidth).map((node) => node.textContent)"
    assert page.evaluate(shown) == ["Body x", "Body y", "Body z", "trace 6 s"]
    assert page.evaluate("[...new Set(station.strips.strips.flatMap(({ about }) => about.lines.map((line) => line.report)))]") == ["ACTUATORS/20"]
    station.until(page, "window.station.strips.strips[0].plot.data[1].some((value) => typeof value === 'number')")


def test_the_octets_of_a_packet_are_shown_with_its_fields(page):
    """With the keyboard alone. While the octets are shown the list does not change, although packets arrive;
    Esc returns to the row of the packet."""
    page.click("#log-Packets")
    page.wait_for_selector(".kinds .entry:has-text('status report')")
    rows = "[...document.querySelectorAll('.kinds .entry')].map((node) => node.textContent.replace(/^[–.\\d]+/, ''))"
    page.focus(".kinds .entry >> nth=0")
    while "ACTUATORS structure 20" not in page.evaluate(FOCUSED):
        page.keyboard.press("ArrowDown")
    before, time = page.evaluate(rows), "document.activeElement.firstChild.textContent"
    page.evaluate(WATCH_SHIFTS)
    station.until(page, f"Number({time}) > {page.evaluate(time)} + 1")
    assert page.evaluate(SHIFTS) == []
    page.keyboard.press("Enter")
    page.wait_for_selector(".dump [data-at]")
    octets = page.evaluate("[...document.querySelectorAll('.dump [data-at]')].map((node) => node.textContent).join('')")
    assert bytes.fromhex(octets)[7:9] == b"\x03\x19" and page.inner_text("station-log .of-packet .entry >> nth=0").split()[:4] == ["0", "to", "1", "type"]
    page.keyboard.press("Tab")  # To Earlier; Later is disabled.
    page.keyboard.press("Tab")
    page.keyboard.press("ArrowDown")
    assert "sequence count" in page.evaluate("document.activeElement.textContent")
    assert page.evaluate("[...document.querySelectorAll('.dump .marked')].map((node) => node.textContent).join('')") == octets[4:8]
    page.hover(f".dump [data-at='{len(octets) // 2 - 1}']")
    assert page.inner_text(".of-packet .marked .name") == "checksum"
    assert station.accessibility(page, "light") == station.accessibility(page, "dark") == []
    shown = "document.querySelector('station-log').packets.kept.shown.time"
    newest = page.evaluate(shown)
    page.click("button:text-is('Earlier')")
    assert page.evaluate(shown) < newest and page.inner_text("station-log .sides .what").endswith("1 packet before the newest")
    page.keyboard.press("Escape")
    assert "structure 20" in page.evaluate(FOCUSED)
    station.until(page, f"{rows}.length >= {len(before)}")
    assert [row for row in page.evaluate(rows) if row in before] == before
    page.click("#log-Events")


def test_a_device_of_the_network_opens_its_frames(page):
    """With the keyboard alone; a second press on the device shows the frames of all devices."""
    page.click("#work-Operate")
    page.focus("station-network [aria-label='VALVES: open tab Bus']")
    page.keyboard.press("Enter")
    page.wait_for_selector(".frames td:text-is('VALVES_HEARTBEAT')")
    frames = "[...document.querySelectorAll('.frames:not(.devices) tr:not(.below) td.name')].map((node) => node.textContent.split('_')[0])"
    assert set(page.evaluate(frames)) == {"VALVES"}
    assert page.evaluate("document.activeElement.textContent") == "VALVES" and page.get_attribute("#work-Bus", "aria-selected") == "true"
    assert page.inner_text(".devices tr:has-text('VALVES')").split()[1:3] == ["0x3A", "live"]
    assert station.accessibility(page, "dark") == []
    page.keyboard.press("Enter")
    page.wait_for_selector(".frames td:text-is('BOOM_HEARTBEAT')")


def test_the_network_of_a_mission_without_links_shows_a_member_in_error_and_whole_names_of_devices(page):
    words, is_failed, narrow = page.evaluate("""() => {
        const network = document.querySelector("station-network"), state = station.store.states.get("ACTUATORS"), before = state.state;
        const narrow = [...network.graph.querySelectorAll("g")].filter((box) => box.querySelector("text").getBBox().width > box.querySelector("rect").getBBox().width - 6);
        state.state = "ERROR_OPERATIONAL";
        network.draw();
        const found = [network.words.textContent, network.sym.firstChild.getAttribute("aria-label"), narrow.map((box) => box.textContent)];
        state.state = before;
        network.draw();
        return found;
    }""")
    assert (words, is_failed, narrow) == ("1 in error, no links", "failed", [])
    assert page.evaluate("document.querySelector('station-network').words.textContent") == "no links in this mission"


def test_a_click_on_a_thruster_opens_the_frames_of_its_valve_box(page):
    """The pointer over it says so. The wheel of this test is no device of the mission, so it opens nothing."""
    page.click("#work-Operate")
    place = """(device) => {
        const { scene } = window.station, { width, height } = scene.extent, { left, top } = scene.canvas.getBoundingClientRect();
        const places = [...scene.actuators.wheels, ...scene.actuators.thrusters].map(({ group }) => {
            const at = group.localToWorld(group.position.clone().set(0, 0.03, 0)).project(scene.camera);
            return [((at.x + 1) / 2) * width, ((1 - at.y) / 2) * height];
        });
        const [x, y] = places.find((one) => scene.deviceAt(...one) === device);
        return [left + x, top + y];
    }"""
    page.mouse.click(*page.evaluate(place, "WHEEL1"))
    assert page.get_attribute("#work-Bus", "aria-selected") == "false"
    page.mouse.move(*page.evaluate(place, "VALVES"))
    station.until(page, "station.scene.canvas.title === 'VALVES: open tab Bus'")
    page.mouse.click(*page.evaluate(place, "VALVES"))
    page.wait_for_selector(".devices [aria-pressed=true]:text-is('VALVES')")
    assert page.get_attribute("#work-Bus", "aria-selected") == "true"
    page.click("#work-Operate")


def test_a_command_that_is_not_checked_or_not_seen_is_not_sent(page):
    page.click("#work-Command")
    assert page.evaluate(HASTY) == ["ping ACTUATORS"]


def test_a_movement_is_sent_at_once_and_twelve_lines_wait_for_answers(page):
    """The page then sends where the hand is after the first answer, not the movements between. It repeats an aim that has not changed when
    the last line of the hand is too old."""
    sent = page.evaluate("""async () => {
        const { store } = window.station, { hand } = document.querySelector("station-work"), lines = [], answers = [];
        store.live = (line) => { lines.push(line); return new Promise((done) => answers.push(done)); };
        hand.aim = [0, 0];
        for (let n = 1; n <= 15; n++) { hand.move(n / 100, 0); hand.sendAim(); }
        const atOnce = lines.length;
        while (answers.length) { answers.shift()({}); await new Promise((done) => setTimeout(done)); }
        const aims = lines.map((line) => Number(line.split(" ")[2]));
        lines.length = 0;
        hand.aim = [...hand.sent]; // On a slow machine the page has given the hand back.
        hand.idle = 0;
        hand.sentAt = performance.now();
        hand.tick();
        const early = lines.length;
        hand.sentAt -= 1000;
        hand.tick();
        hand.aim = null;
        delete store.live;
        return [atOnce, early, lines.length, ...aims];
    }""")
    assert sent[:16] == [12, 0, 1, *(n / 100 for n in range(1, 13)), 0.15]


def test_a_control_keeps_the_focus_when_its_list_is_drawn_again(page):
    """A command has ended, or a bus was chosen: the next press of Tab does not begin at the top of the page."""
    page.click("#work-Bus")
    page.focus(".pick button:text-is('platform')")
    page.keyboard.press("Enter")
    assert page.evaluate(FOCUSED) == "platform" and page.get_attribute(".pick button:text-is('platform')", "aria-pressed") == "true"
    page.click("#work-Command")
    page.fill("#find", "ACTUATORS.")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("ArrowDown")
    chosen = page.evaluate(FOCUSED)
    page.evaluate("station.store.take({ kind: 'command', number: -1, over: true, lights: [], answer: [], text: 'ping', line: 'ping all' })")
    assert page.evaluate(FOCUSED) == chosen != "" and chosen.startswith("ACTUATORS.")


def test_the_page_report_html_moves_a_free_body(browser, session_directory):
    """Mission actuators: a satellite without joints, whose pose is in the truth only."""
    flight = flying.fly(session_directory / "free-body", "--mission", "actuators", "--scenario", "actuators", "--form", "image", report="yes")
    bases = runs.load(flight.directory, has_buses=False).truth["BASE"]
    with browser.new_context(viewport={"width": 1024, "height": 768}, bypass_csp=True) as context:
        page = context.new_page()
        page.set_default_timeout(LIMIT_MS)
        faults = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto((flight.directory / "report.html").resolve().as_uri())
        station.until(page, "Boolean(window.station?.replay?.film)")
        for seconds in (14.0, 11.0):
            page.evaluate("seconds => station.replay.seek(seconds)", seconds)
            row = station.nearest(bases["time_us"] / 1e6, seconds)
            place = page.evaluate("station.scene.bodies[0].arm.node.matrix.elements.slice(12, 15)")
            assert place == pytest.approx(list(bases["position_m"][row, 0]), abs=1e-5) and abs(place[0]) > 1e-3
        page.evaluate("station.replay.seek(0)")
        assert page.evaluate("station.scene.bodies[0].arm.node.matrix.elements.slice(12, 15)") == pytest.approx([0, 0, 0], abs=1e-9)
        assert page.get_attribute("[data-source=telemetry]:disabled", "title") == "The recording has no position of the robot in the telemetry"
        page.screenshot(path=str(session_directory / "report-free-body.png"))
        lines = [f"ACTUATORS {leaf}.{n}" for leaf, count in (("POSITION", 8), ("TORQUE", 4)) for n in range(1, count + 1)]  # Three strips.
        no_robot = ["This mission has no robot that can be drawn.", 0, lines, "The whole flight", True, "No charts yet: P adds a parameter."]
        assert page.evaluate(EMPTY) == no_robot
        fixed, free = (abs(base[0] - tip[0]) for base, tip in (page.evaluate(FRAMED, is_free) for is_free in (False, True)))
        assert free > 1.3 * fixed  # From the side of the arm.
        assert page.evaluate(COVERED) == []
        page.set_viewport_size({"width": 390, "height": 844})
        assert page.evaluate(COVERED) == []
        ends = page.evaluate(FRAMED, False)
        assert all(abs(x) < 0.95 and abs(y) < 0.95 for x, y in ends)
        assert all(abs(one + other) / 2 < 0.25 for one, other in zip(*ends))
        assert not faults


def test_a_robot_is_drawn_by_the_visuals_of_its_urdf(browser, directory, session_directory):
    """A mesh and a coloured cylinder move with their links; there are no shells and housings beside them."""
    world = pressing.write_world(directory / "world")
    urdf = directory / "world" / "rokviss.urdf"
    corners = ((0, 0, 0), (220, 0, 0), (0, 0, 80)), ((0, 0, 0), (0, 60, 0), (220, 0, 0))  # mm
    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for corner in three for x in corner), 0) for three in corners)
    (directory / "world" / "upper.stl").write_bytes(b"\0" * 80 + struct.pack("<I", len(corners)) + triangles)
    visuals = {
        "upper": '<visual><geometry><mesh filename="upper.stl" scale="0.001 0.001 0.001"/></geometry></visual>',
        "lower": '<visual><origin xyz="0.1 0 0" rpy="0 1.5708 0"/><geometry><cylinder radius="0.03" length="0.2"/></geometry>'
                 '<material name="blue"><color rgba="0 0 1 1"/></material></visual>',
    }
    text = urdf.read_text(encoding="utf-8")
    for name, visual in visuals.items():
        text = text.replace(f'<link name="{name}">', f'<link name="{name}">{visual}')
    urdf.write_text(text, encoding="utf-8")
    scenario = flying.write_scenario(directory / "short.scn", "0.5 operator shutdown")
    flight = flying.fly(directory / "out", "--scenario", scenario, "--world", world, "--form", "image", report="yes")
    assert flight.code == 0, flight.transcript()
    with browser.new_context(viewport={"width": 1024, "height": 768}, bypass_csp=True) as context:
        page = context.new_page()
        page.set_default_timeout(LIMIT_MS)
        page.goto((directory / "out" / "report.html").resolve().as_uri())
        station.until(page, "Boolean(window.station?.replay?.film)")
        drawn = page.evaluate("""() => {
            const found = [];  // Without the rings of the brakes and the marks of the limits.
            station.scene.bodies[0].arm.node.traverse((node) => {
                if (node.isMesh && !["TorusGeometry", "ConeGeometry"].includes(node.geometry.type)) found.push([node.geometry.type, node.material.color.getHex()]);
            });
            return found;
        }""")
        page.screenshot(path=str(session_directory / "report-visuals.png"))
    kinds = [kind for kind, _ in drawn]
    assert kinds.count("BufferGeometry") == 1 and ["CylinderGeometry", 0x0000FF] in drawn
    assert len(drawn) == 3  # With the collision sphere of the finger, which has no visual.


@pytest.mark.usefixtures("flight")  # The fixture builds the page.
def test_a_wrong_recording_is_refused_with_a_message(browser, directory):
    directory.mkdir(exist_ok=True)
    (directory / "kept.recording").write_text("no recording", encoding="utf-8")
    with station.serving("--replay", directory / "kept.recording") as address, contextlib.closing(station.opened(browser, address, "true")) as refused:
        station.until(refused, "document.querySelector('station-bar').textContent.includes('Cannot replay: expected a recording of a run')")
        assert "No open alarm" not in refused.locator("station-bar").text_content() and not refused.faults
