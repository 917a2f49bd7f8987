# SPDX-License-Identifier: Apache-2.0
"""The light station in a browser, beside a flight in real time: what the page shows of telecommands, refusals, hand and lost link."""

import json
import os
import re
import signal
import subprocess

import flying
import pytest
from browsing import browsing, opened, serving, until
from hirosco_gse import run as runs

AXE = flying.ROOT / "build" / "station" / "node_modules" / "axe-core" / "axe.min.js"
SEND = "station-work button.go"  # The time line has a button of this class, too, which is hidden in a flight.
SIZES = {"laptop": (1440, 900), "tablet": (1024, 768), "phone": (390, 844)}
TABS = {("laptop", "dark"): ["Operate", "Telemetry"], ("laptop", "light"): ["Keys", "On-board"], ("tablet", "dark"): ["State", "Command"],
        ("tablet", "light"): ["Network", "Bus"], ("phone", "dark"): ["Operate"], ("phone", "light"): ["Operate"]}
QUICK_VIEWS = [("laptop", "dark"), ("tablet", "light"), ("phone", "light")]  # The others with LONG=1.
PAUSE_MS = 1200  # Longer than a report of the display structure, or the status of a subsystem, may be late.
# Ages of subsystems and structures, and the number of ages in the tab Telemetry that are cut off at the right edge of their scroll area.
AGES = "[...document.querySelectorAll('station-subsystems .age, .readings .age')].map((age) => age.textContent)"
AGES_OUTSIDE = """[...document.querySelectorAll('.readings .age')].filter((age) =>
    age.getBoundingClientRect().right > age.closest('.scroll').getBoundingClientRect().right).length"""
# Texts of the bar, cells of the tab Telemetry, and legends of charts, that do not fit their boxes.
CUT = """[...document.querySelectorAll('station-bar, station-bar *, .readings td, .strip .legend')].filter((node) =>
    node.clientWidth && (node.scrollWidth > node.clientWidth + 1 || node.getBoundingClientRect().right > innerWidth + 1)).map((node) => node.textContent)"""
# Pairs of boxes over the scene that cover each other.
OVERLAPPING = """(() => {
    const boxes = [...document.querySelectorAll('station-scene .hud')].map((node) => [node.className, node.getBoundingClientRect()]).filter(([, box]) => box.width);
    return boxes.flatMap(([name, a], n) => boxes.slice(n + 1).filter(([, b]) =>
        a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom).map(([other]) => `${name} / ${other}`));
})()"""
# How often a jump of a replay draws the network, and how many parts the hidden time line draws at once.
DRAWN_BY_A_JUMP = """async () => {
    const network = document.querySelector("station-network"), line = document.querySelector("station-timeline");
    station.replay.seek(station.replay.end);
    await Promise.resolve();
    let count = 0; network.draw = () => { count++; Object.getPrototypeOf(network).draw.call(network); };
    station.replay.seek(0);
    await Promise.resolve();
    delete network.draw;
    line.drawing.replaceChildren();
    line.draw();
    return [count, line.drawing.childElementCount];
}"""
SCENARIO = """
0.0 hand rest
0.2 operator state MANIPULATOR PRE_OPERATIONAL
0.2 operator state JOYSTICK PRE_OPERATIONAL
1.0 operator config MANIPULATOR STAND_ALONE
1.0 operator config JOYSTICK STAND_ALONE
1.5 operator state MANIPULATOR SAFE_OPERATIONAL
1.5 operator state JOYSTICK SAFE_OPERATIONAL
2.0 operator state MANIPULATOR OPERATIONAL
2.0 operator state JOYSTICK OPERATIONAL
3600 operator shutdown
"""


@pytest.fixture(scope="module")
def flight(session_directory):
    subprocess.run(["make", "-s", "build/station/page/index.html"], cwd=flying.ROOT, check=True)
    scenario = session_directory / "station.scn"
    scenario.write_text(SCENARIO, encoding="utf-8")
    flight = flying.start(session_directory / "station", "--time", "real", "--scenario", scenario)
    flight.port()
    yield flight
    flight.abandon()


@pytest.fixture(scope="module")
def address(flight):
    with serving("--run", flight.directory) as address:
        yield address


@pytest.fixture(scope="module")
def browser():
    with browsing() as browser:
        yield browser


