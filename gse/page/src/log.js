// SPDX-License-Identifier: Apache-2.0
// Events, commands, counts of packets, and the time line of the flight.

import { every } from "./beat.js";
import { store } from "./store.js";
import {
  counted,
  el,
  isPageKey,
  lights,
  refill,
  renew,
  SYMBOL_OF_SEVERITY,
  svg,
  symbol,
  tabs,
  text,
} from "./dom.js";
import { lanes, marks, shownMembers, ticks } from "./lanes.js";
import { Packets } from "./packets.js";
import { Telemetry } from "./telemetry.js";

// Most entries that the log shows; entries before and after the present instant of a replay.
const SHOWN = 120,
  AROUND = 30;
const LINE_MAX = 120; // Characters of a command that is shown with its arguments.
const SEVERITIES = ["INFORMATIVE", "LOW", "MEDIUM", "HIGH"];

// A command with its arguments; without them if they are long, such as the octets of a telecommand.
const saidOf = ({ line, text: words }) => (line && line.length <= LINE_MAX ? line : words);

// Scroll a list to its present entry and the line of its reports, but not the page around it.
function reveal(list) {
  const entry = list.querySelector("[aria-current]");
  if (!entry) return;
  const below = entry.nextElementSibling?.matches(".led-to") ? entry.nextElementSibling : entry;
  const first = entry.getBoundingClientRect().top,
    last = below.getBoundingClientRect().bottom;
  const { top, bottom } = list.getBoundingClientRect();
  if (first < top) list.scrollTop += first - top;
  else if (last > bottom) list.scrollTop += last - bottom;
}

