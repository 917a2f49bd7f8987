# SPDX-License-Identifier: Apache-2.0
"""The page of the station during a telepresence in real time: its joystick presses on the contour, keyboard or finger alone are
enough, tables on board are full, and a device is lost."""

import math
import re
import subprocess

import flying
import pytest
import test_mission_station as station
from browsing import LIMIT_MS, SHIFTS, WATCH_SHIFTS

SCENARIO = [*flying.bring_up(0.2), "3600 operator shutdown"]
# Pixels from the centre of the field, to the right and down, above the contour; the lowest presses with more than 20 N.
ABOVE_PIXELS = (-15, 25)
LOWEST_PIXELS = 70
# A gamepad as Chromium presents it to a page; pad.rumbles lists the effects that the page has played on it.
PAD = """() => {
    const pad = window.pad = {index: 1, id: "pad", connected: true, mapping: "standard", axes: [0, 0, 0, 0], buttons: [], rumbles: []};
    pad.vibrationActuator = {playEffect: (kind, effect) => { pad.rumbles.push({kind, ...effect}); return Promise.resolve("complete"); }};
    Object.defineProperty(navigator, "getGamepads", {value: () => [null, pad], configurable: true});
}"""
RANGE_RAD, DEAD_ZONE = 0.35, 0.08  # Angle of a full deflection on the page, and the share of a deflection that counts as none.
# Code that makes the page lose the control of the hand -> message of the page.
LOSSES = {
    "window.dispatchEvent(new Event('blur'))": "the window lost the focus",
    "Object.defineProperty(document, 'hidden', {value: true, configurable: true});"
    "document.dispatchEvent(new Event('visibilitychange')); delete document.hidden": "the page is hidden",
    "document.querySelector('.field').dispatchEvent(new PointerEvent('pointercancel'))": "the pointer was lost",
    "window.station.store.socket.close()": "link lost",
}
# Record the mission time of the page when it first shows that HAND_POSITION is no longer open.
WATCH_LINKS = """() => {
    const rows = document.querySelector("station-network .links");
    new MutationObserver(() => {
        const said = rows.querySelector("[data-link=HAND_POSITION]")?.textContent ?? "";
        if (!window.closedAt && /closed|failed|stale/.test(said)) window.closedAt = window.station.store.time;
    }).observe(rows, {childList: true, subtree: true, characterData: true});
}"""
# Largest number of entries of the tables of the supervisor in this flight: activities, packet stores, request sequences.
CAPACITIES = {11: 1, 15: 2, 21: 1}
# Commands that prepare a table, fill it ({} is a number), and make room in it.
GROUP = "tc SUPERVISOR 11,22 'n=[{\"group_id\": 1, \"group_status\": \"enabled\"}]'"
TABLES = {
    "schedule": ([GROUP], "at +3000 ping SUPERVISOR", "schedule reset"),
    "packet stores": ([], "store create PAGE{} 65536", "store delete PAGE0"),
    "request sequences": ([], "tc SUPERVISOR 21,1 request_sequence_id=PAGE{} 'n=[{\"request\": \"PING\", \"delay\": 1}]'", "tc SUPERVISOR 21,3 request_sequence_id=PAGE0"),
}
# Perform a command, and return why it was refused; null if it was not.
PERFORM = """async (text) => {
    const { command, refused } = await station.store.ask({ do: "command", text });
    while (!refused && !station.store.commands.get(command)?.over) await new Promise((done) => setTimeout(done, 20));
    return refused ?? station.store.commands.get(command).words ?? null;
}"""
FOCUSED = "document.activeElement.getAttribute('aria-label') ?? document.activeElement.textContent"
# Controls of the page that are too small for a finger, or have no name for a screen reader. Those that are used most are larger.
LEAST_PX = 24
POOR = f"""[...document.querySelectorAll("button, select, input")].filter((node) => node.checkVisibility() && node.offsetParent !== null).filter((node) => {{
    const box = node.getBoundingClientRect(), name = node.getAttribute("aria-label") ?? node.getAttribute("aria-labelledby") ?? node.labels?.[0]?.textContent ?? node.textContent;
    return !name?.trim() || Math.min(box.width, box.height) < {LEAST_PX} || node.closest(".acts, .choices, [role=tablist], .stop") && box.height < 36;
}}).map((node) => node.outerHTML)"""
# Controls that the Tab key must reach, in a part of the page, without those that have had the focus.
CONTROLS = """(part) => [...document.querySelectorAll("a[href], button, select, input, [tabindex='0']")].filter((node) =>
    node.closest(part) && !node.disabled && node.tabIndex >= 0 && !window.reached?.has(node instanceof SVGElement ? node.ariaLabel : node) && node.checkVisibility({ visibilityProperty: true }))
    .map((node) => node.outerHTML.slice(0, 120))"""
