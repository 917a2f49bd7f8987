// SPDX-License-Identifier: Apache-2.0
// Movement of the camera round its target: a drag or the arrow keys turn it, the wheel or + and - change its
// distance. A click is a press without a drag.

const TURN = 0.006; // Angle for each pixel of a drag [rad].
const KEY_TURN = 0.12; // Angle for each press of an arrow key [rad].
const KEY_ZOOM = 1.15; // Factor of the distance for each press of + or -.
const CLICK_MAX = 4; // Movement of the pointer up to which a press is a click, not a drag [pixels].
const LOWEST = -0.3,
  HIGHEST = 1.5; // Elevation of the camera [rad].

// Let the user move `camera` round `target` on `canvas`. changed() is called after each movement,
// clicked(event) after a click.
export function orbit(canvas, camera, target, changed, clicked) {
  const turn = (left, up) => {
    const arm = camera.position.clone().sub(target);
    const length = arm.length();
    const angle = Math.atan2(arm.y, arm.x) + left;
    const rise = Math.max(LOWEST, Math.min(HIGHEST, Math.asin(arm.z / length) + up));
    camera.position
      .set(Math.cos(rise) * Math.cos(angle), Math.cos(rise) * Math.sin(angle), Math.sin(rise))
      .multiplyScalar(length)
      .add(target);
    changed();
  };
  const zoom = (factor) => {
    camera.position.sub(target).multiplyScalar(factor).add(target);
    changed();
  };
  const keys = {
    ArrowLeft: () => turn(-KEY_TURN, 0),
    ArrowRight: () => turn(KEY_TURN, 0),
    ArrowUp: () => turn(0, KEY_TURN),
    ArrowDown: () => turn(0, -KEY_TURN),
    "+": () => zoom(1 / KEY_ZOOM),
    "-": () => zoom(KEY_ZOOM),
  };
  // Place of the pointer that drags the scene. A second finger does nothing.
  let from = null,
    pressed = null,
    dragging = null;
  canvas.addEventListener("pointerdown", (event) => {
    if (from) return;
    from = pressed = [event.clientX, event.clientY];
    dragging = event.pointerId;
    canvas.setPointerCapture(dragging);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (!from || event.pointerId !== dragging || !pressed || event.button) return;
    clicked(event);
  });
  for (const kind of ["pointerup", "pointercancel", "lostpointercapture"])
    canvas.addEventListener(kind, (event) => {
      if (event.pointerId === dragging) from = null;
    });
  canvas.addEventListener("pointermove", (event) => {
    if (!from || event.pointerId !== dragging) return;
    if (pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) <= CLICK_MAX) return;
    pressed = null; // The press has become a drag.
    turn((from[0] - event.clientX) * TURN, (event.clientY - from[1]) * TURN);
    from = [event.clientX, event.clientY];
  });
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      zoom(Math.exp(event.deltaY * 0.001));
    },
    { passive: false },
  );
  // Listeners of the window are called last. While the user moves the hand of the simulator, the arrow keys
  // move the hand instead of the camera, because a listener before this one has taken the event.
  window.addEventListener("keydown", (event) => {
    const isFree = !event.defaultPrevented && !event.ctrlKey && !event.altKey && !event.metaKey;
    if (event.target !== canvas || !isFree || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
}
