// SPDX-License-Identifier: Apache-2.0
// Left column: subsystems, the ten states of the selected one, the real-time network.

import { store } from "./store.js";
import { age, el, number, padlock, show, stateSymbol, svg, text } from "./dom.js";

class Subsystems extends HTMLElement {
  connectedCallback() {
    this.rows = new Map();
    this.list = el("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Subsystems" });
    this.append(el("div", { class: "head" }, el("h2", {}, "Subsystems"), el("span", { class: "hint" }, "age of last report")), this.list);
    store.on("hello", () => this.build());
    store.on("state select", () => this.draw());
    setInterval(() => this.draw(), 200);
    document.addEventListener("keydown", (event) => {
      const row = event.altKey && [...this.rows.keys()][Number(event.key) - 1];
      if (row) { store.select(row); event.preventDefault(); }
    });
  }

  build() {
    this.rows.clear();
    for (const { name } of store.ordered()) {
      const parts = { sym: el("span", { class: "sym" }), state: el("span", { class: "state" }), second: el("span", { class: "second" }), age: el("span", { class: "mono age" }) };
      parts.row = el("button", { class: "row", onclick: () => store.select(name) }, parts.sym, el("span", { class: "name" }, name), parts.state, parts.second, parts.age);
      this.rows.set(name, parts);
    }
    this.list.replaceChildren(...[...this.rows.values()].map((parts) => parts.row));
    this.draw();
  }

  draw() {
    for (const [name, parts] of this.rows) {
      const known = store.states.get(name);
      const heard = store.heard.get(name);
      const since = heard === undefined ? null : (store.clock() - heard) / 1000;
      const periods = since === null || store.pace.is_paused ? 0 : since * 1000 / store.period(name);
      const isStale = periods > 3;
      const state = known?.state ?? "not reported";
      show(parts.sym, isStale ? "stale" : periods > 2 ? "caution" : known ? stateSymbol(state) : "off", isStale ? "stale" : periods > 2 ? "late" : state);
      text(parts.state, state);
      text(parts.second, known?.configuration && known.configuration !== "-" ? known.configuration : "no configuration");
      text(parts.age, age(since));
      parts.row.classList.toggle("stale", isStale);
      parts.row.classList.toggle("critical", state === "ERROR_OPERATIONAL");
      parts.row.setAttribute("aria-current", String(name === store.selected));
    }
  }
}
customElements.define("station-subsystems", Subsystems);

// Place of each state [x, y, width, height]: height is activation.
const BOXES = {
  OPERATIONAL: [0, 0, 134, 28], ERROR_OPERATIONAL: [150, 0, 136, 28], SAFE_OPERATIONAL: [0, 43, 134, 28], PRE_OPERATIONAL: [0, 86, 134, 28],
  POST_OPERATIONAL: [150, 89, 136, 22], HARDWARE_INIT: [8, 129, 118, 22], HARDWARE_DEINIT: [159, 129, 118, 22],
  SOFTWARE_INIT: [8, 164, 118, 22], SOFTWARE_DEINIT: [159, 164, 118, 22], OFFLINE: [0, 200, 286, 28],
};
const ARROWS = [
  "M55 43v-15", "M80 28v15", "M67 86v-15", "M67 129v-15", "M67 164v-13", "M67 200v-14", "M134 14h16", "M134 57h8V20h8", "M134 95h16", "M134 62h8v33",
  "M218 28v61", "M218 111v18", "M218 151v13", "M218 186v14",
];

