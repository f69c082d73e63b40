// @ts-check
// Two peers along one axis: both copies where they are, the springs that hold them, hands, every force that acts with whose it is, a ruler,
// and a lens on the gap. Millimetres are those of the ruler; a picture of copies that are far apart is zoomed out, and what is still outside
// stands at its end, and says where it is.

import { write } from "./parts.js";
import { phone } from "./phone.js";
import { make, put } from "./environments.js";
import { lens, rule, writeRule } from "./lens.js";

/** @typedef {import("./environments.js").Value} Value */
/** @typedef {import("./environments.js").Point} Point */

/** Half of the picture's width and from the middle of the object to a hand, in mm where it is not zoomed; the ground, and a hand's height. */
const [HALF, HANDLE, GROUND, LEVEL] = [160, 38, 32, 9];
/** How much smaller a picture is drawn, and beyond which distance from the middle, mm. */
const ZOOMS = [1, 1.5, 2, 3, 5];
const INSIDE = 130;
/** Lengths of a newton, mm, and the longest arrow. */
const SCALES = [1, 2, 5, 10, 20, 50, 100, 200];
const LONGEST = 44;
/** A force that is not drawn, N, and which share of the largest one of late would be no arrow. */
const [NOTHING, UNSEEN] = [0.004, 0.015];

/** A coil spring along x. @param {number} from @param {number} to @param {number} y @param {number} [turns] @param {number} [high] */
export function coil(from, to, y, turns = 5, high = 2.2) {
  const [lead, way] = [0.12 * (to - from), (0.76 * (to - from)) / (2 * turns)];
  const bends = Array.from({ length: 2 * turns - 1 }, (_, at) => {
    return `L${(from + lead + (at + 1) * way).toFixed(2)} ${(y + (at % 2 ? high : -high)).toFixed(2)}`;
  });
  return `M${from.toFixed(2)} ${y}h${lead.toFixed(2)}${bends.join("")}L${(to - lead).toFixed(2)} ${y}H${to.toFixed(2)}`;
}

/** An arrow from a place, as long as it says. @param {number} x @param {number} y @param {number} length */
function arrow(x, y, length) {
  if (!(Math.abs(length) > 0.3)) return "";
  const head = Math.sign(length) * Math.min(4, Math.abs(length));
  return `M${x.toFixed(2)} ${y - 1}h${(length - head).toFixed(2)}v-2l${head.toFixed(2)} 3l${(-head).toFixed(2)} 3v-2h${(head - length).toFixed(2)}z`;
}

/** @param {number} n */
export const handle = (n) => (n === 1 ? -HANDLE : HANDLE);

/** Draws into a group; a lens where it is said to be.
 * @param {SVGElement} to @param {Value} value @param {import("./lens.js").Place} glass */
