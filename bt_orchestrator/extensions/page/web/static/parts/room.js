/** Words in a room of so many lines, so that nothing below moves. Hover, tap or Tab shows all of them. */

import { attribute, h, text } from '../core/dom.js';
import { everySecond } from '../core/tick.js';

/** Make it: an element and `say(words)`. */
export function room(className) {
  const words = h('span', { class: 'room-words' });
  const element = h('p', { class: `room ${className}` }, words);

  function judge() {
    const isCut = words.scrollHeight > element.clientHeight + 2;
    attribute(element, 'data-cut', isCut);
    attribute(element, 'tabindex', isCut ? 0 : null);
  }

  everySecond(element, judge);
  return {
    element,
    say(said) {
      if (words.textContent === said) return;
      text(words, said);
      judge();
    },
  };
}