# Record the control that has the focus. Returns whether it is in the part, and the control if its ring is not seen.
RING = """(part) => {
    const node = document.activeElement, style = getComputedStyle(node), width = parseFloat(style.outlineWidth), edge = parseFloat(style.outlineOffset) + width;
    if (node === document.body) return [false, null];
    (window.reached ??= new Set()).add(node instanceof SVGElement ? node.ariaLabel : node); // A drawing is made again when it changes.
    const sides = (box) => [box.left, box.top, -box.right, -box.bottom], ring = sides(node.getBoundingClientRect()).map((side) => side - edge);
    const clips = [[0, 0, -innerWidth, -innerHeight]];
    for (let up = node.parentElement; up; up = up.parentElement)
        if (getComputedStyle(up).overflow !== "visible") clips.push(sides(up.getBoundingClientRect()));
    const isCut = clips.some((clip) => clip.some((side, n) => ring[n] < side - 1));
    const isSeen = style.outlineStyle !== "none" && width >= 2 && !isCut && (edge > width || style.outlineColor !== style.backgroundColor);
    return [Boolean(node.closest(part)), isSeen ? null : node.outerHTML.slice(0, 120)];
}"""
# Elements that begin or end outside of the page, and the alarm cell if it has no room for its counts.
WIDE = """[...document.querySelectorAll("header *, .panel, .panel > *, .hud, .head > *")].filter((node) => node.checkVisibility() && (([box]) =>
    box && (box.left < -1 || box.right > innerWidth + 1))(node.getClientRects())).concat([...document.querySelectorAll(".counts > span")].filter((node) =>
    node.getBoundingClientRect().right > document.querySelector(".slot").getBoundingClientRect().right)).map((node) => node.outerHTML.slice(0, 120))"""
# Boxes of the regions of the page, rounded to pixels.
BOXES = """[...document.querySelectorAll('station-bar, station-scene, nav > *, aside > *, station-work, station-log')].map((node) =>
    Object.values(node.getBoundingClientRect().toJSON()).map(Math.round))"""


@pytest.fixture(scope="module")
def flight(session_directory):
    subprocess.run(["make", "-s", "build/station/page/index.html"], cwd=flying.ROOT, check=True)
    scenario = flying.write_scenario(session_directory / "station-telepresence.scn", *SCENARIO)
    root = flying.descriptors_copied(session_directory / "small-tables")
    supervisor = root / "descriptors" / "subsystems" / "supervisor.xml"
    text = supervisor.read_text(encoding="utf-8")
    for service, capacity in CAPACITIES.items():
        text, count = re.subn(rf'(<Service type="{service}" capacity=")\d+"', rf'\g<1>{capacity}"', text)
        assert count == 1, service
    supervisor.write_text(text, encoding="utf-8")
    flight = flying.start(session_directory / "station-telepresence", "--time", "real", "--scenario", scenario, root=root)
    flight.port()
    yield flight
    flight.abandon()


@pytest.fixture(scope="module")
def address(flight):
    with station.serving("--run", flight.directory) as address:
        yield address


@pytest.fixture(scope="module")
def browser():
    with station.browsing() as browser:
        yield browser


READY = "window.station.store.states.get('MANIPULATOR')?.state === 'OPERATIONAL' && window.station.scene.last"


@pytest.fixture(scope="module")
def page(address, browser):
    return station.opened(browser, address, READY)