@pytest.fixture(scope="module")
def page(address, browser):
    """The page, with joints whose position telemetry has set."""
    return opened(browser, address, "window.station.store.states.get('MANIPULATOR')?.state === 'OPERATIONAL' && window.station.scene.last")


def accessibility(page, theme):
    """Serious and critical findings of axe in a theme."""
    page.evaluate("theme => { document.documentElement.dataset.theme = theme; window.station.store.tell('theme'); }", theme)
    page.evaluate(AXE.read_text(encoding="utf-8"))
    found = page.evaluate("axe.run(document, {runOnly: ['wcag2a', 'wcag2aa', 'wcag21aa', 'best-practice']})")
    return [f"{rule['id']}: {rule['nodes'][0]['html']}" for rule in found["violations"] if rule["impact"] in ("serious", "critical")]


def choose(page, name):
    """Open the form of a command."""
    page.click("#work-Command")
    page.fill("#find", name)
    page.click(".choices button >> nth=0")


def test_a_telecommand_moves_the_joint_of_the_scene(page):
    choose(page, "MANIPULATOR.MOVE_TO")
    page.fill("label:has-text('POSITION') input", "0.9,-1.3")
    page.fill("label:has-text('DURATION') input", "2")
    page.click(SEND + ":not(:disabled)")
    until(page, "Math.abs(window.station.scene.joints[0] - 0.9) < 0.002 && Math.abs(window.station.scene.joints[1] + 1.3) < 0.002")
    page.wait_for_selector("station-work [aria-label='accepted done, started done, step not reported, completed done']")
    page.click("#log-Commands")  # The list has the command with its arguments.
    page.wait_for_selector("station-log button.again:text-is('cmd MANIPULATOR.MOVE_TO POSITION=0.9,-1.3 DURATION=2')")
    page.click("#log-Events")


def test_the_fastest_structure_moves_the_robot(page):
    """MANIPULATOR reports its positions in two structures, 4 and 20 times a second."""
    page.wait_for_selector("station-scene button:text-is('Telemetry 20 Hz')")
    assert page.evaluate("[station.scene.last.structure, station.store.reports.has('MANIPULATOR/4711')]") == [4720, True]


def test_a_value_out_of_range_is_not_sent(page):
    choose(page, "MANIPULATOR.MOVE_TO")
    page.fill("label:has-text('POSITION') input", "9,0")
    page.fill("label:has-text('DURATION') input", "0.5")
    page.wait_for_selector("text=POSITION, rad: 9 rad is above 2.8 rad")
    assert page.is_disabled(SEND)


def test_a_refusal_contains_its_reason(page):
    choose(page, "MANIPULATOR.TARE")
    page.click(SEND + ":not(:disabled)")
    page.wait_for_selector(".refusal:has-text('refused')")
    assert "0x" in page.inner_text(".refusal .mono")


def test_a_critical_command_is_armed_first(page):
    choose(page, "mission mode")
    page.select_option("label select", "NOMINAL")
    page.wait_for_selector("button:has-text('Arm'):not(:disabled)")
    assert page.is_disabled(SEND)
    page.click("button:has-text('Arm')")
    assert page.is_enabled(SEND)
    page.keyboard.press("Escape")
    page.wait_for_selector(SEND + ":disabled")


def test_a_request_of_the_catalogue_is_filled_in_and_repeated(page):
    """A request with a group of fields is sent, and sent once more from the list of commands."""
    choose(page, "TC[3,5]")
    page.select_option("label:has-text('Subsystem') select", "MANIPULATOR")
    page.fill("label:has-text('hk_structure_id') input", "4711")
    page.wait_for_selector("text=TC[3,5]: complete, in range")
    page.click(SEND + ":not(:disabled)")
    page.wait_for_selector("station-work [aria-label='accepted done, started done, step not reported, completed done']")
    page.click("#log-Commands")
    page.click("station-log button.again:has-text('tc MANIPULATOR 3,5') >> nth=0")
    page.wait_for_selector("text=TC[3,5]: complete, in range")
    page.wait_for_selector("text=tc MANIPULATOR 3,5 'n=[{\"hk_structure_id\": 4711}]' >> nth=0")


def section(page, name):
    """Table of a housekeeping structure in the tab Telemetry."""
    return page.locator(f"section[aria-label='{name}']")


