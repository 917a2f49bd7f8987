# SPDX-License-Identifier: Apache-2.0
"""The page of the station that replays a flight of telepresence, and the self-contained report of this flight.

UPDATE_PICTURES=1 writes the pictures of README and docs again."""

import io
import json
import os
import re
import signal
import subprocess
import sys

import flying
import pytest
import test_mission_station as station
from browsing import LIMIT_MS
from hirosco_gse import run as runs

PICTURE = flying.ROOT / "docs" / "images" / "telepresence.png"
FILM = flying.ROOT / "docs" / "images" / "telepresence.webp"
FILM_S = [20 + n * 0.25 for n in range(40)] + [43 + n * 0.25 for n in range(24)]  # contour, then spring
REPORT_OCTETS = 1_200_000
REPLAYED = "Boolean(window.station?.replay?.film)"
# Changes of the page, and pictures that it requests, while a replay is at rest. Before, the page draws the scene with all pixels. It
# describes the scene every 5 s; the test does this once before and once during the rest.
AT_REST = """async () => {
    const wait = (ms) => new Promise((done) => setTimeout(done, ms)), ask = window.requestAnimationFrame;
    station.replay.play(false);
    station.replay.seek(26);
    while (!station.scene.pictures.isFine || station.scene.pictures.isBusy) await wait(20);
    await wait(600);
    station.scene.describe();
    const isSame = ({ target, attributeName, oldValue }) => ["disabled", "hidden"].includes(attributeName) && target.getAttribute(attributeName) === oldValue;
    const found = [], changes = new MutationObserver((records) => found.push(...records.filter((one) => !isSame(one)).map(({ target, attributeName }) =>
        `${target.nodeName} ${target.className?.baseVal ?? target.className ?? ""} ${attributeName ?? "text"}`)));
    window.requestAnimationFrame = (call) => { found.push("picture"); return ask(call); };
    changes.observe(document.body, {subtree: true, childList: true, attributeOldValue: true, characterData: true});
    station.scene.describe();
    await wait(700);
    changes.disconnect();
    window.requestAnimationFrame = ask;
    return [...new Set(found)];
}"""


@pytest.fixture(scope="module")
def flight(shared_flights):
    subprocess.run(["make", "-s", "build/station/page/index.html"], cwd=flying.ROOT, check=True)
    return shared_flights.flight(again=1, report="yes")


@pytest.fixture(scope="module")
def browser():
    with station.browsing() as browser:
        yield browser


@pytest.fixture(scope="module")
def page(flight, browser):
    with station.serving("--replay", flight.directory) as address:
        yield station.opened(browser, f"{address}?replay", REPLAYED)


def test_a_replay_at_rest_changes_nothing(page):
    """After every change the browser computes the layout and paints the page, which delays the next jump."""
    assert page.evaluate(AT_REST) == []


def test_panels_that_are_drawn_again_without_a_change_keep_their_elements(page):
    """A new element, or a new text node, would make the browser compute styles and layout again."""
    assert page.evaluate("""() => {
        const [states, network] = ["states", "network"].map((name) => document.querySelector(`station-${name}`));
        const nodes = () => [...states.querySelectorAll("*"), ...network.querySelectorAll("*"), ...[...states.boxes.values()].map((box) => box.firstChild.firstChild)];
        const before = nodes();
        states.draw();
        network.draw();
        const after = nodes();
        return before.length > 40 && before.length === after.length && before.every((node, n) => node === after[n]);
    }""")
    assert page.evaluate("""() => {
        const { x } = station.scene.values, node = x.firstChild;
        station.scene.tellTip([1.5, 0, 0]);
        const found = [x.textContent.trim(), x.firstChild === node];
        station.scene.tellPose();
        return found;
    }""") == ["1500.0", True]