export function pairScene(to, value, glass) {
  to.replaceChildren();
  const ground = make(to, "path", { class: "ground" });
  const ticks = make(to, "path", { class: "ground" });
  const numbers = make(to, "g", { class: "ruler" });
  const unit = make(to, "text", { class: "number", x: HALF - 7, y: GROUND + 11 });
  unit.textContent = "mm";
  const peers = [1, 2].map((n) => {
    const group = make(to, "g", { class: `peer${n}` });
    const copy = make(group, "g", { class: "copy" });
    make(copy, "rect", { x: -18, y: -14, width: 36, height: 46, rx: 2 });
    make(copy, "path", { class: "middle", d: "M0 -14v5" });
    make(copy, "text", { x: n === 1 ? -12 : 12, y: -5 }).textContent = `${n}`;
    return {
      n,
      copy,
      contact: make(group, "path", { class: "spring" }),
      pull: make(group, "path", { class: "spring hold" }),
      end: make(group, "circle", { class: "hold", r: 2.5, cy: LEVEL }),
      device: make(group, "circle", { class: "device", r: 6 }),
      // Whose a force is, and at which height it is drawn.
      forces: [
        { of: "hand", name: n === 1 ? "hand 1" : "hand 2", class: "arrow hand", y: -11 },
        { of: "push", name: `simulated hand ${n}`, class: "arrow push", y: n === 1 ? -4 : 1 },
        { of: "coordination", name: `coupling on ${n}`, class: "arrow pulled", y: n === 1 ? 21 : 28 },
      ].map((force) => ({
        ...force,
        path: make(group, "path", { class: force.class }),
        text: make(group, "text", { class: "owner" }),
      })),
      outside: make(to, "text", { class: "outside", y: -2 - 8 * n }),
    };
  });
  const coupling = make(to, "path", { class: "coupling" });
  const cutMark = make(to, "text", { class: "cut from", x: 0, y: -17 });
  cutMark.textContent = "✂ cut";
  const scale = make(to, "g", { class: "scale" });
  const [bar, ofBar] = [make(scale, "path", {}), make(scale, "text", { y: GROUND - 2 })];
  const glassOn = lens(to, glass);
  let [zoom, per, peak, drawn] = [1, 10, 0, 0];

  /** From mm to the drawing, and back. */
  const across = (/** @type {number} */ mm) => mm / zoom;
  const down = (/** @type {number} */ y) => GROUND + (y - GROUND) / zoom;

  /** Zooms out for copies this far from the middle, mm; in again only when they are well inside. @param {number} far */
  function zoomFor(far) {
    const wanted = ZOOMS.find((times) => far <= INSIDE * times) ?? 5;
    if (wanted > zoom || far < 0.8 * INSIDE * wanted) zoom = wanted;
    // On a phone its numbers are farther apart.
    const ruler = phone.matches ? -zoom : zoom;
    if (ruler === drawn) return;
    drawn = ruler;
    const { ticks: marks, numbers: written } = rule(-HALF, HALF - 14, 0, 1 / zoom);
    put(ground, { d: `M${-HALF} ${GROUND}H${HALF}` });
    put(ticks, { d: marks.map(([x, long]) => `M${x.toFixed(2)} ${GROUND}v${long ? 4 : 2}`).join("") });
    writeRule(
      numbers,
      written.filter(([x]) => x > 8 - HALF && x < HALF - 16),
      GROUND + 11,
    );
  }

  /** @param {boolean} cut @param {number} [ago] ticks @param {number} [least] how far from the middle is in the picture at the least, mm */
  function draw(cut, ago = 0, least = 0) {
    const at = [1, 2].map((n) => 1e3 * value(`object_${n}`, ago));
    zoomFor(Math.max(least, ...at.map((mm) => (Number.isFinite(mm) ? Math.abs(mm) : 0))));
    const forces = peers.map(({ n, forces }) => forces.map(({ of }) => value(`${of}_${n}`, ago)));
    const most = Math.max(...forces.flat().map((newton) => (Number.isFinite(newton) ? Math.abs(newton) : 0)));
    peak = Math.max(most, 0.985 * peak);
    per = SCALES.findLast((mm) => mm * peak <= LONGEST) ?? 1;
    const newton = per >= 100 ? 0.1 : per <= 2 ? 10 : 1;
    put(bar, { d: `M${HALF - 6 - per * newton} ${GROUND - 10}h${per * newton}m0 -2v4m${-per * newton} -4v4` });
    put(ofBar, { x: HALF - 6 - (per * newton) / 2 });
    const said = `${newton} N`;
    write(ofBar, said);
    for (const [index, { n, copy, contact, pull, end, device, forces: arrows, outside }] of peers.entries()) {
      const mm = at[index] ?? NaN;
      const x = Math.max(-HALF + 6, Math.min(HALF - 6, across(mm)));
      copy.toggleAttribute("hidden", !Number.isFinite(mm));
      if (Number.isFinite(mm)) put(copy, { transform: `translate(${x.toFixed(3)} ${down(0).toFixed(2)}) scale(${1 / zoom})` });
      const beyond = Number.isFinite(mm) && x !== across(mm);
      outside.toggleAttribute("hidden", !beyond);
      if (beyond) {
        outside.textContent = x > 0 ? `copy ${n}: ${(mm / 1e3).toFixed(1)} m →` : `← copy ${n}: ${(mm / 1e3).toFixed(1)} m`;
        put(outside, { x: x > 0 ? HALF - 26 : 26 - HALF });
      }
      const own = across(1e3 * value(`device_${n}`, ago) + handle(n));
      const level = down(LEVEL);
      const there = Number.isFinite(own);
      device.toggleAttribute("hidden", !there);
      contact.toggleAttribute("hidden", !(there && Number.isFinite(mm)));
      if (there) put(device, { cx: own.toFixed(3), cy: level.toFixed(2), r: 6 / Math.sqrt(zoom) });
      const side = Math.sign(handle(n));
      if (there && Number.isFinite(mm)) put(contact, { d: coil(x + (side * 18) / zoom, own - (side * 6) / zoom, level, 4) });
      const wanted = across(1e3 * value(`wanted_${n}`, ago) + handle(n));
      for (const part of [pull, end]) part.toggleAttribute("hidden", !Number.isFinite(wanted + own));
      if (Number.isFinite(wanted + own)) {
        put(pull, { d: coil(own, wanted, level, 6, 2.8) });
        put(end, { cx: wanted.toFixed(2), cy: level.toFixed(2) });
      }
      for (const [which, { of, name, y, path, text }] of arrows.entries()) {
        const force = forces[index]?.[which] ?? NaN;
        const length = Math.max(-80, Math.min(80, per * force));
        const shown = Math.abs(force) > Math.max(NOTHING, UNSEEN * peak) && Number.isFinite(own);
        text.toggleAttribute("hidden", !shown);
        text.classList.toggle("from", of === "coordination" ? length > 0 : side > 0);
        text.classList.toggle("to", of === "coordination" ? length <= 0 : side < 0);
        if (!shown) {
          put(path, { d: "" });
          continue;
        }
        // On the outer side of its device what pushes ends there, and what pulls begins there; what acts on a copy begins in it.
        const outer = own + (side * 9) / zoom;
        const from = of === "coordination" ? x : length * side > 0 ? outer : outer - length;
        put(path, { d: arrow(from, y, length) });
        const [low, high] = [Math.min(from, from + length), Math.max(from, from + length)];
        const left = of === "coordination" ? length < 0 : side < 0;
        const beside = left ? low - 2 : high + 2;
        const within = left ? Math.max(56 - HALF, beside) : Math.min(HALF - 56, beside);
        // Where there is no room beside it, it stands above.
        put(text, { x: within.toFixed(2), y: within === beside ? y + 1.8 : y - 4.5 });
        const label = `${name}: ${Math.abs(force).toFixed(Math.abs(force) < 100 ? 2 : 0)} N`;
        write(text, label);
      }
    }
    const [one, two] = at.map((mm) => Math.max(-HALF + 6, Math.min(HALF - 6, across(mm))));
    const held = one !== undefined && two !== undefined && Number.isFinite(one + two);
    coupling.toggleAttribute("hidden", !held);
    cutMark.toggleAttribute("hidden", !cut);
    if (held) {
      const [from, until, y] = [one - 14 / zoom, two + 14 / zoom, down(-14) - 5];
      const posts = `M${from.toFixed(2)} ${down(-14).toFixed(2)}V${y}M${until.toFixed(2)} ${down(-14).toFixed(2)}V${y}`;
      const quarter = (until - from) / 4;
      // A line that is cut hangs down from both posts.
      const broken = `${coil(from, from + quarter, y, 2)}l1 4${coil(until, until - quarter, y, 2)}l-1 4`;
      put(coupling, { d: posts + (cut ? broken : coil(from, until, y, 6)) });
      coupling.classList.toggle("broken", cut);
      put(cutMark, { x: (Math.max(from, until) + 4).toFixed(2), y: y + 2 });
    }
    glassOn.draw(at[0] ?? NaN, at[1] ?? NaN, 0, 1 / zoom);
  }
  return {
    draw,
    lens: glassOn,
    zoom: () => zoom,
    /** Where something is in the drawing that is this far from the middle, m. @param {number} metres @param {number} n whose hand @returns {Point} */
    toScene: (metres, n) => [across(1e3 * metres + handle(n)), down(LEVEL)],
    /** How far it is, m. @param {number} x @param {number} n */
    fromScene: (x, n) => (x * zoom - handle(n)) / 1e3,
  };
}