def test_every_structure_is_a_table_with_age_and_switch(page):
    """A structure that is disabled is shown as stale, and its switch enables it again."""
    page.click("#work-Telemetry")
    page.fill("[aria-label='Filter of parameters']", "velocity")
    until(page, "document.querySelectorAll('section:has(.chart)').length >= 4")
    table = section(page, "JOYSTICK 4711")
    table.locator("button:has-text('Disable')").click()
    table.locator("tr.stale >> nth=0").wait_for()
    table.locator("button:has-text('Enable')").click()
    table.locator("tbody tr:not(.stale) >> nth=0").wait_for()
    page.fill("[aria-label='Filter of parameters']", "")
    section(page, "COMMUNICATION 1").locator("text=TM_DROPPED").wait_for()


def test_a_statusword_is_shown_by_its_state_and_flags(page):
    page.click("#work-Telemetry")
    row = section(page, "MANIPULATOR 4711").locator("tr:has-text('STATUSWORD.1')")
    row.locator(".value:text-is('OPERATION_ENABLED')").wait_for()
    assert re.fullmatch(r"0x[0-9A-F]{4}: .*VOLTAGE_ENABLED.*", row.locator("td.worded").get_attribute("title"))


def test_a_parameter_goes_into_the_strip_charts(page):
    """Four lines of one unit fill a strip; the fifth begins another one."""
    page.click("#work-Telemetry")
    page.fill("[aria-label='Filter of parameters']", "4720 velocity")
    until(page, "document.querySelectorAll('section:has(.chart)').length === 2")
    buttons = page.locator("section button.chart")
    assert buttons.count() == 4
    for number in range(4):
        buttons.nth(number).click()
    page.fill("[aria-label='Filter of parameters']", "joystick 4711 velocity")
    until(page, "document.querySelectorAll('section:has(.chart)').length === 1")
    buttons.nth(0).click()
    assert page.locator(".strip").count() == 5
    until(page, "window.station.strips.strips[3].plot.data[4].some((value) => typeof value === 'number')")
    for button in page.locator("button.away").all()[::-1]:
        button.click()
    assert page.locator(".strip").count() == 3
    page.fill("[aria-label='Filter of parameters']", "")


def test_frames_of_a_bus_are_decoded_while_the_tab_is_open(page, flight):
    """Listening adds no node to the bus and no line to the recording."""
    page.click("#work-Bus")
    page.wait_for_selector(".frames td:has-text('JOINT1_TPDO1')")
    page.wait_for_selector(".frames .below td:has-text('Statusword OPERATION_ENABLED, PositionActualValue') >> nth=0")
    until(page, "/^[1-9][0-9]? %$/.test(document.querySelector('.four .value').textContent)")
    # The station adds a warning to its messages while a subsystem flies another interface than that of the database.
    reported = page.evaluate("""(() => { const { store } = window.station, tab = document.querySelector('station-work').bus, said = store.buses.get(tab.name);
        store.buses.set(tab.name, { ...said, warning: "MANIPULATOR flies interface 0x0a" }); tab.draw();
        const words = tab.words.textContent; store.buses.set(tab.name, { problem: "no port" }); tab.draw(); const ended = tab.words.textContent;
        store.buses.set(tab.name, { ...said, frames: said.frames.slice(0, 1), error_count: 1 }); tab.draw(); const one = tab.words.textContent;
        store.buses.set(tab.name, said); tab.draw(); return [words, tab.words.textContent, ended, one]; })()""")
    assert reported[3] == "1 identifier, 1 error frame since this tab is open"
    assert re.fullmatch(r"MANIPULATOR flies interface 0x0a\. \d+ identifiers, 0 error frames since this tab is open", reported[0])
    assert reported[1] == reported[0].removeprefix("MANIPULATOR flies interface 0x0a. ") and reported[2] == "No frames: no port"
    page.click("#work-Operate")
    assert "frames" not in flight.read("live.scn")


