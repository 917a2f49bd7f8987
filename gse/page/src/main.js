// SPDX-License-Identifier: Apache-2.0
import "./station.css";
import { store } from "./store.js";
import { fromBase64, unpack } from "./recording.js";
import { Replay } from "./replay.js";
import { toggleTheme } from "./bar.js";
import "./spacecraft.js";
import "./scene.js";
import "./strips.js";
import "./work.js";
import "./log.js";
import "./player.js";

window.station = {
  store,
  scene: document.querySelector("station-scene"),
  strips: document.querySelector("station-strips"),
};
store.on("state", (message) => {
  document.getElementById("said").textContent =
    message.cause && message.since === message.time ? `${message.subsystem} ${message.state}` : "";
});

let wasLive = false;
store.on("link", ({ is_live, code, text }) => {
  if (wasLive && !is_live && code !== 0)
    document.getElementById("alarm-said").textContent = `link lost: ${text}`;
  wasLive = is_live;
});

document.getElementById("theme")?.addEventListener("click", toggleTheme);

const refuse = (text) => store.take({ kind: "link", is_live: false, is_refused: true, text });

async function replay(octets) {
  let recording;
  try {
    recording = await unpack(octets);
  } catch (error) {
    refuse(
      `Cannot replay: expected a recording of a run, found another or a damaged file (${error.message})`,
    );
    return;
  }
  document.body.classList.add("replay");
  window.station.replay = new Replay(recording);
}

// A report contains its recording. A station supplies the recording of a flight that has ended, or the one
// with which it was started.
async function begin() {
  const within = document.getElementById("recording");
  if (within) {
    await replay(fromBase64(within.textContent.trim()));
    return;
  }
  if (!location.search.includes("replay")) {
    store.connect();
    return;
  }
  store.take({ kind: "link", is_live: false, is_waiting: true, text: "the station prepares the replay" });
  const answer = await fetch("/recording");
  if (answer.ok) await replay(new Uint8Array(await answer.arrayBuffer()));
  else refuse(`Cannot replay: ${await answer.text()}`);
}
begin();
