// @ts-check
// Which moment is shown: the newest, or one of the past, which can be gone to, played from at any speed, and stepped through. What runs goes on meanwhile, and
// one control comes back to it. Of a recording every moment is past; what is not there yet is asked for.

import { choice, element, write } from "./parts.js";

/** What a timeline needs of a page: its samples, seconds in a tick, ticks in a packet period and in a plot, how it looks again at once; and, of a recording, how many ticks it has and how to ask for those
 * from one to before another.
 * @typedef {{ samples: import("./samples.js").Samples, period: () => number, packet: () => number, span: () => number, wake: () => void }} Of */
/** @typedef {{ ticks: number, start_s: number, overview_mm: number[], begin: number, marks: Mark[], ask: (from: number, count: number) => void }} Recording */

/** Something that happened: at which tick, whether it stopped somebody, and in words. @typedef {[number, boolean, string]} Mark */

/** How far back one can go while it runs, ticks. */
const REACH = 60000;
/** What is asked for before a moment of a recording and after it, ticks, if no plot shows more. */
const AROUND = 8192;

export class Timeline {
  playing = false;
  /** What is opened, if it is a recording. @type {Recording | undefined} */
  recording = undefined;
  /** Tick after the last that can be shown, while the past is. */
  #end = 0;
  /** The moment that is shown, between ticks: played slowly, it moves by parts of one. */
  #at = 0;
  #last = 0;
  /** Where a replay ends, and what is done there. @type {{ at: number, done: () => void } | undefined} */
  #until = undefined;
  /** What was asked for and has not come: ticks from one to before another. @type {[number, number] | undefined} */
  #asked = undefined;
  #said = "";
  /** The moment that was said last, if it stands, and when that was, ms. */
  #told = NaN;
  #toldAt = 0;

