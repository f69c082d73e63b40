// @ts-check
// Settings: controls, orders that wait for their answers, the verdict on what holds, and questions.

import { choice, element, input, write } from "./parts.js";

/** @typedef {{ stable: boolean | null, text: string, not_judged: string[] }} Finding */
/** @typedef {{ settings: Record<string, string>, changed: [string, string][], one_way_s: number, edge: number | null, finding: Finding | null }} Holds */
/** @typedef {{ line: string, text: string, instead: string | null }} Question */
/** A control: the key it stands for, how its number becomes the range's, how it is read, and how it orders.
 * @typedef {{ key: string, unit: string, to: (value: number) => number, from: (value: number) => number, digits: number, anyway?: boolean }} Control */

const plain = (/** @type {number} */ scale) => ({
  to: (/** @type {number} */ x) => x * scale,
  from: (/** @type {number} */ x) => x / scale,
});
const decades = { to: Math.log10, from: (/** @type {number} */ x) => Number((10 ** x).toPrecision(3)) };
const ONE_WAY = { key: "one way", unit: "ms", ...plain(1e3), digits: 0 };
const LOSS = { key: "network.loss", unit: "%", ...plain(100), digits: 0 };
const BURST = { key: "network.loss_burst_packets", unit: "packets", ...plain(1), digits: 0 };
const STIFFNESS = { key: "coordination.stiffness_n_per_m", unit: "N/m", ...decades, digits: 0 };
/** @type {Record<string, Control>} */
const CONTROLS = {
  delay: ONE_WAY,
  "story-delay": ONE_WAY,
  jitter: { key: "network.jitter_s", unit: "ms", ...plain(1e3), digits: 0 },
  loss: LOSS,
  burst: BURST,
  "lanes-loss": LOSS,
  "lanes-burst": BURST,
  stiffness: STIFFNESS,
  // What this picture is about is to happen: it does not ask first.
  "story-stiffness": { ...STIFFNESS, anyway: true },
  impedance: { key: "coordination.wave_impedance_n_s_per_m", unit: "N·s/m", ...decades, digits: 1 },
  mass: { key: "object.mass_kg", unit: "kg", ...decades, digits: 3 },
};

/** What a range orders. @param {Control} control @param {number} number in the key's unit */
function order({ key, anyway }, number) {
  if (key === ONE_WAY.key) return `set network.one_way_delay_packets=0 network.extra_delay_s=${number}`;
  if (key === "network.jitter_s") return `set network.jitter=${number > 0 ? "uniform" : "none"} ${key}=${number}`;
  return `${anyway ? "anyway " : ""}set ${key}=${number}`;
}

/** @param {string} id @param {Control} control @param {number} number */
function read(id, { to, unit, digits }, number) {
  const shown = unit === "ms" || unit === "%" ? to(number) : number;
  const said = `${shown.toFixed(digits)} ${unit}`;
  const text = input(id).closest("label")?.querySelector(".value");
  if (text) text.textContent = said;
  input(id).setAttribute("aria-valuetext", said);
}

/** @param {(text: string) => boolean} send says whether it could */
export function settings(send) {
  /** @type {Holds | undefined} */
  let holds;
  /** Orders that wait for the answer to the one before, by the control that gives them: of one control the newest counts.
   * @type {Map<string, string>} */
  const pending = new Map();
  let judging = false;

  /** @param {string} order @param {string} [from] */
  function ask(order, from = order) {
    element("refused").textContent = "";
    element("question").hidden = true;
    pending.set(from, order);
    sendNext();
  }

  function sendNext() {
    const first = pending.entries().next().value;
    if (judging || !first || !send(first[1])) return;
    pending.delete(first[0]);
    judging = true;
  }

  /** The answer to an order is what holds with a verdict, a question, or a refusal. @param {{ holds?: Holds }} message */
  function answered({ holds: now }) {
    if (now && !now.finding) return;
    judging = false;
    sendNext();
  }

  for (const [id, control] of Object.entries(CONTROLS)) {
    input(id).addEventListener("input", () => {
      const number = control.from(Number(input(id).value));
      read(id, control, number);
      ask(order(control, number), id);
    });
  }
  choice("environment").addEventListener("change", () => ask(`show ${choice("environment").value}`, "environment"));
  choice("law").addEventListener("change", () => ask(`law ${choice("law").value}`, "law"));
  input("one-sided").addEventListener("change", () => ask(`set contact.one_sided=${input("one-sided").checked}`, "one-sided"));
  element("controls").addEventListener("submit", (event) => event.preventDefault());

  /** Marks the edge below the range of the picture that tells of it. @param {number | null} at N/m */
  function mark(at) {
    const [edge, range] = [element("stiff-edge"), input("story-stiffness")];
    edge.hidden = at === null;
    if (at === null) return;
    const share = (Math.log10(at) - Number(range.min)) / (Number(range.max) - Number(range.min));
    edge.textContent = `▲ limit, both hands on: ${Math.round(at)} N/m`;
    edge.style.left = `calc(${share.toFixed(4)} * (100% - 1rem) + 0.5rem)`;
  }

  /** @param {Holds} now */
  function show(now) {
    holds = now.finding ? now : { ...now, edge: holds?.edge ?? null };
    mark(holds.edge);
    for (const [id, control] of Object.entries(CONTROLS)) {
      const number = control === ONE_WAY ? now.one_way_s : Number(now.settings[control.key]);
      if (pending.has(id) || !Number.isFinite(number)) continue;
      input(id).value = `${control.to(number)}`;
      read(id, control, number);
    }
    choice("law").value = (now.settings["coordination.comm"] ?? "").replaceAll('"', "");
    input("one-sided").checked = now.settings["contact.one_sided"] === "true";
    const verdict = element("verdict");
    write(verdict, now.finding?.text ?? "judging");
    verdict.classList.toggle("bad", now.finding?.stable === false);
    if (now.finding) element("not-judged").textContent = `Not judged: ${now.finding.not_judged.join("; ")}.`;
  }

  /** @param {Question} question */
  function question({ line, text, instead }) {
    element("question-text").textContent = `This was not set: ${text}.`;
    element("question").hidden = false;
    const better = element("instead");
    better.hidden = instead === null || line.startsWith("file");
    better.textContent = `Set ${instead} as well`;
    const answer = (/** @type {string | undefined} */ order) => () => {
      element("question").hidden = true;
      if (order) ask(order);
    };
    better.onclick = answer(`${line} ${instead}`);
    element("anyway").textContent = "Set it anyway";
    element("anyway").onclick = answer(`anyway ${line}`);
    element("leave").onclick = answer(undefined);
    element("leave").focus({ preventScroll: true });
  }

  return { ask, answered, show, question, holds: () => holds };
}