def test_a_procedure_and_a_file_are_uploaded_and_listed(page):
    """A command for a listed procedure is prepared in the tab Command."""
    page.click("#work-On-board")
    page.set_input_files("section[aria-label='Upload'] input[type=file]", {"name": "a.lua", "mimeType": "text/plain", "buffer": b"local a = 1\n"})
    for path, kind, section_ in (("STATION", "as procedure", "Procedures"), ("/sta tion.lua", "as file", "Files")):
        page.fill("[aria-label='Name of a procedure, or path on board']", path)
        page.click(f"button:has-text('{kind}')")
        section(page, section_).locator(f"td:has-text('{path.strip('/')}')").wait_for()
    for command, request in (("procedure run STATION", "18,3"), ("file delete '/sta tion.lua'", "23,2")):
        page.click("#work-On-board")
        page.click(f'[aria-label="{command}"]')
        page.wait_for_selector(f"text=TC[{request}]: complete, in range")


def test_a_stale_force_is_not_drawn(page):
    shown = page.evaluate("""() => {
      const scene = window.station.scene, seen = scene.last.seen;
      scene.last.seen -= 5000; scene.dim();
      const found = [scene.veil.hidden, scene.shaft.visible, scene.forceLabel.hidden, scene.values.force.textContent];
      scene.last.seen = seen; return found;
    }""")
    assert shown == [False, False, True, "–"]
    page.wait_for_selector(".veil", state="hidden")


def test_pictures_are_drawn_when_something_has_changed(page):
    """A scene that gets no reports is drawn once more with all pixels. A change of the view draws one picture; a report that differs
    by noise only draws none. The page does not wait for the processors, which draw the pictures here. While the page holds the hand,
    whose lines need the processors, a scene at rest is not drawn once more, and slow pictures have fewer pixels."""
    drawn = page.evaluate("""async () => {
        const { scene } = window.station, { pictures, renderer } = scene, { render } = renderer, { pace } = pictures;
        const scales = [], shown = pictures.shown, rest = () => new Promise((done) => { pictures.shown = () => { shown(); done(); }; });
        renderer.render = (...words) => { scales.push(renderer.getPixelRatio()); render.call(renderer, ...words); };
        scene.move = () => {};
        await new Promise((done) => setTimeout(done, 400));
        while (pictures.isBusy || pictures.isWanted || !pictures.isFine) await new Promise((done) => setTimeout(done, 20));
        const atRest = scales.length;
        await new Promise((done) => setTimeout(done, 200));
        const { store } = window.station, { hand } = store;
        store.hand = { page: store.page, other: null };
        await pictures.rest();
        clearTimeout(pictures.resting);
        store.hand = hand;
        const slow = (isHeld) => { const one = new pace.constructor(); for (let n = 0; n < 3; n++) one.note(0, 20, isHeld); return one.scale; };
        const later = scales.length, next = rest();
        scene.view("Side");
        const isBegun = scales.length > later;
        await next;
        const found = [scales[atRest - 1], later - atRest, isBegun, scales.length - later, scales.at(-1) === pace.scale];
        const data = pictures.context.getImageData(0, 0, pictures.canvas.width, pictures.canvas.height).data;
        [pictures.shown, renderer.render] = [shown, render];
        delete scene.move;
        scene.view("Iso");
        const { last } = scene, drawn = (later, size) => {
            scene.last = { ...last, time: last.time + later, positions: last.positions.map((value) => value + size), at: 0 };
            return scene.frame();
        };
        drawn(0.01, 0);
        const noise = [drawn(0.02, 2e-5), drawn(0.03, 1e-2)], moved = (period) => {
            scene.before = last.positions.map((value) => value + 1);
            scene.last = { ...last, time: last.time + 0.04, at: performance.now(), period };
            scene.move();
            return Math.abs(scene.drawn[0] - last.positions[0]) < 1e-9;
        };
        return [...found, new Set(new Uint32Array(data.buffer)).size > 50, ...noise, moved(50), moved(300), slow(false), slow(true)];
    }""")
    # Pixel ratio of the last picture at rest; pictures at rest; whether view() draws at once; pictures for the
    # change; whether the change has the pixel ratio of the pace; whether a picture has more than 50 colours;
    # whether noise requests a picture, and whether a movement does; whether the scene shows the last report of
    # a structure at once if its period is 50 ms, and if it is 300 ms; pixel ratio after slow pictures, without
    # and with the hand.
    assert drawn == [2, 0, False, 1, True, True, False, True, True, False, 1, 0.7]


