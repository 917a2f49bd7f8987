// SPDX-License-Identifier: Apache-2.0
// Bar: mission, link, mode, alarms, clock, pace of simulated time, theme, stop.

import { every } from "./beat.js";
import { store } from "./store.js";
import { ledTo } from "./under_way.js";
import { age, clock, counted, el, isPageKey, number, show, svg, symbol, text } from "./dom.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 10, 0]; // 0: as fast as possible
const speedName = (speed) => (speed === 0 ? "fastest" : `${speed} ×`);
const EPOCH_TAI_S = 378691200; // Seconds from the epoch of TAI, 1958-01-01, to the epoch of Date, 1970-01-01.
// Name of the scenario beside that of the mission, which often is the same.
const scenarioOf = ({ mission, scenario }) =>
  scenario === "none" ? "no scenario" : scenario && scenario !== mission ? scenario : "";
const causeOf = (separator, item, end) => (item.cause ? `${separator}${item.cause}${end}` : "");
const upper = (words) => words[0].toUpperCase() + words.slice(1);
const ORDER = ["HIGH", "MEDIUM", "LOW"];
const SYMBOL = { HIGH: "critical", MEDIUM: "serious", LOW: "caution" };

function octagon() {
  return svg(
    "svg",
    { viewBox: "0 0 24 24", "aria-hidden": "true" },
    svg("path", {
      d: "M7.5 1h9L23 7.5v9L16.5 23h-9L1 16.5v-9z",
      style: "fill:#d0241b;stroke:var(--stop-edge);stroke-width:1.5",
    }),
    svg("rect", { x: 8, y: 8, width: 8, height: 8, style: "fill:#fff" }),
  );
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  store.tell("theme");
}

export function toggleTheme() {
  const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  try {
    localStorage.setItem("theme", next);
  } catch {
    /* Without storage the page keeps the theme until it is closed. */
  }
  setTheme(next);
}

// The page is printed in the light theme.
let before = null;
addEventListener("beforeprint", () => {
  before = document.documentElement.dataset.theme;
  setTheme("light");
});
addEventListener("afterprint", () => {
  if (before) setTheme(before);
});

class Bar extends HTMLElement {
  connectedCallback() {
    this.missionName = el("h1", {}, "hirosco");
    this.scenario = el("span", { class: "what" });
    this.linkSymbol = el("span");
    this.linkText = el("strong");
    this.modeText = el("strong");
    this.power = el("strong", { class: "mono" });
    this.what = el("strong");
    this.counts = el("span", { class: "counts" });
    this.led = el("span", { class: "led", hidden: true });
    this.seen = el(
      "button",
      { hidden: true, title: "End the flashing of the events of severity HIGH", onclick: () => this.see() },
      "Seen ",
      el("kbd", {}, "A"),
    );
    this.slot_ = el(
      "div",
      { class: "cell slot" },
      el("div", { class: "two" }, this.what, this.counts, this.led),
      this.seen,
    );
    this.epoch = el("span", { class: "hint epoch" });
    this.clock = el("span", { class: "clock", role: "timer", "aria-label": "Mission time" });
    this.pause = el(
      "button",
      {
        "aria-label": "Pause the world (Space)",
        title: "Pause the world (Space)",
        onclick: () => this.togglePause(),
      },
      "❚❚",
    );
    this.step = el(
      "button",
      { "aria-label": "Step 0.1 s (.)", title: "Step 0.1 s (.)", onclick: () => store.live("step 0.1") },
      "▶❚",
    );
    this.speed = el(
      "select",
      { "aria-label": "Speed of simulated time", onchange: () => store.live(`speed ${this.speed.value}`) },
      ...SPEEDS.map((speed) => el("option", { value: speed }, speedName(speed))),
    );
    this.theme = el(
      "button",
      { "aria-label": "Light or dark", title: "Light or dark", onclick: toggleTheme },
      "☀",
    );
    this.help = el(
      "button",
      { class: "help", "aria-label": "Keys (?)", title: "Keys (?)", onclick: () => store.tell("keys") },
      "?",
    );
    this.stop = el(
      "button",
      {
        class: "stop",
        id: "stop-all",
        title: "Bring all subsystems to ERROR_OPERATIONAL (Ctrl Shift S)",
        onclick: () => store.command("stop"),
      },
      octagon(),
      "STOP ALL",
    );
    this.append(
      el("div", { class: "cell mission" }, this.missionName, this.scenario),
      el(
        "div",
        { class: "cell link-cell" },
        this.linkSymbol,
        el("div", { class: "two" }, el("span", { class: "hint" }, "Spacecraft link"), this.linkText),
      ),
      el(
        "div",
        { class: "cell mode-cell" },
        el("div", { class: "two" }, el("span", { class: "hint" }, "Mode"), this.modeText),
      ),
      (this.powerCell = el(
        "div",
        {
          class: "cell power-cell",
          title: "Electrical power: needed by the present states / available",
        },
        el("div", { class: "two" }, el("span", { class: "hint" }, "Power"), this.power),
      )),
      this.slot_,
      el("div", { class: "cell" }, el("div", { class: "two" }, this.epoch, this.clock)),
      el("div", { class: "cell pace" }, this.pause, this.step, this.speed),
      el("div", { class: "cell" }, this.theme, this.help),
      this.stop,
    );
    store.on("hello link mode pace event state ready mismatch links", () => this.plan());
    this.since = null;
    every(100, () => this.tick());
    every(200, () => this.tellLed());
    document.addEventListener("keydown", (event) => this.key(event));
    this.draw();
  }

