/** What something waits for: the node's page has the words of each language. */

import { said } from './text.js';

/** Say one wait. */
export function waitWords(wait) {
  return said(wait.said);
}

/** The waits that matter, or else the first of the ordinary ones: one line. */
export function foremostWait(waits) {
  return waits.find((wait) => !wait.is_ordinary) ?? waits[0] ?? null;
}
