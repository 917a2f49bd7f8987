// SPDX-License-Identifier: Apache-2.0
// Strip charts: those of the robot (arm_strips.js), and strips of parameters that the user has chosen, with
// at most four lines of one unit in each. A mission without a robot begins with chosen parameters.

import { every } from "./beat.js";
import uPlot from "uplot";

import { store } from "./store.js";
import { el, isPageKey, number, text, wordOf } from "./dom.js";
import { apart, COLOURS, columnsFor, firstMeasured, isLowest, LINES_MAX, stripsOf } from "./arm_strips.js";
import { leadOf, moving, tipForce } from "./kinematics.js";
import { lineOf } from "./telemetry.js";

const WINDOW_S = 30; // Time that the charts of a flight show.
const REFRESH_MS = 50, // Time between two updates of charts.
  TURNS = 3; // Each update draws a third of the charts, because input waits until a task has ended.
const FIRST_STRIPS = 3; // Strips of a mission without a robot before the user chooses others.
const LABEL_PX = 10; // Least distance of two names at the ends of curves.
const LEAST_S = 0.05; // Shortest view that the keys select.
const STALE_S = 1; // An older last report shows no present value.
const token = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

const forces = new WeakMap(); // Row of values -> force at the tip

function forceOf(row) {
  if (row.FORCE) return Math.hypot(...row.FORCE);
  // The rows of a replay are views whose values change, so their forces cannot be kept.
  if (store.replay) return tipForce(leadOf(store.hello.world), row)?.size ?? null;
  if (!forces.has(row)) forces.set(row, tipForce(leadOf(store.hello.world), row)?.size ?? null);
  return forces.get(row);
}

// The robot that the charts show; null if there is none. A body without joints has only its place, which the
// truth of a recording contains and telemetry does not.
function robotOf(world) {
  const robot = leadOf(world);
  return robot && (store.replay || moving(robot).length) ? robot : null;
}

// Value of a line in a row as a number; null if the row does not contain it.
function numberOf(row, line) {
  const value = row?.[line.leaf]?.[line.n];
  return typeof value === "boolean" ? Number(value) : (value ?? null);
}

// Strips of the chosen lines. Lines with the same unit share a strip until it is full.
function chosen(lines) {
  const found = [];
  for (const line of lines) {
    let about = found.find((one) => one.unit === line.unit && one.lines.length < LINES_MAX);
    if (!about) found.push((about = { title: "", unit: line.unit, lines: [] }));
    const source = line.report.split("/")[0];
    if (!about.title.includes(source)) about.title += `${about.title ? ", " : ""}${source}`;
    about.lines.push({
      ...line,
      short: line.name.split(".").length > 1 ? line.name.split(".").pop() : "",
      colour: COLOURS[about.lines.length],
      of: (row) => numberOf(row, line),
    });
  }
  return found;
}

// The lines that a mission without a robot shows until the user chooses others.
function firstLines() {
  const isReported = (name, id) =>
    !store.replay?.housekeeping ||
    store.replay.housekeeping.some((table) => table.subsystem === name && table.structure === id);
  const { name, id, leaves } =
    firstMeasured(store.members(), (member) => store.configuration(member), isReported) ?? {};
  const lines = (leaves ?? []).flatMap((leaf) =>
    [...Array(leaf.count).keys()].map((n) => lineOf(`${name}/${id}`, leaf, n)),
  );
  return lines.slice(0, FIRST_STRIPS * LINES_MAX);
}

// Join the values of lines from different reports on one time axis.
function joined(lines, range, pixels) {
  const tables = lines.map((line) => {
    if (store.replay)
      return (store.history.get(line.report) ?? store.replay.historyOf(line.report)).drawn(
        [line],
        range,
        pixels,
      );
    const { t, rows } = part(store.history.get(line.report), range);
    return [t, rows.map((row) => (row ? line.of(row) : null))];
  });
  return uPlot.join(tables);
}

