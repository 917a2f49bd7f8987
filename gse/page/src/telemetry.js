// SPDX-License-Identifier: Apache-2.0
// Tab Telemetry: a table for each housekeeping structure of each subsystem. The user can add its values to
// the strip charts.

import { every } from "./beat.js";
import { store } from "./store.js";
import { unitAt } from "./kinematics.js";
import {
  counted,
  el,
  flagsOf,
  number,
  put,
  refill,
  show,
  svg,
  tableHead,
  text,
  unseen,
  wordOf,
} from "./dom.js";

const REFRESH_MS = 200; // Time between two updates of the tables.
const KEPT_MS = 2000; // Age up to which the table of the fastest report keeps it.
const NEAR = 0.1; // Share of the range that counts as near a limit.
const SYMBOL = { live: "normal", late: "caution", stale: "stale", never: "off" };
const WIDTH = 74; // Width of a gauge in units of its drawing.

// Gauge of a value between its limits: the mark is at the left for `share` 0, the lower limit, and at the
// right for 1.
function gauge() {
  const mark = svg("rect", { y: 1, width: 3, height: 10 });
  const node = svg(
    "svg",
    { class: "gauge", viewBox: `0 0 ${WIDTH} 12`, preserveAspectRatio: "none", "aria-hidden": "true" },
    svg("path", { d: "M1 2v8M73 2v8M1 6h72M37 4v4", style: "stroke:var(--line2);fill:none" }),
    mark,
  );
  return {
    node,
    put: (share, colour) => {
      put(mark, "x", 1 + Math.max(0, Math.min(1, share)) * (WIDTH - 5));
      put(mark, "style", `fill:var(--${colour})`);
    },
  };
}

// Age [s] in the four places of its column: tenths below 10 s, hours from 10 000 s.
const ageOf = (seconds) =>
  seconds < 9.95
    ? seconds.toFixed(1)
    : seconds < 9999.5
      ? seconds.toFixed(0)
      : `${(seconds / 3600).toFixed(0)} h`;

// A value with words has no limits: the least and the greatest of its numbers are words like all others.
const isBounded = (leaf) => !leaf.words && !leaf.bits && leaf.min !== undefined && leaf.max !== undefined;

// Rows for all numbers of a report. The table has a column of gauges only if a value has limits.
function rowsOf(report, leaves) {
  const hasGauges = leaves.some(isBounded);
  return leaves.flatMap((leaf) =>
    [...Array(leaf.count).keys()].map((n) => new Row(report, leaf, n, hasGauges)),
  );
}

function head(rows) {
  const hasGauges = rows.some((row) => isBounded(row.leaf));
  const wide = hasGauges ? "" : " wide"; // Values and units have the room of the gauges.
  return tableHead(
    ["Parameter"],
    ["Value", `of-value num${wide}`],
    ["Unit", `of-unit${wide}`],
    ...(hasGauges ? [["Limits", "of-gauge"]] : []),
    ["Age s", "of-age num"],
    [unseen("Chart"), "of-chart"],
  );
}

// Number `n` of a leaf of a report, as a line of the strip charts.
export function lineOf(report, leaf, n) {
  const name = `${leaf.name.split(".").pop()}${leaf.count > 1 ? `.${n + 1}` : ""}`;
  const [subsystem] = report.split("/");
  return {
    key: `${report}/${leaf.name}/${n}`,
    report,
    leaf: leaf.name,
    n,
    name,
    unit: unitAt(leaf, n, store.jointsOf(subsystem)),
    words: leaf.words,
    bits: leaf.bits,
    title: `${subsystem} ${name}`,
  };
}

// Table row of one number of a report; `judge` and the other methods update its cells.
export class Row {
  constructor(report, leaf, n, hasGauges) {
    this.report = report;
    this.n = n;
    this.line = lineOf(report, leaf, n);
    this.leaf = { ...leaf, unit: this.line.unit };
    this.key = this.line.key;
    this.sym = el("span");
    this.value = el("span", { class: "value" });
    this.gauge = isBounded(leaf) ? gauge() : null;
    this.age = el("td", { class: "mono num age" });
    this.chart = el(
      "button",
      {
        class: "chart",
        "aria-pressed": "false",
        "aria-label": `Chart of ${this.line.title}`,
        title: "Add to the strip charts, or remove from them",
        onclick: () => store.tell("chart", this.line),
      },
      "∿",
    );
    this.node = el(
      "tr",
      { draggable: "true" },
      el(
        "td",
        { class: "name", title: [leaf.name, leaf.description].filter(Boolean).join(": ") },
        this.line.name,
      ),
      ...this.cells(hasGauges),
      this.age,
      el("td", {}, this.chart),
    );
    this.node.addEventListener("dragstart", (event) =>
      event.dataTransfer.setData("text/plain", JSON.stringify(this.line)),
    );
  }

