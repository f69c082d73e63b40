// @ts-check
// What is measured of two peers, in words and numbers. What exactly a number is stands in its title.

import { along } from "./pair.js";
import { text, write } from "./parts.js";

/** @typedef {import("./environments.js").Value} Value */

/** Mean of the last ticks. @param {(ago: number) => number} of @param {number} ticks */
export const mean = (of, ticks) => {
  let sum = 0;
  for (let ago = 0; ago < ticks; ago++) sum += of(ago);
  return sum / ticks;
};

/** Quantities of two peers, and the parts of the page that show them.
 * @param {Value} value @param {number} me @param {() => number} axesNow along how many axes they share an object
 * @param {() => boolean} moment whether what is shown is one moment, of the past or the last: numbers are then those of its tick */
export function quantities(value, me, axesNow, moment) {
  const lately = (/** @type {(ago: number) => number} */ of) => mean(of, moment() ? 1 : 200);
  /** Distance of two places, mm. @param {string} one @param {string} other @param {number} ago */
  const distance = (one, other, ago) => {
    const axes = axesNow();
    // Plots ask for thousands a frame.
    if (axes === 1) return 1e3 * Math.abs(value(one, ago) - value(other, ago));
    const to = along(value, axes, other, ago);
    return 1e3 * Math.hypot(...along(value, axes, one, ago).map((at, axis) => at - (to[axis] ?? NaN)));
  };
  const apart = (/** @type {number} */ ago) => distance("object_1", "object_2", ago);
  const decoded = (/** @type {number} */ ago) => distance(`object_${me}`, `decoded_${me}`, ago);
  /** A force: along one axis with its sign, else its size. @param {string} name @param {number} ago */
  const force = (name, ago) => (axesNow() === 1 ? value(name, ago) : Math.hypot(...along(value, axesNow(), name, ago)));
  const fresh = (/** @type {number} */ ticks) => [1, 2].map((n) => mean((ago) => value(`live_${n}`, ago), ticks));
  const forces = (/** @type {string} */ name) => [1, 2].map((n) => lately((ago) => force(`${name}_${n}`, ago)));

  /** Each: where it is written, what it is called, its unit and digits, what it is, and its meaning.
   * @type {{ id: string, name: string, unit: string, digits: number, of: () => number[], means: string }[]} */
  const rows = [
    {
      id: "true",
      name: "copies apart",
      unit: "mm",
      digits: 3,
      of: () => [lately(apart)],
      means: "True distance of the two copies, which neither peer can know",
    },
    {
      id: "decoded",
      name: "as a peer believes",
      unit: "mm",
      digits: 3,
      of: () => [lately(decoded)],
      means: "Distance of a copy from where its peer believes the other to be",
    },
    {
      id: "forces",
      name: "hands",
      unit: "N",
      digits: 2,
      of: () => forces("hand"),
      means: "Force of the hand at device 1 and at device 2; to the right is above 0",
    },
    {
      id: "pushes",
      name: "simulated hands",
      unit: "N",
      digits: 2,
      of: () => forces("push"),
      means: "Force of the scene's user 1 and 2 on their devices, arms included; they act whoever holds a hand",
    },
    {
      id: "coordination",
      name: "coupling on",
      unit: "N",
      digits: 2,
      of: () => forces("coordination"),
      means: "Coordination force F_T on copy 1 and on copy 2",
    },
    {
      id: "line",
      name: "sent, not received",
      unit: "mJ",
      digits: 2,
      of: () => [1e3 * value("line")],
      means:
        "Energy that both peers have sent and neither has received: on its way, or lost with its packet. It is not stored; below 0 the line has made energy",
    },
    {
      id: "kept",
      name: "used up by",
      unit: "mJ",
      digits: 2,
      of: () => [1e3 * value("kept_1"), 1e3 * value("kept_2")],
      means:
        "Energy that the coupling at peer 1 and 2 took in at network and object, less what it gave out and what its spring stores; below 0 it has made energy",
    },
    {
      id: "trip",
      name: "there and back",
      unit: "ms",
      digits: 1,
      of: () => [1e3 * (value("delay_1") + value("delay_2"))],
      means: "How long the newest packets were on their way, both ways together",
    },
    {
      id: "live",
      name: "fresh data at",
      unit: "%",
      digits: 0,
      of: () => fresh(1000).map((share) => 100 * share),
      means:
        "Share of the last second in which what peer 1 and peer 2 have heard was no older than a packet period, or in which their line moved",
    },
  ];
  const written = new Map();
  const parts = rows.map(({ id, name, unit, means }) => {
    const part = document.createElement("div");
    const [term, datum] = ["dt", "dd"].map((kind) => part.appendChild(document.createElement(kind)));
    const number = document.createElement("span");
    [number.id, number.textContent] = [id, "–"];
    if (term)
      [term.textContent, term.title] = [`${name}${["decoded", "true", "line", "trip"].includes(id) ? "" : " 1, 2"}`, means];
    if (term && id === "true") term.id = "apart-name";
    datum?.append(number, ` ${unit}`);
    written.set(id, number);
    part.hidden = true;
    return part;
  });
  function writeAll() {
    for (const [at, { id, digits, of }] of rows.entries()) {
      const now = of();
      const part = parts[at];
      // What was never known, as of a recording that lacks it, is not there.
      if (part?.hidden && now.some(Number.isFinite)) part.hidden = false;
      write(written.get(id), now.map((number) => text(number, digits)).join(", "));
    }
  }
  /** Share of the last quarter of a second in which each has heard something fresh. */
  const live = () => fresh(250);
  return { apart, decoded, force, live, parts, write: writeAll };
}
