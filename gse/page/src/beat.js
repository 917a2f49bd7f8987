// SPDX-License-Identifier: Apache-2.0
// Common period of all panels that draw again and again. All that is due is drawn in one task, so that the
// browser computes layout and painting once for it. Panels with timers of their own would cost a frame each.

const BEAT_MS = 50; // All periods are multiples of it.

const drawings = [];
let last = 0; // Time of the last beat.

// Call draw about every `period` ms.
export function every(period, draw) {
  drawings.push({ period, draw, next: 0 });
}

// Draw what is due. A picture without a graphics processor calls this when it becomes visible: both are in
// one frame then.
export function beat() {
  last = performance.now();
  for (const one of drawings) {
    if (last < one.next - BEAT_MS / 2) continue;
    one.next = Math.max(one.next + one.period, last);
    one.draw();
  }
}

setInterval(() => {
  if (performance.now() - last > 0.8 * BEAT_MS) beat();
}, BEAT_MS / 2);
