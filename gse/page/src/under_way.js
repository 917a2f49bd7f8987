// SPDX-License-Identifier: Apache-2.0
// What is under way at an instant of the flight: a recovery plan, a procedure, a command, or in a replay a
// phase of the scenario. Each is { title, note, steps, share }: steps are { words, is, time }, `is` one of
// done, running and waiting; share is the part that has passed, from 0 to 1, or null if it is not known.

const LONGEST_S = 600; // Longest time between the start of a plan and its last action.
const KEPT_S = 2; // Time for which a plan that has ended is shown.
const LATE_S = 5; // A step that is not reached so long after its time is over: its process may have died.
const UNITS = { us: 1e-6, ms: 1e-3, s: 1 };
const BUILT_IN = {
  name: "built in",
  actions: [{ do: "STATE", target: "NETWORK", state: "OFFLINE", after: "500ms" }],
};
const LED_S = 1; // Time after an event in which reports are counted as those that it led to.
const ENDS = ["ENDED", "FAILED", "STOPPED", "ABORTED"];

// Seconds of a time of the descriptors, such as "500ms".
export function secondsOf(words) {
  const [, number, unit] = /^([\d.]+)\s*(us|ms|s)$/.exec(words ?? "0s") ?? [];
  return number ? Number(number) * UNITS[unit] : 0;
}

// The plan that the supervisor starts for an event of a subsystem; undefined if there is none.
export function planOf(plans, severity, subsystem, event) {
  const fits = (plan) =>
    plan.severity === severity &&
    (!plan.subsystem || plan.subsystem === subsystem) &&
    (!plan.event || plan.event === event);
  return plans.find(fits) ?? (severity === "HIGH" ? BUILT_IN : undefined);
}

// The event of severity HIGH with which an alarm began that is open since a mission time [s], and the number
// of reports that followed it: { severity, time, words, count }; null if no such event was received. The
// alarm of a link has no time of its own (Infinity): it began with the last event.
export function ledTo(events, since) {
  const at = events.findLastIndex(({ severity, time }) => severity === "HIGH" && time <= since);
  if (at < 0) return null;
  const { severity, time, subsystem, event, device } = events[at];
  const words = [subsystem, event, device].filter(Boolean).join(" ");
  const count = events.slice(at + 1).filter((one) => one.time <= time + LED_S).length;
  return { severity, time, words, count };
}

// Steps of a plan: first the reaction of the supervisor that precedes each plan, then the actions.
function stepsOf(plan, severity, subsystem) {
  const first = { HIGH: ["network", "ERROR_OPERATIONAL"], MEDIUM: [subsystem, "SAFE_OPERATIONAL"] }[severity];
  const steps = first
    ? [{ words: `${first[0]} to ${first[1]}`, due: 0, of: subsystem, state: first[1] }]
    : [];
  for (const { do: kind, target, state, mode, after } of plan.actions) {
    const due = secondsOf(after);
    const who = { NETWORK: "network", SELF: subsystem }[target] ?? target;
    const of = ["NETWORK", "SELF"].includes(target) ? subsystem : target;
    if (kind === "STATE") steps.push({ words: `${who} to ${state}`, due, of, state });
    if (kind === "MODE") steps.push({ words: `mode ${mode}`, due });
  }
  return steps.filter(({ words }, n) => steps.findIndex((one) => one.words === words) === n);
}

// When a step was performed; null if it was not yet.
function endOf({ due, of, state }, start, time, lanes) {
  if (time < start + due) return null;
  if (!state) return start + due;
  const reached = (lanes.get(of) ?? []).find(
    ([from, name]) => name === state && from >= start - 0.1 && from <= time,
  );
  if (reached) return reached[0];
  return time > start + due + LATE_S ? start + due + LATE_S : null;
}