def pulled(page):
    """True if the stick follows the hand. The page returns the hand after 2 s without input; then take and
    drag it again."""
    if not page.evaluate("document.querySelector('station-work').hand.aim"):
        page.mouse.up()
        page.click("button:has-text('Take the hand')")
        box = page.locator(".field").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 30, y, steps=5)
    return page.evaluate("window.station.store.value('JOYSTICK', 'CUR_VALUES.POSITION')[0] > 0.05")


def test_the_hand_moves_the_stick(page, flight):
    page.click("#work-Operate")
    page.wait_for_selector("button:has-text('Take the hand'):not(:disabled)")
    flying.wait_until(lambda: pulled(page), "the stick follows the hand")
    page.mouse.up()
    page.keyboard.press("Escape")
    flying.wait_until(lambda: "hand rest # station" in flight.read("live.scn"), "the hand is given back")
    assert " hand aim " in flight.read("live.scn")


def at_rest(page, expression):
    """The value of an expression once it is the same twice: the page draws some periods behind the flight."""
    values = [page.evaluate(expression)]
    while len(values) < 100 and (len(values) < 2 or values[-1] != values[-2]):
        page.wait_for_timeout(300)
        values.append(page.evaluate(expression))
    return values[-1]


@pytest.fixture
def resumed(page):
    """The flight continues after the test, whatever its result."""
    yield
    if page.get_attribute("[aria-label='Pause the world (Space)']", "aria-pressed") == "true":
        page.click("[aria-label='Pause the world (Space)']")


def test_the_page_pauses_simulated_time(page, resumed):
    """In the middle of a movement robot, clock and ages stand still, and nothing becomes stale; a step moves the robot."""
    present = "[...window.station.scene.joints, window.station.store.now()]"
    page.evaluate("window.station.store.command('cmd MANIPULATOR.MOVE_TO POSITION=0.4,-0.8 DURATION=10')")
    start = page.evaluate("window.station.scene.joints[0]")
    until(page, f"Math.abs(window.station.scene.joints[0] - {start}) > 0.02")
    page.click("[aria-label='Pause the world (Space)']")
    page.wait_for_selector("[aria-label='Pause the world (Space)'][aria-pressed='true']")
    before = at_rest(page, f"[{present}, {AGES}]")
    page.wait_for_timeout(PAUSE_MS)
    assert page.evaluate(f"[{present}, {AGES}]") == before
    assert abs(before[0][0] - 0.4) > 0.02, "the movement has ended before the pause"
    assert page.locator(".veil").is_hidden() and page.locator(".row.stale").count() == 0
    page.click("[aria-label='Step 0.1 s (.)']")
    until(page, f"{present}[0] !== {before[0][0]}")
    assert page.get_attribute("[aria-label='Pause the world (Space)']", "aria-pressed") == "true"
    page.click("[aria-label='Pause the world (Space)']")
    page.wait_for_selector("[aria-label='Pause the world (Space)'][aria-pressed='false']")
    until(page, "window.station.store.freshness('SUPERVISOR', 1) === 'live'")  # On a slow machine the flight lags behind the wall clock.
    until(page, "Math.abs(window.station.scene.joints[0] - 0.4) < 0.002")


@pytest.mark.parametrize(("size", "theme"), [pytest.param(*view, id="-".join(view), marks=() if view in QUICK_VIEWS else pytest.mark.long) for view in TABS])
def test_the_page_is_accessible(page, theme, size, session_directory):
    page.set_viewport_size(dict(zip(("width", "height"), SIZES[size])))
    found = []
    for tab in TABS[size, theme][0 if os.environ.get("LONG") else -1:]:
        page.evaluate("tab => document.getElementById(`work-${tab}`).click()", tab)
        found += [*accessibility(page, theme), *page.evaluate(CUT), *page.evaluate(OVERLAPPING)]
        page.screenshot(path=str(session_directory / f"page-{size}-{theme}-{tab}.png"))
    page.set_viewport_size({"width": 1440, "height": 900})
    assert not found


