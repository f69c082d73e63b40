// @ts-check
// A lens on the gap between the two copies: their middles, enlarged by a round number that stands beside them, over a ruler in mm whose 0 is
// copy 1.

import { write } from "./parts.js";
import { make, put } from "./environments.js";
import { phone } from "./phone.js";

/** Where a lens stands in a drawing, and the most that it enlarges.
 * @typedef {{ x: number, y: number, width: number, height: number, most: number }} Place */

const POWERS = [1, 2, 5, 10, 20, 50, 100, 200, 500];
/** Distances of a ruler's ticks, mm, and how far apart in the drawing ticks and numbers are at least. */
const STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];
const TICK_APART = 4;
const NUMBER_APART = { usual: 15, phone: 30 };
/** From a copy's line to the middle of its name. */
const NAME_APART = { usual: 12, phone: 22 };
/** Share of its width that the gap may fill. */
const FILLS = 0.7;

/** On a phone the same letters take more of the drawing. @param {{ usual: number, phone: number }} sizes */
const of = (sizes) => (phone.matches ? sizes.phone : sizes.usual);

/** A number of a ruler without needless zeros. @param {number} mm */
const plain = (mm) => `${Number(mm.toFixed(2))}`.replace("-", "−");

/** Round numbers beside a ruler, from one place of the drawing to another: a path of its ticks and where its numbers stand.
 * @param {number} from @param {number} to @param {number} zero where 0 mm is @param {number} perMm
 * @returns {{ ticks: [number, boolean][], numbers: [number, string][] }} */
export function rule(from, to, zero, perMm) {
  const step = STEPS.find((mm) => mm * perMm >= TICK_APART) ?? 100;
  const numbered =
    STEPS.find((mm) => mm * perMm >= of(NUMBER_APART) && Math.abs(mm / step - Math.round(mm / step)) < 1e-9) ?? 100;
  const each = Math.round(numbered / step);
  const ticks = /** @type {[number, boolean][]} */ ([]);
  const numbers = /** @type {[number, string][]} */ ([]);
  for (let at = Math.ceil((from - zero) / perMm / step); at <= (to - zero) / perMm / step; at++) {
    const x = zero + at * step * perMm;
    ticks.push([x, at % each === 0]);
    if (at % each === 0) numbers.push([x, plain(at * step)]);
  }
  return { ticks, numbers };
}

/** Writes numbers into a group, and makes or takes away texts at need. @param {SVGElement} group @param {[number, string][]} numbers @param {number} y */
export function writeRule(group, numbers, y) {
  while (group.childElementCount > numbers.length) group.lastElementChild?.remove();
  for (const [at, [x, text]] of numbers.entries()) {
    const label = /** @type {SVGElement} */ (group.children[at] ?? make(group, "text", { class: "number" }));
    put(label, { x: x.toFixed(2), y });
    write(label, text);
  }
}

/** @param {SVGElement} to @param {Place} place */
export function lens(to, { x, y, width, height, most }) {
  const group = make(to, "g", { class: "lens" });
  const leads = make(group, "path", { class: "lead" });
  const pane = make(group, "rect", { class: "glass", x, y, width, height, rx: 3 });
  const ticks = make(group, "path", { class: "ticks" });
  const numbers = make(group, "g", {});
  const [one, two] = [1, 2].map((n) => make(group, "path", { class: `middle${n}` }));
  const names = [1, 2].map((n) => {
    const name = make(group, "text", { class: `name${n}`, y: y + 8 });
    name.textContent = `copy ${n}`;
    return name;
  });
  const span = make(group, "path", { class: "span" });
  const gap = make(group, "text", { class: "gap", x: x + width / 2, y: y + 8 });
  const label = make(group, "text", { class: "power", x: x + 4, y: y + 8 });
  const [middle, ground] = [x + width / 2, y + height - 9];
  let [power, peak] = [Math.min(most, 20), 0];
  let said = "";
  /** Draws the copies, which are at these places (mm), of a line that stands at `over` in the drawing, `perMm` of it a millimetre.
   * @param {number} at1 @param {number} at2 @param {number} over @param {number} perMm */
  function draw(at1, at2, over, perMm) {
    const there = Number.isFinite(at1 + at2);
    group.toggleAttribute("hidden", !there);
    if (!there) return;
    const apart = Math.abs(at2 - at1);
    peak = Math.max(apart, 0.97 * peak);
    const fits = (/** @type {number} */ at) => peak * at <= FILLS * width;
    power = POWERS.findLast((at) => at <= most && fits(at)) ?? 1;
    const centre = 0.5 * (at1 + at2);
    const placed = (/** @type {number} */ mm) => Math.max(x, Math.min(x + width, middle + (mm - centre) * power));
    const [x1, x2] = [placed(at1), placed(at2)];
    const { ticks: marks, numbers: written } = rule(x + 6, x + width - 12, middle + (at1 - centre) * power, power);
    put(ticks, {
      d: `${marks.map(([at, long]) => `M${at.toFixed(2)} ${ground}v${long ? 4 : 2}`).join("")}M${x} ${ground}h${width}`,
    });
    writeRule(numbers, written, y + height - 0.8);
    const [top, low] = [y + 11, ground];
    if (one) put(one, { d: `M${x1.toFixed(2)} ${top}V${low}` });
    if (two) put(two, { d: `M${x2.toFixed(2)} ${top}V${low}` });
    const aside = Math.abs(x2 - x1) / 2 + of(NAME_APART);
    const side = x1 <= x2 ? 1 : -1;
    const names1 = 0.5 * (x1 + x2) - side * aside;
    const names2 = 0.5 * (x1 + x2) + side * aside;
    const edge = of(NAME_APART);
    const within = (/** @type {number} */ at) => Math.max(x + edge, Math.min(x + width - edge, at)).toFixed(2);
    if (names[0]) put(names[0], { x: within(names1), y: y + 20 });
    if (names[1]) put(names[1], { x: within(names2), y: y + 20 });
    put(span, { d: Math.abs(x2 - x1) > 1 ? `M${x1.toFixed(2)} ${ground - 4}H${x2.toFixed(2)}` : "" });
    leads.toggleAttribute("hidden", power < 5);
    const [left, right] = [over + (centre - width / 2 / power) * perMm, over + (centre + width / 2 / power) * perMm];
    put(leads, { d: `M${x} ${y}L${left.toFixed(2)} -22H${right.toFixed(2)}L${x + width} ${y}` });
    const text = `${apart.toFixed(apart < 1 ? 3 : 2)} mm apart`;
    write(gap, text);
    // What does not fit needs no lens.
    const fitting = apart * power <= width - 8;
    for (const part of [pane, ticks, numbers, one, two, span, ...names]) part?.toggleAttribute("hidden", !fitting);
    const now = !fitting ? "" : phone.matches ? `×${power}` : `lens ×${power}`;
    if (now !== said) [said, label.textContent] = [now, now];
  }
  return { draw, power: () => power };
}
