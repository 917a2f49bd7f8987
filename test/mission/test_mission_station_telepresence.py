# SPDX-License-Identifier: Apache-2.0
"""The page of the station beside a telepresence by the wall clock: its joystick presses on the contour, and a device is lost."""

import math
import subprocess

import flying
import pytest
import test_mission_station as station

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
# The mission time of the page when it first shows that a link of telepresence is not open any more.
WATCH_LINKS = """() => {
    const rows = document.querySelector("station-network .links");
    new MutationObserver(() => {
        const said = rows.querySelector("[data-link=HAND_POSITION]")?.textContent ?? "";
        if (!window.closedAt && /closed|failed|stale/.test(said)) window.closedAt = window.station.store.time;
    }).observe(rows, {childList: true, subtree: true, characterData: true});
}"""
# Boxes of the regions of the page, rounded to pixels.
BOXES = """[...document.querySelectorAll('station-bar, station-scene, nav > *, aside > *, station-work, station-log')].map((node) =>
    Object.values(node.getBoundingClientRect().toJSON()).map(Math.round))"""


@pytest.fixture(scope="module")
def flight(session_folder):
    subprocess.run(["make", "-s", "build/station/page/index.html"], cwd=flying.ROOT, check=True)
    scenario = flying.write_scenario(session_folder / "station-telepresence.scn", *SCENARIO)
    flight = flying.start(session_folder / "station-telepresence", "--time", "real", "--scenario", scenario)
    flight.port()
    yield flight
    flight.abandon()


@pytest.fixture(scope="module")
def page(flight):
    with station.serving("--run", flight.folder) as address, station.browsing() as browser:
        page = station.opened(browser, address, "window.station.store.states.get('MANIPULATOR')?.state === 'OPERATIONAL' && window.station.scene.last")
        yield page


def test_forms_of_another_interface_are_disabled_with_the_reason(page):
    """Also words that the user has typed. A ping can be sent: that request is the same for every interface."""
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
    """Chromium has no gamepad here, so the page is given one of its form. It presses on the contour, and is disconnected."""
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


def test_the_name_of_a_curve_is_at_its_end(page):
    """The curve ends in the middle of its view."""
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


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_a_device_that_is_unplugged_is_an_alarm_that_everybody_can_read(page, flight, theme, session_folder):
    """The fault comes from the command line; the page shows it without a change of the layout, and axe finds nothing serious."""
    if theme == "dark":
        station.until(page, "['HAND_POSITION', 'ROBOT_STATE'].every((name) => window.station.store.links.some((row) => row.name === name && row.state === 'open'))")
        boxes = page.evaluate(BOXES)
        page.evaluate(WATCH_LINKS)
        answer = flying.gse(flight, "--run", flight.folder, "fault", "unplug", "robot", "JOINT1")
        assert answer.returncode == 0, answer.stderr
        page.wait_for_selector("station-log .entry.critical:has-text('MANIPULATOR DEVICE_LOST')")
        page.wait_for_selector("[data-link=HAND_POSITION]:has-text('closed')")
        assert page.evaluate(BOXES) == boxes
        # Both in mission time, so that a slow machine changes nothing: the links are closed after the event.
        lost = page.evaluate("window.station.store.events.findLast((event) => event.event === 'DEVICE_LOST').time")
        assert lost - 1e-6 <= page.evaluate("window.closedAt") < lost + 1.0
    found = station.accessibility(page, theme)
    page.screenshot(path=str(session_folder / f"page-alarm-{theme}.png"))
    assert not found


def test_nothing_fails_on_the_page(page):
    assert page.faults == []
