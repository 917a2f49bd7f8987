// SPDX-License-Identifier: Apache-2.0
// Parts of a time line: ticks, a lane of states for each of the first two subsystems, marks of events.

import { store } from "./store.js";
import { SYMBOL_OF_SEVERITY, svg, symbol } from "./dom.js";

// States in the order in which a lane draws them, from the lowest to the highest.
const ACTIVATION = [
  "OFFLINE",
  "SOFTWARE_INIT",
  "HARDWARE_INIT",
  "PRE_OPERATIONAL",
  "SAFE_OPERATIONAL",
  "OPERATIONAL",
];
const RANK = { LOW: 1, MEDIUM: 2, HIGH: 3 };
const DIGIT = 6.7; // Width of a digit of a tick [pixels].
const NEAR = 6; // Distance [pixels] below which only the more severe of two marks is drawn.

export const shownMembers = () =>
  store
    .ordered()
    .filter((item) => !item.infrastructure && store.lanes.has(item.name))
    .map((item) => item.name)
    .slice(0, 2);

export function ticks(x, end, y, width) {
  const most = Math.max(4, width / 80);
  const unit =
    [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 3600].find((step) => end / step <= most) ?? 36000;
  const found = [];
  for (let t = 0; t < end; t += unit) {
    const words = String(t);
    // The last number is on the left of its tick if the line ends before it.
    const fits = x(t) + 3 + words.length * DIGIT <= width;
    const place = fits ? { x: x(t) + 3 } : { x: x(t) - 3, "text-anchor": "end" };
    found.push(
      svg("path", { d: `M${x(t)} ${y}v5`, style: "stroke:var(--fg2)" }),
      svg("text", { ...place, y: y + 9 }, words),
    );
  }
  return found;
}

// A lane has one path for each style of its states, because an hour of flight has thousands of states. The
// style uses `fill-opacity`: an `opacity` would make the browser draw each path into a layer of its own.
export function lanes(x, members, end, top) {
  return members.flatMap((name, row) => {
    const lane = store.lanes.get(name),
      paths = new Map();
    lane.forEach(([from, state], n) => {
      const width = x(lane[n + 1]?.[0] ?? end) - x(from);
      if (width <= 0) return;
      const part = `M${x(from).toFixed(2)} ${top + row * 14}h${width.toFixed(2)}v10h${(-width).toFixed(2)}z`;
      paths.set(lookOf(state), (paths.get(lookOf(state)) ?? "") + part);
    });
    return [...paths].map(([style, d]) => svg("path", { class: "lane", d, style }));
  });
}

function lookOf(state) {
  if (state === "ERROR_OPERATIONAL") return "fill:var(--critical-fill)";
  const grade = ACTIVATION.indexOf(state);
  return `fill:var(--fg0);fill-opacity:${grade < 0 ? 0.15 : (0.1 + 0.14 * grade).toFixed(2)}`;
}

export function marks(x, events, y) {
  const shown = [];
  for (const event of events) {
    if (!RANK[event.severity]) continue;
    const last = shown[shown.length - 1];
    if (last && x(event.time) - x(last.time) < NEAR) {
      if (RANK[event.severity] > RANK[last.severity]) shown[shown.length - 1] = event;
    } else shown.push(event);
  }
  return shown.map((event) => {
    const mark = symbol(SYMBOL_OF_SEVERITY[event.severity], event.severity);
    for (const [key, value] of Object.entries({ x: x(event.time) - 5, y, width: 10, height: 10 }))
      mark.setAttribute(key, value);
    mark.append(svg("title", {}, `${event.time.toFixed(4)} s ${event.subsystem} ${event.event}`));
    return mark;
  });
}
