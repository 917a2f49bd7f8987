// SPDX-License-Identifier: Apache-2.0
// The lower corners of the scene: the numbers of the tip at the left, and the legend at the right. A body
// without joints has no tip and no force at it.

import { moving } from "./kinematics.js";
import { TRACE_S } from "./scene_marks.js";
import { el, text } from "./dom.js";

const key = (colour, words) =>
  el(
    "span",
    { class: "hint", style: "margin-right:10px" },
    el("i", { class: "key", style: `background:var(--${colour})` }),
    words,
  );

export class Corners {
  constructor() {
    this.values = Object.fromEntries(
      ["x", "y", "z", "force"].map((name) => [
        name,
        el("span", { class: name === "force" ? "value force" : "value" }),
      ]),
    );
    this.lines = Object.fromEntries(
      Object.entries(this.values).map(([name, value]) => [
        name,
        [
          el("span", { class: "name", style: "font-weight:500" }, name === "force" ? "Force" : `Tip ${name}`),
          value,
          el("span", { class: "hint" }, name === "force" ? "N" : "mm"),
        ],
      ]),
    );
    this.numbers = el("div", { class: "hud bl" }, ...Object.values(this.lines).flat());
    this.forceKey = key("force", "force, 2.4 mm/N");
    this.rings = el(
      "span",
      { class: "hint rings", style: "margin-right:10px", hidden: true },
      "white ring: brake holds",
    );
    this.grid = el("span", { class: "hint grid-key" }, "grid 50 mm");
    this.legend = el(
      "div",
      { class: "hud br" },
      this.forceKey,
      key("measured", `trace ${TRACE_S} s`),
      this.rings,
      this.grid,
    );
  }

  // Show the lines that a robot has. An arm of at most two joints moves in a plane.
  fit(robot) {
    const joints = moving(robot).length;
    this.isArm = joints > 0;
    this.isPlanar = this.isArm && joints < 3;
    for (const name of ["x", "y", "z"]) text(this.lines[name][0], `${this.isArm ? "Tip" : "Body"} ${name}`);
    for (const node of this.lines.y) node.hidden = this.isPlanar;
    for (const node of [...this.lines.force, this.forceKey]) node.hidden = !this.isArm;
    this.grid.hidden = Boolean(robot.free);
  }
}
