// SPDX-License-Identifier: Apache-2.0
// Controls of a replay: play, speed, and a time line with phases of the scenario, events, states and the
// present instant.

import { store } from "./store.js";
import { clock, el, isPageKey, put, svg, text } from "./dom.js";
import { lanes, marks, shownMembers, ticks } from "./lanes.js";

const SPEEDS = [0.1, 1, 4, 16];
const STEPS = { ArrowLeft: -1, ArrowRight: 1, ArrowDown: -0.1, ArrowUp: 0.1, PageDown: -10, PageUp: 10 };
const LANES_TOP = 50;
const PHASE_LEAST = 4; // Least width of a phase that has its own tooltip [pixels].

class Player extends HTMLElement {
  connectedCallback() {
    this.width = 0; // Width of the slider when it was drawn last.
    this.start = el("button", { class: "go", onclick: () => store.replay?.play(!store.replay.isPlaying) });
    this.clock = el("span", { class: "clock", role: "timer", "aria-label": "Time of the replay" });
    this.speeds = SPEEDS.map((speed) =>
      el("button", { "aria-pressed": "false", onclick: () => store.replay?.fast(speed) }, `${speed} ×`),
    );
    this.drawing = svg("svg", { "aria-hidden": "true" });
    this.head = el("div", { class: "playhead" });
    this.names = el("div", { class: "names", "aria-hidden": "true" });
    this.slider = el(
      "div",
      {
        class: "slider",
        role: "slider",
        tabindex: 0,
        "aria-label": "Instant of the flight",
        "aria-valuemin": 0,
      },
      this.drawing,
      this.head,
    );
    this.append(
      this.start,
      el(
        "div",
        { class: "times" },
        this.clock,
        el("div", { class: "speeds", role: "group", "aria-label": "Speed of the replay" }, ...this.speeds),
      ),
      this.names,
      this.slider,
    );
    store.on("player", () => this.tick());
    store.on("theme ready", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(this.slider);
    this.drag();
    document.addEventListener("keydown", (event) => this.key(event));
  }

  drag() {
    const go = (event) =>
      store.replay?.seek(
        ((event.clientX - this.slider.getBoundingClientRect().left) / this.slider.clientWidth) *
          store.replay.end,
      );
    this.slider.addEventListener("pointerdown", (event) => {
      this.slider.setPointerCapture(event.pointerId);
      go(event);
    });
    this.slider.addEventListener("pointermove", (event) => {
      if (this.slider.hasPointerCapture(event.pointerId)) go(event);
    });
  }

  key(event) {
    if (
      !store.replay ||
      !isPageKey(event) ||
      event.target.closest("[role=tab], .scroll") ||
      (event.target.closest("canvas") && event.key.startsWith("Arrow"))
    )
      return;
    const place = SPEEDS.indexOf(store.replay.speed) + ({ "[": -1, "]": 1 }[event.key] ?? 0);
    if (event.key === " ") store.replay.play(!store.replay.isPlaying);
    else if (event.key in STEPS) store.replay.seek(store.replay.time + STEPS[event.key]);
    else if (event.key === "Home" || event.key === "End")
      store.replay.seek(event.key === "Home" ? 0 : store.replay.end);
    else if ("[]".includes(event.key) && SPEEDS[place]) store.replay.fast(SPEEDS[place]);
    else return;
    event.preventDefault();
  }

  tick() {
    const { time, end, isPlaying, speed } = store.replay;
    text(this.clock, clock(time));
    text(this.start, isPlaying ? "❚❚" : "▶");
    put(this.start, "aria-label", isPlaying ? "Pause (Space)" : "Play (Space)");
    this.speeds.forEach((button, n) => put(button, "aria-pressed", SPEEDS[n] === speed));
    // The stored width is used: reading it from the slider would make the browser compute the layout at once.
    this.head.style.transform = `translateX(${((time / end) * this.width).toFixed(1)}px)`;
    put(this.slider, "aria-valuemax", end.toFixed(1));
    this.slider.setAttribute("aria-valuenow", time.toFixed(1));
    this.slider.setAttribute("aria-valuetext", `${time.toFixed(1)} of ${end.toFixed(1)} seconds`);
  }

  draw() {
    const width = (this.width = this.slider.clientWidth);
    if (!store.replay || !width) return;
    const { end, phases, events } = store.replay;
    const x = (t) => (t / end) * width;
    const members = shownMembers();
    this.names.replaceChildren(...members.map((name) => el("div", {}, name)));
    this.drawing.replaceChildren(
      ...ticks(x, end, 18, width),
      ...this.phases(x, phases),
      ...lanes(x, members, end, LANES_TOP),
      ...marks(x, events, 35),
    );
    this.tick();
  }

  // A phase without room for its name shows it shortened, or only as tooltip. The narrow phases, which cannot
  // be pointed at, are one path without a name.
  phases(x, phases) {
    const isNarrow = ([from, to]) => x(to) - x(from) < PHASE_LEAST;
    const narrow = phases
      .filter(isNarrow)
      .map(
        ([from, to]) =>
          `M${x(from).toFixed(2)} 0h${Math.max(1, x(to) - x(from) - 2).toFixed(2)}v15H${x(from).toFixed(2)}z`,
      );
    const wide = phases
      .filter((phase) => !isNarrow(phase))
      .map(([from, to, words]) => {
        const group = svg(
          "g",
          {},
          svg("rect", {
            class: "phase",
            x: x(from),
            y: 0,
            width: Math.max(1, x(to) - x(from) - 2),
            height: 15,
          }),
          svg("title", {}, words),
        );
        const fits = Math.floor((x(to) - x(from) - 8) / 6);
        if (fits >= Math.min(4, words.length))
          group.append(
            svg(
              "text",
              { class: "phase-name", x: x(from) + 4, y: 11 },
              words.length > fits ? `${words.slice(0, fits - 1)}…` : words,
            ),
          );
        return group;
      });
    return narrow.length ? [...wide, svg("path", { class: "phase", d: narrow.join("") })] : wide;
  }
}
customElements.define("station-player", Player);
