// @ts-check
// Delay: two simulated hands pull one object apart, and a lens shows the gap between its copies. The line is not taut here, so that it gives
// way at rest like a spring: F·(2/K_T + T/b), softer the longer it is. What is said of it is measured.

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

/** How long after another delay was set nothing is said of the spring that it makes, ms. */
const SETTLES = 2000;

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

/** Over so many ticks: the force that pulls the copies apart, N, how far they are, m, each below 0 where the hands press, and the spring that they
 * make of the line, N/m. @param {Value} value @param {number} ago */
function pulled(value, ago) {
  const over = (/** @type {(ago: number) => number} */ of) => mean((at) => of(at + ago), 200);
  const force = 0.5 * over((at) => value("coordination_1", at) - value("coordination_2", at));
  const far = over((at) => value("object_2", at) - value("object_1", at));
  return { force, far, spring: force / far };
}

/** @param {SVGSVGElement} svg @param {HTMLElement} says @param {Value} value @param {number} me
 * @param {() => { one_way_s: number } | undefined} holds @returns {View} */
export function delay(svg, says, value, me, holds) {
  const { view } = inLens(svg, value, me);
  let state = /** @type {[string, boolean]} */ (["starting", false]);
  /** The delay that was set last, ms, and when that was, or a start, ms. */
  let [set, since] = ["", 0];
  /** A peer does not run. */
  let off = false;
  /** Why not, in a sentence. */
  let why = "";
  function tell() {
    const gap = mean((ago) => apart(value, ago), 200);
    const ms = (1e3 * (holds()?.one_way_s ?? NaN)).toFixed(0);
    if (!Number.isFinite(gap + Number(ms))) return;
    if (ms !== set) [set, since] = [ms, performance.now()];
    const far = `${gap.toFixed(1)} mm`;
    state =
      gap > TOGETHER_MM
        ? [`the copies are ${gap.toFixed(0)} mm apart`, true]
        : ["two simulated hands pull the object apart, and it holds", false];
    if (off) {
      write(says, `${why}. The gap of ${far} is left from before. Press Start.`);
      return;
    }
    const [now, before] = [pulled(value, 0), pulled(value, 800)];
    const does = now.force > 0 ? "pull one object apart" : "press one object together";
    const hands = `Two people, each at a copy of the object, ${does} with ${Math.abs(now.force).toFixed(1)} N.`;
    // While the line moves, its mass counts as well, and after another delay its length changes.
    const rests =
      performance.now() - since > SETTLES &&
      Math.abs(now.force) > 0.2 &&
      now.spring > 0 &&
      Math.abs(now.spring / before.spring - 1) < 0.2;
    write(
      says,
      rests
        ? `${hands} Over a delay of ${ms} ms the line between them gives way like a spring of ${Number(now.spring.toPrecision(2))} N/m, so the copies stand ${far} apart. A longer line is a softer spring: the force stays, the gap grows.`
        : `${hands} The line between them, over a delay of ${ms} ms, is not at rest: the copies are ${far} apart now.`,
    );
  }
  return {
    ...view,
    slowly: tell,
    status: () => state,
    told: (modes, base) => {
      const stopped = modes.some((mode) => mode !== 1);
      const fault = modes.findIndex((mode) => mode > base);
      why = fault < 0 ? "Stopped: the motors are off, and no hand reaches the object now" : `Peer ${fault + 1} stopped itself`;
      if (off && !stopped) since = performance.now();
      off = stopped;
    },
    help: "Drag the ring to take a hand as well. Springs are drawn as springs, arrows are forces with whose they are, and the ruler is in millimetres.",
  };
}
