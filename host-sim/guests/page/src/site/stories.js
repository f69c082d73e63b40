// @ts-check
// The pictures that a page opens with, and the way between them and the workshop.

import { delay } from "./delay.js";
import { laws } from "./laws.js";
import { drawing, element } from "./parts.js";
import { tooStiff } from "./stiff.js";

/** @typedef {import("./environments.js").Value} Value */
/** @typedef {import("./environments.js").View} View */
/** What a picture needs beside the samples: the meaning of a fault by its number, what holds, and whether a moment of the past is shown.
 * @typedef {{ me: number, faults: Record<string, string>, holds: () => { settings: Record<string, string>, one_way_s: number, edge: number | null } | undefined, past: () => boolean }} About */

/** Each picture: what its button says, and what shows it.
 * @type {Record<string, { title: string, line: string, show: (value: Value, about: About) => View }>} */
const PICTURES = {
  delay: {
    title: "Delay",
    line: "Two hands pull. How far apart is one object in two places?",
    show: (value, { me, holds }) => delay(drawing("delay-picture"), element("delay-says"), value, me, holds),
  },
  "bad-network": {
    title: "A bad network",
    line: "The same hands, the same lost packets, three ways to couple.",
    show: (value, { me, faults }) => laws(element("lanes"), value, me, faults),
  },
  "too-stiff": {
    title: "Too stiff",
    line: "Make the coupling stiffer, until it cannot hold any more.",
    show: (value, about) => tooStiff(drawing("stiff-picture"), element("stiff-says"), value, about),
  },
};

/** Whether this environment is a picture. @param {string} name */
const isPicture = (name) => name in PICTURES;

/** The view of a picture, if it is one; the page shows its part. @param {string} name @param {Value} value @param {About} about @returns {View | undefined} */
export function story(name, value, about) {
  document.body.classList.toggle("story", isPicture(name));
  document.body.dataset.shown = isPicture(name) ? name : "workshop";
  for (const button of /** @type {Iterable<HTMLElement>} */ (/** @type {unknown} */ (element("pictures").children))) {
    const current = button.dataset.show === document.body.dataset.shown;
    if (current) button.setAttribute("aria-current", "page");
    else button.removeAttribute("aria-current");
  }
  return PICTURES[name]?.show(value, about);
}

/** The buttons of all pictures and of the workshop, which shows what it has shown last.
 * @param {(name: string) => void} show @param {() => string} last */
export function pictures(show, last) {
  const button = (/** @type {string} */ name, /** @type {string} */ title, /** @type {string} */ line) => {
    const made = document.createElement("button");
    [made.type, made.id, made.dataset.show] = ["button", `to-${name}`, name];
    const [strong, small] = ["strong", "span"].map((kind) => made.appendChild(document.createElement(kind)));
    if (strong && small) [strong.textContent, small.textContent] = [title, line];
    made.addEventListener("click", () => show(name === "workshop" ? last() : name));
    return made;
  };
  element("pictures").replaceChildren(
    ...Object.entries(PICTURES).map(([name, { title, line }]) => button(name, title, line)),
    button("workshop", "Workshop", "Everything there is to set, and your own hands."),
  );
}
