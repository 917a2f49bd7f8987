// SPDX-License-Identifier: Apache-2.0
// Left column: subsystems, the ten states of the selected one, the real-time network.

import { every } from "./beat.js";
import { store } from "./store.js";
import { busOf, lostOf } from "./bus_devices.js";
import {
  age,
  counted,
  el,
  isPageKey,
  number,
  once,
  padlock,
  put,
  renew,
  show,
  stateSymbol,
  svg,
  text,
} from "./dom.js";

class Subsystems extends HTMLElement {
  connectedCallback() {
    this.rows = new Map();
    this.list = el("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Subsystems" });
    this.append(
      el(
        "div",
        { class: "head" },
        el("h2", {}, "Subsystems"),
        el("span", { class: "hint" }, "age of last report"),
      ),
      this.list,
    );
    store.on("hello", () => this.build());
    store.on(
      "state select",
      once(() => this.draw()),
    );
    every(200, () => this.draw());
    document.addEventListener("keydown", (event) => {
      const row = event.altKey && [...this.rows.keys()][Number(event.key) - 1];
      if (row) {
        store.select(row);
        event.preventDefault();
      }
    });
  }

  build() {
    this.rows.clear();
    for (const { name } of store.ordered()) {
      const parts = {
        sym: el("span", { class: "sym" }),
        state: el("span", { class: "state" }),
        second: el("span", { class: "second" }),
        age: el("span", { class: "mono age" }),
      };
      parts.row = el(
        "button",
        { class: "row", onclick: () => store.select(name) },
        parts.sym,
        el("span", { class: "name" }, name),
        parts.state,
        parts.second,
        parts.age,
      );
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
      const periods = since === null ? 0 : (since * 1000) / store.period(name);
      const isStale = periods > 3;
      const state = known?.state ?? "not reported";
      show(
        parts.sym,
        isStale ? "stale" : periods > 2 ? "caution" : known ? stateSymbol(state) : "off",
        isStale ? "stale" : periods > 2 ? "late" : state,
      );
      text(parts.state, state);
      text(
        parts.second,
        known?.configuration && known.configuration !== "-" ? known.configuration : "no configuration",
      );
      text(parts.age, age(since));
      parts.row.classList.toggle("stale", isStale);
      parts.row.classList.toggle("critical", state === "ERROR_OPERATIONAL");
      put(parts.row, "aria-current", name === store.selected);
    }
  }
}
customElements.define("station-subsystems", Subsystems);

// Box of each state in the drawing [x, y, width, height]; states with a higher activation are drawn higher.
const BOXES = {
  OPERATIONAL: [0, 0, 134, 28],
  ERROR_OPERATIONAL: [150, 0, 136, 28],
  SAFE_OPERATIONAL: [0, 43, 134, 28],
  PRE_OPERATIONAL: [0, 86, 134, 28],
  POST_OPERATIONAL: [150, 89, 136, 22],
  HARDWARE_INIT: [8, 129, 118, 22],
  HARDWARE_DEINIT: [159, 129, 118, 22],
  SOFTWARE_INIT: [8, 164, 118, 22],
  SOFTWARE_DEINIT: [159, 164, 118, 22],
  OFFLINE: [0, 200, 286, 28],
};
// Paths of the arrows between the boxes in the drawing.
const ARROWS = [
  "M55 43v-15",
  "M80 28v15",
  "M67 86v-15",
  "M67 129v-15",
  "M67 164v-13",
  "M67 200v-14",
  "M134 14h16",
  "M134 57h8V20h8",
  "M134 95h16",
  "M134 62h8v33",
  "M218 28v61",
  "M218 111v18",
  "M218 151v13",
  "M218 186v14",
];