def test_the_truth_of_the_simulator_moves_the_robot_and_is_marked(page):
    """The selection of the truth is not recorded, because it changes nothing in the flight. The other button
    selects telemetry again."""
    page.click("station-scene button:text-is('Truth')")
    page.wait_for_selector("station-scene.truth .hud:has-text('truth 20 Hz')")
    until(page, "window.station.scene.last.values['CUR_VALUES.TORQUE'] && !window.station.scene.last.values['CUR_VALUES.STATE']")
    seen, reported = page.evaluate("[window.station.scene.joints, window.station.store.value('MANIPULATOR', 'CUR_VALUES.POSITION')]")
    assert seen == pytest.approx(reported, abs=5e-3)
    page.click("station-scene button:has-text('Telemetry')")
    until(page, "window.station.scene.last.values['CUR_VALUES.STATE'] && !window.station.scene.classList.contains('truth')")


def test_brakes_are_those_of_telemetry_and_agree_with_the_truth(page):
    """The statusword says which drives control their motors: those have released their brakes."""
    held = "window.station.scene.arm.brakes.map(({ isHeld }) => isHeld)"
    assert not page.evaluate("window.station.scene.classList.contains('truth')")
    until(page, f"{held}.join() === 'false,false'")
    assert page.evaluate("window.station.store.value('MANIPULATOR', 'CUR_VALUES.STATUSWORD').map((word) => word & 0x6f)") == [0x27, 0x27]
    shown = page.evaluate(f"""(() => {{ const {{ last }} = window.station.scene, values = {{ ...last.values, "CUR_VALUES.STATUSWORD": [0x233, 0x237] }};
        window.station.scene.take({{ subsystem: "MANIPULATOR", time: last.time + 0.001, values }}); window.station.scene.frame(); return {held}; }})()""")
    assert shown == [True, False]  # The call that changes the statuswords also reads the brakes, so no report of the flight comes between.
    page.click("station-scene button:text-is('Truth')")
    until(page, f"window.station.scene.truth.last && {held}.join() === 'false,false'")
    page.click("station-scene button:has-text('Telemetry')")
    until(page, "window.station.scene.last.values['CUR_VALUES.STATE'] && !window.station.scene.classList.contains('truth')")


def test_states_and_network_are_tabs_of_a_tablet(page):
    page.set_viewport_size({"width": 1024, "height": 768})
    page.click("#work-Network")
    page.locator("station-work station-network .link-row >> nth=0").wait_for()
    page.click("#work-State")
    page.locator("station-work station-states .box >> nth=0").wait_for()
    page.set_viewport_size({"width": 1440, "height": 900})
    page.locator("nav station-states").wait_for()
    page.wait_for_selector("#work-State", state="hidden")


def test_stop_all_is_dimmed_only_where_it_can_have_no_effect(page):
    """A station or flight that does not answer executes STOP ALL once it answers again. Without a link, or read only, STOP ALL has no effect."""
    cases = {"live": {"is_live": True, "text": "live"}, "silent": {"is_live": False, "is_silent": True, "text": "no telemetry arrives"},
             "lost": {"is_live": False, "text": "no link"}, "ended": {"is_live": False, "code": 0, "text": "flight ended"}}
    shown = page.evaluate("""(cases) => {
        const { store } = window.station, bar = document.querySelector("station-bar"), { link, hello } = store, look = () => {
            bar.draw();
            return [bar.stop.disabled, Number(getComputedStyle(bar.stop).opacity) < 1];
        };
        const found = Object.fromEntries(Object.entries(cases).map(([name, one]) => { store.link = one; return [name, look()]; }));
        store.link = cases.live;
        store.hello = { ...hello, read_only: true };
        found.read_only = look();
        Object.assign(store, { link, hello });
        bar.draw();
        return found;
    }""", cases)
    assert shown == {"live": [False, False], "silent": [False, False], "lost": [True, True], "ended": [True, True], "read_only": [True, True]}


def test_a_dictionary_of_another_mission_is_a_caution_at_the_link(page):
    """The station publishes such a message when the interface that a subsystem reports is not that of its dictionary."""
    symbol, words, what = page.evaluate("""() => {
        const { store } = window.station, bar = document.querySelector("station-bar"), { link } = store;
        store.link = { is_live: true, text: "live" };
        store.take({ kind: "mismatch", subsystem: "MANIPULATOR", words: "MANIPULATOR flies interface 0x0a, the dictionary has 0x0b" });
        bar.draw();
        const found = [bar.linkSymbol.firstChild.getAttribute("aria-label"), bar.linkText.title, bar.what.textContent];
        store.mismatches.clear();
        store.link = link;
        bar.draw();
        return found;
    }""")
    assert symbol == "other dictionary" and what in words and what.startswith("MANIPULATOR flies interface 0x0a")