def test_forms_of_another_interface_are_disabled_with_the_reason(page):
    """Commands that the user has typed are disabled too. A ping can be sent: this request is the same for every interface."""
    words = "MANIPULATOR flies interface 0x0a, the dictionary has 0x0b"

    def take(said):
        page.evaluate("(words) => window.station.store.take({kind: 'mismatch', subsystem: 'MANIPULATOR', words})", said)

    station.choose(page, "MANIPULATOR.STOP")
    page.wait_for_selector(station.SEND + ":not(:disabled)")
    take(words)
    page.wait_for_selector(f"{station.SEND}:disabled ~ .hint:has-text('disabled: {words}')")
    station.choose(page, "MANIPULATOR.MOVE_TO")
    page.wait_for_selector(".form fieldset:disabled label:has-text('POSITION') input:disabled")
    station.choose(page, "cmd MANIPULATOR.STOP")
    page.wait_for_selector(f"{station.SEND}:disabled ~ .hint:has-text('{words}')")
    station.choose(page, "MANIPULATOR: ping")
    page.wait_for_selector(station.SEND + ":not(:disabled)")
    take(None)
    station.choose(page, "MANIPULATOR.STOP")
    page.wait_for_selector(station.SEND + ":not(:disabled)")
    page.fill("#find", "")


class Drag:
    """A drag of the page's joystick: to a place above the contour, then down by one pixel at each check until the finger presses, and back."""

    def __init__(self, page):
        self.page = page
        self.down, self.jitter = 0, 0.0

    def presses(self, force_n):
        """True if the page shows a contact force above this number of newtons; otherwise the hand is moved further down."""
        if self.page.evaluate("window.station.scene.force ?? 0") > force_n:
            return True
        self.take()
        self.down = min(self.down + 1, LOWEST_PIXELS)
        self.move(self.down)
        return False

    def is_free(self):
        """True if the page draws no force; otherwise the hand is moved back to the centre."""
        if self.page.evaluate("!window.station.scene.shaft.visible"):
            return True
        self.take()
        self.move(0)
        return False

    def move(self, down):
        """Move the pointer. Each call adds another fraction of a pixel, because the page keeps the hand only while the pointer moves."""
        self.jitter = 0.2 - self.jitter
        self.page.mouse.move(self.centre[0] + ABOVE_PIXELS[0], self.centre[1] + down + self.jitter)

    def is_held(self):
        """Take the hand. Returns True if the pointer now drags it."""
        self.take()
        self.move(ABOVE_PIXELS[1])
        return self.page.evaluate("Boolean(document.querySelector('station-work').hand.from)")

    def take(self):
        """Take the hand and press the button of the mouse again if the page has given the hand back."""
        page = self.page
        if not page.evaluate("Boolean(document.querySelector('station-work').hand.aim)"):
            page.mouse.up()
            page.click("button:has-text('Take the hand'):not(:disabled)")
            box = page.locator(".field").bounding_box()
            self.centre = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
            page.mouse.move(*self.centre)
            page.mouse.down()
            self.down = ABOVE_PIXELS[1]


def test_the_joystick_of_the_page_presses_on_the_contour(page, flight):
    """The robot feels the contour, the joystick reflects it, and the page draws both forces and another picture."""
    page.click("#work-Operate")
    assert page.evaluate("window.station.scene.shaft.visible") is False
    free = page.locator("station-scene canvas").screenshot()
    drag = Drag(page)
    flying.wait_until(lambda: drag.presses(5.0), "a contact force on the page")
    station.until(page, "window.station.scene.shaft.visible && / N$/.test(window.station.scene.forceLabel.textContent)")
    station.until(page, "Math.hypot(...window.station.store.value('JOYSTICK', 'CUR_VALUES.FELT_TORQUE')) > 0.05")
    station.until(page, "(document.querySelector('station-work').hand.arrow.getAttribute('d') ?? '').startsWith('M')")
    assert page.locator("station-scene canvas").screenshot() != free
    flying.wait_until(drag.is_free, "the finger leaves the contour")
    page.mouse.up()
    page.keyboard.press("Escape")
    flying.wait_until(lambda: "hand rest # station" in flight.read("live.scn"), "the hand is given back")