class States extends HTMLElement {
  connectedCallback() {
    if (this.title_) return; // The browser calls this again when the element moves within the page.
    this.title_ = el("h2");
    this.config = el("select", { "aria-label": "Configuration", onchange: () => this.configure() });
    this.since = el("span", { class: "hint" });
    this.boxes = new Map();
    const drawing = svg(
      "svg",
      { viewBox: "0 0 286 230", "aria-hidden": "true" },
      svg(
        "defs",
        {},
        svg(
          "marker",
          {
            id: "tip",
            viewBox: "0 0 6 6",
            refX: 5,
            refY: 3,
            markerWidth: 6,
            markerHeight: 6,
            orient: "auto",
          },
          svg("path", { d: "M0 0L6 3L0 6z", style: "fill:var(--line2);stroke:none" }),
        ),
      ),
      ...ARROWS.map((d) => svg("path", { d, "marker-end": "url(#tip)" })),
    );
    const machine = el("div", { class: "machine" }, drawing);
    for (const [state, [x, y, width, height]] of Object.entries(BOXES)) {
      const isPass = height === 22; // A state in which a subsystem does not stay: its box is lower.
      const box = el(
        "button",
        {
          class: isPass ? "box pass" : "box",
          style: `left:${x}px;top:${y}px;width:${width}px;height:${height}px`,
          onclick: () => this.ask(state),
        },
        el("span", { class: "mark" }),
        el("span", {}, state),
      );
      this.boxes.set(state, box);
      machine.append(box);
    }
    this.reason = el("p", { class: "reason", style: "margin:0" });
    this.append(
      el("div", { class: "head" }, this.title_, this.config),
      el("div", { class: "sides" }, this.since, el("span", { class: "hint" }, "press a number to request")),
      machine,
      this.reason,
    );
    store.on(
      "state select hello link",
      once(() => this.draw()),
    );
    document.addEventListener("keydown", (event) => {
      if (!isPageKey(event)) return;
      const state = store.hello?.states[Number(event.key)];
      if (event.key !== " " && state && this.targets()[event.key] === null) this.ask(state);
    });
  }

  targets() {
    return !store.barrier() ? (store.states.get(store.selected)?.targets ?? {}) : {};
  }

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
      this.config.replaceChildren(
        el("option", { value: "" }, "Configuration"),
        ...(about?.configurations ?? []).map((item) => el("option", {}, item.name)),
      );
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
      if (isPresent) box.setAttribute("aria-current", "true");
      else box.removeAttribute("aria-current");
      const mark = box.firstChild;
      if (isPresent) show(mark, stateSymbol(state), "present");
      else {
        delete mark.dataset.symbol;
        renew(mark, bar ? padlock() : isLegal ? String(n) : "");
      }
      if (bar) barred.push([n, bar]);
    }
    const reasons = new Map();
    for (const [n, words] of barred) reasons.set(words, [...(reasons.get(words) ?? []), n]);
    const line = [...reasons].map(([words, numbers]) => `${numbers.join(", ")} barred: ${words}`).join("; ");
    text(
      this.reason,
      line ||
        (known?.state === "ERROR_OPERATIONAL" ? "recovery leads through OFFLINE" : "") ||
        (known?.phase && known.phase !== "IDLE" ? `phase ${known.phase}` : "") ||
        (store.replay || store.hello?.read_only ? store.barrier() : ""),
    );
    this.reason.title = line;
  }
}
customElements.define("station-states", States);

const LINK_SYMBOL = {
  open: "normal",
  requested: "passing",
  accepted: "passing",
  stale: "critical",
  failed: "critical",
};
const isBroken = (state) => state === "stale" || state === "failed";
// With these sizes, two members with their devices and four links are visible at 1280x800, in a replay, too.
const BOX = { width: 120, height: 38, x: [8, 180], top: 2, pitch: 96, wire: 44, device: 50, end: 82 };
// The devices of a member that is alone have the width of the panel, in rows.
const GRID = { x: 12, width: 290, columns: 4, most: 12, pitch: 42 };
const rowsOf = (devices) => Math.ceil(devices.length / GRID.columns);
// Whether the devices of a member are drawn in rows.
const isGrid = (devices) => store.members().length === 1 && devices.length > 1 && devices.length <= GRID.most;

// Attributes of the box of a device, which opens the tab Bus at this device. A box of several devices, null,
// opens the bus of the first one. A box cannot be pressed in a replay, which has no tab Bus, or if its device
// is not on a bus.
function pressable(device, ends) {
  const bus = store.replay ? undefined : busOf(store, ends);
  return bus
    ? {
        class: "press",
        role: "button",
        tabindex: 0,
        "aria-label": `${device ?? "Devices"}: open tab Bus`,
        "data-device": device ?? "",
        "data-bus": bus,
      }
    : {};
}

