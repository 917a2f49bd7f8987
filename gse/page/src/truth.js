// SPDX-License-Identifier: Apache-2.0
// The simulator's truth: its last row in a flight, with poses of the bases between two rows; and the parts of
// a world that only the truth contains.

import { posesBetween } from "./kinematics.js";
import { store } from "./store.js";

const PERIOD_MS = 50, // Period of the rows until the second one has come.
  LONGEST_MS = 300; // Longest period; after a longer pause the bases move to the new row within this time.

export class LiveTruth {
  constructor() {
    this.last = this.before = null;
  }

  take({ time, values, names }) {
    if (this.last && time === this.last.time) return;
    const now = performance.now();
    this.before = this.last;
    this.last = { time, row: values, names, at: now };
    this.period = this.before ? Math.min(LONGEST_MS, now - this.before.at) || PERIOD_MS : PERIOD_MS;
    this.isNew = true; // Until now() has given this row itself: the picture still changes.
  }

  // The present row { row, names, time }; null if there is none. It lags by one period, so that bases move
  // evenly.
  now() {
    if (!this.last) return null;
    const share = Math.min(1, (performance.now() - this.last.at) / this.period);
    this.isNew = share < 1;
    const { row, names, time } = this.last;
    const from = this.before?.row.BASE;
    if (!row.BASE || from?.length !== row.BASE.length) return { row, names, time };
    return { row: { ...row, BASE: posesBetween(from, row.BASE, share) }, names, time };
  }
}

// Pose x, y, z, w, x, y, z of the base of the robot that telemetry of any subsystem reports as BASE_POSITION
// and BASE_ATTITUDE; null if there is no such report.
export function reportedBase() {
  for (const leaves of store.values.values()) {
    const of = (name) => {
      for (const [leaf, { value }] of leaves) if (leaf.split(".").pop() === name) return value;
      return null;
    };
    const position = of("BASE_POSITION"),
      attitude = of("BASE_ATTITUDE");
    if (position?.length === 3 && attitude?.length === 4) return [...position, ...attitude];
  }
  return null;
}

// Parts of a world that telemetry does not contain, in words. `lead`: the robot that the page follows.
export function notReported(world, lead) {
  const others = world.robots.filter((robot) => robot !== lead);
  const found = [];
  if (lead.free && !reportedBase()) found.push("base");
  if (others.some((robot) => robot.free || robot.joints.some((joint) => joint.kind !== "fixed")))
    found.push("other bodies");
  if (world.wheels?.length) found.push("wheels");
  if (world.valves?.length) found.push("thrusters");
  return found;
}
