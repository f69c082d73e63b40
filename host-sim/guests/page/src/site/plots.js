// @ts-check
// Plots of what is shown, one below the other, over a window of time in which the moment that is shown lies; and what leaves the page of them: CSV of every
// column, SVG and PNG with title, axes, units and legend. Drawn anew only where something that is seen has changed.

import { element, write } from "./parts.js";
import { canvasPen, DASHES, draw, inside, legend, range, svgPen } from "./figure.js";

/** @typedef {import("./environments.js").Strip} Strip */
/** @typedef {import("./figure.js").Extremes} Extremes */
/** @typedef {import("./figure.js").Colours} Colours */
/** What the plots need of a page: its samples, seconds in a tick, the time of tick 0, ticks that can be shown, what to write above an export and into which files, and how one
 * goes to a moment.
 * @typedef {{ samples: import("./samples.js").Samples, period: () => number, start: () => number, whole: () => [number, number], title: () => string[], file: () => string,
 *   seek: (tick: number) => void, key: (event: KeyboardEvent) => void }} Of */

/** Shortest and longest time that is shown, ticks. */
const [SHORTEST, LONGEST] = [60, 60000];
/** Width of an export, and height of each plot in it with its heading, pixels; and what stands above all. */
const [WIDE, HIGH, HEADING, ABOVE] = [900, 150, 22, 52];

