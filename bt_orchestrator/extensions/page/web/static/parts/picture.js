/** The drawing of the line, live: fetched when the line changed, at most once a second. */
import { h } from '../core/dom.js';
import { currentLanguage, t } from '../core/text.js';
import { PanZoom } from './pan_zoom.js';

const PAUSE_MS = 1000;

/**
 * @param {function(string): void} onPick is told the name of the part that was clicked
 * @returns {Picture}
 */
export function picture(onPick) {
  return new Picture(onPick);
}

class Picture {
  constructor(onPick) {
    this.room = h('div', {
      class: 'picture-room',
      tabindex: 0,
      role: 'group',
      'aria-label': t('why.picture'),
      'aria-describedby': 'picture-help',
      onclick: (event) => {
        const part = event.target.closest('[data-part]');
        if (part) onPick(part.dataset.part);
      },
    });
    this.panZoom = new PanZoom(this.room);
    this.element = h('div', { class: 'picture' }, this.#buttons(), this.room, help());
    this.parts = new Map(); // name: {element, source}
    this.marked = { way: [], root: '' };
    this.start = '';
    this.onShown = () => !document.hidden && this.show(this.digest);
    document.addEventListener('visibilitychange', this.onShown);
    this.onResized = () => {
      this.panZoom.resized(this.#start());
      this.onShown(); // a telephone that is turned has room for it
    };
    addEventListener('resize', this.onResized);
  }

  #buttons() {
    const button = (word, sign, does) =>
      h(
        'button',
        { type: 'button', class: 'tool', 'aria-label': t(word), title: t(word), onclick: does },
        sign,
      );
    return h(
      'div',
      { class: 'picture-tools' },
      button('why.closer', '+', () => this.panZoom.zoom(1.4)),
      button('why.further', '−', () => this.panZoom.zoom(1 / 1.4)),
      button('why.whole', '⤢', () => this.panZoom.whole()),
    );
  }

  show(digest) {
    this.digest = digest;
    if (!digest || document.hidden || !this.room.checkVisibility() || this.timer) {
      this.isWanted = true;
      return;
    }
    this.isWanted = false;
    this.timer = setTimeout(() => {
      this.timer = null;
      if (this.isWanted) this.show(this.digest);
    }, PAUSE_MS);
    this.#fetch(digest);
  }

  mark(way, root) {
    this.marked = { way, root };
    for (const [name, { element }] of this.parts) {
      element.classList.toggle('is-on-way', way.includes(name));
      element.classList.toggle('is-root', name === root);
    }
  }

  /** Name the part that a picture begins with, if there is no room for the whole of it. */
  beginAt(name) {
    this.start = name;
  }

  lookAt(name) {
    const part = this.parts.get(name);
    if (part) this.panZoom.lookAt(part.element);
  }

  end() {
    clearTimeout(this.timer);
    document.removeEventListener('visibilitychange', this.onShown);
    removeEventListener('resize', this.onResized);
  }

  async #fetch(digest) {
    const address = `/api/drawing/${digest}.svg?live=1&bare=1&language=${currentLanguage()}`;
    const answer = await fetch(address).catch(() => null);
    if (!answer?.ok || digest !== this.digest) return; // the top bar says that the page is silent
    const source = new DOMParser().parseFromString(await answer.text(), 'image/svg+xml');
    this.#take(document.importNode(source.documentElement, true));
  }

  /** Put a newer drawing in place of this one; parts that did not change stay. */
  #take(svg) {
    const fresh = new Map(
      [...svg.querySelectorAll(':scope > g > g[id]')].map((one) => [one.id, one]),
    );
    const isSame =
      this.size === svg.getAttribute('viewBox') &&
      fresh.size === this.parts.size &&
      [...fresh.keys()].every((name) => this.parts.has(name));
    this.size = svg.getAttribute('viewBox');
    for (const [name, element] of fresh) {
      const source = new XMLSerializer().serializeToString(element);
      const before = this.parts.get(name);
      if (isSame && before.source === source) continue;
      if (isSame) before.element.replaceWith(element);
      this.parts.set(name, { element, source });
      element.dataset.part = name;
      element.removeAttribute('id'); // the page has others of the same name
    }
    if (!isSame) this.#begin(svg, fresh);
    this.mark(this.marked.way, this.marked.root);
  }

  #begin(svg, fresh) {
    for (const name of this.parts.keys()) if (!fresh.has(name)) this.parts.delete(name);
    for (const one of svg.querySelectorAll('[id]')) one.removeAttribute('id');
    svg.removeAttribute('width');
    svg.removeAttribute('height');
    this.room.replaceChildren(svg);
    this.panZoom.show(svg, this.#start());
  }

  #start() {
    return this.parts.get(this.start)?.element;
  }
}

function help() {
  return h('p', { class: 'help', id: 'picture-help' }, t('why.picture_help'));
}