// Part of a history that a view shows; it begins at least one sample before the view, so that curves reach
// its edge.
function part(history, range) {
  if (!history) return { t: [], rows: [] };
  let first = history.t.findIndex((t) => t >= range[0] - 1);
  if (first < 0) first = history.t.length;
  first = Math.max(0, first - 1);
  return { t: history.t.slice(first), rows: history.rows.slice(first) };
}

// Range of the values of a plot. A plot without values has an axis, too, so that all plots have one width.
function heights(from, to) {
  if (from === null || (from === 0 && to === 0)) return [-1, 1];
  return uPlot.rangeNum(from, to, 0.1, true);
}

class Strip {
  constructor(about, hasTimes) {
    this.about = about;
    this.hasTimes = hasTimes;
    this.values = about.lines.map(() => el("span", { class: "value" }));
    const isChosen = Boolean(about.lines[0]?.report);
    this.legend = el(
      "div",
      {
        class: "legend",
        ...(isChosen ? { tabindex: 0, role: "group", "aria-label": `Lines of ${about.title}` } : {}),
      },
      el("span", { class: "name" }, about.title),
      ...about.lines.map((line, n) =>
        el(
          "span",
          {},
          el("i", { class: line.dashed ? "dashed" : "", style: `border-color:var(--${line.colour})` }),
          line.name,
          " ",
          this.values[n],
          line.report
            ? el(
                "button",
                {
                  class: "away",
                  "aria-label": `Remove ${line.title}`,
                  title: "Remove from the charts",
                  onclick: () => store.tell("chart", line),
                },
                "×",
              )
            : null,
        ),
      ),
      el("span", { class: "hint unit" }, about.unit),
    );
    this.place = el("div", { class: "plot" });
    this.node = el("div", { class: "strip" }, this.legend, this.place);
    this.zoom = null;
  }

  make() {
    this.plot?.destroy();
    const grid = { stroke: token("line"), width: 1 };
    const axis = { stroke: token("fg2"), font: '11px "IBM Plex Mono"', grid, ticks: { show: false } };
    this.plot = new uPlot(
      {
        width: this.place.clientWidth || 600,
        height: this.place.clientHeight || 72,
        legend: { show: false },
        padding: [6, 24, this.hasTimes ? 0 : 6, 0], // Room for half a number of the axis above and below.
        cursor: { sync: { key: "station" }, drag: { x: true, y: false }, points: { show: false } },
        scales: { x: { time: false }, y: { range: (_, from, to) => heights(from, to) } },
        axes: [
          {
            ...axis,
            size: this.hasTimes ? 20 : 0,
            space: 70,
            values: (_, ticks) => ticks.map((t) => (this.hasTimes ? `${t} s` : "")),
          },
          {
            ...axis,
            size: 48,
            space: 22,
            values: (_, ticks) => ticks.map((v) => String(v).replace("-", "−")),
          },
        ],
        series: [
          {},
          ...this.about.lines.map((line) => ({
            stroke: token(line.colour),
            width: 1.5,
            dash: line.dashed ? [4, 3] : undefined,
            points: { show: false },
            spanGaps: false,
          })),
        ],
        hooks: {
          draw: [(plot) => this.marks(plot)],
          setSelect: [
            (plot) => {
              if (plot.select.width > 2)
                this.onzoom([
                  plot.posToVal(plot.select.left, "x"),
                  plot.posToVal(plot.select.left + plot.select.width, "x"),
                ]);
            },
          ],
        },
      },
      [[0], ...this.about.lines.map(() => [null])],
      this.place,
    );
    this.plot.over.addEventListener("dblclick", () => this.onzoom(null));
    this.plot.over.addEventListener("click", (event) => {
      if (store.replay && this.plot.select.width <= 2)
        store.replay.seek(this.plot.posToVal(event.offsetX, "x"));
    });
  }