def test_the_table_of_the_fastest_report_keeps_its_rows_for_two_seconds_and_the_focus_afterwards(page):
    """Otherwise the table would change whenever a loaded machine is late, and the focus would go to the top of the page."""
    assert page.evaluate("""() => {
        const { store } = station, { table } = document.querySelector("station-work"), now = store.clock(), kept = store.reports;
        const reports = [["MANIPULATOR/1", 500, 0], ["MANIPULATOR/2", 50, 1900]].map(([key, period, age]) =>
            [key, { subsystem: "MANIPULATOR", id: Number(key.at(-1)), at: now - age, period, count: 9, values: { STATE: [6] } }]);
        const periodOf = store.periodOf;
        store.periodOf = (name, id) => store.reports.get(`${name}/${id}`).period;
        store.reports = new Map(reports);
        store.selected = "MANIPULATOR";
        table.draw();
        const found = [table.title_.textContent];
        table.table.querySelector("button").focus();
        const name = document.activeElement.getAttribute("aria-label");
        reports[1][1].at -= 200;
        table.draw();
        found.push(table.title_.textContent, name !== null && document.activeElement.getAttribute("aria-label") === name);
        Object.assign(store, { periodOf, reports: kept });
        delete store.periodOf;
        table.draw();
        return found;
    }""") == ["MANIPULATOR 2", "MANIPULATOR 1", True]


def test_a_lane_of_the_time_line_has_one_part_for_each_style(page):
    """An hour has thousands of states. Each part that is transparent as a whole would be a layer of its own."""
    drawn, styles, passed = page.evaluate("""() => {
        const parts = [...document.querySelectorAll("station-player .lane")], lanes = [...station.store.lanes.values()];
        return [parts.length, new Set(parts.map((part) => part.getAttribute("style"))).size, Math.max(...lanes.map((lane) => lane.length))];
    }""")
    assert 2 < styles <= 7 < passed and drawn <= 2 * styles
    assert page.evaluate("[...document.querySelectorAll('station-player .lane')].every((part) => getComputedStyle(part).opacity === '1')")


def test_both_tabs_of_the_log_count_and_list_the_whole_flight(page):
    """At the beginning of the replay all events and commands are still to come; the lists have 30 before and after the present instant. A click on
    a command shows its instant."""
    events, times = page.evaluate("[station.replay.events.length, station.replay.commands.filter((call) => !call.own).map((call) => call.time)]")
    assert events > 10 and len(times) > 60
    page.click("#log-Commands")
    for seconds in (0, 30):
        page.evaluate("seconds => station.replay.seek(seconds)", seconds)
        past = sum(time <= seconds for time in times)
        entries = "[...document.querySelectorAll('station-log [aria-label=Commands] .entry')]"
        station.until(page, f"{entries}.map((entry) => Number(entry.matches('.to-come'))).join('') === '{'0' * min(30, past)}{'1' * min(30, len(times) - past)}'")
        assert [page.inner_text("#log-Events"), page.inner_text("#log-Commands")] == [f"Events {events}", f"Commands {len(times)}"]
    last = page.locator("station-log [aria-label=Commands] .entry >> nth=-1")
    assert "accepted not reached" in last.locator(".lights").get_attribute("aria-label")
    last.click()
    assert page.evaluate("station.replay.time") == pytest.approx(times[past + 29])
    page.wait_for_selector("station-log [aria-label=Commands] .entry[aria-current]:not(.to-come)")
    page.click("#log-Events")


def test_a_command_lists_the_reports_that_it_led_to(page):
    """A click on one of them shows its instant. In a replay only those until the present instant are listed; an open list stays open."""
    page.click("#log-Commands")
    call = page.evaluate("station.replay.commands.find((call) => call.text === 'state MANIPULATOR SAFE_OPERATIONAL' && call.led_to.count > 4)")
    times = [row[0] for row in call["led_to"]["rows"]]
    page.evaluate("seconds => station.replay.seek(seconds)", times[-1])
    line = page.locator(f"station-log .led-to[aria-label='led to {len(times)} reports: {call['text']} at {call['time']:.4f} s']")
    line.click()
    assert line.get_attribute("aria-expanded") == "true" and line.evaluate("node => node === document.activeElement")
    rows = page.locator("station-log .reports .entry")
    assert rows.count() == len(times) and "TM[129,2]MANIPULATOR: PRE_OPERATIONAL -> SAFE_OPERATIONAL" in "".join(rows.all_inner_texts()).replace("\n", "")
    rows.nth(2).click()
    assert page.evaluate("station.replay.time") == pytest.approx(times[2])
    station.until(page, f"document.querySelectorAll('station-log .reports .entry').length === {sum(time <= times[2] for time in times)}")
    page.locator("station-log .led-to[aria-expanded=true]").click()
    assert page.locator("station-log .reports").count() == 0
    page.evaluate("station.replay.seek(60)")
    page.evaluate("document.querySelector('station-log').drawCommands()")
    assert page.evaluate("""() => {
        const line = document.querySelector("station-log [aria-label=Commands] [aria-current] + .led-to"), list = line.parentElement;
        return line.getBoundingClientRect().bottom <= list.getBoundingClientRect().bottom + 1;
    }""")
    page.click("#log-Events")