  /** @param {Of} of */
  constructor(of) {
    this.of = of;
    element("pause").addEventListener("click", () => this.toggle());
    element("now").addEventListener("click", () => this.now());
    for (const [id, step] of /** @type {[string, () => number][]} */ ([
      ["packet-back", () => -of.packet()],
      ["tick-back", () => -1],
      ["tick-on", () => 1],
      ["packet-on", () => of.packet()],
    ]))
      element(id).addEventListener("click", () => this.step(step()));
    element("speed").addEventListener("change", () => {
      // Slower than it runs is the past from now on.
      if (!this.past && this.speed < 1) this.#enter(true);
    });
    const slider = element("scrub");
    const seek = (/** @type {PointerEvent} */ event) => {
      const box = element("track").getBoundingClientRect();
      const share = Math.max(0, Math.min(1, (event.clientX - box.left) / box.width));
      const [from, to] = this.whole();
      this.seek(from + share * (to - 1 - from));
    };
    slider.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      slider.setPointerCapture(event.pointerId);
      seek(event);
    });
    slider.addEventListener("pointermove", (event) => slider.hasPointerCapture(event.pointerId) && seek(event));
    slider.addEventListener("keydown", this.key);
  }

  get past() {
    return this.of.samples.past;
  }

  get speed() {
    return Number(choice("speed").value);
  }

  /** Ticks that can be shown: from one to before another. @returns {[number, number]} */
  whole() {
    if (this.recording) return [0, this.recording.ticks];
    const { samples } = this.of;
    const end = this.past ? this.#end : samples.next;
    return [Math.max(samples.there.first, end - REACH), end];
  }

  /** A recording is opened, at its first fault or where the copies were farthest apart. @param {Recording} recording */
  open(recording) {
    [this.recording, this.#asked] = [recording, undefined];
    element("now").hidden = true;
    this.#overview(recording.overview_mm);
    for (const mark of document.querySelectorAll("#track .mark")) mark.remove();
    for (const [tick, stopped, words] of recording.marks) {
      const mark = element("track").appendChild(document.createElement("span"));
      [mark.className, mark.title] = [stopped ? "mark bad" : "mark", words];
      mark.style.setProperty("left", `${((100 * tick) / Math.max(1, recording.ticks - 1)).toFixed(2)}%`);
    }
    this.seek(recording.begin);
  }

  /** Goes to the next thing that happened, or to the one before. @param {boolean} back */
  #toMark(back) {
    const ticks = (this.recording?.marks ?? []).map(([tick]) => tick);
    const tick = back ? ticks.findLast((tick) => tick < this.#at) : ticks.find((tick) => tick > this.#at);
    if (tick !== undefined) this.seek(tick);
  }

  /** What happened last at the moment that is shown, and when. */
  #happened() {
    const marks = this.recording?.marks ?? [];
    const last = marks.findLast(([tick]) => tick <= this.#at)?.[0];
    if (last === undefined) return "";
    const words = marks.filter(([tick]) => tick === last).map(([, , words]) => words);
    return `${((this.recording?.start_s ?? 0) + last * this.of.period()).toFixed(3)} s: ${words.join("; ")}`;
  }

  /** Shows the newest, as it comes. */
  now() {
    if (this.recording) return;
    this.playing = false;
    choice("speed").value = "1";
    this.of.samples.show(undefined);
    this.of.wake();
  }

  /** From now on what is shown is what was. @param {boolean} playing */
  #enter(playing) {
    const { samples } = this.of;
    if (!this.past && !this.recording) [this.#end, this.#at] = [samples.next, samples.next - 1];
    [this.playing, this.#until] = [playing, undefined];
    this.#go(this.#at);
  }

  /** Shows this moment. @param {number} tick */
  seek(tick) {
    this.#enter(false);
    this.#go(tick);
  }

  /** @param {number} ticks */
  step(ticks) {
    this.seek(Math.round(this.past ? this.#at : this.of.samples.next - 1) + ticks);
  }

  /** Shows the last so many seconds once more, at this speed, and holds what was when it was asked for.
   * @param {number} seconds @param {number} speed 1, 0.5, 0.1 or 0.01 @param {() => void} [done] what comes then */
  replay(seconds, speed, done = () => {}) {
    this.now();
    choice("speed").value = `${speed}`;
    this.#enter(true);
    this.#until = { at: this.#end - 1, done };
    this.#go(this.#end - 1 - Math.round(seconds / this.of.period()));
  }

  /** Holds what is shown, or plays on from there. */
  toggle() {
    const [from, to] = this.whole();
    if (this.past && !this.playing && this.#at >= to - 1 && this.recording) this.#at = from;
    this.#enter(this.past && !this.playing);
  }

  /** @param {number} at */
  #go(at) {
    const { samples } = this.of;
    const [from, to] = this.whole();
    this.#at = Math.max(from, Math.min(to - 1, at));
    // Of a recording nothing has to be held: it can be asked for again.
    samples.show(Math.floor(this.#at), this.recording ? Infinity : from);
    this.#fetch();
    this.of.wake();
  }

  /** Asks for what is not there. */
  #fetch() {
    if (!this.recording) return;
    const { first, next } = this.of.samples;
    const [at, ticks] = [Math.floor(this.#at), this.recording.ticks];
    const around = Math.max(AROUND, this.of.span());
    const has = first < next && at >= first && at < next && (first === 0 || at - first >= around / 2);
    if (has && (next === ticks || next - at >= around / 2)) return;
    // On from the end of what is there, or around a moment elsewhere.
    const from = has ? next : Math.max(0, at - around);
    const to = Math.min(ticks, (has ? next : at) + around);
    if (this.#asked && at >= this.#asked[0] && at < this.#asked[1]) return;
    this.#asked = [has ? at : from, to];
    this.recording.ask(from, to - from);
  }

  /** What was asked for has come. */
  came() {
    this.#asked = undefined;
    this.#fetch();
  }

  /** Goes on, if it plays; once a frame. @param {number} now ms */
  frame(now) {
    const passed = Math.min(200, now - this.#last);
    this.#last = now;
    if (!this.past) return;
    if (this.playing) {
      const { samples } = this.of;
      const to = this.recording ? this.recording.ticks : samples.there.next;
      const at = this.#at + (this.speed * passed) / 1e3 / this.of.period();
      if (!this.recording) this.#end = Math.max(this.#end, Math.min(to, Math.floor(at) + 1));
      // It waits for what is on its way.
      if (!this.recording || (at >= samples.first && at < samples.next) || at >= to - 1) this.#go(at);
      if (at >= to - 1) this.playing = false;
      if (this.#until && at >= this.#until.at) {
        const { at: end, done } = this.#until;
        this.seek(end);
        done();
      }
    }
  }

  /** @param {KeyboardEvent} event */
  key = (event) => {
    const [from, to] = this.whole();
    const far = event.shiftKey ? this.of.packet() : 1;
    const second = Math.round(1 / this.of.period());
    const steps = { ArrowLeft: -far, ArrowDown: -far, ArrowRight: far, ArrowUp: far, PageUp: second, PageDown: -second };
    const step = steps[/** @type {keyof typeof steps} */ (event.key)];
    if (step) this.step(step);
    else if (event.key === "Home") this.seek(from);
    else if (event.key === "End") this.recording ? this.seek(to - 1) : this.now();
    else if (event.key === "n" || event.key === "p") this.#toMark(event.key === "p");
    else if (event.key === " ") this.toggle();
    else return;
    event.preventDefault();
  };

  /** How long ago, s, or when in a recording, what is shown was. */
  words() {
    const { samples } = this.of;
    const at = samples.shown() * this.of.period();
    if (this.recording) {
      const { start_s, ticks } = this.recording;
      return `${(start_s + at).toFixed(3)} s, of ${start_s.toFixed(0)} to ${(start_s + ticks * this.of.period()).toFixed(0)} s`;
    }
    return this.past ? `${((samples.next - 1 - samples.shown()) * this.of.period()).toFixed(1)} s ago` : "now";
  }

  /** Says which moment is shown, where that has changed; how long ago that is, once a second. @param {number} now ms */
  write(now) {
    const { samples } = this.of;
    const moment = this.past && !this.playing ? samples.shown() : NaN;
    if (moment === this.#told && now - this.#toldAt < 1000) return;
    [this.#told, this.#toldAt] = [moment, now];
    const [from, to] = this.whole();
    const words = this.words();
    const share = this.past ? (samples.shown() - from) / Math.max(1, to - 1 - from) : 1;
    const key = [words, this.past, this.playing, share.toFixed(4)].join();
    if (key === this.#said) return;
    this.#said = key;
    const [slider, pause] = [element("scrub"), element("pause")];
    document.body.classList.toggle("past", this.past && !this.recording);
    element("moment").textContent = words;
    write(element("happened"), this.#happened());
    element("past").hidden = !this.past || Boolean(this.recording);
    element("when").textContent = `${words}, at ${(samples.shown() * this.of.period()).toFixed(3)} s`;
    element("steps").hidden = !this.past;
    element("now").hidden = !this.past || Boolean(this.recording);
    write(pause, this.past && !this.playing ? "Play" : "Pause");
    pause.setAttribute("aria-pressed", `${this.past && !this.playing}`);
    element("thumb").style.setProperty("left", `${(100 * share).toFixed(2)}%`);
    // Of a recording its own time, else how long ago.
    const zero = this.recording ? this.recording.start_s : -(to - 1) * this.of.period();
    const [least, most, value] = [from, to - 1, samples.shown()].map((tick) => zero + tick * this.of.period());
    for (const [name, number] of [
      ["min", least],
      ["max", most],
      ["now", value],
    ])
      slider.setAttribute(`aria-value${name}`, Number(number).toFixed(3));
    slider.setAttribute("aria-valuetext", this.playing ? `${words}, playing` : words);
  }

  /** How far the copies were apart, along the whole of a recording. @param {number[]} mm */
  #overview(mm) {
    const most = mm.reduce((most, number) => Math.max(most, number), 0);
    const high = (/** @type {number} */ number) => (20 - (20 * Math.max(0, number)) / (most || 1)).toFixed(2);
    element("overview").setAttribute("viewBox", `0 0 ${Math.max(1, mm.length)} 20`);
    const path = mm.map((number, at) => `L${at} ${high(number)}H${at + 1}`).join("");
    element("overview").firstElementChild?.setAttribute("d", `M0 20${path}V20z`);
  }
}