/** Hands a file to the person. @param {string} name @param {Blob} blob */
export function download(name, blob) {
  const link = document.createElement("a");
  [link.href, link.download] = [URL.createObjectURL(blob), name];
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

export class Plots {
  /** Ticks that are shown, and the tick after the last of them. */
  #span = 4000;
  #end = 0;
  /** @type {Strip[]} */
  #strips = [];
  /** What each strip shows from bottom to top, before it is made round. @type {Map<string, [number, number]>} */
  #ranges = new Map();
  /** Where a pointer is over the plots, as a share of their width; none: nowhere. */
  #over = NaN;
  /** What was drawn last; another one is drawn. */
  #drawn = "";
  /** Strips that are in sight. @type {Set<string>} */
  #seen = new Set();
  #sight = new IntersectionObserver((all) => {
    for (const { target, isIntersecting } of all) isIntersecting ? this.#seen.add(target.id) : this.#seen.delete(target.id);
    this.#drawn = "";
  });
  #sizes = new ResizeObserver(() => (this.#drawn = ""));

  /** @param {Of} of */
  constructor(of) {
    this.of = of;
    element("closer").addEventListener("click", () => this.zoom(0.5));
    element("farther").addEventListener("click", () => this.zoom(2));
    element("csv").addEventListener("click", () => download(`${of.file()}.csv`, new Blob([this.asCsv()], { type: "text/csv" })));
    element("svg").addEventListener("click", () =>
      download(`${of.file()}.svg`, new Blob([this.asSvg()], { type: "image/svg+xml" })),
    );
    element("png").addEventListener("click", () => this.asPng((blob) => blob && download(`${of.file()}.png`, blob)));
    this.#sizes.observe(element("strips"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (this.#drawn = ""));
  }

  /** @param {number} factor */
  zoom(factor) {
    const longest = Math.min(LONGEST, Math.max(4000, this.of.whole()[1] - this.of.whole()[0]));
    this.#span = Math.round(Math.max(SHORTEST, Math.min(longest, this.#span * factor)));
    element("span").textContent = `${Number((this.#span * this.of.period()).toPrecision(3))} s`;
    this.#drawn = "";
  }

  /** How many ticks are shown. */
  get span() {
    return this.#span;
  }

  /** The ticks that are shown: from one to before another. @returns {[number, number]} */
  window() {
    const { samples } = this.of;
    const [first, last] = this.of.whole();
    const at = samples.shown();
    if (!samples.past) this.#end = samples.next;
    else if (at >= this.#end && at < this.#end + this.#span / 4) this.#end = at + 1;
    else if (at >= this.#end || at < this.#end - this.#span) {
      this.#end = Math.max(Math.min(first + this.#span, last), Math.min(last, Math.round(at + this.#span / 2)));
    }
    return [this.#end - this.#span, this.#end];
  }

  /** Shows other plots. @param {Strip[]} strips */
  show(strips) {
    this.#strips = strips;
    this.#ranges.clear();
    this.#seen.clear();
    this.#sight.disconnect();
    element("strips").replaceChildren(...strips.map((strip) => this.#figure(strip)));
    this.#drawn = "";
  }

  /** @param {Strip} strip */
  #figure({ id, title, unit, series }) {
    const [figure, caption, canvas] = ["figure", "figcaption", "canvas"].map((kind) => document.createElement(kind));
    if (!figure || !caption || !canvas) throw new Error("no figure");
    caption.append(`${title}${unit ? `, ${unit}` : ""} `);
    for (const [at, { name }] of series.entries()) {
      const part = document.createElement("span");
      part.className = `c${at + 1}`;
      const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
      svg.setAttribute("viewBox", "0 0 28 8");
      svg.setAttribute("aria-hidden", "true");
      const line = svg.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "path"));
      line.setAttribute("d", "M0 4h28");
      line.setAttribute("stroke-dasharray", at === 0 ? "none" : `${DASHES[at % DASHES.length]}`);
      part.append(svg, ` ${name}`);
      caption.append(part);
    }
    canvas.id = id;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${title}, ${unit}; press to show a moment, arrow keys go a tick back or on`);
    const share = (/** @type {PointerEvent} */ event) => {
      const { x, wide } = inside(canvas.clientWidth, canvas.clientHeight);
      return Math.max(0, Math.min(1, (event.offsetX - x) / wide));
    };
    const seek = (/** @type {PointerEvent} */ event) => {
      const [from, to] = this.window();
      this.of.seek(from + Math.round(share(event) * (to - from - 1)));
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      this.#over = share(event);
      if (canvas.hasPointerCapture(event.pointerId)) seek(event);
    });
    canvas.addEventListener("pointerleave", () => (this.#over = NaN));
    canvas.addEventListener("keydown", this.of.key);
    figure.append(caption, canvas);
    this.#sight.observe(canvas);
    return figure;
  }

  /** Lowest and highest of a series in each of so many columns of the window, the last sample of the column before included: nothing of a tick is lost.
   * @param {(ago: number) => number} of @param {number} pixels @returns {Extremes[]} */
  #extremes(of, pixels) {
    const [from] = this.window();
    const [now, span] = [this.of.samples.shown(), this.#span];
    let last = NaN;
    return Array.from({ length: pixels }, (_, x) => {
      let [low, high] = [last, last];
      const end = from + Math.floor(((x + 1) * span) / pixels);
      for (let tick = from + Math.floor((x * span) / pixels); tick < end; tick++) {
        last = of(now - tick);
        if (!(low <= last)) low = last;
        if (!(high >= last)) high = last;
      }
      return [low, high];
    });
  }

  /** Colours of text, of lines behind, and of series, as a part of the page has them. @param {Element} of @returns {Colours} */
  #colours(of) {
    const made = ["p", "hr", ..."1234"].map((name) => {
      const probe = document.createElement("i");
      if (name > "0" && name < "5") probe.className = `c${name}`;
      if (name === "hr") probe.className = "faint";
      return of.appendChild(probe);
    });
    const [ink = "black", faint = "grey", ...series] = made.map((probe) => getComputedStyle(probe).color);
    for (const probe of made) probe.remove();
    return { ink, faint, series };
  }

  /** Seconds at both ends of the window, and how many pixels of it went by before. @param {number} wide @param {boolean} absolute */
  #time(wide, absolute) {
    const [from, to] = this.window();
    const now = !absolute && !this.of.samples.past;
    const period = this.of.period();
    const zero = now ? to * period : -this.of.start();
    const phase = Math.floor((from * wide) / this.#span);
    return { from: from * period - zero, to: to * period - zero, now, phase };
  }

  /** The time of a tick, s. @param {number} tick */
  at = (tick) => (this.of.start() + tick * this.of.period()).toFixed(3);

  /** Draws what has changed, if anything has. */
  draw() {
    const { samples } = this.of;
    const [from, to] = this.window();
    // What stands still for as long as is shown looks the same wherever it is.
    const rests = !samples.past && samples.next - samples.moved > this.#span && samples.next - samples.first > this.#span;
    const there = samples.past ? [samples.shown(), Math.max(from, samples.there.first), Math.min(to, samples.there.next)] : [];
    const now = [from, to, this.#over, this.#span, devicePixelRatio, ...there];
    const key = rests ? `rests ${this.#over} ${this.#span}` : now.join(" ");
    if (key === this.#drawn) return;
    this.#drawn = key;
    this.#readout();
    if (this.#seen.size === 0) return;
    const colours = this.#colours(element("strips"));
    for (const strip of this.#strips) if (this.#seen.has(strip.id)) this.#strip(strip, colours, !rests && !samples.past);
  }

  /** @param {Strip} strip @param {Colours} colours @param {boolean} flows the last range is kept for a while */
  #strip(strip, colours, flows) {
    const canvas = /** @type {HTMLCanvasElement} */ (element(strip.id));
    const context = canvas.getContext("2d");
    if (!context) return;
    const ratio = devicePixelRatio || 1;
    const [wide, high] = [canvas.clientWidth, canvas.clientHeight];
    const [across, down] = [Math.round(wide * ratio), Math.round(high * ratio)];
    if (canvas.width !== across || canvas.height !== down) [canvas.width, canvas.height] = [across, down];
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, wide, high);
    const place = inside(wide, high);
    const lines = strip.series.map(({ of }) => this.#extremes(of, Math.round(place.wide * ratio)));
    const { raw, range: shown } = range(
      lines.flat(2).filter(Number.isFinite),
      flows ? this.#ranges.get(strip.id) : undefined,
      strip.unit,
    );
    this.#ranges.set(strip.id, raw);
    const pen = canvasPen(context);
    draw(pen, strip, lines, shown, this.#time(place.wide, false), place, colours);
    const [from, to] = this.window();
    const mark = (/** @type {number} */ share, /** @type {number} */ thick) =>
      pen.marks([[place.x + share * place.wide, place.y, place.y + place.high]], colours.ink, thick);
    if (this.of.samples.past) mark((this.of.samples.shown() - from) / (to - from - 1), 2);
    if (Number.isFinite(this.#over)) mark(this.#over, 1);
  }

  /** The numbers at the pointer, or at the moment that is shown. */
  #readout() {
    const { samples } = this.of;
    const [from, to] = this.window();
    const pointed = Number.isFinite(this.#over);
    const tick = pointed ? from + Math.round(this.#over * (to - from - 1)) : samples.shown();
    const ago = samples.shown() - tick;
    const text = (/** @type {Strip} */ { unit, series }) =>
      series.flatMap(({ name, of }) => (Number.isFinite(of(ago)) ? `${name} ${of(ago).toFixed(2)} ${unit}` : [])).join(", ");
    const said = pointed || samples.past ? `${this.at(tick)} s: ${this.#strips.map(text).filter(Boolean).join("; ")}` : "";
    write(element("cursor"), said);
  }

  /** Every column of the window, a row a tick. */
  asCsv() {
    const { samples } = this.of;
    const names = [...samples.named].map(([name, unit]) => (unit ? `${name}_${unit.toLowerCase()}` : name));
    const rows = [["time_s", ...names].join(",")];
    const [from, to] = this.window();
    for (let tick = from; tick < to; tick++) {
      // What was not there yet is no row; what is no number is empty.
      if (!Number.isFinite(samples.of("restarts", tick))) continue;
      const numbers = [...samples.named.keys()].map((name) => samples.of(name, tick));
      rows.push([this.at(tick), ...numbers.map((number) => (Number.isFinite(number) ? `${number}` : ""))].join(","));
    }
    return `${rows.join("\n")}\n`;
  }

  /** All strips with their headings and what is said above them. @param {import("./figure.js").Pen} pen */
  #compose(pen) {
    const paper = element("paper");
    const colours = this.#colours(paper);
    const measure = document.createElement("canvas").getContext("2d");
    const wide = (/** @type {string} */ text) => {
      if (measure) measure.font = "11px system-ui, sans-serif";
      return measure?.measureText(text).width ?? 6 * text.length;
    };
    const [title = "", ...more] = this.of.title();
    pen.text(title, 0, 16, colours.ink, "start", true);
    pen.text(more.join(" · "), 0, 34, colours.ink, "start");
    for (const [row, strip] of this.#strips.entries()) {
      const top = ABOVE + row * (HIGH + HEADING);
      const heading = `${strip.title}${strip.unit ? `, ${strip.unit}` : ""}`;
      pen.text(heading, 0, top + 12, colours.ink, "start", true);
      legend(pen, strip, wide(heading) * 1.15 + 18, top + 12, colours, wide);
      const box = inside(WIDE, HIGH);
      const place = { ...box, y: box.y + top + HEADING - 6 };
      const lines = strip.series.map(({ of }) => this.#extremes(of, place.wide));
      const { range: shown } = range(lines.flat(2).filter(Number.isFinite), undefined, strip.unit);
      draw(pen, strip, lines, shown, this.#time(place.wide, true), place, colours);
    }
    pen.text("time since the beginning, s", WIDE / 2, this.#high() - 6, colours.ink, "middle");
  }

  #high = () => ABOVE + this.#strips.length * (HIGH + HEADING) + 22;

  /** The strips, one below the other, dark on white. */
  asSvg() {
    /** @type {string[]} */
    const parts = [];
    this.#compose(svgPen(parts));
    const high = this.#high();
    const size = `width="${WIDE + 20}" height="${high}" viewBox="-10 0 ${WIDE + 20} ${high}"`;
    const back = `<rect x="-10" width="${WIDE + 20}" height="${high}" fill="white"/>`;
    return `<svg xmlns="http://www.w3.org/2000/svg" ${size} font-family="system-ui, sans-serif" font-size="11">${back}${parts.join("")}</svg>\n`;
  }

  /** The same as a picture, twice as fine. @param {(blob: Blob | null) => void} done */
  asPng(done) {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [2 * (WIDE + 20), 2 * this.#high()];
    const context = canvas.getContext("2d");
    if (!context) return;
    context.fillStyle = "white";
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.setTransform(2, 0, 0, 2, 20, 0);
    this.#compose(canvasPen(context));
    canvas.toBlob(done);
  }
}