def test_limits_are_coloured_springs_stretched_and_held_brakes_ringed(page):
    """Arcs of the joints have the colour of the distance to their limits; the spring reaches the tip while it is hooked."""
    colours = page.evaluate("""() => {
        const { scene } = station, [arc, other] = scene.arcs, { lower, upper } = arc.joint;
        const token = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
        const named = Object.fromEntries(["fg2", "caution", "critical"].map((name) => [token(name).slice(1), name]));
        const colourAt = (share) => { const at = [...scene.joints]; at[arc.n] = lower + (upper - lower) * share; scene.drawLimits(at); return named[arc.look.color.getHexString()]; };
        const found = [0.5, 0.88, 0.92, 0.08, 1.01, -0.01].map(colourAt);
        scene.drawLimits(scene.joints);
        return [...found, Boolean(other)];
    }""")
    assert colours == ["fg2", "fg2", "caution", "caution", "critical", "critical", True]
    page.evaluate("station.replay.use('truth')")
    seen = page.evaluate("""() => {
        const { replay, scene } = station, { t, index } = replay.truth, at = (wanted) => t.find((time) => Boolean(replay.truthAt(time)?.row.HOOKED?.[0] > 0.5) === wanted && time > 20);
        return [true, false].map((wanted) => { replay.seek(at(wanted)); const [spring] = scene.springs;
            return [spring.shown === scene.tip.map((value) => value.toFixed(3)).join(), spring.shown === spring.hook.map((value) => value.toFixed(3)).join()]; });
    }""")
    assert seen == [[True, False], [False, True]]
    shown = "station.scene.arm.brakes.map(({ isHeld, rings }) => [isHeld, ...rings.map((ring) => ring.visible)])"
    page.evaluate("station.replay.seek(0.5)")
    assert page.evaluate(shown) == [[True, True, True]] * 2
    page.evaluate("station.replay.seek(26)")
    assert page.evaluate(shown) == [[False, False, False]] * 2


def test_the_camera_has_presets_and_is_moved_by_the_mouse_only(page):
    place, pressed = "station.scene.camera.position.toArray()", "[...document.querySelectorAll('station-scene .tr [aria-pressed=true]')].map((button) => button.textContent)"
    page.click("station-scene button:text-is('Iso')")
    places = [page.evaluate(place)]
    page.evaluate("document.activeElement.blur()")
    for name in ("Side", "Tool", "Fit", "Iso"):
        page.keyboard.press("V")
        assert page.evaluate(pressed) == [name]
        places.append(page.evaluate(place))
    assert places[-1] == pytest.approx(places[0]) and len({tuple(one) for one in places[:-1]}) == 4
    page.evaluate("station.replay.seek(40)")
    assert page.evaluate(place) == pytest.approx(places[0])
    box = page.locator("station-scene canvas").bounding_box()
    page.mouse.move(box["x"] + 200, box["y"] + 150)
    page.mouse.down()
    page.mouse.move(box["x"] + 260, box["y"] + 150, steps=3)
    page.mouse.up()
    page.mouse.wheel(0, 200)
    station.until(page, f"Math.hypot(...{place}.map((value, n) => value - {places[0]}[n])) > 0.1")
    page.mouse.down()
    before = page.evaluate(place)
    for kind, pointer in (("pointerdown", 7), ("pointermove", 7), ("pointercancel", 1)):  # A second finger, then the end of the mouse's drag.
        page.evaluate(f"document.querySelector('station-scene canvas').dispatchEvent(new PointerEvent('{kind}', {{ pointerId: {pointer}, clientX: 9, clientY: 9 }}))")
    page.mouse.move(box["x"] + 200, box["y"] + 150)
    page.mouse.up()
    assert page.evaluate(place) == before
    page.click("station-scene button:text-is('Iso')")