  // Cells of value, unit and limits. A value with words takes the place of all three; the unit of a value
  // without limits, such as "connections", takes the place of these.
  cells(hasGauges) {
    const { words, bits, unit } = this.leaf;
    const own = [this.sym, " ", this.value];
    if ((words || bits) && !unit)
      return [(this.cell = el("td", { class: "num worded", colspan: hasGauges ? 3 : 2 }, ...own))];
    this.cell = el("td", { class: "num" }, ...own);
    if (!this.gauge)
      return [this.cell, el("td", { class: "unit", title: unit, colspan: hasGauges ? 2 : 1 }, unit)];
    return [this.cell, el("td", { class: "unit", title: unit }, unit), el("td", {}, this.gauge.node)];
  }

  // Grade of a value: beyond a limit, or near a limit unless the value is a setting; null otherwise.
  judge(value, freshness) {
    const { min, max, settable } = this.leaf;
    if (!this.gauge || freshness === "stale" || typeof value !== "number") return null;
    const share = (value - min) / (max - min);
    if (share < 0 || share > 1) return ["serious", "beyond its limit"];
    return !settable && (share < NEAR || share > 1 - NEAR) ? ["caution", "near its limit"] : null;
  }

  // The title of a number whose bits have names: the number, and the flags that are set.
  tellBits(value) {
    const flags = flagsOf(this.leaf, value).join(", ") || "no flag is set";
    const words = `0x${value.toString(16).toUpperCase().padStart(4, "0")}: ${flags}`;
    if (this.cell.title !== words) this.cell.title = words;
  }

  draw(freshness) {
    const report = store.reports.get(this.report);
    const value = report?.values[this.leaf.name]?.[this.n];
    const verdict = this.judge(value, freshness);
    if (verdict) show(this.sym, ...verdict);
    else if (this.sym.firstChild) {
      this.sym.replaceChildren();
      delete this.sym.dataset.symbol;
    }
    const word = wordOf(this.leaf, value);
    text(this.value, word ?? number(value, this.leaf.unit, this.leaf.type));
    if (this.leaf.bits && typeof value === "number") this.tellBits(value);
    this.value.classList.toggle("word", word !== undefined && word !== null);
    this.value.style.color = verdict ? `var(--${verdict[0]})` : "";
    this.node.classList.toggle("stale", freshness === "stale");
    text(this.age, report ? ageOf((store.clock() - report.at) / 1000) : "–");
    if (this.gauge && typeof value === "number")
      this.gauge.put(
        (value - this.leaf.min) / (this.leaf.max - this.leaf.min),
        freshness === "stale" ? "fg2" : (verdict?.[0] ?? "fg0"),
      );
    put(this.chart, "aria-pressed", store.charted.has(this.key));
  }
}

// Section of a structure: a heading, a button, and the table of its rows.
class Section {
  constructor(name, id, rows) {
    this.name = name;
    this.id = id;
    this.rows = rows;
    this.sym = el("span");
    this.words = el("span", { class: "hint" });
    this.toggle = el("button", { onclick: () => this.switch() });
    this.reason = el("p", { class: "reason", hidden: true });
    this.node = el(
      "section",
      { "aria-label": `${name} ${id}` },
      el("div", { class: "head" }, this.sym, el("h2", {}, `${name} ${id}`), this.words, this.toggle),
      this.reason,
      el("table", { class: "values readings" }, head(rows), el("tbody", {}, ...rows.map((row) => row.node))),
    );
  }

  key() {
    return `${this.name}/${this.id}`;
  }

  isOn() {
    const known = store.enabled.get(this.key());
    return known ? known.enabled : ["live", "late"].includes(store.freshness(this.name, this.id));
  }

  // Words that follow those of the first structure of a configuration without a display structure.
  mark() {
    const structures = store.members().some((one) => one.name === this.name)
      ? store.configuration(this.name)?.structures
      : undefined;
    return structures?.[0]?.id === this.id && !store.display(this.name) ? ", no display structure" : "";
  }

  async switch() {
    const answer = await store.ask({
      do: "command",
      text: `hk ${this.isOn() ? "disable" : "enable"} ${this.name} ${this.id}`,
      display: true,
    });
    this.reason.hidden = !answer.refused;
    text(this.reason, answer.refused ?? "");
  }

  draw() {
    const freshness = store.freshness(this.name, this.id);
    const isOn = this.isOn();
    show(this.sym, !isOn && freshness !== "live" ? "off" : SYMBOL[freshness], freshness);
    const report = store.reports.get(this.key());
    const hertz = 1000 / (store.periodOf(this.name, this.id) * (store.pace.speed || 1));
    const rate =
      hertz >= 1 ? `${Number(hertz.toPrecision(2))} Hz` : `every ${Number((1 / hertz).toPrecision(2))} s`;
    text(
      this.words,
      report
        ? `${rate}, ${counted(report.count, "report")}${this.mark()}`
        : store.states.get(this.name)?.configuration === "-"
          ? "needs a configuration"
          : "no report received yet",
    );
    text(this.toggle, isOn ? "Disable" : "Enable");
    this.toggle.setAttribute("aria-label", `${isOn ? "Disable" : "Enable"} ${this.name} ${this.id}`);
    this.toggle.disabled = !store.link.is_live || (store.hello?.read_only && isOn);
    for (const row of this.rows) row.draw(freshness);
  }
}

