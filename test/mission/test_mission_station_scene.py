# SPDX-License-Identifier: Apache-2.0
"""The scene of a replay of telepresence: its colours in both themes, and the devices that the user points at."""

import pytest
import test_mission_station as station
from test_mission_station_replay import REPLAYED

# A function of a place on the canvas [pixels], which is given to the functions below: the end of the axis of the housing of joint `n`.
PLACE = """const place = (n) => {
    const { scene } = window.station, { joint, still } = [...scene.arm.groups.values()][n];
    const at = still.localToWorld(still.position.clone().set(...joint.axis).multiplyScalar(0.2 * scene.arm.size)).project(scene.camera);
    return [((at.x + 1) / 2) * scene.extent.width, ((1 - at.y) / 2) * scene.extent.height];
};"""
# Colours of the first housing and of the sky in a theme, when the scene is drawn with all pixels.
HOUSING = f"""async (theme) => {{
    {PLACE}
    const {{ scene, store }} = window.station, {{ dataset }} = document.documentElement, before = dataset.theme;
    const drawn = async (one) => {{
        dataset.theme = one;
        scene.pictures.isFine = false;
        store.tell("theme");
        while (!scene.pictures.isFine || scene.pictures.isBusy) await new Promise((done) => setTimeout(done, 20));
    }};
    await drawn(theme);
    const scale = scene.canvas.width / scene.extent.width, at = place(0).map((value) => Math.round(value * scale));
    const pixel = [...scene.canvas.getContext("2d").getImageData(...at, 1, 1).data];
    const skies = ["sky0", "sky1"].map((name) => getComputedStyle(document.documentElement).getPropertyValue(`--${{name}}`).trim().slice(1));
    await drawn(before);
    return [pixel, skies];
}}"""


@pytest.fixture(scope="module")
def flight(shared_flights):
    return shared_flights.flight(again=1, report="yes")


@pytest.fixture(scope="module")
def browser():
    with station.browsing() as browser:
        yield browser


@pytest.fixture(scope="module")
def page(flight, browser):
    with station.serving("--replay", flight.directory) as address:
        page = station.opened(browser, f"{address}?replay", REPLAYED)
        page.evaluate("station.replay.seek(9)")
        yield page
        assert not page.faults


def contrast(*colours):
    """Contrast of two colours as in WCAG 2.1."""
    def luminance(colour):
        parts = [int(colour[at : at + 2], 16) / 255 for at in (0, 2, 4)]
        return sum(share * (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4) for share, part in zip((0.2126, 0.7152, 0.0722), parts))

    darker, lighter = sorted(map(luminance, colours))
    return (lighter + 0.05) / (darker + 0.05)


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_the_grid_of_the_scene_has_the_colour_of_the_theme(page, theme):
    """The grid is visible on each shade of the background, with less contrast than anything that has a meaning."""
    is_visible, drawn, grid, *skies = page.evaluate("""(theme) => {
        const { scene, store } = window.station, root = document.documentElement, before = root.dataset.theme;
        const set = (one) => { root.dataset.theme = one; store.tell("theme"); };
        set(theme);
        const found = ["grid", "sky0", "sky1"].map((name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim().slice(1));
        const drawn = scene.floor.material.color.getHexString();
        set(before);
        return [scene.floor.visible, drawn, ...found];
    }""", theme)
    assert is_visible and drawn == grid
    assert all(1.1 < contrast(grid, sky) < 2.0 for sky in skies)


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_the_housing_of_a_joint_is_seen_before_the_sky_of_the_theme(page, theme):
    """Measured in the picture, because light and shadow change the colour of the material."""
    (*colour, opacity), skies = page.evaluate(HOUSING, theme)
    assert opacity == 255
    assert min(contrast("".join(f"{part:02x}" for part in colour), sky) for sky in skies) > 3.0