class Log extends HTMLElement {
  connectedCallback() {
    this.least = el(
      "select",
      { "aria-label": "Least severity shown", onchange: () => this.draw() },
      ...SEVERITIES.map((severity) =>
        el(
          "option",
          { value: severity },
          severity === "INFORMATIVE" ? "all severities" : `${severity} and above`,
        ),
      ),
    );
    this.from = el(
      "select",
      { "aria-label": "Subsystem shown", onchange: () => this.draw() },
      el("option", { value: "" }, "all subsystems"),
    );
    this.filter = el("div", { class: "filter" }, this.least, this.from);
    this.eventList = el("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Events" });
    this.whose = el(
      "select",
      {
        "aria-label": "Commands shown",
        onchange: () => store.replay.showOwn(this.whose.value === "all"),
      },
      el("option", { value: "" }, "commands of operators"),
      el("option", { value: "all" }, "all, with requests of stations for their pages"),
    );
    this.own = el("div", { class: "filter", hidden: true }, this.whose);
    this.commandList = el("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Commands" });
    this.packets = new Packets();
    const { list, fields } = this.packets.kept;
    for (const entries of [this.eventList, this.commandList, list, fields])
      entries.addEventListener("keydown", (event) => this.walk(event));
    this.lists = [
      ["Events", this.eventList],
      ["Commands", this.commandList],
      ["Packets", this.packets.node],
    ];
    // A report has no panel with these tabs; its log has them.
    if (document.body.classList.contains("report")) {
      const values = new Telemetry();
      this.lists.push(["Values", values.node], ["Links", el("station-network")]);
      store.on("parameter", () => {
        this.pages.open("Values");
        values.find.focus();
      });
      this.lists.push([
        "Run",
        (this.facts = el("div", {
          class: "scroll",
          tabindex: 0,
          role: "group",
          "aria-label": "Content of run.json",
        })),
      ]);
    }
    this.pages = tabs(
      "log",
      this.lists.map(([name, list]) => [
        name,
        el("div", {}, { Events: this.filter, Commands: this.own }[name], list),
      ]),
      () => this.pages && this.draw(),
    );
    this.opened = new Set(); // Numbers of the commands whose reports are listed.
    this.made = new Map(); // In a replay: event -> its entry, which is shown again and again.
    this.append(this.pages.list, ...this.lists.map(([, list]) => list.parentElement));
    store.on("hello", () => this.opened.clear());
    store.on("hello event command counts seen ready", () => this.plan());
    store.on("event", (event) => {
      if (event.severity === "HIGH")
        document.getElementById("alarm-said").textContent =
          `${event.subsystem} ${event.event}, high: ${event.text ?? ""}`;
    });
    document.addEventListener("keydown", (event) => {
      if (!isPageKey(event)) return;
      const page = { E: "Events", C: "Commands" }[event.key.toUpperCase()];
      if (page) this.pages.open(page);
    });
  }

  plan() {
    if (this.planned) return;
    this.planned = true;
    setTimeout(() => {
      this.planned = false;
      this.draw();
    }, 200);
  }

  // In a replay, the entries around the present instant: AROUND before it and AROUND after it.
  around(entries, isPast) {
    const present = entries.filter(isPast).length;
    return entries.slice(Math.max(0, present - AROUND), present + AROUND);
  }

  isShown(event) {
    return (
      SEVERITIES.indexOf(event.severity) >= SEVERITIES.indexOf(this.least.value) &&
      (!this.from.value || event.subsystem === this.from.value)
    );
  }

  // Offer the subsystems of the mission as choices of the filter.
  offer() {
    const names = store.ordered().map((item) => item.name);
    if (this.from.dataset.of === names.join()) return;
    this.from.dataset.of = names.join();
    this.from.replaceChildren(
      el("option", { value: "" }, "all subsystems"),
      ...names.map((name) => el("option", { value: name }, name)),
    );
  }

  entry(event, isUnseen) {
    const sym = symbol(SYMBOL_OF_SEVERITY[event.severity], event.severity);
    if (isUnseen) sym.classList.add("unseen-high");
    const parts = [
      el("span", { class: "mono" }, event.time.toFixed(4)),
      sym,
      el(
        "span",
        {},
        el("span", { class: "name" }, `${event.subsystem} ${event.event}`),
        event.text ? `  ${event.text}` : "",
      ),
    ];
    return this.jump(event.time, parts, isUnseen);
  }

  // Entry whose click shows its instant: in a flight in charts and time line, in a replay everywhere.
  jump(time, parts, isUnseen) {
    const show = () => (store.replay ? store.replay.seek(time) : store.tell("instant", time));
    return el(
      "button",
      { class: isUnseen ? "entry critical" : "entry", tabindex: -1, onclick: show },
      ...parts,
    );
  }

  // A list is one stop of the Tab key; the arrow keys go through its entries.
  walk(event) {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const entries = [...event.currentTarget.querySelectorAll("button.entry, .led-to")];
    const next = entries[Math.max(0, entries.indexOf(document.activeElement) + step)];
    if (!step || !next) return;
    event.preventDefault();
    next.focus();
  }

  // Entry of an event of a replay, marked as past, present or to come.
  replayed(event) {
    if (!this.made.has(event)) this.made.set(event, this.entry(event));
    const entry = this.made.get(event);
    entry.classList.toggle("to-come", event.number >= store.events.length);
    if (event.number === store.events.length - 1) entry.setAttribute("aria-current", "true");
    else entry.removeAttribute("aria-current");
    return entry;
  }

  draw() {
    // In a replay both lists, and so both numbers, are of the whole flight.
    const events = (store.replay ?? store).events.length;
    const commands = store.replay ? store.replay.shownCommands().length : store.commands.size;
    text(this.pages.list.querySelector("#log-Events"), `Events ${events}`);
    text(this.pages.list.querySelector("#log-Commands"), `Commands ${commands}`);
    const tab = this.pages.list.querySelector("#log-Packets");
    tab.hidden = Boolean(store.replay); // No station has counted the packets of a recording.
    text(tab, `Packets ${this.packets.sum("received")}`);
    this.offer();
    this.own.hidden = !store.replay?.commands.some((call) => call.own);
    // Only the list of the open tab is drawn.
    if (!this.eventList.parentElement.hidden) this.drawEvents();
    if (!this.commandList.parentElement.hidden) this.drawCommands();
    if (this.facts && store.replay && !this.facts.firstChild) this.drawFacts();
  }

  drawEvents() {
    const entries = store.replay ? this.replayedEntries() : this.newestEntries();
    refill(
      this.eventList,
      ...(entries.length
        ? entries
        : [
            el(
              "p",
              { class: "reason" },
              store.events.length ? "No event that the filter shows." : "No event yet.",
            ),
          ]),
    );
    reveal(this.eventList);
  }

  // In a flight: the newest events, with those of severity HIGH that the user has not seen first.
  newestEntries() {
    const newest = store.events
      .filter((event) => this.isShown(event))
      .slice(-SHOWN)
      .reverse();
    const unseen = newest.filter(
      (event) => event.severity === "HIGH" && store.events.indexOf(event) >= store.seen,
    );
    const ordered = [...unseen, ...newest.filter((event) => !unseen.includes(event))];
    return ordered.map((event) => this.entry(event, unseen.includes(event)));
  }

  replayedEntries() {
    const events = store.replay.events.filter((event) => this.isShown(event));
    return this.around(events, (event) => event.number < store.events.length).map((event) =>
      this.replayed(event),
    );
  }

  drawCommands() {
    const isPast = (call) => call.time <= store.time;
    const commands = store.replay
      ? this.around(store.replay.shownCommands(), isPast).map((call) => store.replay.callAt(call))
      : [...store.commands.values()].slice(-SHOWN).reverse();
    const entries = commands.map((call) => [this.command(call), ...this.reportsOf(call)]);
    for (const [entry, line] of entries) entry.classList.toggle("leads", Boolean(line));
    if (store.replay) {
      const past = commands.filter(isPast).length;
      entries.forEach(([entry], n) => entry.classList.toggle("to-come", n >= past));
      entries[past - 1]?.[0].setAttribute("aria-current", "true");
    }
    const none = store.replay ? "No command of an operator." : "No command of this station yet.";
    refill(this.commandList, ...(entries.length ? entries.flat() : [el("p", { class: "reason" }, none)]));
    reveal(this.commandList);
  }

  command(call) {
    const repeat = () =>
      el(
        "button",
        {
          class: "again",
          title: "Open this command in the tab Command",
          onclick: () => store.tell("again", call.line),
        },
        saidOf(call),
      );
    const parts = [
      el("span", { class: "mono" }, (call.time ?? 0).toFixed(4)),
      lights(call.lights),
      el(
        "span",
        {},
        call.line && !store.replay ? repeat() : call.text,
        call.silent && !call.over ? el("span", { class: "hint" }, " no answer for 10 s") : "",
        call.words
          ? el(
              "span",
              { class: call.unknown ? "hint" : "words" },
              ` ${call.words.replace(`${call.text}: `, "")}`,
            )
          : "",
      ),
    ];
    return store.replay ? this.jump(call.time, parts) : el("div", { class: "entry" }, ...parts);
  }

  // A line below a command with the number of reports that it led to. A click lists them; a click on one
  // shows its instant.
  reportsOf(call) {
    const { number, time, led_to } = call;
    if (!led_to) return [];
    const { count, rows } = led_to;
    const isOpen = this.opened.has(number);
    const toggle = () => {
      if (!this.opened.delete(number)) this.opened.add(number);
      this.drawCommands();
    };
    const said = `led to ${counted(count, "report")}`;
    const line = el(
      "button",
      {
        class: "led-to",
        tabindex: -1,
        "aria-expanded": String(isOpen),
        "aria-label": `${said}: ${saidOf(call)} at ${(time ?? 0).toFixed(4)} s`,
        onclick: toggle,
      },
      `${isOpen ? "▾" : "▸"} ${said}`,
    );
    if (!isOpen) return [line];
    const more = count > rows.length ? [el("p", { class: "reason" }, `${count - rows.length} more`)] : [];
    return [line, el("div", { class: "reports" }, ...rows.map((row) => this.report(row)), ...more)];
  }

  report([time, message, words]) {
    const mono = (part) => el("span", { class: "mono" }, part);
    return this.jump(time, [mono(time.toFixed(4)), mono(message), el("span", {}, words)]);
  }

  drawFacts() {
    const words = (value) =>
      value !== null && typeof value === "object" ? JSON.stringify(value) : String(value);
    this.facts.append(
      el(
        "table",
        {},
        el(
          "tbody",
          {},
          ...Object.entries(store.replay.about?.facts ?? {}).map(([name, value]) =>
            el("tr", {}, el("td", { class: "name" }, name), el("td", { class: "mono words" }, words(value))),
          ),
        ),
      ),
    );
  }
}
customElements.define("station-log", Log);

