/**
 * A dialog over the screen: it takes the focus, gives it back, and Escape closes it.
 *
 * The bar above stays free, since abort, pause and stop are one press, whatever is open.
 */

import { focusNear, h } from '../core/dom.js';
import { t } from '../core/text.js';
import { clearSettled } from './notes.js';

/** Pixels between the bar, which is higher on a telephone, and a dialog. */
const BELOW_BAR = 12;

const open = [];
let count = 0;

/**
 * Open a dialog.
 * @param {string} title
 * @param {(Node|string)[]} body
 * @param {Object} options
 * @param {string} [options.name] its `data-dialog`
 * @param {function(): void} [options.closed] called once, however it was closed
 * @returns {{element: HTMLDialogElement, close: function(): void}}
 */
export function openDialog(title, body, { name = '', closed = () => {} } = {}) {
  const id = `dialog-${(count += 1)}`;
  const before = document.activeElement;
  const around = ancestors(before);
  clearSettled();
  const element = h(
    'dialog',
    { 'aria-labelledby': id, 'data-dialog': name, tabindex: -1 },
    h(
      'h2',
      { id },
      title.split(' ').flatMap((word) => [h('span', {}, word), ' ']),
    ),
    ...body,
  );
  const cover = h('div', { class: 'cover' }, element);
  cover.style.paddingTop = `${document.getElementById('top').offsetHeight + BELOW_BAR}px`;
  const close = () => element.close();
  element.addEventListener('close', () => {
    cover.remove();
    open.splice(open.indexOf(element), 1);
    letOthersBe();
    giveBack(before, around);
    closed();
  });
  element.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape') return;
    event.stopPropagation();
    close();
  });
  document.body.append(cover);
  open.push(element);
  element.show();
  letOthersBe();
  return { element, close };
}

/** Give the focus back; where the element has gone meanwhile, to what is left around it. */
function giveBack(before, around) {
  before?.focus?.({ preventScroll: true });
  if (document.activeElement !== before || before === document.body) {
    focusNear(around.find((one) => one.isConnected));
  }
}

function ancestors(element) {
  const found = [];
  for (let one = element?.parentElement; one; one = one.parentElement) found.push(one);
  return found;
}

/** Close all: another screen is shown. */
export function closeDialogs() {
  for (const element of [...open].reverse()) element.close();
}

/** Only the newest dialog takes keys and clicks, and the bar. */
function letOthersBe() {
  document.getElementById('main').inert = open.length > 0;
  open.forEach((element, index) => {
    element.inert = index < open.length - 1;
  });
}

/** The row of buttons at the end of a dialog; the one that leaves all as it is comes first. */
export function dialogButtons(close, ...others) {
  const leave = h('button', { type: 'button', onclick: close, 'data-do': 'leave' }, t('ask.leave'));
  return h('div', { class: 'dialog-buttons' }, leave, ...others);
}