# Function that gives drawn elements with those within them.
PARTS = "const parts = (nodes) => nodes.flatMap((node) => [node, ...node.querySelectorAll('*')]);"


def test_the_network_shows_the_node_of_a_device_or_the_type_of_its_end_node(page):
    drawn = "(devices) => { " + PARTS + """
        const network = document.querySelector("station-network"), { store } = station;
        store.configuration = () => ({ devices, nodes: { DRIVE: "0x11" }, endnodes: { DRIVE: "robot", LAMP: "UDP" } });
        const words = parts(network.member("JOYSTICK", 0, 0)).filter((node) => node.nodeName === "text").map((node) => node.textContent);
        delete store.configuration;
        return words.slice(2);
    }"""
    assert page.evaluate(drawn, ["DRIVE", "LAMP"]) == ["DRIVE", "0x11", "LAMP", "UDP"]
    # A mission with one member has room for the names of more devices, in two rows of two lines.
    many = "(devices) => { " + PARTS + """
        const network = document.querySelector("station-network"), { store } = station, members = store.members;
        store.configuration = () => ({ devices, nodes: { A: "0x11" }, endnodes: { A: "arm-1", B: "UDP", C: "UDP", D: "UDP", E: "UDP" } });
        const words = (alone) => {
            store.members = () => members.call(store).slice(0, alone ? 1 : 2);
            return parts(network.member("JOYSTICK", 94, 2)).filter((node) => node.nodeName === "text").slice(2);
        };
        const found = [words(false).map((node) => node.textContent), words(true).map((node) => node.textContent),
            [...new Set(words(true).map((node) => node.getAttribute("y")))].length];
        delete store.configuration;
        delete store.members;
        return found;
    }"""
    assert page.evaluate(many, list("ABCDE")) == [
        ["5 devices", "arm-1, UDP"], ["A", "0x11 arm-1", "B", "UDP", "C", "UDP", "D", "UDP", "E", "UDP"], 4]


def test_a_lost_device_is_marked_if_others_have_its_number(page):
    """A device of another configuration has the same node; the configuration that is selected tells which one is lost."""
    marked = "([devices, ...events]) => { " + PARTS + """
        const network = document.querySelector("station-network"), { store } = station, { events: kept } = store;
        store.configuration = () => ({ devices, nodes: {}, endnodes: {} });
        store.events = events.map((event) => ({ subsystem: "JOYSTICK", event, device: "DRIVE or WHEEL", time: 1e6 }));
        const words = parts(network.member("JOYSTICK", 0, 0)).filter((node) => node.matches(".broken + .device, .lost")).map((node) => node.textContent);
        const broken = parts(network.member("JOYSTICK", 0, 0)).filter((node) => node.matches("rect.broken")).length;
        delete store.configuration;
        store.events = kept;
        return [words, broken];
    }"""
    assert page.evaluate(marked, [["LAMP", "WHEEL"], "DEVICE_LOST"]) == [["WHEEL", "lost"], 1]
    assert page.evaluate(marked, [["LAMP", "WHEEL"], "DEVICE_LOST", "DEVICE_RETURNED"]) == [[], 0]
    assert page.evaluate(marked, [["LAMP", "DRIVE"], "DEVICE_LOST"]) == [["DRIVE", "lost"], 1]