export class Telemetry {
  constructor() {
    this.find = el("input", {
      type: "search",
      autocomplete: "off",
      "aria-label": "Filter of parameters",
      oninput: () => this.build(),
    });
    this.list = el("div");
    this.node = el(
      "div",
      { style: "display:contents" },
      el("label", { class: "filter" }, el("span", {}, "Filter"), this.find),
      el(
        "div",
        { class: "scroll", tabindex: 0, role: "group", "aria-label": "Housekeeping structures" },
        this.list,
      ),
    );
    this.sections = [];
    store.on("hello", () => {
      this.shown = null;
    });
    every(REFRESH_MS, () => this.draw());
  }

  // Structures of the present configurations, and all others that have been received, as [subsystem, id].
  structures() {
    const found = [];
    for (const { name, configurations } of store.hello?.subsystems ?? []) {
      const part = store.configuration(name) ?? configurations[0];
      const heard = [...store.reports.values()]
        .filter((report) => report.subsystem === name)
        .map((report) => report.id);
      for (const id of [...new Set([...part.structures.map((one) => one.id), ...heard])].sort(
        (a, b) => a - b,
      ))
        found.push([name, id]);
    }
    return found;
  }

  rows(name, id) {
    const parameters = store.subsystem(name).parameters;
    const leaves =
      store.structure(name, id)?.leaves ?? Object.keys(store.reports.get(`${name}/${id}`)?.values ?? {});
    return rowsOf(
      `${name}/${id}`,
      leaves.map(
        (leaf) => parameters.find((one) => one.name === leaf) ?? { name: leaf, count: 1, unit: "", type: "" },
      ),
    );
  }

  build() {
    const wanted = this.find.value.trim().toLowerCase().split(/\s+/);
    const fits = (row) => wanted.every((word) => row.key.toLowerCase().includes(word));
    this.sections = this.structures()
      .map(([name, id]) => new Section(name, id, this.rows(name, id).filter(fits)))
      .filter((section) => section.rows.length);
    this.list.replaceChildren(
      ...this.sections.map((section) => section.node),
      ...(this.sections.length
        ? []
        : [el("p", { class: "reason" }, "No parameter has a name with these words.")]),
    );
    this.draw();
  }

  draw() {
    const isShown = this.node.parentElement && !this.node.parentElement.hidden && store.hello;
    if (!isShown) {
      this.shown = null;
      return;
    }
    const shown = this.structures()
      .map(
        ([name, id]) =>
          `${name}/${id}/${store.reports.has(`${name}/${id}`)}/${store.states.get(name)?.configuration}`,
      )
      .join();
    if (shown !== this.shown) {
      this.shown = shown;
      if (!store.replay)
        for (const { name } of store.hello.subsystems) store.ask({ do: "structures", subsystem: name });
      this.build();
      return;
    }
    for (const section of this.sections) section.draw();
  }
}

// Tab Operate: the fastest report of the selected subsystem.
export class Fastest {
  constructor() {
    this.title_ = el("h2");
    this.words = el("span", { class: "hint" });
    this.table = el("table", { class: "values readings" });
    this.node = el(
      "div",
      { style: "display:contents" },
      el("div", { class: "head" }, this.title_, this.words),
      el("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Housekeeping" }, this.table),
    );
    this.rows = [];
  }

  // The fastest report that is not stale, or not older than KEPT_MS; without such a report, the one that was
  // received last. A fast report that is late for a moment does not change the table.
  report() {
    const own = [...store.reports.values()].filter((report) => report.subsystem === store.selected);
    const rank = (report) => {
      const isStale = store.freshness(report.subsystem, report.id) === "stale";
      const age = store.clock() - report.at;
      return isStale && age > KEPT_MS ? 1e9 + age : store.periodOf(report.subsystem, report.id);
    };
    return own.sort((a, b) => rank(a) - rank(b))[0];
  }

  draw() {
    const report = this.report();
    const key = report
      ? `${report.subsystem}/${report.id}/${store.configuration(report.subsystem)?.name}`
      : `${store.selected}`;
    if (this.key !== key) {
      this.key = key;
      const parameters = store.subsystem(store.selected)?.parameters ?? [];
      const leaves = Object.entries(report?.values ?? {}).map(
        ([leaf, values]) =>
          parameters.find((one) => one.name === leaf) ?? {
            name: leaf,
            count: values.length,
            unit: "",
            type: "",
          },
      );
      this.rows = report ? rowsOf(`${report.subsystem}/${report.id}`, leaves) : [];
      refill(this.table, head(this.rows), el("tbody", {}, ...this.rows.map((row) => row.node)));
    }
    text(this.title_, report ? `${report.subsystem} ${report.id}` : (store.selected ?? "Housekeeping"));
    text(this.words, report ? "housekeeping" : "no housekeeping in this configuration yet");
    for (const row of this.rows) row.draw(store.freshness(report.subsystem, report.id));
  }
}
