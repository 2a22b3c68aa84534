/** The mark of a task: a shape and a word. The marks are those of the drawing. */

import { attribute, h, text } from '../core/dom.js';
import { t } from '../core/text.js';
import { reshape, shape } from '../core/shape.js';

const SHAPES = {
  new: 'none',
  waiting: 'dots',
  running: 'play',
  held: 'triangle',
  done: 'check',
  marked_done: 'check',
  skipped: 'skip',
  continued: 'cross',
  rejected: 'cross',
  failed: 'again',
  aborted: 'cross',
};

/** Make a mark: an element and `update(mark)`. */
export function mark() {
  const drawn = shape('none');
  const word = h('span', { class: 'mark-word' });
  const element = h('span', { class: 'mark' }, drawn, word);
  return {
    element,
    update(name) {
      attribute(element, 'data-mark', name);
      reshape(drawn, SHAPES[name] ?? 'none');
      text(word, t(`mark.${name}`));
    },
  };
}
