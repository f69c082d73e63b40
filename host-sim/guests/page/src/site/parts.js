// @ts-check
// Parts of the page by their names, and texts that are written only where they change: what is written though nothing changed is work for a
// browser whose page is at rest.

/** @param {string} id @returns {HTMLElement} */
export const element = (id) => {
  const found = document.getElementById(id);
  if (!found) throw new Error(`no #${id}`);
  return found;
};
export const input = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (element(id));
export const choice = (/** @type {string} */ id) => /** @type {HTMLSelectElement} */ (element(id));
export const drawing = (/** @type {string} */ id) => /** @type {SVGSVGElement} */ (/** @type {unknown} */ (element(id)));

/** A number as it is read: what rounds to nothing has no sign, which would come and go at rest, and what is huge no decimals.
 * @param {number} number @param {number} digits */
export const text = (number, digits) =>
  Number.isFinite(number) ? number.toFixed(Math.abs(number) < 1e4 ? digits : 0).replace(/^-(?=[0.]*$)/, "") : "–";

/** @param {Element} to @param {string} text */
export const write = (to, text) => {
  if (to.textContent !== text) to.textContent = text;
};
