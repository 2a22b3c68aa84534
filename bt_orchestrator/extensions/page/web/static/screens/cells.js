/** The cells of the plant: how each stands, how old that is, and the way to its page. */
import { get } from '../core/api.js';
import { repeat } from '../core/asking.js';
import { h, show, text } from '../core/dom.js';
import { at, duration, number, t, tOr } from '../core/text.js';
import { table } from '../parts/table.js';

const PAUSE_MS = 5000;

/** Show it in a root, until the function that is returned is called. */
export function mount(root) {
  const screen = new Cells();
  root.append(screen.element);
  return () => screen.end();
}

class Cells {
  constructor() {
    this.table = table({
      caption: t('cells.title'),
      key: (cell) => cell.name,
      empty: t('cells.none'),
      columns: [
        { head: t('cells.cell'), cell: nameOf },
        { head: t('cells.state'), cell: stateOf },
        { head: t('cells.since'), cell: (cell) => momentOf(cell.state_since) },
        { head: t('cells.last'), cell: (cell) => momentOf(cell.last_event) },
        { head: t('cells.age'), cell: ageOf, isNumber: true },
      ],
    });
    this.note = h('p', { class: 'nothing', role: 'status' }, t('cells.asking'));
    this.panel = h('section', { class: 'panel', hidden: true }, this.table.element);
    this.element = h(
      'div',
      { class: 'screen' },
      h('div', { class: 'screen-head' }, h('h1', {}, t('cells.title'))),
      h('p', { class: 'help' }, t('cells.help')),
      this.note,
      this.panel,
    );
    this.end = repeat(() => this.#ask(), PAUSE_MS);
  }

  async #ask() {
    try {
      const { cells, has_plant } = await get('/api/cells');
      this.table.show(cells);
      show(this.panel, has_plant);
      this.#say(has_plant ? '' : t('cells.no_plant'));
    } catch (refused) {
      this.#say(refused.message || t('cells.silent'));
    }
  }

  #say(words) {
    text(this.note, words);
    show(this.note, Boolean(words));
  }
}

function nameOf({ name, page }) {
  return page ? h('a', { href: page }, name) : name;
}

function stateOf({ state, stop_reason }) {
  const word = state ? tOr(`state.${state}`, state) : t('cells.unknown');
  return stop_reason ? `${word}: ${tOr(`stop_reason.${stop_reason}`, stop_reason)}` : word;
}

const momentOf = (epoch) => (epoch === null ? '' : at(epoch));

function ageOf({ behind_s, gaps }) {
  const age = behind_s === null ? t('cells.never') : duration(behind_s);
  return gaps ? `${age}, ${t('cells.gaps', { count: number(gaps) })}` : age;
}