def test_small_screens_show_links_bar_and_numbers_of_the_time_line_as_a_whole(page):
    """All four links are seen without scrolling; the last number of the time line is not cut; a longer number of events moves no tab."""
    page.set_viewport_size({"width": 1280, "height": 800})
    page.click("#work-Telemetry")
    page.evaluate("station.replay.seek(26)")
    shown = page.evaluate("""() => {
        const all = document.querySelector("station-network .scroll"), player = document.querySelector("station-player"), { end } = station.replay;
        station.replay.end = 90.2;
        player.draw();
        const line = player.slider.getBoundingClientRect(), numbers = [...player.drawing.querySelectorAll("text:not(.phase-name)")];
        const past = numbers.filter((node) => node.getBoundingClientRect().right > line.right).map((node) => node.textContent);
        station.replay.end = end;
        player.draw();
        const place = () => document.querySelector("#log-Commands").offsetLeft, tab = document.querySelector("#log-Events"), { textContent } = tab;
        const places = ["Events 0", "Events 1234"].map((words) => { tab.textContent = words; return place(); });
        tab.textContent = textContent;
        return [all.scrollHeight - all.clientHeight, numbers.at(-1).textContent, past, places[1] - places[0]];
    }""")
    page.wait_for_selector("#log-Packets", state="hidden")  # A recording has no counts of packets.
    cut = page.evaluate(station.CUT)
    page.evaluate("""() => {  // An event of severity HIGH that nobody has seen, and numbers of two digits.
        const { store } = station, bar = document.querySelector("station-bar"), numbers = { HIGH: 12, MEDIUM: 10, LOW: 22 };
        bar.kept = [store.events, store.seen];
        store.events = Object.entries(numbers).flatMap(([severity, count]) => Array(count).fill({ severity }));
        store.seen = 0;
        bar.drawAlarm();
    }""")
    cut += page.evaluate(station.CUT)
    page.set_viewport_size({"width": 1024, "height": 768})
    cut += page.evaluate(station.CUT)
    assert page.is_visible("station-bar button:has-text('Seen')")
    page.evaluate("""() => {
        const bar = document.querySelector("station-bar");
        [station.store.events, station.store.seen] = bar.kept;
        bar.drawAlarm();
    }""")
    page.evaluate("document.querySelector('station-bar .mission h1').textContent = 'ur5e-telepresence'")  # The longest name of a mission.
    cut += page.evaluate(station.CUT)
    page.evaluate("document.querySelector('station-bar').draw()")
    page.set_viewport_size({"width": 1440, "height": 900})
    assert shown == [0, "90", [], 0] and cut == []


# The charts of an arm with seven joints: pixels that do not fit, legends that are cut, strips with a time axis, columns, and the width
# beside the last strip. The charts of the flight return after that.
SEVEN = """async () => {
    const { store, strips } = station, { world } = store.hello;
    const joint = (n) => ({ name: `j${n}`, kind: "revolute", parent: `l${n}`, child: `l${n + 1}`, axis: [0, 0, 1], pose: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] });
    const show = async (changed) => {
        store.hello.world = changed;
        strips.arrange();
        await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
    };
    await show({ ...world, drives: {}, robots: [{ ...world.robots[0], joints: [...Array(7).keys()].map(joint) }] });
    strips.strips.forEach((strip) => strip.values.forEach((value) => { value.textContent = "−12.345"; }));
    const { area } = strips, nodes = [...area.querySelectorAll(".strip")];
    const found = [area.scrollHeight - area.clientHeight, [...area.querySelectorAll(".legend")].filter((node) => node.scrollWidth > node.clientWidth + 1).length,
        strips.strips.flatMap((strip, n) => (strip.plot.axes[0]._size > 0 ? [n] : [])), new Set(nodes.map((node) => node.getBoundingClientRect().x)).size,
        area.clientWidth - nodes.at(-1).clientWidth];
    await show(world);
    return found;
}"""


@pytest.mark.parametrize("size", [(1280, 800), (1024, 768), (820, 1180), (1920, 1080)])
def test_the_charts_of_an_arm_with_seven_joints_fit(page, size):
    """Five strips in two columns, each of which ends with a time axis. The last one has both."""
    page.set_viewport_size({"width": size[0], "height": size[1]})
    found = page.evaluate(SEVEN)
    page.set_viewport_size({"width": 1440, "height": 900})
    assert found == [0, 0, [3, 4], 2, 0] and page.locator(".strip").count() == 3


