// SPDX-License-Identifier: Apache-2.0
// The devices of the buses: which are lost, and when a frame of each was last seen.

const HEARTBEAT = 0x700; // Identifier of the heartbeat of node 0 (CiA 301).
const SILENT_S = 3; // Age of the newest frame of a device from which it is silent.

// Which of these devices of a subsystem were lost and since then have neither returned nor been commissioned
// again. If several devices have the same number, `device` of an event contains all their names.
export function lostOf(store, name, devices) {
  const [started] = (store.lanes.get(name) ?? []).findLast(
    ([time, state]) => state === "HARDWARE_INIT" && time <= store.time,
  ) ?? [0];
  const found = new Set();
  for (const { subsystem, event, device, time } of store.events) {
    if (subsystem !== name || !device || time < started) continue;
    const named = device.split(" or ").filter((one) => devices.includes(one));
    if (event === "DEVICE_LOST") named.forEach((one) => found.add(one));
    if (event === "DEVICE_RETURNED") named.forEach((one) => found.delete(one));
  }
  return found;
}

const busNames = (store) => new Set((store.hello?.buses ?? []).map((bus) => bus.name));

// The first bus in the words about an end node; undefined if it is on none.
export const busOf = (store, ends) => (ends ?? "").split(", ").find((one) => busNames(store).has(one));

// All devices of the present configurations that are on a bus: {device, bus, node, isLost}. A device on two
// buses is listed for both.
export function devicesOn(store) {
  const known = busNames(store);
  return store.members().flatMap(({ name, configurations }) => {
    const part = store.configuration(name) ?? configurations[0];
    const lost = lostOf(store, name, part?.devices ?? []);
    return (part?.devices ?? []).flatMap((device) =>
      (part.endnodes[device] ?? "")
        .split(", ")
        .filter((bus) => known.has(bus))
        .map((bus) => ({ device, bus, node: part.nodes[device], isLost: lost.has(device) })),
    );
  });
}

// The bus of a device of the present configurations; undefined if it is on none, or there is no such device.
export const busOfDevice = (store, device) => devicesOn(store).find((one) => one.device === device)?.bus;

// Symbol and word for the ages [s] of the frames of a device; null: no such frame was seen.
export function stateOf(heartbeat, data) {
  const seen = [heartbeat, data].filter((one) => one !== null);
  if (!seen.length) return ["off", "no frame"];
  return Math.min(...seen) < SILENT_S ? ["normal", "live"] : ["stale", "silent"];
}

// Ages [s] of the heartbeat of a device and of its newest process data in the message of the tap of its bus;
// null without such a frame.
export function agesOf(device, node, said) {
  const isHeartbeat = (one) => parseInt(one.id, 16) === HEARTBEAT + Number(node);
  const isData = (one) => one.name.startsWith(`${device}_TPDO`);
  const ageOf = (isWanted) => {
    const times = (said?.frames ?? []).filter(isWanted).map((one) => one.time);
    return times.length ? Math.max(0, said.time - Math.max(...times)) : null;
  };
  return { heartbeat: ageOf(isHeartbeat), data: ageOf(isData) };
}
