// SPDX-License-Identifier: Apache-2.0
// Functions that make elements, symbols and texts of numbers.

const SVG = "http://www.w3.org/2000/svg";

// Make an HTML element; attributes beginning with "on" are listeners.
export function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  set(node, attributes);
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

// Make an SVG element with the same rules for its attributes.
export function svg(tag, attributes = {}, ...children) {
  const node = document.createElementNS(SVG, tag);
  set(node, attributes);
  node.append(...children);
  return node;
}

function set(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value);
  }
}

// Make the head of a table. A column is [words, class]; words may be an element.
export const tableHead = (...columns) =>
  el("thead", {}, el("tr", {}, ...columns.map(([words, column]) => el("th", { class: column }, words))));

// Words of a column that only screen readers read: its cells have buttons.
export const unseen = (words) => el("span", { class: "unseen" }, words);

// Set the text of an element only if it differs: after each change the browser computes the layout again. A
// new text node would also make it check the rules with :has().
export function text(node, words) {
  if (node.textContent === words) return;
  const only = node.childNodes.length === 1 && node.firstChild;
  if (only?.nodeType === Node.TEXT_NODE) only.data = words;
  else node.textContent = words;
}

const nameOf = (node) => node.getAttribute("aria-label") ?? node.textContent;

// Replace the content of an element. If a control in it has the focus, the control of the same name that
// takes its place gets it: without it, the Tab key would begin at the top of the page again.
export function refill(node, ...children) {
  const held = document.activeElement;
  const isWithin = held !== node && node.contains(held);
  node.replaceChildren(...children);
  if (!isWithin) return;
  const same = [...node.querySelectorAll("button")].find((one) => nameOf(one) === nameOf(held));
  (node.contains(held) ? held : same)?.focus({ preventScroll: true });
}

// Replace the content of an element only if it differs.
export function renew(node, ...children) {
  const nodes = children.map((child) => (child instanceof Node ? child : document.createTextNode(child)));
  const isSame =
    nodes.length === node.childNodes.length && nodes.every((one, n) => one.isEqualNode(node.childNodes[n]));
  if (!isSame) node.replaceChildren(...nodes);
}

// Set an attribute of an element only if it differs: after each change the browser paints the page again.
export function put(node, name, value) {
  if (node.getAttribute(name) !== String(value)) node.setAttribute(name, value);
}

const fill = (name) => ({ style: `fill:var(--${name}-fill);stroke:var(--${name}-edge);stroke-width:1` });
const ring = (name) => ({ style: `fill:none;stroke:var(--${name});stroke-width:2.6` });

const SHAPES = {
  critical: () => [svg("path", { d: "M0.5 1.5h13L7 13z", ...fill("critical") })],
  serious: () => [svg("path", { d: "M7 0.5 13.5 7 7 13.5 0.5 7z", ...fill("serious") })],
  caution: () => [svg("rect", { x: 1.5, y: 1.5, width: 11, height: 11, ...fill("caution") })],
  normal: () => [svg("circle", { cx: 7, cy: 7, r: 5.5, ...fill("normal") })],
  standby: () => [svg("circle", { cx: 7, cy: 7, r: 4.6, ...ring("standby") })],
  passing: () => [svg("circle", { cx: 7, cy: 7, r: 4.6, "stroke-dasharray": "4.2 3", ...ring("standby") })],
  off: () => [
    svg("circle", { cx: 7, cy: 7, r: 4.8, style: "fill:none;stroke:var(--off);stroke-width:1.6" }),
    svg("path", { d: "M3.8 10.2 10.2 3.8", style: "stroke:var(--off);stroke-width:1.6" }),
  ],
  stale: () => [
    svg("circle", {
      cx: 7,
      cy: 7,
      r: 5,
      "stroke-dasharray": "3 2",
      style: "fill:none;stroke:var(--off);stroke-width:1.6",
    }),
    svg("path", { d: "M7 4v3h2.4", style: "fill:none;stroke:var(--off);stroke-width:1.4" }),
  ],
  done: () => [svg("path", { d: "M2.5 7.5l3 3 6-7", style: "fill:none;stroke:var(--fg0);stroke-width:1.8" })],
  informative: () => [svg("circle", { cx: 7, cy: 7, r: 2.2, style: "fill:var(--fg2)" })],
};