# Places of the regions of the page.
REGIONS = "[...document.querySelectorAll('.panel, header .cell, .hud:not(.now)')].map((node) => Object.values(node.getBoundingClientRect().toJSON()).join())"
# Texts of the alarm cell that are wider or higher than their place.
CUT = """[...document.querySelectorAll(".slot .two > :not([hidden])")].filter((node) =>
    node.scrollWidth > node.clientWidth || node.scrollHeight > node.clientHeight).map((node) => node.textContent)"""


@pytest.mark.parametrize("size", [(1440, 900), (1280, 800), (1024, 768), (820, 1180), (800, 780), (390, 844)])
def test_the_slot_now_shows_what_is_under_way_and_moves_nothing(page, size):
    """A plan of the supervisor, then a command, and otherwise the phase of the scenario. The slot covers no control."""
    page.set_viewport_size({"width": size[0], "height": size[1]})
    lost = page.evaluate("station.replay.events.find(({ event }) => event === 'DEVICE_LOST').time")
    page.evaluate("station.replay.use('telemetry')")
    places, shown = [], []
    for seconds in (26.0, lost + 0.3, lost + 4.0):
        page.evaluate("async (seconds) => { station.replay.seek(seconds); await Promise.resolve(); }", seconds)
        shown.append(page.inner_text(".hud.now .name") if page.is_visible(".hud.now") else "")
        places.append(page.evaluate(REGIONS))
        assert page.evaluate(station.OVERLAPPING) == []
        if "Plan" in shown[-1]:
            assert page.locator(".hud.now .steps .present").inner_text().split("\n")[0].startswith("network to OFFLINE")
            assert page.evaluate("document.querySelector('.hud.now .runs i').style.width") == "60%"
            # In the place of the counts, the alarm says with which event it began and how many reports have followed.
            followed = page.evaluate("(lost) => station.store.events.filter(({ time }, n) => n > station.store.events.findIndex((one) => one.time === lost)).length", lost)
            station.until(page, f"document.querySelector('.led').textContent === 'HIGH, 0.30 s ago, led to {followed} reports'")
            assert page.is_visible(".led") and page.is_hidden(".counts") and page.inner_text(".slot strong").startswith("JOYSTICK DEVICE_LOST STICK; ")
            # Nothing of it is cut, also beside the button that a flight has.
            page.evaluate("document.querySelector('.slot button').hidden = false")
            assert page.evaluate(CUT) == []
            page.evaluate("document.querySelector('.slot button').hidden = true")
    page.set_viewport_size({"width": 1440, "height": 900})
    assert shown[:2] == ["follow", "Plan NETWORK_DOWN"] and "Plan" not in shown[2]
    assert places[0] == places[1] == places[2]


def test_keys_turn_the_scene_and_zoom_the_charts_that_have_the_focus(page):
    """Where neither scene nor chart has the focus, the same keys move the instant of the replay."""
    seconds, distance = page.evaluate("station.replay.time"), "station.scene.camera.position.distanceTo(station.scene.target)"
    angle = "Math.atan2(station.scene.camera.position.y - station.scene.target.y, station.scene.camera.position.x - station.scene.target.x)"
    page.focus("station-scene canvas")
    turned, far = page.evaluate(angle), page.evaluate(distance)
    for key in ("ArrowRight", "ArrowRight", "+"):
        page.keyboard.press(key)
    assert page.evaluate(angle) - turned == pytest.approx(0.24) and page.evaluate(distance) == pytest.approx(far / 1.15)
    page.click("station-scene button:text-is('Iso')")
    title, zoom = page.locator("station-strips h2"), "station.strips.zoom"
    end = page.evaluate("station.replay.end")
    page.focus("station-strips .strips")
    page.keyboard.press("+")
    assert page.evaluate(zoom) == pytest.approx([end / 4, end * 3 / 4]) and title.inner_text() == "Zoomed"
    page.keyboard.press("ArrowLeft")
    assert page.evaluate(zoom) == pytest.approx([end / 8, end * 5 / 8])
    page.keyboard.press("-")
    page.keyboard.press("Escape")
    assert page.evaluate(zoom) is None and title.inner_text() == "The whole flight"
    assert page.evaluate("station.replay.time") == seconds
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("station.replay.time") == pytest.approx(seconds + 1)


