/** An entry of a form: label, input, what it means, and what is wrong with it. */

import { attribute, h, show, text } from '../core/dom.js';

let count = 0;

/**
 * Make it: an element, `input`, `value()`, `warn(words)`.
 * @param {string} label
 * @template {HTMLInputElement|HTMLSelectElement|HTMLTextAreaElement} T
 * @param {T} input
 * @param {string} hint
 */
export function fieldWith(label, input, hint = '') {
  const id = `entry-${(count += 1)}`;
  const explained = h('span', { class: 'hint', id: `${id}-hint` }, hint);
  const warning = h('p', {
    class: 'field-warning',
    id: `${id}-warning`,
    role: 'alert',
    hidden: true,
  });
  input.setAttribute('aria-describedby', `${id}-hint ${id}-warning`);
  return {
    element: h(
      'div',
      { class: 'field' },
      h('label', {}, h('span', {}, label), input),
      hint ? explained : null,
      warning,
    ),
    input,
    hint: explained,
    value: () => input.value.trim(),
    warn(words) {
      text(warning, words);
      show(warning, Boolean(words));
      attribute(input, 'aria-invalid', words ? 'true' : null);
    },
  };
}