  key(event) {
    if (event.ctrlKey && event.shiftKey && event.key.toUpperCase() === "S") {
      store.command("stop");
      event.preventDefault();
      return;
    }
    if (!isPageKey(event)) return;
    if (event.key === " ") {
      this.togglePause();
      event.preventDefault();
    }
    if (event.key === ".") store.live("step 0.1");
    if (event.key.toUpperCase() === "T") store.tell("other-source");
    if (event.key.toUpperCase() === "L" && location.search.includes("replay")) location.assign("/");
    if (event.key.toUpperCase() === "A") this.see();
    const place = SPEEDS.indexOf(store.pace.speed) + { "[": -1, "]": 1 }[event.key];
    if (SPEEDS[place]) store.live(`speed ${SPEEDS[place]}`);
  }

  // The user has seen the events of severity HIGH. Only this page notes it.
  see() {
    store.seen = store.events.length;
    store.tell("seen");
    this.draw();
  }

  // Another page or the command line may have set a speed that is not in the list.
  followSpeed(speed) {
    this.speed.querySelector("[data-other]")?.remove();
    if (!SPEEDS.includes(speed))
      this.speed.append(el("option", { value: speed, "data-other": "" }, speedName(speed)));
    this.speed.value = String(speed);
  }

  togglePause() {
    if (!store.replay) store.live(store.pace.is_paused ? "resume" : "pause");
  }

  tick() {
    text(this.clock, clock(store.now()));
    const epoch = store.hello?.epoch;
    if (!epoch) return;
    const date = new Date((epoch + Math.floor(store.now()) - EPOCH_TAI_S) * 1000);
    text(this.epoch, `Mission time, TAI ${date.toISOString().slice(0, 19).replace("T", " ")}`);
  }

  draw() {
    text(this.missionName, store.hello?.mission ?? "hirosco");
    text(this.scenario, scenarioOf(store.hello ?? {}));
    this.scenario.title = this.scenario.textContent;
    const { is_live, is_waiting, code } = store.link;
    const is_over = code === 0;
    // A subsystem flies another interface than that of the dictionary: values and commands may mean something
    // else.
    const others = [...store.mismatches.values()];
    const problems = store.replay?.about?.problems ?? [];
    if (is_live && others.length) show(this.linkSymbol, "caution", "other dictionary");
    else if (problems.length) show(this.linkSymbol, "caution", "incomplete recording");
    else if (is_live) show(this.linkSymbol, "normal", "live");
    else if (store.replay || is_over) show(this.linkSymbol, "off", is_over ? "ended" : "replay");
    else if (is_waiting) show(this.linkSymbol, "standby", "waiting");
    else show(this.linkSymbol, "critical", "lost");
    text(this.linkText, this.wordOfLink());
    this.linkText.title = [store.link.text, ...others, ...problems].join("; ");
    text(this.modeText, store.mode ?? "–");
    const needed = store.power();
    this.powerCell.hidden = needed === null && store.hello !== null; // The mission defines no power.
    text(this.power, needed === null ? "–" : `${needed} / ${store.hello.power_available_w} W`);
    const is_there = store.pace.is_there && !store.barrier();
    this.pause.disabled = this.step.disabled = this.speed.disabled = !is_there;
    this.pause.setAttribute("aria-pressed", String(store.pace.is_paused));
    this.followSpeed(store.pace.speed);
    // A station or flight that is silent executes the waiting commands once it answers again. A late stop is
    // better than none.
    this.stop.disabled = Boolean(store.barrier()) && !store.link.is_silent;
    this.drawAlarm();
  }