def rests(flight):
    return flight.read("live.scn").count("hand rest # station")


def aimed(axes):
    """Rest point of the hand for a deflection of a gamepad's stick."""
    size = math.hypot(*axes)
    share = max(0.0, size - DEAD_ZONE) / (1 - DEAD_ZONE) / size * RANGE_RAD
    return f" hand aim {axes[0] * share:.5f} {-axes[1] * share:.5f} "


def deflect(page, x, y):
    page.evaluate("axes => { window.pad.axes = [...axes, 0, 0]; }", [x, y])


def test_a_gamepad_moves_the_hand_and_rumbles_with_the_felt_torque(page, flight):
    """A simulated gamepad presses on the contour and is then disconnected."""
    page.click("#work-Operate")
    page.evaluate(PAD)
    before = rests(flight)
    page.click("button:has-text('Take the hand'):not(:disabled)")
    axes, low = (-0.25, 0.25), 0.25
    deflect(page, *axes)
    page.wait_for_selector("text=Your hand, gamepad 2")
    flying.wait_until(lambda: aimed(axes) in flight.read("live.scn"), "the hand follows the gamepad")

    def rumbles():
        nonlocal low
        low = min(0.9, low + 0.005)
        deflect(page, axes[0], low)
        return page.evaluate("window.pad.rumbles.some((one) => one.strongMagnitude > 0.05)")

    flying.wait_until(rumbles, "the gamepad rumbles")
    played = page.evaluate("window.pad.rumbles")
    felt = page.evaluate("Math.hypot(...window.station.store.value('JOYSTICK', 'CUR_VALUES.FELT_TORQUE'))")
    assert felt > 0.0 and {one["kind"] for one in played} == {"dual-rumble"} and max(one["strongMagnitude"] for one in played) <= 1
    assert 1 <= sum(one["weakMagnitude"] == 1 for one in played) < sum(one["strongMagnitude"] > 0 for one in played)  # A pulse for a contact.
    page.evaluate("window.pad.connected = false")
    page.wait_for_selector("text=Hand given back: the gamepad was disconnected.")
    flying.wait_until(lambda: rests(flight) == before + 1, "the hand is given back")


@pytest.mark.parametrize("loss", LOSSES)
def test_the_hand_is_given_back_when_focus_pointer_or_station_is_lost(page, flight, loss):
    """The page gives the hand back. If its connection to the station ends, the station does so."""
    drag = Drag(page)
    flying.wait_until(drag.is_held, "the hand is taken")
    before = rests(flight)
    page.evaluate(loss)
    page.wait_for_selector(f"text=Hand given back: {LOSSES[loss]}.")
    flying.wait_until(lambda: rests(flight) > before, "the hand is given back")
    assert page.evaluate("document.querySelector('station-work').hand.aim === null")
    page.mouse.up()
    station.until(page, "window.station.store.hasSocket && window.station.store.link.is_live")


def test_only_a_station_that_does_not_answer_loses_the_hand(page, flight):
    """A page that was itself busy for 1.5 s keeps the hand: it may still have to read the answers of that time."""
    drag = Drag(page)
    flying.wait_until(drag.is_held, "the hand is taken")
    before = rests(flight)
    is_kept, note = page.evaluate("""async () => {
        const { hand } = document.querySelector("station-work"), { store } = window.station, answers = [];
        store.live = () => new Promise((answer) => answers.push(answer));
        hand.move(0.01, 0.01);
        hand.sendAim();
        while (!answers.length) await new Promise((wake) => setTimeout(wake, 1));
        const end = performance.now() + 1500;
        while (performance.now() < end);
        hand.tick();
        const isKept = Boolean(hand.aim);
        while (hand.aim) await new Promise((wake) => setTimeout(wake, 1));
        delete store.live;
        for (const answer of answers) answer({});
        store.live("hand rest");
        return [isKept, hand.note];
    }""")
    assert (is_kept, note) == (True, "Hand given back: the station does not answer.")
    flying.wait_until(lambda: rests(flight) > before, "the hand is given back")
    page.mouse.up()