// Make the symbol of a severity or state; `word` is read by screen readers.
export function symbol(name, word) {
  const node = svg("svg", {
    class: name === "passing" ? "sym turns" : "sym",
    viewBox: "0 0 14 14",
    role: "img",
    "aria-label": word ?? name,
  });
  node.append(...SHAPES[name]());
  return node;
}

// Make the symbol of a command that cannot be sent now.
export function padlock() {
  return svg(
    "svg",
    { viewBox: "0 0 10 12", width: 10, height: 12, role: "img", "aria-label": "barred" },
    svg("path", { d: "M3 5V3.5a2 2 0 0 1 4 0V5", style: "fill:none;stroke:currentColor;stroke-width:1.4" }),
    svg("path", { d: "M1 5h8v6.5H1z", style: "fill:currentColor;stroke:none" }),
  );
}

// Show a symbol in an element; it is drawn again only if it has changed.
export function show(holder, name, word) {
  if (holder.dataset.symbol === `${name}/${word}`) return;
  holder.dataset.symbol = `${name}/${word}`;
  holder.replaceChildren(symbol(name, word));
}

export const SYMBOL_OF_STATE = {
  OFFLINE: "off",
  PRE_OPERATIONAL: "standby",
  SAFE_OPERATIONAL: "standby",
  OPERATIONAL: "normal",
  ERROR_OPERATIONAL: "critical",
};
export const SYMBOL_OF_SEVERITY = {
  HIGH: "critical",
  MEDIUM: "serious",
  LOW: "caution",
  INFORMATIVE: "informative",
};
// Symbol of a state. States without a symbol of their own are transitions: they have the symbol `passing`.
export const stateSymbol = (state) => SYMBOL_OF_STATE[state] ?? "passing";

const DIGITS = { rad: 4, "rad/s": 3, Nm: 2, N: 1, mm: 1, s: 3, J: 2, kg: 3 };

// Each unit has a fixed number of digits, and the sign a column of its own, so that the text keeps its
// position when the value changes.
export function number(value, unit, type) {
  if (value === undefined || value === null) return "–";
  if (!(type ?? "DOUBLE").startsWith("DOUBLE") && !(type ?? "").startsWith("FLOAT")) return String(value);
  if (!Number.isFinite(value)) return "not a number";
  const words = Math.abs(value).toFixed(DIGITS[unit] ?? 4);
  return (value < 0 && Number(words) !== 0 ? "−" : " ") + words;
}

// A number of things in words: "1 report", "2 reports".
export const counted = (count, thing) => `${count} ${thing}${count === 1 ? "" : "s"}`;

// Word that the dictionary gives to a number; undefined if it gives none.
export const wordOf = (leaf, value) => (leaf.bits ? stateOf(leaf, value) : leaf.words?.[Number(value)]);

// Name of the state of a number whose bits have names; undefined without a number.
const stateOf = ({ bits }, value) =>
  value === undefined || value === null
    ? undefined
    : (bits.states.find(([mask, one]) => (value & mask) === one)?.[2] ?? "UNKNOWN");

// Names of the flags that are set in such a number.
export const flagsOf = ({ bits }, value) =>
  Object.entries(bits?.flags ?? {})
    .filter(([bit]) => (value >> bit) & 1)
    .map(([, name]) => name);

// Time as mm:ss.mmm.
export function clock(seconds) {
  const whole = Math.max(0, seconds);
  const minutes = Math.floor(whole / 60);
  return `${String(minutes).padStart(2, "0")}:${(whole - 60 * minutes).toFixed(3).padStart(6, "0")}`;
}

// Age of a value; "–" if it was never received.
export const age = (seconds) =>
  seconds === null ? "–" : `${seconds < 10 ? seconds.toFixed(2) : Math.round(seconds)} s`;