def test_a_part_of_the_robot_belongs_to_the_drive_that_moves_it(page):
    """The pedestal, the contour and the sky belong to no device."""
    found = page.evaluate(f"""() => {{
        {PLACE}
        const {{ scene }} = window.station, pick = (at) => scene.deviceAt(...at) ?? null;
        const [x, y] = place(0), contour = scene.fixtures[0].getWorldPosition(scene.target.clone()).project(scene.camera);
        return [pick([x, y]), pick(place(1)), pick([x, y + 60]), pick([5, 5]),
            pick([((contour.x + 1) / 2) * scene.extent.width, ((1 - contour.y) / 2) * scene.extent.height])];
    }}""")
    assert found == ["JOINT1", "JOINT2", None, None, None]


def test_a_click_on_a_device_of_a_replay_opens_no_tab(page):
    """A replay has no frames. A drag is no click, either."""
    for state in ("replay", "drag"):
        left, top = page.evaluate(f"() => {{ {PLACE} const {{ left, top }} = station.scene.canvas.getBoundingClientRect(), [x, y] = place(0); return [left + x, top + y]; }}")
        page.mouse.move(left, top)
        page.mouse.down()
        page.mouse.move(left + 30 * (state == "drag"), top)
        page.mouse.up()
        assert page.get_attribute("#work-Bus", "aria-selected") == "false"


def test_tables_show_the_unit_of_each_joint(page):
    """The descriptor of an arm with joints of both kinds has one unit for the list of their positions."""
    assert page.evaluate("""() => {
        const { store } = window.station, { table } = document.querySelector("station-work"), [first, second] = store.hello.world.robots[0].joints;
        const position = store.subsystem("MANIPULATOR").parameters.find((one) => one.name === "CUR_VALUES.POSITION"), { kind } = second;
        const draw = () => {
            table.key = null;
            table.draw();
            return [...table.table.querySelectorAll("tr")].filter((row) => row.innerText.startsWith("POSITION")).map((row) => row.querySelector(".unit").textContent);
        };
        position.unit = "rad or m";
        second.kind = "prismatic";
        const found = [first.kind, ...draw()];
        position.unit = "rad";
        second.kind = kind;
        draw();
        return found;
    }""") == ["revolute", "rad", "m"]


def test_a_word_is_not_judged_by_the_numbers_of_the_first_and_the_last_word(page):
    """A device that is present is no caution, although its number is the least of the enumeration; the word has the place of the gauge."""
    assert page.evaluate("""() => {
        const { store } = window.station, { table } = document.querySelector("station-work");
        const state = store.subsystem("MANIPULATOR").parameters.find((one) => one.name === "CUR_VALUES.STATE");
        const draw = () => {
            table.key = null;
            table.draw();
            const row = [...table.table.querySelectorAll("tr")].find((one) => one.innerText.startsWith("STATE"));
            return [row.querySelectorAll(".gauge, [data-symbol]").length, row.querySelector(".value").style.color, row.querySelector(".worded").colSpan];
        };
        Object.assign(state, { min: 0, max: 5 });  // Its value is OPERATIONAL, 5.
        const found = draw();
        delete state.min;
        delete state.max;
        draw();
        return found;
    }""") == [0, "", 3]


# Of the points of the robots and the fixtures: the largest distance from the middle of the scene to its left or right edge, in halves of the width.
WIDEST = """() => {
    const { scene } = station;
    scene.view("Iso");
    scene.camera.lookAt(scene.target);
    scene.camera.updateMatrixWorld();
    let most = 0;
    for (const node of [...scene.bodies.map(({ arm }) => arm.node), ...scene.fixtures])
        node.traverse((mesh) => {
            const places = mesh.isMesh && mesh.visible ? mesh.geometry.attributes.position : { count: 0 };
            for (let n = 0; n < places.count; n++)
                most = Math.max(most, Math.abs(mesh.localToWorld(scene.target.clone().fromBufferAttribute(places, n)).project(scene.camera).x));
        });
    return most;
}"""