class TimeLine extends HTMLElement {
  connectedCallback() {
    this.names = el("div", { class: "name", style: "font-weight:500" });
    this.drawing = svg("svg", { role: "img", "aria-label": "Flight so far" });
    this.mark = el("a", { class: "live-mark", onclick: (event) => this.follow(event) }, "LIVE");
    this.instant = null; // Instant that the charts show instead of the present one [s].
    store.on("instant", (time) => {
      this.instant = time;
      this.draw();
    });
    store.on("hello", () => (this.instant = null));
    const go = ({ offsetX }) =>
      store.tell("instant", Math.min(store.now(), this.end * (offsetX / this.width)));
    this.drawing.addEventListener("pointerdown", (event) => {
      this.drawing.setPointerCapture(event.pointerId);
      go(event);
    });
    this.drawing.addEventListener("pointermove", (event) => {
      if (this.drawing.hasPointerCapture(event.pointerId)) go(event);
    });
    document.addEventListener("keydown", (event) => {
      if (isPageKey(event) && event.key.toUpperCase() === "L" && this.instant !== null) this.follow(event);
    });
    this.append(
      el("div", {}, el("div", { class: "hint" }, "Flight so far: states and events"), this.names),
      this.drawing,
      this.mark,
    );
    every(500, () => this.draw());
  }

