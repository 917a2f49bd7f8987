// SPDX-License-Identifier: Apache-2.0
// Pictures of the scene without a graphics processor. The processors compute a picture while the page goes
// on; a page that showed the canvas of WebGL itself would wait for each picture.

import { LEAST_MS, Pace } from "./pace.js";
import { store } from "./store.js";

// Share of the pixels of each axis of a scene at rest, whose edges are smooth then; time after which the
// scene is at rest; time between two questions whether a picture is complete.
const [FINE, REST_MS, LOOK_MS] = [2, 300, 2];

// Whether the processors compute what WebGL draws.
export function isSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

// Copy the rows of a picture from the lowest to the highest, without the factor of transparency in its
// colours.
function copy(from, to, width, height) {
  const row = 4 * width;
  for (let y = 0; y < height; y++) to.set(from.subarray(y * row, (y + 1) * row), (height - 1 - y) * row);
  for (let at = 3; at < to.length; at += 4) {
    const alpha = to[at];
    if (alpha === 0 || alpha === 255) continue;
    for (let n = at - 3; n < at; n++) to[n] = Math.min(255, (to[n] * 255) / alpha);
  }
}

const after = (ms) => new Promise((done) => setTimeout(done, ms));

export class Pictures {
  // canvas: visible, without WebGL; draw(scale, isForced): draws the scene by WebGL if it has changed or
  // isForced is true, and returns whether it has drawn; shown(): called when a picture is visible.
  constructor(canvas, gl, draw, shown) {
    Object.assign(this, { canvas, gl, draw, shown });
    this.context = canvas.getContext("2d");
    this.buffer = gl.createBuffer();
    this.pace = new Pace();
    this.isBusy = this.isWanted = this.isFine = false;
    document.addEventListener("visibilitychange", () => this.wake());
  }

  // Something may have changed: draw as soon as the pace permits it, or at once if the operator jumps in a
  // replay that stands still.
  wake() {
    this.isWanted = true;
    if (this.isBusy || document.hidden) return;
    this.isBusy = true;
    const isJump = store.replay && !store.replay.isPlaying;
    const wait = isJump ? 0 : this.pace.wait(performance.now());
    // At the end of this task, the processors begin before the page computes its layout.
    if (wait) setTimeout(() => this.next(), wait);
    else queueMicrotask(() => this.next());
  }

  async next() {
    this.isWanted = false;
    let isDrawn = false;
    try {
      const began = performance.now();
      if ((isDrawn = this.draw(this.pace.scale))) {
        clearTimeout(this.resting);
        this.resting = setTimeout(() => this.rest(), REST_MS);
        this.isFine = false;
        if (await this.read()) this.pace.note(began, performance.now(), store.isHolding());
      }
    } finally {
      this.isBusy = false;
    }
    if (this.isWanted) setTimeout(() => this.wake(), isDrawn ? 0 : LEAST_MS);
  }

  // Draw the scene at rest. It has so many pixels that the processors would delay the lines of the hand.
  async rest() {
    if (this.isBusy || store.isHolding()) {
      this.resting = setTimeout(() => this.rest(), this.isBusy ? LOOK_MS : REST_MS);
      return;
    }
    this.isBusy = this.isFine = true;
    try {
      if (this.draw(FINE, true)) await this.read();
    } finally {
      this.isBusy = false;
    }
    if (this.isWanted) this.wake();
  }

  // Show the picture that WebGL has been told to draw, when it is complete. Returns whether it was shown.
  async read() {
    const { gl } = this;
    const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.buffer);
    if (this.pixels?.length !== 4 * width * height) {
      this.pixels = new Uint8Array(4 * width * height);
      gl.bufferData(gl.PIXEL_PACK_BUFFER, this.pixels.length, gl.STREAM_READ);
    }
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    let state = gl.TIMEOUT_EXPIRED;
    while (state === gl.TIMEOUT_EXPIRED) {
      await after(LOOK_MS);
      state = gl.clientWaitSync(fence, 0, 0);
    }
    gl.deleteSync(fence);
    if (state === gl.WAIT_FAILED) return false; // The browser has taken the context away.
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.buffer);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, this.pixels);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    this.show(width, height);
    return true;
  }

  show(width, height) {
    if (this.image?.width !== width || this.image?.height !== height) {
      this.image = new ImageData(width, height);
      Object.assign(this.canvas, { width, height });
    }
    copy(this.pixels, this.image.data, width, height);
    this.context.putImageData(this.image, 0, 0);
    this.shown();
  }
}