def test_a_replay_plays_once_however_often_it_is_started(page):
    """Each further press of play requests no further pictures."""
    assert page.evaluate("""async () => {
        const ask = window.requestAnimationFrame, waiting = new Set(), { replay } = station;
        window.requestAnimationFrame = (call) => { const id = ask((now) => { waiting.delete(id); call(now); }); waiting.add(id); return id; };
        const forget = window.cancelAnimationFrame;
        window.cancelAnimationFrame = (id) => { waiting.delete(id); forget(id); };
        for (const is of [true, false, true, true]) replay.play(is);
        const found = waiting.size;
        replay.play(false);
        const left = waiting.size;
        [window.requestAnimationFrame, window.cancelAnimationFrame] = [ask, forget];
        return [found, left];
    }""") == [1, 0]


def test_a_jump_begins_its_picture_at_once(page):
    """The processors draw the picture while the browser computes the layout. The page reads no size of an
    element: after a change, this would make the browser compute the layout first."""
    begun, asked = page.evaluate("""async () => {
        const { scene, replay, strips } = station, { pictures, renderer } = scene, { render } = renderer, own = Element.prototype;
        const width = Object.getOwnPropertyDescriptor(own, "clientWidth");
        replay.play(false);
        replay.seek(10);
        strips.draw();
        while (!pictures.isFine || pictures.isBusy) await new Promise((done) => setTimeout(done, 20));
        let begun = 0, asked = 0;
        renderer.render = (...words) => { begun++; render.call(renderer, ...words); };
        Object.defineProperty(own, "clientWidth", { ...width, get() { asked++; return width.get.call(this); } });
        replay.seek(12);
        strips.draw();
        await Promise.resolve();
        renderer.render = render;
        Object.defineProperty(own, "clientWidth", width);
        return [begun, asked];
    }""")
    assert (begun, asked) == (1, 0)


def test_a_hidden_page_does_not_jump_when_it_is_shown_again(page):
    """A browser draws no picture of a hidden page, so the replay stands still; it goes on where it was."""
    before, after = page.evaluate("""async () => {
        const hide = (is) => { Object.defineProperty(document, "hidden", {value: is, configurable: true}); document.dispatchEvent(new Event("visibilitychange")); };
        const ask = window.requestAnimationFrame, { replay } = station, pictures = [];
        replay.seek(10);
        replay.fast(16);
        window.requestAnimationFrame = (call) => pictures.push(call);
        replay.play(true);
        hide(true);
        await new Promise((done) => setTimeout(done, 1000));
        const before = replay.time;
        hide(false);
        window.requestAnimationFrame = ask;
        for (const call of pictures) call(performance.now());
        const after = replay.time;
        replay.play(false);
        replay.fast(1);
        delete document.hidden;
        return [before, after];
    }""")
    assert before == 10 and 10 <= after < 16  # A second at this speed is 16 s of the flight.


def test_the_station_says_that_it_prepares_the_replay(flight, browser):
    """Until the recording is made, the page shows what it waits for, and no alarm."""
    with station.serving("--replay", flight.directory) as address:
        page = browser.new_page()
        page.set_default_timeout(LIMIT_MS)
        asked = []
        page.route("**/recording", lambda route: asked.append(route))
        page.goto(f"{address}?replay")
        page.wait_for_selector(".slot:not(.critical):has-text('The station prepares the replay')")
        page.wait_for_selector(".link-cell svg[aria-label='waiting']")
        assert page.is_disabled(".stop")
        asked[0].continue_()
        station.until(page, REPLAYED)
        page.wait_for_selector(".slot:not(.critical):has-text('No open alarm')")
        page.close()


