// @ts-check
// Delay: two simulated hands pull one object apart, and a lens shows the gap that their delay leaves between its copies.

import { make, put, strip } from "./environments.js";
import { mean } from "./numbers.js";
import { write } from "./parts.js";
import { pairScene } from "./scene.js";
import { TOGETHER_MM } from "./status.js";

/** @typedef {import("./environments.js").Value} Value */
/** @typedef {import("./environments.js").View} View */

const BOX = "-160 -38 320 146";
/** Where the lens stands, below the ground. */
const GLASS = { x: -150, y: 52, width: 300, height: 52, most: 20 };

/** Copies apart, mm. @param {Value} value @param {number} ago */
export const apart = (value, ago = 0) => 1e3 * Math.abs(value("object_1", ago) - value("object_2", ago));

/** Two peers with a lens in a drawing of their own, and what a view of them is before it says anything; its hand stands where it was so many ticks ago.
 * @param {SVGSVGElement} svg @param {Value} value @param {number} me @param {() => number} [ago] */
export function inLens(svg, value, me, ago = () => 0) {
  svg.replaceChildren();
  put(svg, { viewBox: BOX });
  const picture = pairScene(make(svg, "g", {}), value, GLASS);
  const view = /** @type {Omit<View, "help">} */ ({
    box: BOX,
    flat: true,
    stages: [svg],
    toScene: ([x]) => picture.toScene(x, me),
    fromScene: ([x]) => [picture.fromScene(x, me), 0, 0],
    hand: `wanted_${me}`,
    own: () => [value(`device_${me}`, ago()), 0, 0],
    draw: (cut) => picture.draw(cut),
    numbers: [],
    strips: [
      strip("apart", "Copies apart", "mm", [1], () => ["true", (ago) => apart(value, ago)]),
      strip("force", "Force", "N", [1, 2], (n) => [`simulated hand ${n}`, (ago) => value(`push_${n}`, ago)]),
    ],
  });
  return { picture, view };
}

/** @param {SVGSVGElement} svg @param {HTMLElement} says @param {Value} value @param {number} me
 * @param {() => { one_way_s: number } | undefined} holds @returns {View} */
export function delay(svg, says, value, me, holds) {
  const { view } = inLens(svg, value, me);
  let state = /** @type {[string, boolean]} */ (["starting", false]);
  function tell() {
    const [gap, one, two] = [
      mean((ago) => apart(value, ago), 200),
      mean((ago) => value("push_1", ago), 200),
      mean((ago) => value("push_2", ago), 200),
    ];
    const ms = 1e3 * (holds()?.one_way_s ?? NaN);
    if (!Number.isFinite(gap + ms)) return;
    const pull = 0.5 * (Math.abs(one) + Math.abs(two));
    const text =
      `Two people hold one object, each at a copy of it, and pull with about ${pull.toFixed(1)} N. ` +
      `Each feels what the other did ${ms.toFixed(0)} ms ago, so the two copies stand ${gap.toFixed(1)} mm apart: the later the news, the wider the gap.`;
    write(says, text);
    state =
      gap > TOGETHER_MM
        ? [`the copies are ${gap.toFixed(0)} mm apart`, true]
        : ["two simulated hands pull the object apart, and it holds", false];
  }
  return {
    ...view,
    slowly: tell,
    status: () => state,
    help: "Drag the ring to take a hand as well. Springs are drawn as springs, arrows are forces with whose they are, and the ruler is in millimetres.",
  };
}