// Real-time network: a box for each member with its bus and devices, an arrow for each link that is not
// closed, and a line of values for each link.
class Network extends HTMLElement {
  connectedCallback() {
    if (this.sym) return; // The browser calls this again when the element moves within the page.
    this.sym = el("span");
    this.words = el("span", { class: "words" });
    this.graph = svg("svg", { class: "graph", role: "group", "aria-label": "Real-time network" });
    this.graph.addEventListener("click", ({ target }) => this.open(target));
    this.graph.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault(); // The space bar would scroll the panel.
      event.stopPropagation(); // It also pauses the world.
      this.open(event.target);
    });
    this.rows = el("div", { class: "links", role: "list", "aria-label": "Real-time links" });
    this.body = el(
      "div",
      { class: "scroll", tabindex: 0, role: "group", "aria-label": "Members and links" },
      this.graph,
      this.rows,
    );
    this.append(el("div", { class: "head" }, el("h2", {}, "Network"), this.sym, this.words), this.body);
    store.on(
      "hello state links link theme event",
      once(() => this.draw()),
    );
    every(500, () => this.drawRows());
  }

  // A device opens the tab Bus.
  open(node) {
    const { device, bus } = node.closest("[data-bus]")?.dataset ?? {};
    if (bus) store.tell("device", { bus, device: device || null });
  }

  known() {
    return new Map(store.links.map((row) => [row.name, row]));
  }

  draw() {
    if (!store.hello) return;
    const rows = this.known(),
      links = store.hello.links;
    const open = links.filter((link) => rows.get(link.name)?.state === "open");
    const broken = links.filter((link) => isBroken(rows.get(link.name)?.state));
    const used = links.filter((link) => (rows.get(link.name)?.state ?? "closed") !== "closed");
    const lost = links.reduce((sum, link) => sum + (rows.get(link.name)?.lost ?? 0), 0);
    // A link of a member that has failed may still be reported as open.
    const failed = store
      .members()
      .filter(({ name }) => store.states.get(name)?.state === "ERROR_OPERATIONAL").length;
    const isFailed = broken.length + failed > 0;
    show(
      this.sym,
      isFailed ? "critical" : open.length ? "normal" : "off",
      isFailed ? "failed" : open.length ? "open" : "closed",
    );
    text(
      this.words,
      !links.length
        ? failed
          ? `${failed} in error, no links`
          : "no links in this mission"
        : isFailed
          ? broken.length
            ? `${broken.length} failed, ${open.length} open`
            : `${failed} in error, ${open.length} open`
          : open.length
            ? `${open.length} open, ${lost} lost`
            : "closed",
    );
    const held = this.graph.contains(document.activeElement) ? document.activeElement : null;
    renew(this.graph, ...this.parts(used.length ? used : links, rows));
    if (held && !held.isConnected)
      this.graph.querySelector(`[aria-label="${held.getAttribute("aria-label")}"]`)?.focus();
    const states = links.map((link) => `${link.name} ${rows.get(link.name)?.state ?? "closed"}`);
    this.graph.setAttribute("aria-label", `Real-time network: ${states.join(", ")}`);
    if (this.listed !== links) this.rows.replaceChildren(...links.map((link) => this.row(link)));
    this.listed = links;
    this.drawRows();
  }

  row(link) {
    return el(
      "div",
      { class: "link-row", role: "listitem", "data-link": link.name },
      el("span", { class: "sym" }),
      el("span", { class: "name" }, link.name),
      el("span", { class: "second" }, `${link.producer} to ${link.consumer}`),
      el("span", { class: "figures-of" }),
    );
  }

  // Age of the last sample of a link [s], and whether it may be less: it is reported by the consumer if this
  // is its only link, otherwise it is the time since the number of its samples last grew.
  age(link, row) {
    const rows = this.known();
    const incoming = store.hello.links.filter(
      (one) => one.consumer === link.consumer && rows.get(one.name)?.state === "open",
    );
    const said = incoming.length === 1 ? store.value(link.consumer, "LINK_AGE")?.[0] : undefined;
    const isDisplayed = store.freshness(link.consumer, store.display(link.consumer)?.id) === "live";
    if (said !== undefined && isDisplayed) return [said / 1e6, false];
    return row.heard === undefined || row.heard === null
      ? [null]
      : [Math.max(0, store.now() - row.heard), true];
  }

  drawRows() {
    if (!store.hello) return;
    const rows = this.known();
    for (const link of store.hello.links) {
      const node = this.rows.querySelector(`[data-link="${CSS.escape(link.name)}"]`);
      if (!node) continue;
      const row = rows.get(link.name) ?? { state: "closed" };
      const [since, isMost] = row.state === "open" ? this.age(link, row) : [null];
      const isLate = since !== null && row.rate === 0 && !store.pace.is_paused;
      show(
        node.firstChild,
        isLate ? "caution" : (LINK_SYMBOL[row.state] ?? "off"),
        isLate ? "late" : row.state,
      );
      const figures =
        row.state === "closed"
          ? "closed"
          : [
              row.state === "open" ? null : row.state,
              row.cause && isBroken(row.state) ? row.cause : null,
              row.rate === undefined || row.rate === null ? null : `${Math.round(row.rate)} /s`,
              since === null
                ? null
                : since < 0.1
                  ? `${(since * 1000).toFixed(1)} ms old`
                  : `${isMost ? "≤ " : ""}${age(since)} old`,
              `${row.lost ?? 0} lost`,
            ]
              .filter(Boolean)
              .join(", ");
      text(node.lastChild, figures);
      const samples = row.received === undefined ? "" : `, ${counted(row.received, "sample")} received`;
      put(node, "title", `${link.producer} to ${link.consumer}${samples}`);
      node.classList.toggle("critical", isBroken(row.state));
    }
  }

  parts(links, rows) {
    const members = store
      .members()
      .map((item) => item.name)
      .sort((a, b) => store.drives(store.subsystem(b)) - store.drives(store.subsystem(a)));
    const positions = new Map(
      members.map((name, n) => [
        name,
        [members.length === 1 ? 94 : BOX.x[n % 2], BOX.top + Math.floor(n / 2) * BOX.pitch],
      ]),
    );
    const devices = this.part(members[0])?.devices ?? [];
    const below = isGrid(devices)
      ? (rowsOf(devices) - 1) * GRID.pitch
      : (Math.ceil(members.length / 2) - 1) * BOX.pitch;
    const height = BOX.top + Math.max(0, below) + BOX.end + 2;
    this.graph.setAttribute("viewBox", `0 0 308 ${height}`);
    this.graph.style.height = `${height}px`;
    return [
      ...links.flatMap((link, n) => this.arrow(link, rows.get(link.name), positions, n)),
      ...members.flatMap((name) => this.member(name, ...positions.get(name))),
    ];
  }

  // The present configuration of a member, or its first one.
  part(name) {
    return name && (store.configuration(name) ?? store.subsystem(name).configurations[0]);
  }

  // Draw a member with its devices below. A member in an error state is red; the line to each device that was
  // lost is red and dashed.
  member(name, x, y) {
    const about = store.subsystem(name);
    const part = this.part(name);
    const devices = part?.devices ?? [];
    const isFailed = store.states.get(name)?.state === "ERROR_OPERATIONAL";
    const lost = lostOf(store, name, devices);
    const wire = (isLost) => (isLost ? "wire broken" : "wire");
    const found = [
      svg("rect", { x, y, width: BOX.width, height: BOX.height, rx: 3, class: isFailed ? "broken" : "" }),
      svg("text", { x: x + 8, y: y + 16, class: "strong" }, name),
      svg("text", { x: x + 8, y: y + 31 }, `APID ${about.apid}${isFailed ? ", error" : ""}`),
    ];
    if (!devices.length) return found;
    const isMany = devices.length > 3 && !isGrid(devices);
    const [one] = lost;
    const all = !lost.size
      ? `${devices.length} devices`
      : lost.size > 1
        ? `${lost.size} of ${devices.length} lost`
        : `${one} of ${devices.length} lost`;
    const shown = isMany ? [all] : devices;
    // The bus of each device, or the type of its end node.
    const ends = part.endnodes ?? {};
    const kinds = [...new Set(Object.values(ends))];
    const bus = kinds.length > 2 ? `${kinds.length} types of end node` : kinds.join(", ");
    const columns = isGrid(devices) ? Math.ceil(devices.length / rowsOf(devices)) : shown.length;
    const [left, width] = isGrid(devices) ? [GRID.x, GRID.width] : [x, BOX.width];
    const each = width / columns;
    const boxes = [];
    found.push(
      svg("path", { class: wire(lost.size), d: `M${x + 60} ${y + BOX.height}V${y + BOX.wire}` }),
      svg("title", {}, `${name}: ${devices.map((device) => `${device} (${ends[device]})`).join(", ")}`),
    );
    shown.forEach((device, n) => {
      const row = Math.floor(n / columns);
      const cx = left + each * ((n % columns) + 0.5);
      const down = y + row * GRID.pitch;
      const isLost = isMany ? lost.size > 0 : lost.has(device);
      const node = part.nodes?.[device];
      const end =
        node && kinds.length > 1 && isGrid(devices) ? `${node} ${ends[device]}` : (node ?? ends[device]);
      const below = isLost ? "lost" : isMany ? bus : (end ?? "");
      // A wire to a lower row passes the upper ones at the left.
      const passed = row ? `H${GRID.x / 2}V${down + BOX.wire}` : "";
      found.push(
        svg("path", {
          class: wire(isLost),
          d: `M${x + 60} ${y + BOX.wire}${passed}H${cx}V${down + BOX.device}`,
        }),
      );
      boxes.push(
        svg(
          "g",
          pressable(
            isMany ? (lost.size === 1 ? one : null) : device,
            ends[isMany ? (one ?? devices[0]) : device],
          ),
          svg("rect", {
            x: cx - each / 2 + 1,
            y: down + BOX.device,
            width: each - 2,
            height: BOX.end - BOX.device,
            rx: 3,
            class: isLost ? "broken" : "",
          }),
          svg(
            "text",
            { x: cx, y: down + (below ? 63 : 70), "text-anchor": "middle", class: "device" },
            device,
          ),
          svg("text", { x: cx, y: down + 77, "text-anchor": "middle", class: isLost ? "lost" : "" }, below),
        ),
      );
    });
    found.push(...boxes);
    return found;
  }

  arrow(link, row, positions, n) {
    const from = positions.get(link.producer),
      to = positions.get(link.consumer);
    if (!from || !to) return [];
    const isOpen = row?.state === "open";
    const kind = isBroken(row?.state) ? "wire broken" : isOpen ? "wire open" : "wire closed";
    const isSameRow = from[1] === to[1],
      isRight = to[0] > from[0];
    const shift = 8 + (n % 4) * 8;
    const [x1, y1] = isSameRow
      ? [isRight ? from[0] + BOX.width : from[0], from[1] + shift]
      : [from[0] + BOX.width / 2 + shift, from[1] + (to[1] > from[1] ? BOX.height : 0)];
    const [x2, y2] = isSameRow
      ? [isRight ? to[0] : to[0] + BOX.width, to[1] + shift]
      : [to[0] + BOX.width / 2 + shift, to[1] + (to[1] > from[1] ? 0 : BOX.height)];
    const size = Math.hypot(x2 - x1, y2 - y1) || 1,
      ux = (x2 - x1) / size,
      uy = (y2 - y1) / size;
    return [
      svg("path", { class: kind, d: `M${x1} ${y1}L${x2 - 6 * ux} ${y2 - 6 * uy}` }),
      svg("path", {
        class: isBroken(row?.state) ? "head-of broken" : "head-of",
        d: `M${x2} ${y2}l${-8 * ux - 4 * uy} ${-8 * uy + 4 * ux}l${8 * uy} ${-8 * ux}z`,
      }),
      svg("title", {}, `${link.name}: ${row?.state ?? "closed"}`),
    ];
  }
}
customElements.define("station-network", Network);