def show(page, seconds):
    """Show an instant of the replay, and wait until the scene is drawn with all pixels."""
    page.evaluate("seconds => { station.replay.seek(seconds); station.scene.pictures.isFine = false; station.scene.change(); }", seconds)
    station.until(page, "station.scene.pictures.isFine && !station.scene.pictures.isBusy")


def write_film(browser, directory):
    """Make a film of the page that replays a flight: four pictures for each second of the flight, played at
    double speed."""
    from PIL import Image  # Only this function needs it.

    words = [sys.executable, "-m", "hirosco_gse.station", "--replay", directory, "--http-port", "0"]
    process = subprocess.Popen(words, cwd=flying.ROOT, stdout=subprocess.PIPE, text=True)
    try:
        address = re.search(r"http://127\.0\.0\.1:\d+/", process.stdout.readline()).group()
        with browser.new_context(viewport={"width": 1440, "height": 900}, color_scheme="dark") as context:
            page = context.new_page()
            page.goto(f"{address}?replay")
            station.until(page, REPLAYED)
            pictures = []
            for seconds in FILM_S:
                show(page, seconds)
                pictures.append(Image.open(io.BytesIO(page.screenshot())).convert("RGB").resize((1080, 675), Image.LANCZOS))
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(flying.MOMENT_S)
    pictures[0].save(FILM, save_all=True, append_images=pictures[1:], duration=125, loop=0, quality=60, method=4)


def test_a_report_is_one_file(browser, flight, session_directory):
    """Only the file itself is loaded; it contains film and figures, and is accessible in both sizes and
    themes."""
    subprocess.run([flying.ROOT / "build" / "venv" / "bin" / "python", "-m", "hirosco_gse.report", flight.directory], cwd=flying.ROOT, check=True)
    assert json.loads(flight.read("run.json"))["report"]["octets"] < REPORT_OCTETS
    with browser.new_context(viewport={"width": 1440, "height": 900}, color_scheme="dark", bypass_csp=True) as context:
        page = context.new_page()
        page.set_default_timeout(LIMIT_MS)
        asked, faults = [], []
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto((flight.directory / "report.html").resolve().as_uri())
        station.until(page, REPLAYED)
        page.evaluate("station.replay.seek(26)")
        truth = runs.load(flight.directory, has_buses=False).truth["JOINTS"]
        row = station.nearest(truth["time_us"] / 1e6, 26.0)
        assert page.evaluate("station.scene.joints") == pytest.approx(list(truth["position_rad"][row]), abs=1e-3)
        assert page.locator(".figures tr.holds").count() == 16
        assert page.evaluate("station.scene.arm.brakes.map((brake) => brake.isHeld)") == [False, False]
        page.evaluate("station.replay.seek(0.5)")
        assert page.evaluate("station.scene.arm.brakes.map((brake) => brake.isHeld)") == [True, True]
        show(page, 26)
        page.screenshot(path=str(PICTURE if os.environ.get("UPDATE_PICTURES") else session_directory / "report-dark.png"))
        if os.environ.get("UPDATE_PICTURES"):
            write_film(browser, flight.directory)
        page.keyboard.press("P")  # The values are in a tab of the log: any of them goes into the charts.
        assert page.evaluate("document.activeElement.closest('#log-Values-panel') !== null")
        page.click("section[aria-label='JOYSTICK 4711'] button.chart >> nth=1")
        assert page.locator(".strip").count() == 4 and page.evaluate("station.strips.area.scrollHeight - station.strips.area.clientHeight") == 0
        page.click("button.away")
        page.click("#log-Links")
        page.locator("station-log .link-row:has-text('ROBOT_STATE')").wait_for()
        page.evaluate(station.AXE.read_text(encoding="utf-8"))
        found = page.evaluate("axe.run(document, {runOnly: ['wcag2a', 'wcag2aa', 'wcag21aa', 'best-practice']})")
        assert not [f"{rule['id']}: {rule['nodes'][0]['html']}" for rule in found["violations"] if rule["impact"] in ("serious", "critical")]
        assert len(asked) == 1 and not faults
