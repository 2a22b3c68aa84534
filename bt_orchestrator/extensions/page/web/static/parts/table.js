/**
 * Tables whose rows belong to things: a row that stays keeps its elements, and so the focus. On a
 * telephone each row is a card, in which every value stands beside its head (`screens.css`).
 */
import { h, keyed, show } from '../core/dom.js';

/**
 * @param {Object} about
 * @param {string} about.caption what it lists; screen readers say it,
 * @param {Array<{head: string, cell: function(*): *, isNumber?: boolean}>} about.columns
 * @param {function(*): (string|number)} about.key of a thing
 * @param {string} about.empty said where there are no rows
 * @param {boolean} [about.isCaptionShown]
 * @returns {{element: Element, show: function(Array): void}}
 */
export function table({ caption, columns, key, empty, isCaptionShown = false }) {
  const body = h('tbody', { role: 'rowgroup' });
  const nothing = h('p', { class: 'nothing' }, empty);
  const look = (column) => (column.isNumber ? 'number' : null);
  const heads = columns.map((one) =>
    h('th', { scope: 'col', role: 'columnheader', class: look(one) }, one.head),
  );
  const whole = h(
    'div',
    // what scrolls has to be reached by keys
    { class: 'table-room', tabindex: 0, role: 'region', 'aria-label': caption },
    h(
      'table',
      { class: 'things', role: 'table' },
      h('caption', { class: isCaptionShown ? null : 'for-readers' }, caption),
      h('thead', { role: 'rowgroup' }, h('tr', { role: 'row' }, heads)),
      body,
    ),
  );
  const fill = keyed(body, key, () => makeRow(columns, look));
  return {
    element: h('div', {}, whole, nothing),
    show(things) {
      fill(things);
      show(whole, things.length > 0);
      show(nothing, things.length === 0);
    },
  };
}

function makeRow(columns, look) {
  const cells = columns.map((one, place) =>
    place
      ? h('td', { role: 'cell', class: look(one), 'data-head': one.head })
      : h('th', { scope: 'row', role: 'rowheader', class: look(one) }),
  );
  let before = '';
  return {
    element: h('tr', { role: 'row' }, cells),
    update(thing) {
      const now = JSON.stringify(thing);
      if (now === before) return;
      before = now;
      cells.forEach((cell, place) =>
        cell.replaceChildren(...[columns[place].cell(thing) ?? ''].flat()),
      );
    },
  };
}