@pytest.mark.parametrize("size", [(820, 1180), (1024, 768), (1440, 900)])
def test_the_robot_fits_the_scene_of_every_size(page, size):
    """The scene of a tablet that stands upright is higher than wide."""
    page.set_viewport_size({"width": size[0], "height": size[1]})
    station.until(page, "Math.abs(station.scene.camera.aspect - station.scene.clientWidth / station.scene.clientHeight) < 0.01")
    widest = page.evaluate(WIDEST)
    page.set_viewport_size({"width": 1440, "height": 900})
    assert 0.3 < widest < 1


def test_the_bar_says_that_the_recording_is_incomplete(page):
    words = "packets.log: 800 of 1761 packets are there, the last at 45.123 s; the log was cut after the flight"
    slot = "document.querySelector('station-bar .slot strong').textContent"
    assert page.evaluate(slot) == "No open alarm"
    page.evaluate("words => { station.replay.about.problems = [words]; station.store.tell('link', station.store.link); }", words)
    station.until(page, f"{slot} === '{words}'")
    assert page.get_attribute("station-bar .link-cell svg", "aria-label") == "incomplete recording"
    page.evaluate("station.replay.about.problems = []; station.store.tell('link', station.store.link)")
    station.until(page, f"{slot} === 'No open alarm'")


def test_the_time_line_has_the_states_before_the_page_was_opened(page):
    """The station sends them with the present state, which begins no new part."""
    assert page.evaluate("""() => {
        const { store } = station, { lanes, time } = store, { state, ...rest } = store.states.get("MANIPULATOR");
        store.take({ kind: "lanes", lanes: { MANIPULATOR: [[1.5, "PRE_OPERATIONAL"], [4, state]] } });
        store.take({ ...rest, state, kind: "state", subsystem: "MANIPULATOR", time: null, since: 4 });
        const found = [store.lanes.get("MANIPULATOR"), state];
        Object.assign(store, { lanes, time });
        return found;
    }""") == [[[1.5, "PRE_OPERATIONAL"], [4, "OPERATIONAL"]], "OPERATIONAL"]


def test_an_age_that_is_counted_on_ground_is_the_largest_possible_one(page):
    """Only a consumer with one link reports the age of its last sample. The other age is that of the last growth of a counter, which is read
    once a second."""
    words = "() => document.querySelector('[data-link=HAND_POSITION] .figures-of').textContent"
    assert "≤" not in page.evaluate(words)
    told = page.evaluate("""(words) => {
        const { store } = station, network = document.querySelector("station-network"), { value, now } = store, rows = network.known();
        Object.assign(rows.get("HAND_POSITION"), { heard: now.call(store) - 0.74 });
        store.value = (name, leaf) => (leaf === "LINK_AGE" ? undefined : value.call(store, name, leaf));
        network.known = () => rows;
        network.drawRows();
        delete store.value;
        const found = document.querySelector("[data-link=HAND_POSITION] .figures-of").textContent;
        delete network.known;
        network.drawRows();
        return found;
    }""")
    assert "≤ 0.74 s old" in told


# Height of the floor, and of the lowest point of the housings, of an arm on z = 0 whose first joint turns about z.
UPRIGHT = """() => {
    const { scene, store } = station, { hello } = store, pose = (z) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, z, 0, 0, 0, 1];
    const joints = [0, 0.3].map((z, n) => ({ name: `j${n}`, kind: "revolute", parent: `l${n}`, child: `l${n + 1}`, axis: [0, 0, 1], pose: pose(z), lower: -1, upper: 1 }));
    const robot = { name: "arm", root: "l0", free: false, start: {}, links: { l0: [], l1: [], l2: [] }, joints };
    const empty = Object.entries(hello.world).map(([name, value]) => [name, Array.isArray(value) ? [] : {}]);
    const show = (world) => store.take({ ...hello, kind: "hello", world });
    show({ ...Object.fromEntries(empty), robots: [robot] });
    const found = [scene.floor.position.z, scene.arm.lowest()];
    show(hello.world);
    return found;
}"""


def test_the_floor_does_not_cross_the_foot_of_an_arm(page):
    """The last test of this page: the world of another arm clears what the page knows of the flight."""
    floor, lowest = page.evaluate(UPRIGHT)
    assert floor == lowest < -0.05
