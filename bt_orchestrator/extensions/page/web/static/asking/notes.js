/** What became of commands: small notes that readers of the screen are told too. */

import { attribute, h, text } from '../core/dom.js';
import { t } from '../core/text.js';

const STAY_MS = 6000;

/**
 * Show a note.
 * @param {'accepted'|'told'|'refused'|'unknown'} kind accepted ones go by themselves; they and what
 *   somebody else did go when something else is asked
 * @param {string} words
 * @returns {function(string, string): void} says something else in its place
 */
export function note(kind, words) {
  const said = h('span', { class: 'note-words' });
  const close = () => element.remove();
  const element = h(
    'div',
    { class: 'note' },
    said,
    h(
      'button',
      { type: 'button', class: 'quiet-button', onclick: close, 'data-do': 'close-note' },
      t('ask.close'),
    ),
  );
  let timer = 0;

  function say(nowKind, nowWords) {
    clearTimeout(timer);
    attribute(element, 'data-note', nowKind);
    text(said, nowWords);
    if (nowKind === 'accepted') timer = setTimeout(close, STAY_MS);
  }

  say(kind, words);
  document.getElementById('notes').append(element);
  return say;
}

/** Take away what is settled: it must not lie over what is asked next. */
export function clearSettled() {
  const settled = document.querySelectorAll('[data-note="accepted"], [data-note="told"]');
  for (const element of settled) element.remove();
}
