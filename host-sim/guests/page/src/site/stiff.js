// @ts-check
// Too stiff: a coupling that is made stiffer until a peer stops itself. The picture then stands, shows both copies, and replays the last two
// seconds at a tenth of their speed, again and again.

import { apart, inLens } from "./delay.js";
import { make, put } from "./environments.js";
import { mean } from "./numbers.js";
import { write } from "./parts.js";
import { plainly, TOGETHER_MM } from "./status.js";

/** @typedef {import("./environments.js").Value} Value */
/** @typedef {import("./environments.js").View} View */

/** What is replayed, ticks; how much slower than it was; and how long the last picture then stands, ms. */
const [BEFORE, SLOWER, STANDS] = [2000, 10, 1500];
const KT = "coordination.stiffness_n_per_m";
const still = matchMedia("(prefers-reduced-motion: reduce)");

/** @param {SVGSVGElement} svg @param {HTMLElement} says @param {Value} value @param {import("./stories.js").About} about @returns {View} */
export function tooStiff(svg, says, value, { me, faults, holds, past }) {
  const { picture, view } = inLens(svg, value, me, () => ago);
  const note = make(svg, "text", { class: "replay", x: 0, y: -31 });
  const way = make(svg, "path", { class: "replay", d: "" });
  /** Who has stopped itself, and why. @type {{ peer: number, why: string } | undefined} */
  let fault;
  let [begun, far, ago] = [0, 0, 0];
  /** Samples before the stop that there are. */
  let kept = 0;
  let state = /** @type {[string, boolean]} */ (["starting", false]);

  /** @param {number[]} modes @param {number} base */
  function told(modes, base) {
    const at = modes.findIndex((mode) => mode > base);
    if (at < 0) {
      fault = undefined;
      return;
    }
    if (fault) return;
    fault = { peer: at + 1, why: plainly((modes[at] ?? 0) - base, faults) };
    kept = 0;
    const restarts = value("restarts");
    while (kept < BEFORE && value("restarts", kept) === restarts) kept += 1;
    const places = Array.from({ length: kept }, (_, at) => [1, 2].map((n) => Math.abs(1e3 * value(`object_${n}`, at)))).flat();
    far = Math.max(0, ...places.filter(Number.isFinite));
    begun = performance.now();
    tell();
  }

  function replay() {
    const length = (kept - 1) * SLOWER;
    const since = (performance.now() - begun) % (length + STANDS);
    ago = still.matches ? 0 : Math.max(0, Math.round((length - since) / SLOWER));
    picture.draw(false, ago, far);
    const text = ago > 0 ? `replayed ten times slower: ${(1e-3 * ago).toFixed(2)} s before the stop` : "here it stopped";
    write(note, text);
    const share = kept > 1 ? 1 - ago / (kept - 1) : 1;
    put(way, { d: `M-60 -27h${(120 * share).toFixed(1)}` });
  }

  function tell() {
    const now = holds();
    const [stiffness, ms, edge] = [Number(now?.settings[KT]), 1e3 * (now?.one_way_s ?? NaN), now?.edge ?? NaN];
    if (!Number.isFinite(stiffness + ms)) return;
    const spring = `${stiffness.toFixed(0)} N/m`;
    const limit = Number.isFinite(edge)
      ? `below ${10 * Math.floor(edge / 10)} N/m it holds while both hands are on`
      : "a softer one holds";
    if (fault && stiffness <= edge) {
      says.textContent = `Peer ${fault.peer} stopped itself: ${fault.why}. Not the coupling of ${spring} did that: start again.`;
      state = [`peer ${fault.peer} stopped itself`, true];
      return;
    }
    if (fault) {
      says.textContent =
        `Peer ${fault.peer} stopped itself: ${fault.why}. With a coupling of ${spring}, each pull answers a position that is ${ms.toFixed(0)} ms old. ` +
        `It comes too late, goes too far, and the next one is stronger. Make it softer: ${limit}.`;
      state = [`too stiff: peer ${fault.peer} stopped itself`, true];
      return;
    }
    const gap = mean((at) => apart(value, at), 200);
    const beyond = stiffness > edge;
    const text = beyond
      ? `The coupling is now a spring of ${spring}, too stiff for data that is ${ms.toFixed(0)} ms old. Each pull comes too late, and makes the next one stronger.`
      : `Two people press one object together. A spring of ${spring} couples its two copies, with data that is ${ms.toFixed(0)} ms old. A stiffer one keeps the copies closer. Move the slider to the right.`;
    write(says, text);
    const worst = Number.isFinite(gap) ? gap : 0;
    const far = `the copies are ${worst.toFixed(1)} mm apart`;
    if (beyond) state = [`too stiff: it will not hold; ${far}`, true];
    else state = worst > TOGETHER_MM ? [`${far}: they are no longer one object`, true] : [`it holds: ${far}`, false];
  }

  return {
    ...view,
    draw: (cut) => {
      for (const part of [note, way]) part.toggleAttribute("hidden", !fault || past());
      if (fault && !past()) return replay();
      ago = 0;
      picture.draw(cut);
    },
    told,
    /** Ticks before the stop that are drawn now, of a replay. */
    replayed: () => (fault && !past() ? ago : NaN),
    slowly: tell,
    status: () => state,
    help: "Drag the ring to take a hand as well. When a peer stops, the last two seconds are shown again, ten times slower.",
  };
}
