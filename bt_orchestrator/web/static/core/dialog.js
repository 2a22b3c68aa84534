/** A dialog over the page: it takes the focus, gives it back, and Escape closes it. */

import { h } from './dom.js';
import { t } from './text.js';

let count = 0;

/**
 * Open a dialog.
 * @param {string} title
 * @param {Element[]} body
 * @param {Object} options
 * @param {string} [options.name] its `data-dialog`
 * @param {function(): void} [options.closed] called once, however it was closed
 * @returns {{element: HTMLDialogElement, close: function(): void}}
 */
export function openDialog(title, body, { name = '', closed = () => {} } = {}) {
  const id = `dialog-${(count += 1)}`;
  const element = h(
    'dialog',
    { 'aria-labelledby': id, 'data-dialog': name },
    h('h2', { id }, title),
    ...body,
  );
  element.addEventListener('close', () => {
    element.remove();
    closed();
  });
  document.body.append(element);
  element.showModal();
  return { element, close: () => element.close() };
}

/** The row of buttons at the end of a dialog; the one that leaves all as it is comes first. */
export function dialogButtons(close, ...others) {
  const leave = h('button', { type: 'button', onclick: close, 'data-do': 'leave' }, t('ask.leave'));
  return h('div', { class: 'dialog-buttons' }, leave, ...others);
}