function planUnderWay({ time, events, plans, lanes, severityOf }) {
  const isSame = (one, other) =>
    one.values.APID === other.values.APID && one.values.EVENT === other.values.EVENT;
  const ended = [];
  for (let n = events.length - 1; n >= 0 && events[n].time > time - LONGEST_S; n--) {
    const one = events[n];
    if (one.event === "PLAN_OVERRULED") ended.push(one);
    if (one.event !== "PLAN_STARTED" || !one.values || ended.some((other) => isSame(one, other))) continue;
    const { APID: subsystem, EVENT: event } = one.values;
    const severity = severityOf(subsystem, event) ?? "HIGH";
    const plan = planOf(plans, severity, subsystem, event);
    if (!plan) continue;
    const steps = stepsOf(plan, severity, subsystem).map((step) => ({
      ...step,
      end: endOf(step, one.time, time, lanes),
    }));
    const present = steps.findIndex(({ end }) => end === null);
    const last = Math.max(one.time, ...steps.map(({ end }) => end ?? 0));
    if (present < 0 && time > last + KEPT_S) continue;
    const longest = Math.max(...steps.map(({ due }) => due), 0);
    return {
      title: `Plan ${plan.name}`,
      note: present < 0 ? "completed" : `running, step ${present + 1} of ${steps.length}`,
      steps: steps.map(({ words, end, due }, n) => ({
        words,
        is: end !== null ? "done" : n === present ? "running" : "waiting",
        time: end !== null ? `${end.toFixed(4)} s` : inFuture(one.time + due - time),
      })),
      share: present < 0 ? 1 : longest > 0 ? Math.min(1, (time - one.time) / longest) : null,
    };
  }
  return null;
}

const inFuture = (seconds) => (seconds > 0 ? `in ${seconds.toFixed(1)} s` : "");

// The supervisor reports the steps of a procedure while its observation is enabled.
function procedureUnderWay({ events }) {
  const seen = new Set();
  for (let n = events.length - 1; n >= 0; n--) {
    const { event, values } = events[n];
    if (!["PROCEDURE_OBSERVED", "PROCEDURE_FAILED"].includes(event) || seen.has(values?.PROCEDURE)) continue;
    seen.add(values?.PROCEDURE);
    if (ENDS.includes(values?.WHAT)) continue;
    const words = values.WHAT === "HELD" ? "suspended" : "running";
    return {
      title: `Procedure ${values.PROCEDURE}`,
      note: `${words}, step ${values.STEP}`,
      steps: [],
      share: null,
    };
  }
  return null;
}

// The newest command whose execution has started and not ended.
function commandUnderWay({ time, commands }) {
  const call = commands.findLast((one) => !one.over && one.lights[1] === "done");
  if (!call) return null;
  const passed = Math.max(0, time - (call.time ?? time));
  const duration = Number(/\bDURATION=([\d.]+)/.exec(call.text)?.[1] ?? 0);
  const left = duration - passed;
  return {
    title: call.text,
    note: duration ? (left > 0 ? `${left.toFixed(1)} s to go` : "ends now") : `for ${passed.toFixed(1)} s`,
    steps: [],
    share: duration ? Math.min(1, passed / duration) : null,
  };
}

function phaseUnderWay({ time, phases }) {
  const phase = phases.find(([from, to]) => from <= time && time < to);
  if (!phase) return null;
  const [from, to, words] = phase;
  return {
    title: words,
    note: `${(to - time).toFixed(1)} s to go`,
    steps: [],
    share: (time - from) / (to - from),
  };
}

// What is under way; null if nothing is. time: instant [s]; events, commands: those until this instant, the
// newest last; plans: of the mission; lanes: Map of subsystem to [time, state] pairs; severityOf(subsystem,
// event): severity of an event, or undefined; phases: [from, to, words] of the scenario.
export const underWay = (instant) =>
  planUnderWay(instant) ?? procedureUnderWay(instant) ?? commandUnderWay(instant) ?? phaseUnderWay(instant);