def test_a_station_that_is_silent_is_an_alarm(page, address):
    """The connection to the station stays open. The page reports the silence, in its title too, and disables the commands except STOP. When the
    station continues, so does the page."""
    address.process.send_signal(signal.SIGSTOP)
    try:
        page.wait_for_selector(".slot.critical:has-text('Link lost: the station does not answer')")
        page.wait_for_selector(".veil:has-text('the station does not answer; last seen')")
        assert page.title() == "▼ Link lost: the station does not answer: rokviss"
        assert page.inner_text("#alarm-said") == "link lost: the station does not answer"
        assert page.evaluate("window.station.store.barrier()") == "the station does not answer"
        assert page.is_disabled("[aria-label='Pause the world (Space)']") and page.is_enabled(".stop")
        assert page.inner_text(".live-mark") == "LIVE" and page.get_attribute(".live-mark", "href") is None
    finally:
        address.process.send_signal(signal.SIGCONT)
    page.wait_for_selector(".slot:not(.critical):has-text('No open alarm')")
    page.wait_for_selector(".veil", state="hidden")
    assert page.is_enabled("[aria-label='Pause the world (Space)']") and page.title() == "rokviss: ground station"


def test_a_page_that_was_busy_does_not_call_the_station_silent(page):
    """Messages that arrived while the page computed are read after its timers."""
    texts = page.evaluate("""async () => {
        const { store } = window.station, found = [];
        store.on("link", () => found.push(store.link.text));
        const until = performance.now() + 1600;
        while (performance.now() < until);
        await new Promise((done) => setTimeout(done, 500));
        return found;
    }""")
    assert texts == []


def test_the_trace_has_the_reports_that_no_picture_shows(page):
    """A page in the background draws no pictures. When it is shown again, its trace is that of the tip."""
    points = page.evaluate("""async () => {
        const { scene, store } = window.station, before = scene.last.time;
        scene.frame = () => false;
        await store.command("cmd MANIPULATOR.MOVE_TO POSITION=0.9,-1.3 DURATION=0.5");
        while (scene.last.time < before + 1.5) await new Promise((done) => setTimeout(done, 50));
        delete scene.frame;
        return scene.trace.filter(([time]) => time > before).length;
    }""")
    assert points >= 20


def test_only_the_present_state_is_marked(page):
    """States that the subsystem has left lose their symbols. The last housekeeping report of the flight is made in SAFE_OPERATIONAL."""
    reported = ".readings .value.word >> nth=0"
    for state in ("SAFE_OPERATIONAL", "PRE_OPERATIONAL"):
        page.evaluate("state => window.station.store.command(`state MANIPULATOR ${state}`)", state)
        until(page, f"window.station.store.states.get('MANIPULATOR').state === '{state}'")
        # The page shows a report in its next picture, and housekeeping follows the report of the state.
        flying.wait_until(lambda: page.locator("station-states .box .mark:has(svg[aria-label='present'])").count() == 1, "one state that is marked")
        flying.wait_until(lambda: page.inner_text(reported) == "SAFE_OPERATIONAL", "the state in housekeeping")
        assert page.evaluate(AGES_OUTSIDE) == 0, "expected no age hidden by a long name of a state"


def test_the_end_of_the_flight_is_shown_and_is_no_alarm(page, flight):
    """This test ends the flight, so it is the last one that uses the flight."""
    flight.process.send_signal(signal.SIGINT)
    flight.wait()
    facts = json.loads(flight.read("run.json"))
    page.wait_for_selector(f".slot:not(.critical):has-text('Flight ended at {facts['simulated_s']:.2f} s, code 0')")
    page.wait_for_selector(".veil:has-text('last seen')")
    page.wait_for_selector(".link-cell svg[aria-label='ended']")
    assert page.is_disabled(".stop")


def test_nothing_leaves_the_machine_and_nothing_fails(page):
    assert page.outside == [] and page.faults == []


def nearest(times, seconds):
    return min(range(len(times)), key=lambda n: abs(times[n] - seconds))