def test_the_name_of_a_curve_is_at_its_end(page):
    """In this test the curve ends in the middle of the chart."""
    placed, end = page.evaluate("""async () => {
        const strip = station.strips.strips[2], { plot } = strip, drawn = [];
        strip.about.lines[0].short = "f";
        strip.put([[0, 15], [1, 2]], [0, 30]);
        await Promise.resolve();
        plot.ctx.fillText = (...words) => drawn.push(words);
        strip.marks(plot);
        delete plot.ctx.fillText;
        delete strip.about.lines[0].short;
        return [drawn[0][1], plot.valToPos(15, "x", true)];
    }""")
    assert end < placed < end + 10


def touch(session, kind, x=None, y=None):
    """A finger on the screen, as Chromium takes it from a touch screen."""
    session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [] if x is None else [{"x": x, "y": y}]})


def test_a_finger_on_a_tablet_opens_tabs_fills_in_forms_and_moves_the_hand(browser, address, session_directory):
    with browser.new_context(viewport={"width": 1024, "height": 768}, has_touch=True, is_mobile=True) as context:
        page = context.new_page()
        page.set_default_timeout(LIMIT_MS)
        page.goto(address)
        station.until(page, READY)
        page.tap("#work-Command")
        page.fill("#find", "MANIPULATOR.MOVE_TO")
        page.tap(".choices button >> nth=0")
        for field, value in (("POSITION", "0.9,-1.3"), ("DURATION", "2")):
            page.tap(f"label:has-text('{field}') input")
            page.keyboard.type(value)
        page.wait_for_selector("text=complete, in range")
        assert page.evaluate(POOR) == []
        page.tap("#work-Operate")
        assert page.evaluate(POOR) == []
        take, hidden = page.locator("button:has-text('Take the hand'):not(:disabled)"), page.locator("station-log").bounding_box()["y"]
        take.wait_for()
        assert take.bounding_box()["y"] + take.bounding_box()["height"] < hidden, "expected a whole button"
        page.screenshot(path=str(session_directory / "page-touch.png"))
        session, touches = context.new_cdp_session(page), 0

        def follows():
            """True if the stick follows the finger."""
            nonlocal touches
            if not page.evaluate("document.querySelector('station-work').hand.from"):
                if touches:
                    touch(session, "touchEnd")
                touches += 1
                if not page.evaluate("document.querySelector('station-work').hand.aim"):
                    take.tap()
                box = page.locator(".field").bounding_box()
                x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
                touch(session, "touchStart", x, y)
                for n in range(6):
                    touch(session, "touchMove", x + 5 * n, y)
            return page.evaluate("window.station.store.value('JOYSTICK', 'CUR_VALUES.POSITION')[0] > 0.05")

        flying.wait_until(follows, "the stick follows the finger")
        touch(session, "touchEnd")

        def is_given_back():
            """True once the user has released the hand. A slow page gives it back by itself; it is then taken again."""
            is_held = page.evaluate("document.querySelector('station-work').hand.aim")
            (page.locator("button:has-text('Give back')") if is_held else take).tap()
            return page.is_visible("text=Hand given back: released.")

        flying.wait_until(is_given_back, "the hand to be released")


def tab_to(page, name):
    """Press the Tab key until the control of this name has the focus."""
    for _ in range(100):
        if page.evaluate(FOCUSED).strip().startswith(name):
            return
        page.keyboard.press("Tab")
    raise AssertionError(f"'{name}' cannot be reached; the focus is at {page.evaluate(FOCUSED)[:100]!r}")