  // The cell of the link has room for a word; the alarm slot beside it says more.
  wordOfLink() {
    const { is_live, is_waiting, is_silent, code } = store.link;
    if (is_live) return store.hello?.read_only ? "live, read only" : "live";
    if (store.replay) return "replay";
    if (code !== undefined) return code === 0 ? "ended" : "failed";
    if (is_waiting) return "waiting";
    if (is_silent) return "silent";
    return store.hello ? "lost" : "no link";
  }

  plan() {
    if (this.planned) return;
    this.planned = true;
    setTimeout(() => {
      this.planned = false;
      this.draw();
    }, 20);
  }

  // While an alarm is open, the line of the counts says which event it began with, when that was, and how
  // many reports it led to.
  tellLed() {
    const led = this.since === null ? null : ledTo(store.events, this.since);
    this.led.hidden = led === null;
    this.counts.hidden = led !== null;
    if (led === null) return;
    const { severity, time, count } = led;
    const reports = count ? `, led to ${counted(count, "report")}` : "";
    text(this.led, `${severity}, ${age(Math.max(0, store.now() - time))} ago${reports}`);
  }

  drawAlarm() {
    const failed = [...store.states.values()].filter((item) => item.state === "ERROR_OPERATIONAL");
    const counts = Object.fromEntries(
      ORDER.map((severity) => [severity, store.events.filter((event) => event.severity === severity).length]),
    );
    const broken = store.links.filter((row) => ["stale", "failed"].includes(row.state));
    const isRefused = Boolean(store.link.is_refused);
    const { is_live, is_waiting, code } = store.link;
    const is_over = code === 0;
    const isLost = isRefused || (!is_live && !is_over && !store.replay && store.hello !== null);
    const isBroken = !is_over && (failed.length > 0 || broken.length > 0);
    this.slot_.classList.toggle("critical", isBroken || isLost);
    // Mission time at which the open alarm began; null without one. The alarm of a lost link began on ground.
    const begins = [...failed, ...broken].map((item) => item.since ?? Infinity);
    this.since = isBroken && !isLost && begins.length ? Math.min(...begins) : null;
    this.tellLed();
    if (code !== undefined || is_waiting) text(this.what, upper(store.link.text));
    else if (!store.hello) text(this.what, upper(store.link.text));
    else if (isLost) text(this.what, isRefused ? store.link.text : `Link lost: ${store.link.text}`);
    else if (failed.length) {
      const led = ledTo(store.events, this.since);
      const names = failed.map((item) => item.subsystem).join(", ");
      const since = `since ${number(failed[0].since, "s").trim()} s${causeOf(": ", failed[0], "")}`;
      // With its first event an alarm needs no more words: the line below says when it was.
      text(this.what, led ? `${led.words}; ${names} in error` : `${names} in ERROR_OPERATIONAL ${since}`);
    } else if (broken.length) {
      const states = broken.map((row) => `${row.name} ${row.state}${causeOf(" (", row, ")")}`);
      text(this.what, `Link ${states.join(", ")}`);
    } else if (store.mismatches.size) text(this.what, [...store.mismatches.values()][0]);
    else if (store.replay?.about?.problems?.length) text(this.what, store.replay.about.problems.join("; "));
    else text(this.what, "No open alarm");
    this.what.title = this.what.textContent;
    this.seen.hidden = !store.events.slice(store.seen).some((event) => event.severity === "HIGH");
    const isAlarm = this.slot_.classList.contains("critical");
    const name = store.hello?.mission ?? "hirosco";
    // The title is all that a page in the background shows.
    document.title = isAlarm ? `▼ ${this.what.textContent}: ${name}` : `${name}: ground station`;
    this.counts.replaceChildren(
      ...ORDER.map((severity) =>
        el(
          "span",
          {},
          symbol(counts[severity] ? SYMBOL[severity] : "off", severity),
          `${counts[severity]} ${severity}`,
        ),
      ),
    );
  }
}
customElements.define("station-bar", Bar);

const wished = (() => {
  try {
    return localStorage.getItem("theme");
  } catch {
    return null;
  }
})();
document.documentElement.dataset.theme =
  wished ?? (matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark");
