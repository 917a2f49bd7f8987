# SPDX-License-Identifier: Apache-2.0
"""The page of the station beside a telepresence by the wall clock: its joystick presses on the contour, and a device is lost."""

import re
import signal
import subprocess
import sys

import flying
import pytest
import test_mission_station as station
from playwright.sync_api import sync_playwright

SCENARIO = [*flying.bring_up(0.2), "3600 operator shutdown"]
# Pixels from the centre of the field, to the right and down, above the contour; the lowest presses with more than 20 N.
ABOVE_PIXELS = (-15, 25)
LOWEST_PIXELS = 70
# Boxes of the regions of the page, rounded to pixels.
BOXES = """[...document.querySelectorAll('station-bar, station-scene, nav > *, aside > *, station-work, station-log')].map((node) =>
    Object.values(node.getBoundingClientRect().toJSON()).map(Math.round))"""


@pytest.fixture(scope="module")
def flight(hangar):
    subprocess.run(["make", "-s", "build/station/page/index.html"], cwd=flying.ROOT, check=True)
    scenario = flying.write_scenario(hangar / "station-telepresence.scn", *SCENARIO)
    flight = flying.start(hangar / "station-telepresence", "--time", "real", "--scenario", scenario)
    flight.port()
    yield flight
    flight.abandon()


@pytest.fixture(scope="module")
def page(flight):
    words = [sys.executable, "-m", "hirosco_gse.station", "--run", flight.folder, "--http-port", "0"]
    process = subprocess.Popen(words, cwd=flying.ROOT, stdout=subprocess.PIPE, text=True)
    address = re.search(r"http://127\.0\.0\.1:\d+/", process.stdout.readline()).group()
    with sync_playwright() as playwright, playwright.chromium.launch(executable_path=station.CHROMIUM, args=station.WITHOUT_SCREEN) as browser:
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.set_default_timeout(station.LIMIT_MS)
        page.faults = []
        page.on("pageerror", lambda error: page.faults.append(str(error)))
        page.goto(address)
        station.until(page, "window.station.store.states.get('MANIPULATOR')?.state === 'OPERATIONAL' && window.station.scene.last")
        yield page
    process.send_signal(signal.SIGINT)
    process.wait(flying.MOMENT_S)


class Drag:
    """A drag of the page's joystick: to a place above the contour, then down by one pixel at each look until the finger presses, and back."""

    def __init__(self, page):
        self.page = page
        self.down, self.jitter = 0, 0.0

    def presses(self, force_n):
        """Whether the page shows a contact force of so many newtons; moves the hand on otherwise."""
        if self.page.evaluate("window.station.scene.force ?? 0") > force_n:
            return True
        self.take()
        self.down = min(self.down + 1, LOWEST_PIXELS)
        self.move(self.down)
        return False

    def is_free(self):
        """Whether the page draws no force; moves the hand back to the centre otherwise."""
        if self.page.evaluate("!window.station.scene.shaft.visible"):
            return True
        self.take()
        self.move(0)
        return False

    def move(self, down):
        """Move the pointer; each call by another fraction of a pixel, because only a pointer that moves keeps the hand."""
        self.jitter = 0.2 - self.jitter
        self.page.mouse.move(self.centre[0] + ABOVE_PIXELS[0], self.centre[1] + down + self.jitter)

    def take(self):
        """Take the hand and press the button of the mouse, if the page has given the hand back since."""
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
    flying.wait_until(lambda: drag.presses(5.0), "the page shows no contact force")
    station.until(page, "window.station.scene.shaft.visible && / N$/.test(window.station.scene.forceLabel.textContent)")
    station.until(page, "Math.hypot(...window.station.store.value('JOYSTICK', 'CUR_VALUES.FELT_TORQUE')) > 0.05")
    station.until(page, "(document.querySelector('station-work').hand.arrow.getAttribute('d') ?? '').startsWith('M')")
    assert page.locator("station-scene canvas").screenshot() != free
    flying.wait_until(drag.is_free, "the finger does not leave the contour")
    page.mouse.up()
    page.keyboard.press("Escape")
    flying.wait_until(lambda: "hand rest # station" in flight.read("live.scn"), "the hand is not given back")


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_a_device_that_is_unplugged_is_an_alarm_that_everybody_can_read(page, flight, theme, hangar):
    """The fault comes from the command line; the page shows it without a change of the layout, and axe finds nothing serious."""
    if theme == "dark":
        boxes = page.evaluate(BOXES)
        answer = flying.gse(flight, "--run", flight.folder, "fault", "unplug", "robot", "JOINT1")
        assert answer.returncode == 0, answer.stderr
        page.wait_for_selector("station-log .entry.critical:has-text('MANIPULATOR DEVICE_LOST')")
        page.wait_for_selector(".link-row:has-text('closed') >> nth=0")
        assert page.evaluate(BOXES) == boxes
    found = station.accessibility(page, theme)
    page.screenshot(path=str(hangar / f"page-alarm-{theme}.png"))
    assert not found


def test_nothing_fails_on_the_page(page):
    assert page.faults == []