def test_the_keyboard_alone_is_enough(page, flight):
    """The user finds the joystick and moves it, requests a state and reads why a command is refused."""
    page.click("#work-Operate")
    page.evaluate("document.activeElement.blur()")
    page.wait_for_selector("button:has-text('Take the hand'):not(:disabled)")
    tab_to(page, "Take the hand")
    page.keyboard.press("Enter")
    before = flight.read("live.scn").count(" hand aim ")
    page.keyboard.down("ArrowRight")
    flying.wait_until(lambda: re.search(r" hand aim 0\.0[1-9]", flight.read("live.scn")[before:]), "an arrow key moves the hand")
    page.keyboard.up("ArrowRight")
    page.keyboard.press("Escape")
    page.wait_for_selector("text=Hand given back: Esc.")
    for key, state, power in (("4", "SAFE_OPERATIONAL", "45 / 200 W"), ("5", "OPERATIONAL", "135 / 200 W")):
        station.until(page, f"[...document.querySelectorAll('station-states .box.legal')].some((box) => box.textContent.includes('{state}'))")
        page.keyboard.press(key)
        assert page.evaluate(FOCUSED) == "MANIPULATOR: request state"
        page.wait_for_selector("button:has-text('Arm'):not(:disabled)")
        tab_to(page, "Arm")
        page.keyboard.press("Enter")
        tab_to(page, "Send")
        page.keyboard.press("Enter")
        station.until(page, f"window.station.store.states.get('MANIPULATOR').state === '{state}'")
        station.until(page, f"document.querySelector('.power-cell strong').textContent === '{power}'")  # JOYSTICK is OPERATIONAL and needs 15 W.
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("/")
    page.keyboard.type("MANIPULATOR.TARE")
    page.keyboard.press("ArrowDown")
    assert page.evaluate(FOCUSED).startswith("MANIPULATOR.TARE")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    assert page.evaluate(FOCUSED) == "MANIPULATOR.TARE"
    page.wait_for_selector("text=complete, in range")
    page.keyboard.press("Control+Enter")
    page.wait_for_selector("[aria-live=polite] .refusal:has-text('TARE: refused')")


def lost_in(page, part):
    """Press Tab from the present focus until it leaves a part of the page. Returns the controls that were not reached, and those whose focus is
    not seen."""
    page.evaluate(RING, part)  # Without a key no ring is drawn.
    unseen = []
    for _ in range(250):
        page.keyboard.press("Tab")
        is_within, found = page.evaluate(RING, part)
        unseen += [found] if found else []
        if not is_within:
            break
    return page.evaluate(CONTROLS, part), unseen


def test_the_tab_key_reaches_every_control_and_the_focus_is_seen(page):
    """In each tab, too; the list of commands is one stop, and the arrow keys go through it."""
    page.click("#work-Operate")
    page.focus(".skip")  # The first control of the page.
    assert lost_in(page, "body") == ([], [])
    station.choose(page, "TC[3,5]")
    for tab, last in (("Command", "hk_structure_id"), ("Telemetry", "COMMUNICATION 1"), ("Bus", "joystick"), ("On-board", "Upload")):
        page.click(f"#work-{tab}")
        page.wait_for_selector(f"#work-{tab}-panel :text('{last}') >> nth=0")
        page.focus(f"#work-{tab}")
        assert lost_in(page, "station-work") == ([], []), tab


def test_an_event_and_the_time_line_show_their_instant_until_the_flight_is_followed(page):
    page.locator("station-log [aria-label=Events]").press("ArrowDown")  # The keys go through the entries.
    seconds = page.evaluate("(() => { const entry = document.activeElement; entry.click(); return entry.querySelector('.mono').textContent; })()")
    view, first = "(({min, max}) => [min, max])(window.station.strips.strips[1].plot.scales.x)", max(0, float(seconds) - 15)
    assert page.evaluate(view) == pytest.approx([first, first + 30])
    page.click("station-timeline svg", position={"x": 5, "y": 40})
    station.until(page, f"{view}.join() === '0,30' && document.querySelector('.live-mark').textContent.endsWith('s behind')")
    page.keyboard.press("L")
    page.wait_for_selector("station-strips h2:text-is('Last 30 s')")


def test_the_keys_are_listed_and_escape_closes_the_list(page):
    """The keys also act while a button has the focus: the button takes the space bar only."""
    keys, shown = page.locator("#work-Keys"), page.locator("td:has-text('STOP ALL') >> nth=0")
    page.click("#work-Operate")
    page.locator("station-scene canvas").focus()
    page.keyboard.press("?")
    shown.wait_for()
    assert page.evaluate(FOCUSED) == "Keys"
    page.keyboard.press("Escape")
    page.wait_for_selector("#work-Operate[aria-selected=true]")
    assert keys.is_hidden() and page.evaluate("document.activeElement.nodeName") == "CANVAS"
    for is_shown in (True, False):
        page.click("[aria-label='Keys (?)']")
        assert shown.is_visible() == keys.is_visible() == is_shown
    page.evaluate("window.station.store.seen = -1")
    page.focus("[aria-label='Light or dark']")
    page.keyboard.press("a")
    assert page.evaluate("window.station.store.seen === window.station.store.events.length")