  // Draw events of severity HIGH and MEDIUM as vertical lines, and the short name of each curve at its right
  // end.
  marks(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.lineWidth = 1;
    ctx.setLineDash([]);
    for (const event of store.replay?.events ?? store.events) {
      if (event.severity !== "HIGH" && event.severity !== "MEDIUM") continue;
      if (event.time < plot.scales.x.min || event.time > plot.scales.x.max) continue;
      const x = Math.round(plot.valToPos(event.time, "x", true)) + 0.5;
      ctx.strokeStyle = token(event.severity === "HIGH" ? "critical" : "serious");
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
    }
    ctx.font = `${11 * devicePixelRatio}px "IBM Plex Mono"`;
    ctx.textAlign = "left"; // uPlot has left those of its axes.
    ctx.textBaseline = "middle";
    const labels = this.about.lines.flatMap((line, n) => {
      const data = plot.data[n + 1];
      const at = data.findLastIndex((item) => item !== null && item !== undefined);
      if (!line.short || at < 0) return [];
      const x = Math.min(plot.valToPos(plot.data[0][at], "x", true), bbox.left + bbox.width);
      return [{ line, x, y: plot.valToPos(data[at], "y", true) }];
    });
    const wanted = labels.map(({ y }) => y);
    apart(wanted, LABEL_PX * devicePixelRatio, bbox.top, bbox.top + bbox.height).forEach((y, n) => {
      ctx.fillStyle = token(labels[n].line.colour);
      ctx.fillText(labels[n].line.short, labels[n].x + 3 * devicePixelRatio, y);
    });
    ctx.restore();
  }

  show(t, rows, range) {
    if (this.about.lines[0].report) {
      this.showChosen(range);
      return;
    }
    const data = [
      t,
      ...this.about.lines.map((line) => rows.map((row) => (row ? (line.of(row) ?? null) : null))),
    ];
    this.put(data, range);
    const newest = store.now() - t[t.length - 1] < STALE_S ? rows[rows.length - 1] : null;
    this.tell(newest);
  }

  put(data, range) {
    this.plot.setData(data, false);
    this.plot.setScale("x", { min: range[0], max: range[1] });
  }

  pixels() {
    return Math.max(200, this.place.clientWidth);
  }

  // In a replay, draw the part of a history that the view shows.
  showHistory(history, range) {
    if (this.about.lines[0].report) this.showChosen(range);
    else
      this.put(
        history?.drawn(this.about.lines, range, this.pixels()) ?? [[], ...this.about.lines.map(() => [])],
        range,
      );
  }

  showChosen(range) {
    this.put(joined(this.about.lines, range, this.pixels()), range);
    this.tell();
  }

  // Show the values at the pointer, otherwise those of a row, or of the last reports.
  tell(row) {
    const at = this.pointed();
    for (const [n, line] of this.about.lines.entries()) {
      const unit = this.about.unit === "rad" ? "rad/s" : this.about.unit;
      if (at !== null) {
        const value = this.plot.data[n + 1][at];
        text(this.values[n], wordOf(line, value) ?? number(value, line.report ? line.unit : unit));
      } else if (line.report) this.tellChosen(n, line);
      else text(this.values[n], row ? number(line.of(row), unit) : "–");
    }
  }

  // Place of the values under the pointer, in this strip or in another one; null without a pointer.
  pointed() {
    const { left, idx } = this.plot.cursor;
    return left >= 0 && idx !== null && idx !== undefined ? idx : null;
  }

  tellChosen(n, line) {
    const [name, id] = line.report.split("/");
    const value =
      store.freshness(name, Number(id)) === "stale"
        ? null
        : store.reports.get(line.report)?.values[line.leaf]?.[line.n];
    text(this.values[n], wordOf(line, value) ?? number(value, line.unit));
  }

  // In a replay, show the cursor and the values at the cursor.
  point(time, row) {
    if (!this.cursor) this.cursor = el("div", { class: "now" });
    if (this.cursor.parentNode !== this.plot.over) this.plot.over.append(this.cursor);
    const x = this.plot.valToPos(time, "x");
    this.cursor.style.transform = `translateX(${x.toFixed(1)}px)`;
    this.cursor.hidden = x < 0 || x > this.plot.bbox.width / devicePixelRatio;
    this.tell(row);
  }
}