const LIGHT = {
  done: () => [
    svg("rect", { x: 0.5, y: 0.5, width: 15, height: 13, rx: 2, style: "fill:none;stroke:var(--fg1)" }),
    svg("path", { d: "M4 7l3 3 5-6", style: "fill:none;stroke:var(--fg0);stroke-width:1.6" }),
  ],
  failed: () => [
    svg("rect", {
      x: 0.5,
      y: 0.5,
      width: 15,
      height: 13,
      rx: 2,
      style: "fill:#d0241b;stroke:var(--critical)",
    }),
    svg("path", { d: "M5 4l6 6M11 4l-6 6", style: "stroke:#fff;stroke-width:1.8" }),
  ],
  waiting: () => [
    svg("rect", {
      x: 0.5,
      y: 0.5,
      width: 15,
      height: 13,
      rx: 2,
      "stroke-dasharray": "3 2",
      style: "fill:none;stroke:var(--standby)",
    }),
    svg("circle", { cx: 8, cy: 7, r: 2, style: "fill:var(--standby)" }),
  ],
  none: () => [
    svg("rect", { x: 0.5, y: 0.5, width: 15, height: 13, rx: 2, style: "fill:none;stroke:var(--line2)" }),
    svg("path", { d: "M5 7h6", style: "stroke:var(--fg2)" }),
  ],
  empty: () => [
    svg("rect", { x: 0.5, y: 0.5, width: 15, height: 13, rx: 2, style: "fill:none;stroke:var(--line2)" }),
  ],
};
const STAGES = ["accepted", "started", "step", "completed"];
const LIGHT_WORDS = {
  done: "done",
  failed: "failed",
  waiting: "waiting",
  none: "not reported",
  empty: "not reached",
};

// Make four lights: acceptance, start, progress and completion of one telecommand.
export function lights(cells) {
  const words = cells.map((cell, n) => `${STAGES[n]} ${LIGHT_WORDS[cell]}`).join(", ");
  const node = el("span", { class: "lights", role: "img", "aria-label": words });
  node.append(
    ...cells.map((cell) => svg("svg", { viewBox: "0 0 16 14", "aria-hidden": "true" }, ...LIGHT[cell]())),
  );
  return node;
}

// Make the tabs of a panel from pairs [name, element]. `opened` is called after a tab was opened. Returns the
// list element and a function that opens a tab.
export function tabs(prefix, pairs, opened = () => {}) {
  const list = el("div", { role: "tablist", "aria-label": prefix });
  const idOf = (name) => `${prefix}-${name.replace(" ", "-")}`;
  const open = (wanted) => {
    for (const [name, panel] of pairs) {
      const tab = list.querySelector(`#${idOf(name)}`);
      tab.setAttribute("aria-selected", String(name === wanted));
      tab.tabIndex = name === wanted ? 0 : -1;
      panel.hidden = name !== wanted;
    }
    opened();
  };
  for (const [name, panel] of pairs) {
    const tab = el(
      "button",
      { role: "tab", id: idOf(name), "aria-controls": `${idOf(name)}-panel`, onclick: () => open(name) },
      name,
    );
    tab.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      const names = pairs
        .map(([item]) => item)
        .filter((item) => !list.querySelector(`#${idOf(item)}`).hidden);
      const next = names[(names.indexOf(name) + step + names.length) % names.length];
      open(next);
      list.querySelector(`#${idOf(next)}`).focus();
    });
    panel.setAttribute("role", "tabpanel");
    panel.id = `${idOf(name)}-panel`;
    panel.setAttribute("aria-labelledby", tab.id);
    list.append(tab);
  }
  open(pairs[0][0]);
  return { list, open };
}

// Whether a pressed key is for the whole page: without Ctrl, Alt and Meta, outside of fields, and unless it
// presses the button that has the focus.
export function isPageKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey) return false;
  if (event.target.closest("input, select, textarea")) return false;
  return !([" ", "Enter"].includes(event.key) && event.target.closest("button, a"));
}

// Returns a function that calls `draw` once after all changes of one task, even if the task calls it several
// times: a jump of a replay changes the states of all subsystems.
export function once(draw) {
  let isPlanned = false;
  return () => {
    if (isPlanned) return;
    isPlanned = true;
    queueMicrotask(() => {
      isPlanned = false;
      draw();
    });
  };
}