@pytest.mark.parametrize("width", [800, 360])
def test_nothing_is_cut_off_on_a_small_screen(page, width):
    """At widths between those of the layouts, too: no text is cut, no box covers another, nothing exceeds the page."""
    page.set_viewport_size({"width": width, "height": 780})
    found = page.evaluate(station.CUT) + page.evaluate(station.OVERLAPPING) + page.evaluate(WIDE)
    page.set_viewport_size({"width": 1440, "height": 900})
    assert found == []


def test_the_commands_of_the_flight_are_saved_as_a_script(page):
    page.click("#work-Command")
    with page.expect_download() as download:
        page.click("button:has-text('Save as script')")
    assert download.value.suggested_filename == "rokviss.scn"
    with open(download.value.path(), encoding="utf-8") as file:
        lines = [line.split(maxsplit=1)[1] for line in file if line.strip() and not line.startswith("#")]
    assert [line.strip() for line in lines][-3:] == [f"operator {words}" for words in
                                                     ("state MANIPULATOR SAFE_OPERATIONAL", "state MANIPULATOR OPERATIONAL", "try cmd MANIPULATOR.TARE")]


def sent(page, words):
    """Send a command as typed, and return the text of its result."""
    page.click("#work-Command")
    page.fill("#find", words)
    page.click(".choices button:has-text('as typed')")
    page.wait_for_selector("text=complete, in range")
    if page.is_visible("button:has-text('Arm')"):
        page.click("button:has-text('Arm')")
    page.click(station.SEND + ":not(:disabled)")
    return page.inner_text(".form [aria-live=polite]:has-text('completed'), .form .refusal:has(strong)")


@pytest.mark.parametrize("table", TABLES)
def test_a_full_table_is_refused_with_a_message_and_takes_entries_again(page, table):
    prepare, fill, make_room = TABLES[table]
    fill = fill.replace("PING", page.evaluate("station.store.ask({do: 'plan', text: 'ping SUPERVISOR'})")["octets"][0])
    for words in prepare:
        assert page.evaluate(PERFORM, words) is None
    results = []
    while len(results) <= max(CAPACITIES.values()) and not any(results):
        results.append(page.evaluate(PERFORM, fill.replace("{}", str(len(results)), 1)))
    assert len(results) > 1 and "full" in results[-1]
    refused = sent(page, fill.replace("{}", "9", 1))
    assert "full" in refused and "0x0205" in refused
    assert page.evaluate(PERFORM, make_room) is None
    assert "completed" in sent(page, fill.replace("{}", "9", 1))
    assert not page.faults


def test_the_page_says_that_a_configuration_has_no_display_structure(page):
    page.click("#work-Telemetry")
    for ids, words in (([], ", no display structure"), ([4720], "")):
        page.evaluate("""(ids) => { for (const part of window.station.store.subsystem('MANIPULATOR').configurations)
            for (const one of part.structures) one.display = ids.includes(one.id); }""", ids)
        page.wait_for_selector("station-scene .hud:text-is('no display structure')", state="visible" if words else "hidden")
        page.wait_for_selector(f"section[aria-label='MANIPULATOR 4711'] .hint:text-matches('reports{words}$')")


def test_a_parameter_is_dragged_into_the_charts(page):
    page.click("#work-Telemetry")
    page.fill("[aria-label='Filter of parameters']", "manipulator 4720 velocity")
    station.until(page, "document.querySelectorAll('section:has(.chart)').length === 1")
    count = page.locator(".strip").count()
    page.locator("section tr[draggable] >> nth=1").drag_to(page.locator("station-strips"))
    page.locator("[aria-label='Remove MANIPULATOR VELOCITY.2']").wait_for()
    assert page.locator(".strip").count() == count + 1
    page.click("[aria-label='Remove MANIPULATOR VELOCITY.2']")
    page.fill("[aria-label='Filter of parameters']", "")