class Strips extends HTMLElement {
  connectedCallback() {
    this.pause = el(
      "button",
      {
        "aria-pressed": "false",
        "aria-label": "Hold the view",
        title: "Hold the view; data are still received",
        onclick: () => this.hold(),
      },
      "❚❚",
    );
    this.title_ = el("h2", {}, `Last ${WINDOW_S} s`);
    this.area = el("div", {
      class: "strips scroll",
      tabindex: 0,
      role: "group",
      "aria-label": "Strip charts",
    });
    this.add = el(
      "button",
      { class: "add", onclick: () => store.tell("parameter") },
      "Add parameter ",
      el("kbd", {}, "P"),
    );
    this.append(
      el(
        "div",
        { class: "head" },
        this.title_,
        el("span", { class: "hint" }, "drag to zoom, double click to zoom out"),
        this.pause,
        this.add,
      ),
      this.area,
    );
    store.on("chart", (line) => this.toggle(line));
    store.on("instant", (time) => this.goTo(time));
    // Listeners of the window are called last: the arrow keys move the hand instead while the user has taken
    // it.
    window.addEventListener("keydown", (event) => this.key(event));
    this.addEventListener("dragover", (event) => {
      if (event.dataTransfer.types.includes("text/plain")) event.preventDefault();
    });
    this.addEventListener("drop", (event) => this.drop(event));
    document.addEventListener("keydown", (event) => {
      if (event.key.toUpperCase() !== "P" || !isPageKey(event)) return;
      event.preventDefault();
      store.tell("parameter");
    });
    this.strips = [];
    this.turn = 0;
    store.on("hello", () => this.build());
    store.on("state", () => this.begin() && this.arrange());
    store.on("theme", () => this.remake());
    // A plot also changes its height when its legend needs another row.
    this.sizes = new ResizeObserver(() =>
      this.strips.forEach((strip) =>
        strip.plot?.setSize({ width: strip.place.clientWidth, height: strip.place.clientHeight }),
      ),
    );
    document.fonts.ready.then(() => this.remake());
    every(REFRESH_MS, () => this.draw((this.turn = (this.turn + 1) % TURNS)));
  }

  // Add a parameter to the charts, or remove it.
  toggle(line) {
    this.isChosen = true;
    if (!store.charted.delete(line.key)) store.charted.set(line.key, line);
    this.arrange();
    const added = this.strips.find((strip) => strip.about.lines.some((one) => one.key === line.key));
    added?.node.scrollIntoView({ block: "nearest" });
  }

  drop(event) {
    event.preventDefault();
    let line = null;
    try {
      line = JSON.parse(event.dataTransfer.getData("text/plain"));
    } catch {
      return;
    }
    if (line?.key && !store.charted.has(line.key)) this.toggle(line);
  }

  build() {
    this.zoom = this.held = null;
    this.source = store.members().find((item) => store.drives(item))?.name;
    this.begin();
    this.arrange();
  }

  // Chart the first lines of a mission without a robot that moves, if the user has chosen none. Returns
  // whether they have changed, as those of another configuration do.
  begin() {
    if (this.isChosen || !store.hello || robotOf(store.hello.world)) return false;
    const lines = firstLines();
    if (lines.map((line) => line.key).join() === [...store.charted.keys()].join()) return false;
    store.charted = new Map(lines.map((line) => [line.key, line]));
    return true;
  }