class States extends HTMLElement {
  connectedCallback() {
    this.title_ = el("h2");
    this.config = el("select", { "aria-label": "Configuration", onchange: () => this.configure() });
    this.since = el("span", { class: "hint" });
    this.boxes = new Map();
    const drawing = svg("svg", { viewBox: "0 0 286 230", "aria-hidden": "true" },
      svg("defs", {}, svg("marker", { id: "tip", viewBox: "0 0 6 6", refX: 5, refY: 3, markerWidth: 6, markerHeight: 6, orient: "auto" },
        svg("path", { d: "M0 0L6 3L0 6z", style: "fill:var(--line2);stroke:none" }))),
      ...ARROWS.map((d) => svg("path", { d, "marker-end": "url(#tip)" })));
    const machine = el("div", { class: "machine" }, drawing);
    for (const [state, [x, y, width, height]] of Object.entries(BOXES)) {
      const isPass = height === 22;
      const box = el("button", { class: isPass ? "box pass" : "box", style: `left:${x}px;top:${y}px;width:${width}px;height:${height}px`, onclick: () => this.ask(state) },
        el("span", { class: "mark" }), el("span", {}, state));
      this.boxes.set(state, box);
      machine.append(box);
    }
    this.reason = el("p", { class: "reason", style: "margin:0" });
    this.append(el("div", { class: "head" }, this.title_, this.config), el("div", { class: "sides" }, this.since, el("span", { class: "hint" }, "press a number to request")), machine, this.reason);
    store.on("state select hello link", () => this.draw());
    document.addEventListener("keydown", (event) => {
      if (event.target.closest("input, select, textarea") || event.ctrlKey || event.altKey || event.metaKey) return;
      const state = store.hello?.states[Number(event.key)];
      if (event.key !== " " && state && this.targets()[event.key] === null) this.ask(state);
    });
  }

  targets() { return !store.barrier() ? store.states.get(store.selected)?.targets ?? {} : {}; }

  ask(state) {
    const words = `state ${store.selected} ${state}`;
    if (state === "ERROR_OPERATIONAL") store.command(words);
    else store.tell("prepare", words);
  }

  configure() {
    if (this.config.value) store.tell("prepare", `config ${store.selected} ${this.config.value}`);
    this.draw();
  }

  draw() {
    const known = store.states.get(store.selected);
    const about = store.subsystem(store.selected);
    text(this.title_, store.selected ?? "State machine");
    const wanted = `${store.selected}/${about?.configurations.length}`;
    if (this.config.dataset.of !== wanted) {
      this.config.dataset.of = wanted;
      this.config.replaceChildren(el("option", { value: "" }, "Configuration"), ...(about?.configurations ?? []).map((item) => el("option", {}, item.name)));
    }
    this.config.value = "";
    text(this.since, known?.since ? `since ${number(known.since, "s").trim()} s` : "");
    const targets = this.targets();
    const barred = [];
    for (const [state, box] of this.boxes) {
      const n = store.hello?.states.indexOf(state);
      const isPresent = known?.state === state;
      const isLegal = targets[n] === null;
      const bar = targets[n];
      box.disabled = !isLegal;
      box.classList.toggle("legal", isLegal);
      box.classList.toggle("barred", Boolean(bar));
      box.toggleAttribute("data-is-present", isPresent);
      if (isPresent) box.setAttribute("aria-current", "true"); else box.removeAttribute("aria-current");
      const mark = box.firstChild;
      if (isPresent) show(mark, stateSymbol(state), "present");
      else { delete mark.dataset.symbol; mark.replaceChildren(bar ? padlock() : isLegal ? String(n) : ""); }
      if (bar) barred.push([n, bar]);
    }
    const reasons = new Map();
    for (const [n, words] of barred) reasons.set(words, [...(reasons.get(words) ?? []), n]);
    const line = [...reasons].map(([words, numbers]) => `${numbers.join(", ")} barred: ${words}`).join("; ");
    text(this.reason, line || (known?.phase && known.phase !== "IDLE" ? `phase ${known.phase}` : "") || (store.replay || store.hello?.read_only ? store.barrier() : ""));
    this.reason.title = line;
  }
}
customElements.define("station-states", States);