def test_charts_are_zoomed_held_and_read_at_the_pointer(page):
    title, view = page.locator("station-strips h2"), "(({min, max}) => [min, max])(window.station.strips.strips[1].plot.scales.x)"
    box = page.locator(".strip .u-over >> nth=0").bounding_box()
    x, y = box["x"] + box["width"] * 0.7, box["y"] + 20
    page.mouse.move(x, y)
    page.wait_for_selector("station-strips h2:text-matches('^Last 30 s, at [0-9.]+ s$')")
    # All strips show their values at the same instant.
    assert page.evaluate("""() => { const { strips } = window.station.strips; window.station.strips.draw();
        return strips.every((strip) => strip.plot.cursor.left > 0 && strip.values.every((value, n) => {
            const wanted = strip.plot.data[n + 1][strip.plot.cursor.idx];
            return wanted === null || wanted === undefined ? value.textContent === "–" : Math.abs(Number(value.textContent.replace("−", "-")) - wanted) < 0.06; })); }""")
    page.mouse.down()
    page.mouse.move(x + 100, y, steps=4)
    page.mouse.up()
    station.until(page, "(({min, max}) => max - min < 12)(window.station.strips.strips[1].plot.scales.x)")
    assert title.inner_text().startswith("Zoomed")
    zoomed = page.evaluate(view)
    page.mouse.dblclick(x, y)
    page.mouse.move(x, box["y"] - 40)
    page.wait_for_selector("station-strips h2:text-is('Last 30 s')")
    page.click("[aria-label='Hold the view']")
    page.wait_for_selector("station-strips h2:text-is('Held')")
    held = page.evaluate(view)
    now = page.evaluate("window.station.store.time")
    station.until(page, f"window.station.store.time > {now} + 0.5")
    assert page.evaluate(view) == held != zoomed
    page.click("[aria-label='Hold the view']")
    station.until(page, f"{view}[1] > {held[1]} + 0.5")


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_a_device_that_is_unplugged_is_an_alarm_that_everybody_can_read(page, flight, theme, session_directory):
    """The fault comes from the command line; the page shows it without a change of the layout, and axe finds nothing serious."""
    if theme == "dark":
        station.until(page, "['HAND_POSITION', 'ROBOT_STATE'].every((name) => window.station.store.links.some((row) => row.name === name && row.state === 'open'))")
        boxes = page.evaluate(BOXES)
        page.evaluate(WATCH_LINKS)
        page.evaluate(WATCH_SHIFTS)
        answer = flying.gse(flight, "--run", flight.directory, "fault", "unplug", "robot", "JOINT1")
        assert answer.returncode == 0, answer.stderr
        page.wait_for_selector("station-log .entry.critical:has-text('MANIPULATOR DEVICE_LOST A device does not answer any more: node JOINT1 (0x11)')")
        page.wait_for_selector("[data-link=HAND_POSITION]:has-text('closed')")
        # In the network drawing the line to the lost device is broken, and the other line is not.
        broken = "[...document.querySelectorAll('station-network .graph rect.broken + .device')].map((node) => node.textContent).join()"
        station.until(page, f"{broken} === 'JOINT1'")
        assert page.evaluate(BOXES) == boxes and page.evaluate(SHIFTS) == []
        # Both in mission time, so that a slow machine changes nothing: the links are closed after the event.
        lost = page.evaluate("window.station.store.events.findLast((event) => event.event === 'DEVICE_LOST').time")
        assert lost - 1e-6 <= page.evaluate("window.closedAt") < lost + 1.0
    found = station.accessibility(page, theme)
    page.screenshot(path=str(session_directory / f"page-alarm-{theme}.png"))
    assert not found
    if theme == "light":
        page.click(".slot button:has-text('Seen')")
        page.wait_for_selector("station-log .unseen-high", state="detached")
        assert page.is_hidden(".slot button:has-text('Seen')")


def test_nothing_fails_on_the_page(page):
    assert page.faults == []