def test_the_flight_that_has_ended_is_replayed(page, address, flight):
    """At any instant, scene, states and housekeeping are those of the logs; commands are disabled, and the
    reason is shown."""
    page.goto(f"{address}?replay")
    until(page, "Boolean(window.station?.replay?.film)")
    run = runs.load(flight.directory, has_buses=False)
    truth = run.truth["JOINTS"]
    end = truth["time_us"][-1] / 1e6
    for share in (0.9, 0.3, 0.5, 0.0, 0.7):
        seconds = page.evaluate("time => { station.replay.seek(time); return station.store.time; }", end * share)
        row = nearest(truth["time_us"] / 1e6, seconds)
        assert page.evaluate("station.scene.joints") == pytest.approx(list(truth["position_rad"][row]), abs=2e-3)
        for name, history in run.states().items():
            past = [state for time, state in history if time <= seconds]
            assert page.evaluate("name => station.store.states.get(name)?.state", name) == (past[-1] if past else None)
    reports = [(time_ns / 1e9, decoded) for time_ns, packet, decoded in run.reports_of("housekeeping")
               if run.dictionary.name_of_apid(packet.apid) == "MANIPULATOR" and "CUR_VALUES" in decoded["values"]]
    page.evaluate("station.replay.use('telemetry')")
    for seconds, decoded in reports[:: len(reports) // 5]:
        page.evaluate("time => station.replay.seek(time)", seconds + 1e-6)
        wanted = pytest.approx(list(decoded["values"]["CUR_VALUES"]["POSITION"]), abs=1e-5)
        assert page.evaluate("station.scene.joints") == wanted
        assert page.evaluate("station.store.value('MANIPULATOR', 'CUR_VALUES.POSITION')") == wanted
    # At this time no subsystem is in a transition, whose phase would replace the reason.
    assert page.evaluate(DRAWN_BY_A_JUMP) == [1, 0]
    page.evaluate("station.replay.seek(0)")
    assert page.is_disabled(".stop")
    assert "takes no commands" in page.inner_text("station-states .reason")
    assert not page.faults


def test_a_jump_makes_no_entry_of_the_log_twice_and_none_that_is_hidden(page):
    """This test continues on the page of the test before."""
    kept, count, commands = page.evaluate("""async () => {
        const log = document.querySelector("station-log"), rest = () => new Promise((done) => setTimeout(done, 300));
        station.replay.seek(station.replay.end); await rest();
        const before = [...log.eventList.children];
        station.replay.seek(station.replay.end / 2); await rest();
        const after = [...log.eventList.children];
        return [after.filter((entry) => before.includes(entry)).length, after.length, log.commandList.childElementCount];
    }""")
    assert kept == count > 0 and commands == 0
    page.click("#log-Commands")
    entries = page.locator("station-log [aria-label='Commands'] .entry")
    assert entries.count() > 5
    # As in a flight, those that the station sent for its page are shown only if the user selects them.
    page.evaluate("station.replay.seek(station.replay.end)")
    assert page.evaluate("[...station.store.commands.values()].filter((call) => call.own).length") == 0
    page.select_option("[aria-label='Commands shown']", "all")
    page.evaluate("station.replay.seek(station.replay.end)")
    until(page, "[...station.store.commands.values()].filter((call) => call.own).length > 10")
    assert not page.evaluate("[...station.store.commands.values()].some((call) => call.own && /^(state|config|cmd|stop)/.test(call.text))")
    page.select_option("[aria-label='Commands shown']", "")
    page.click("#log-Events")


def test_the_player_plays_and_seeks(page):
    """This test continues on the page of the test before."""
    page.evaluate("station.replay.seek(1)")
    page.click("station-player button[aria-label='Play (Space)']")
    until(page, "station.store.time > 1.05")
    page.click("station-player button[aria-label='Pause (Space)']")
    page.focus("[role=slider]")
    page.keyboard.press("End")
    assert page.get_attribute("[role=slider]", "aria-valuenow") == page.get_attribute("[role=slider]", "aria-valuemax")
    page.evaluate("""() => { const { pictures } = station.scene, { draw, pace } = pictures, from = station.store.time;
        pace.wait = () => 1e9; window.drawn = from;
        pictures.draw = (...words) => { if ((window.drawn = station.store.time) !== from) delete pace.wait; return draw(...words); }; }""")
    page.click("[role=slider]")
    until(page, "window.drawn === station.store.time && Math.abs(window.drawn / station.replay.end - 0.5) < 0.01")  # Without the pace.
