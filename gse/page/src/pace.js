// SPDX-License-Identifier: Apache-2.0
// Pace of pictures that the processors compute: when the next one may begin, and which share of the pixels of
// each axis it has. The rule:
// - The next picture begins LEAST_MS after the last one at the earliest, and not before the processors have
//   rested for as long as the last one took, but for SLOWEST_MS at most.
// - While the user holds the hand, BUDGET_MS is HELD_MS: the lines of the hand need the processors, too.
// - If OVER pictures in succession take longer than BUDGET_MS, the next ones have half as many pixels.
// - If UNDER pictures in succession take less than half of BUDGET_MS, the next ones have twice as many
//   pixels.

export const LEAST_MS = 40;
const [BUDGET_MS, HELD_MS, SLOWEST_MS, OVER, UNDER] = [25, 10, 1000, 3, 20];
const SCALES = [1, 0.7, 0.5];

export class Pace {
  constructor() {
    this.level = this.over = this.under = 0;
    this.next = 0; // Earliest beginning of the next picture.
  }

  get scale() {
    return SCALES[this.level];
  }

  // A picture has been computed between these times [ms].
  note(began, ended, isHeld) {
    const took = ended - began,
      budget = isHeld ? HELD_MS : BUDGET_MS;
    this.next = Math.max(began + LEAST_MS, ended + Math.min(took, SLOWEST_MS));
    this.over = took > budget ? this.over + 1 : 0;
    this.under = took < budget / 2 ? this.under + 1 : 0;
    if (this.over === OVER && this.level < SCALES.length - 1) this.change(1);
    else if (this.under === UNDER && this.level > 0) this.change(-1);
    this.over %= OVER;
    this.under %= UNDER;
  }

  change(step) {
    this.level += step;
    this.over = this.under = 0;
  }

  // Time until the next picture may begin [ms].
  wait(now) {
    return Math.max(0, this.next - now);
  }
}