class Network extends HTMLElement {
  connectedCallback() {
    this.sym = el("span");
    this.words = el("span");
    this.graph = svg("svg", { class: "graph", role: "img", "aria-label": "Real-time network" });
    this.append(el("div", { class: "head" }, el("h2", {}, "Network"), this.sym, this.words), this.graph);
    store.on("hello state links link theme", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(this);
  }

  draw() {
    if (!store.hello) return;
    const rows = new Map(store.links.map((row) => [row.name, row]));
    const used = store.hello.links.filter((link) => (rows.get(link.name)?.state ?? "closed") !== "closed");
    const links = used.length ? used : store.hello.links.slice(0, 2);
    const open = links.filter((link) => rows.get(link.name)?.state === "open");
    const lost = links.reduce((sum, link) => sum + (rows.get(link.name)?.lost ?? 0), 0);
    const isFailed = links.some((link) => ["stale", "failed"].includes(rows.get(link.name)?.state));
    show(this.sym, isFailed ? "critical" : links.length && open.length === links.length ? "normal" : "off", isFailed ? "failed" : open.length ? "open" : "closed");
    text(this.words, links.length ? (open.length ? `${open.length} open, ${lost} lost` : "closed") : "no links in this mission");
    this.graph.replaceChildren(...this.parts(links, rows));
    this.graph.setAttribute("aria-label", `Real-time network: ${links.map((link) => `${link.name} ${rows.get(link.name)?.state ?? "closed"}`).join(", ")}`);
  }

  parts(links, rows) {
    const width = 308, height = Math.max(150, this.graph.clientHeight || 240);
    this.graph.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const names = store.members().map((item) => item.name);
    if (names.length === 2) names.sort((a, b) => store.drives(store.subsystem(b)) - store.drives(store.subsystem(a)));
    const shown = names.slice(0, 2);
    const boxes = new Map(shown.map((name, n) => [name, [shown.length === 1 ? 92 : 8 + n * 172, 50]]));
    const found = [];
    for (const [name, [x, y]] of boxes) {
      const member = store.subsystem(name);
      const devices = store.configuration(name)?.devices ?? member.configurations[0]?.devices ?? [];
      const each = Math.min(62, 126 / Math.max(1, devices.length));
      const left = Math.max(4, Math.min(width - each * devices.length - 4, x + 60 - (each * devices.length) / 2));
      const bottom = height - 46;
      const bus = (y + 40 + bottom) / 2;
      devices.forEach((device, n) => {
        const cx = left + each * (n + 0.5);
        found.push(svg("path", { class: "wire", d: `M${x + 60} ${y + 40}V${bus}H${cx}V${bottom}` }),
          svg("rect", { x: cx - each / 2 + 2, y: bottom, width: each - 4, height: 32, rx: 3 }),
          svg("text", { x: cx, y: bottom + 20, "text-anchor": "middle", class: "strong" }, device));
      });
      const state = store.states.get(name)?.state;
      found.push(svg("rect", { x, y, width: 120, height: 40, rx: 3 }), svg("text", { x: x + 10, y: y + 17, class: "strong" }, name),
        svg("text", { x: x + 10, y: y + 32 }, `APID ${member.apid}${state === "ERROR_OPERATIONAL" ? ", error" : ""}`));
    }
    links.forEach((link, n) => {
      const from = boxes.get(link.producer), to = boxes.get(link.consumer);
      if (!from || !to) return;
      const isRight = to[0] > from[0];
      const y = isRight ? from[1] + 13 : from[1] + 29;
      const [a, b] = isRight ? [from[0] + 120, to[0]] : [from[0], to[0] + 120];
      const row = rows.get(link.name);
      const isOpen = row?.state === "open";
      const word = isOpen ? `${row.received ?? 0} received` : row?.state ?? "closed";
      found.push(svg("path", { class: isOpen ? "wire open" : "wire closed", d: `M${a} ${y}H${b + (isRight ? -6 : 6)}` }),
        svg("path", { class: "head-of", d: isRight ? `M${b} ${y}l-8 -4v8z` : `M${b} ${y}l8 -4v8z` }),
        svg("text", { x: width / 2, y: isRight ? 22 : from[1] + 58, "text-anchor": "middle", class: "strong" }, link.name),
        svg("text", { x: width / 2, y: isRight ? 38 : from[1] + 73, "text-anchor": "middle" }, word));
    });
    return found;
  }
}
customElements.define("station-network", Network);