  arrange() {
    for (const strip of this.strips) strip.plot?.destroy();
    const reported = store.subsystem(this.source)?.parameters.map((item) => item.name) ?? [];
    this.strips = [
      ...stripsOf(robotOf(store.hello.world), reported, forceOf),
      ...chosen(store.charted.values()),
    ].map((about, n, all) => new Strip(about, isLowest(n, all.length)));
    this.area.classList.toggle("two", columnsFor(this.strips.length) > 1);
    for (const strip of this.strips) strip.onzoom = (range) => this.zoomTo(range);
    const none = el("p", { class: "reason" }, "No charts yet: P adds a parameter.");
    this.sizes.disconnect();
    for (const strip of this.strips) this.sizes.observe(strip.place);
    this.area.replaceChildren(...(this.strips.length ? this.strips.map((strip) => strip.node) : [none]));
    this.remake();
  }

  remake() {
    for (const strip of this.strips) strip.make();
  }

  // Show an instant of the flight in the middle of the charts; null: follow the flight.
  goTo(time) {
    const from = Math.max(0, (time ?? 0) - WINDOW_S / 2);
    this.zoom = time === null ? null : [from, from + WINDOW_S];
    this.draw();
  }

  // The user has changed the view. Without a zoom the charts of a flight follow it again.
  zoomTo(range) {
    if (range === null && !store.replay) store.tell("instant", null);
    else this.zoom = range;
    this.draw();
  }

  // Part of the flight that the charts show [s, s].
  range() {
    if (store.replay) return this.zoom ?? [0, store.replay.end];
    const now = Math.max(WINDOW_S, store.now());
    return this.zoom ?? this.held ?? [now - WINDOW_S, now];
  }

  // While the charts have the focus, + and - zoom, the arrow keys move the view, and Esc ends the zoom.
  key(event) {
    const isOurs = this.area.contains(event.target) && !event.defaultPrevented && isPageKey(event);
    const [from, to] = this.strips.length && isOurs ? this.range() : [0, 0];
    const step = (to - from) / 4;
    const next = {
      "+": [from + step, to - step],
      "-": [Math.max(0, from - 2 * step), to + 2 * step],
      ArrowLeft: [from - step, to - step],
      ArrowRight: [from + step, to + step],
      Escape: null,
    }[event.key];
    if (!step || next === undefined || (next && (next[1] - next[0] < LEAST_S || next[0] < 0))) return;
    event.preventDefault();
    this.zoomTo(next);
  }

  // Words for the title with the time under the pointer.
  pointed() {
    const [strip] = this.strips;
    if (!strip?.plot || strip.pointed() === null) return "";
    return `, at ${strip.plot.posToVal(strip.plot.cursor.left, "x").toFixed(2)} s`;
  }

  hold() {
    this.held = this.held ? null : [store.now() - WINDOW_S, store.now()];
    this.pause.setAttribute("aria-pressed", String(Boolean(this.held)));
    this.draw();
  }

  // turn: draw the charts whose turn it is; without it draw all of them.
  draw(turn) {
    if (document.hidden) return;
    if (store.replay) {
      this.drawReplay(store.history.get(this.source));
      return;
    }
    const range = this.range();
    text(this.title_, `${this.zoom ? "Zoomed" : this.held ? "Held" : `Last ${WINDOW_S} s`}${this.pointed()}`);
    if (!this.strips.length) return;
    const { t, rows } = part(store.history.get(this.source), range);
    for (const [n, strip] of this.strips.entries())
      if (turn === undefined || turn === n % TURNS) strip.show(t, rows, range);
  }

  // Draw the whole flight or the zoomed part. The curves do not change during the replay; only the cursor
  // moves.
  drawReplay(history) {
    const range = this.range();
    const drawn = [range.join(), history, ...this.strips.map((strip) => strip.plot)];
    if (!this.drawn || drawn.some((item, n) => item !== this.drawn[n])) {
      this.drawn = drawn;
      for (const strip of this.strips) strip.showHistory(history, range);
    }
    text(this.title_, `${this.zoom ? "Zoomed" : "The whole flight"}${this.pointed()}`);
    if (!this.strips.length) return;
    const row = store.replay.at(store.time);
    for (const strip of this.strips) strip.point(store.time, row);
  }
}
customElements.define("station-strips", Strips);
