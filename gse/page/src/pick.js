// SPDX-License-Identifier: Apache-2.0
// The devices that the user points at in the scene: drives by the links that they move, wheels, and valve
// boxes by their thrusters.

import * as THREE from "three";

import { busOfDevice } from "./bus_devices.js";
import { store } from "./store.js";
import { put } from "./dom.js";

const LOOK_MS = 100; // Time between a movement of the pointer and the search for the device under it.

// The device to which a part of the scene belongs; undefined if it belongs to none.
function deviceOf(node, devices) {
  for (let one = node; one; one = one.parent) {
    const device = one.userData.device ?? devices.get(one.userData.joint);
    if (device) return device;
  }
  return undefined;
}

// The device at a place of the canvas [pixels] of a scene; undefined if there is none, or a fixture covers
// it.
function deviceAt({ camera, extent, bodies, fixtures }, x, y) {
  const { width, height } = extent;
  if (!bodies?.length || !width || !height) return undefined;
  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2((2 * x) / width - 1, 1 - (2 * y) / height), camera);
  const devices = new Map(Object.entries(store.hello.world.drives).map(([device, joint]) => [joint, device]));
  const [hit] = ray
    .intersectObjects([...bodies.map(({ arm }) => arm.node), ...fixtures])
    .filter(({ object }) => object.isMesh && object.visible);
  return hit && deviceOf(hit.object, devices);
}

// Show on the canvas which device the pointer is over. Returns the function that a click calls: it opens the
// tab Bus at the device, as its box in the drawing of the network does, which the keyboard reaches, too.
export function picking(scene) {
  const { canvas } = scene;
  scene.deviceAt = (x, y) => deviceAt(scene, x, y);
  // A replay has no frames for the tab Bus.
  const found = ({ offsetX, offsetY }) => {
    const device = store.replay ? undefined : scene.deviceAt(offsetX, offsetY);
    return { device, bus: device && busOfDevice(store, device) };
  };
  let moved = null;
  const look = () => {
    const { device, bus } = moved.buttons ? {} : found(moved);
    moved = null;
    put(canvas, "title", bus ? `${device}: open tab Bus` : "");
    canvas.style.cursor = bus ? "pointer" : "";
  };
  canvas.addEventListener("pointermove", (event) => {
    if (!moved) setTimeout(look, LOOK_MS);
    moved = event;
  });
  return (event) => {
    const { device, bus } = found(event);
    if (bus) store.tell("device", { bus, device });
  };
}
