/** A button that has to be held down: by finger, mouse or key. For what cannot be taken back. */

import { h } from '../core/dom.js';

const HELD_MS = 1200;

/** A key that is still held repeats, on whatever has the focus next: it must press nothing there. */
function swallowKeys() {
  const swallow = (event) => event.repeat && event.preventDefault();
  document.addEventListener('keydown', swallow, { capture: true });
  document.addEventListener(
    'keyup',
    () => document.removeEventListener('keydown', swallow, { capture: true }),
    { once: true },
  );
}

/**
 * Make it: fires only after it was held down for the whole time.
 * @param {string} words
 * @param {string} how says that it has to be held
 * @param {function(): boolean} isReady asked before it begins: false, and nothing begins
 * @param {function(): void} done
 */
export function holdButton(words, how, isReady, done) {
  const fill = h('span', { class: 'hold-fill', 'aria-hidden': 'true' });
  const button = h(
    'button',
    { type: 'button', class: 'primary hold-button', 'data-hold-to-confirm': true },
    fill,
    h('span', { class: 'hold-words' }, words),
    h('span', { class: 'hold-how' }, how),
  );
  let timer = 0;

  function begin() {
    if (timer || button.disabled || !isReady()) return;
    button.classList.add('is-held');
    timer = setTimeout(() => {
      release();
      swallowKeys();
      done();
    }, HELD_MS);
  }

  function release() {
    clearTimeout(timer);
    timer = 0;
    button.classList.remove('is-held');
  }

  const isKey = (event) => event.key === ' ' || event.key === 'Enter';
  button.addEventListener('pointerdown', (event) => event.button === 0 && begin());
  for (const end of ['pointerup', 'pointerleave', 'pointercancel', 'blur'])
    button.addEventListener(end, release);
  button.addEventListener('keydown', (event) => {
    if (!isKey(event)) return;
    event.preventDefault();
    if (!event.repeat) begin();
  });
  button.addEventListener('keyup', (event) => isKey(event) && release());
  button.addEventListener('contextmenu', (event) => event.preventDefault());
  return button;
}
