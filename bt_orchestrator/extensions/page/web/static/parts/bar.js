/** The bar of a job: what has left the line, is on it, and is to come; and how many were bad. */

import { attribute, h, text } from '../core/dom.js';
import { t } from '../core/text.js';

/** Make a bar: an element and `update(job)`. */
export function jobBar() {
  const left = h('span', { class: 'bar-left' });
  const bad = h('span', { class: 'bar-bad' });
  const onLine = h('span', { class: 'bar-on' });
  const track = h('span', { class: 'bar-track' }, left, bad, onLine);
  const words = h('span', { class: 'bar-words' });
  const badWords = h('span', { class: 'bar-bad-words' });
  const element = h(
    'div',
    { class: 'bar' },
    track,
    h('span', { class: 'bar-line' }, words, badWords),
  );
  return {
    element,
    update(job) {
      const whole = Math.max(job.quantity, 1);
      const lost = job.rejected + job.missing;
      width(left, (job.left - lost) / whole);
      width(bad, lost / whole);
      width(onLine, job.on_line / whole);
      text(words, barWords(job));
      text(badWords, badCounts(job));
      attribute(element, 'data-left', job.left);
    },
  };
}

/** Say how far a job is. */
export function barWords(job) {
  const toCome = Math.max(job.quantity - job.left - job.on_line, 0);
  return t('bar.words', { left: job.left, quantity: job.quantity, on: job.on_line, to: toCome });
}

/** Say how many items were bad; empty: none. */
export function badCounts(job) {
  const kinds = ['rejected', 'missing', 'nonconforming'].filter((kind) => job[kind]);
  return kinds.map((kind) => t(`bar.${kind}`, { count: job[kind] })).join(', ');
}

function width(element, share) {
  element.style.width = `${Math.max(0, Math.min(1, share)) * 100}%`;
}
