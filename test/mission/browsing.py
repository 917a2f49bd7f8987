# SPDX-License-Identifier: Apache-2.0
"""A station and the browser that shows its page, for tests and measurements."""

import contextlib
import re
import signal
import subprocess

import flying
from playwright.sync_api import sync_playwright

CHROMIUM = "/usr/bin/chromium"
WITHOUT_SCREEN = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-gpu-compositing"]
LIMIT_MS = flying.MOMENT_S * 1000
# From now on, record each element of the page that moves without an input of the user. SHIFTS returns them, each with its old and new box.
WATCH_SHIFTS = """() => {
    const sides = ({ x, y, width, height }) => [x, y, width, height].join();
    // Only elements have outerHTML: a text that changes within its element is not recorded.
    const note = (list) => window.shifts.push(...list.getEntries().flatMap(({ sources }) => sources.filter(({ node }) => node?.outerHTML))
        .map(({ node, previousRect, currentRect }) => [node.outerHTML.slice(0, 200), sides(previousRect), sides(currentRect)].join(" ")));
    window.shifts = [];
    window.shiftsSeen = new PerformanceObserver(note);
    window.shiftsSeen.observe({type: "layout-shift"});
    window.takeShifts = () => { note({ getEntries: () => window.shiftsSeen.takeRecords() }); return window.shifts; };
}"""
SHIFTS = "window.takeShifts()"
# Chromium draws the scene on the processors, which the flight needs too: three pictures a second are enough for a test.
FEW_PICTURES = "() => { const pictures = window.station?.scene?.pictures; if (pictures) pictures.pace.wait = () => 333; }"


class Address(str):
    """Address of a station; `process` is its process."""

    process = None


@contextlib.contextmanager
def serving(*options):
    """Run a station with these options. Returns its address."""
    words = [flying.ROOT / "build" / "venv" / "bin" / "python", "-m", "hirosco_gse.station", *options, "--http-port", "0"]
    process = subprocess.Popen(words, cwd=flying.ROOT, stdout=subprocess.PIPE, text=True)
    address = Address(re.search(r"http://127\.0\.0\.1:\d+/", process.stdout.readline()).group())
    address.process = process
    try:
        yield address
    finally:  # Also if the test fails.
        process.send_signal(signal.SIGINT)
        process.wait(flying.MOMENT_S)


@contextlib.contextmanager
def browsing():
    """A browser without a screen."""
    with sync_playwright() as playwright, playwright.chromium.launch(executable_path=CHROMIUM, args=WITHOUT_SCREEN) as browser:
        yield browser


def opened(browser, address, ready, **options):
    """Open the page at an address and wait until the expression `ready` of the page is true. page.faults contains its errors."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, **options)
    page.set_default_timeout(LIMIT_MS)
    page.outside, page.faults = [], []  # page.outside: requests to other machines.
    page.on("request", lambda request: request.url.startswith((address, "data:")) or page.outside.append(request.url))
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on("console", lambda line: line.type == "error" and page.faults.append(line.text))
    page.goto(address)
    until(page, ready)
    page.evaluate(FEW_PICTURES)
    return page


def until(page, expression):
    """Wait until an expression of the page is true. Playwright's own function compiles text in the page,
    which the page's policy forbids."""
    flying.wait_until(lambda: page.evaluate(expression), expression)