  // The charts follow the flight again.
  follow(event) {
    if (this.instant === null) return; // The mark may be a link to the replay.
    event.preventDefault();
    store.tell("instant", null);
  }

  // In a replay this time line is hidden, because the player has its own.
  draw() {
    if (store.replay) return;
    // Only a station that answers can replay the flight.
    const isOver = !store.link.is_live && store.hasSocket && !store.link.is_silent && store.hello !== null;
    const behind = this.instant === null ? null : Math.max(0, store.now() - this.instant);
    this.mark.classList.toggle("is-off", !store.link.is_live);
    this.mark.classList.toggle("is-behind", behind !== null);
    const words = behind === null ? (isOver ? "Replay" : "LIVE") : `LIVE, ${Math.round(behind)} s behind`;
    text(this.mark, words);
    if (behind !== null) this.mark.href = "#live";
    else if (isOver) this.mark.href = "/?replay";
    else this.mark.removeAttribute("href");
    const members = shownMembers();
    renew(this.names, ...members.map((name) => el("div", { style: "line-height:14px" }, name)));
    const width = this.drawing.clientWidth || 800;
    const now = store.now();
    const end = Math.max(60, now * 1.15);
    const x = (t) => (t / end) * width;
    [this.end, this.width] = [end, width];
    const parts = [
      ...ticks(x, end, 2, width),
      ...lanes(x, members, now, 30),
      ...marks(x, store.events.slice(-300), 17),
    ];
    const shown = x(this.instant ?? now);
    parts.push(
      svg("path", { d: `M${shown} 4v54`, style: "stroke:var(--fg0);stroke-width:2" }),
      svg("path", { d: `M${shown - 5} 0h10l-5 7z`, style: "fill:var(--fg0)" }),
    );
    renew(this.drawing, ...parts);
  }
}
customElements.define("station-timeline", TimeLine);
