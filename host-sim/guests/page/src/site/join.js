// @ts-check
// Who is joined to a run, and how: a window's line to the program, which comes back by itself and says why when it does not; and for the
// operator who holds which hand, and the code by which a phone takes one.

import { element, write } from "./parts.js";

/** Why the program closes a line: it has ended, or another window has taken this hand. */
const OVER = 4000;
const TAKEN = 4001;
/** How long an answer, or a new line, is waited for, ms. */
const PATIENCE = 3000;
/** From one attempt to the next, ms. */
const AGAIN = 1000;

const NEW = "scan the new code, or open the address that the new run prints";
const ENDED = `this link belongs to a run that has ended: ${NEW}`;

/** @typedef {{ hear: (data: any) => void, opened: (socket: WebSocket) => void, lost: (why: string) => void }} Line */

/** A line to the program by these keys, which is opened at once. @param {string} ring @param {Line} line */
export function join(ring, { hear, opened, lost }) {
  const button = element("rejoin");
  /** @type {WebSocket | undefined} */
  let socket;
  /** Since when something is waited for: a line that opens, a greeting, an answer; none, and nothing is. @type {number | undefined} */
  let since;
  let isOpen = false;
  /** Attempts in a row that the program refused although it is there. */
  let refused = 0;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;

  function open() {
    clearTimeout(timer);
    timer = undefined;
    button.hidden = true;
    [since, isOpen] = [performance.now(), false];
    const now = new WebSocket(`ws://${location.host}/ws/${ring}`);
    socket = now;
    now.binaryType = "arraybuffer";
    now.onopen = () => {
      [since, isOpen, refused] = [performance.now(), true, 0];
      opened(now);
    };
    now.onmessage = ({ data }) => {
      since = undefined;
      hear(data);
    };
    now.onclose = ({ code }) => closed(now, code);
  }

  /** @param {WebSocket} which @param {number} code */
  async function closed(which, code) {
    if (which !== socket) return;
    since = undefined;
    if (code === OVER) lost(`closed: this run has ended. For the next one ${NEW}`);
    else if (code === TAKEN) {
      lost("closed: another window took this hand");
      button.hidden = false;
    } else {
      lost("no answer from the program: the network is lost, or it has ended. Trying again");
      // A line that is refused looks like one that is not there; a file tells them apart.
      const there = !isOpen && (await fetch("page.css", { cache: "no-store" }).catch(() => undefined))?.ok;
      refused = there ? refused + 1 : 0;
      if (which !== socket) return;
      if (refused > 1) lost(ENDED);
      else timer = setTimeout(open, AGAIN);
    }
  }

  // A line that a phone's sleep or another network has cut stays open for minutes as far as the browser knows.
  setInterval(() => {
    if (document.hidden || since === undefined || performance.now() - since < PATIENCE) return;
    const dead = socket;
    lost("no answer from the program: the network is lost, or it has ended. Trying again");
    open();
    dead?.close();
  }, AGAIN);
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) return;
    // What was waited for while nobody looked is not late yet, and what was lost is tried again at once.
    if (since !== undefined) since = performance.now();
    else if (timer !== undefined) open();
  });
  button.addEventListener("click", open);
  open();
  return {
    /** An answer is waited for from now on. */
    asks: () => {
      since ??= performance.now();
    },
  };
}

/** Says who holds which hand. @param {number[]} people @param {number} own the hand of this window, or 0
 * @param {number} elsewhere the hand of another machine, or 0 */
export function showPeople(people, own, elsewhere) {
  const said = people.map((there, at) => {
    const hand = at + 1;
    const who =
      hand === own ? "this window" : hand === elsewhere ? "the other machine's" : there ? "somebody is there" : "nobody";
    return `hand ${hand}: ${who}`;
  });
  write(element("people"), said.join(" · "));
}

/** Shows the code that a phone scans. @param {{ address: string, hand: number, side: number, path: string }} joining */
export function showJoin({ address, hand, side, path }) {
  const [part, code] = [element("join"), element("join-code")];
  part.hidden = false;
  const drawn = document.createElementNS("http://www.w3.org/2000/svg", "path");
  drawn.setAttribute("d", path);
  code.setAttribute("viewBox", `0 0 ${side} ${side}`);
  code.setAttribute("aria-label", `QR code of the address of hand ${hand}`);
  code.replaceChildren(drawn);
  element("join-address").textContent = address;
  for (const number of part.querySelectorAll(".hand-number")) number.textContent = `${hand}`;
}
