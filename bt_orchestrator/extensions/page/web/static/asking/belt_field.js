/** What stands on the belt, slot by slot: for `clear`. It begins with what the page shows. */

import { h, text } from '../core/dom.js';
import { part, partsOf } from '../core/store.js';
import { t } from '../core/text.js';

const EMPTY = 'empty';

/** Make the field. Untouched it says nothing: then the belt is as the offer shows it. */
export function beltField() {
  const slots = part('cell').sections.map((number) => {
    const shown = shownAs(part(`section/${number}`)?.slot);
    return { number, shown, select: selectOf(shown) };
  });
  const rows = slots.map(({ number, select }) =>
    h('label', { class: 'belt-row' }, h('span', {}, t('part.section', { number })), whole(select)),
  );
  const element = h(
    'fieldset',
    { class: 'field belt-field', 'data-field': 'belt' },
    h('legend', {}, t('ask.belt')),
    h('p', { class: 'quiet' }, t('ask.belt_hint')),
    h('div', { class: 'belt-rows' }, rows),
  );
  return { element, read: () => ({ value: statement(slots) }), warn: () => {} };
}

function statement(slots) {
  if (slots.every(({ shown, select }) => select.value === shown)) return undefined;
  const belt = slots.map(({ number, select }) => `${number}=${select.value}`);
  return { instead: { belt, as_shown: undefined } };
}

function shownAs(slot) {
  return slot?.present ? slot.id : EMPTY;
}

function selectOf(shown) {
  const names = new Set([shown, EMPTY, ...itemsOnTheLine()]);
  return h(
    'select',
    {},
    [...names].map((name) =>
      h(
        'option',
        { value: name, selected: name === shown },
        name === EMPTY ? t('overview.empty_slot') : name,
      ),
    ),
  );
}

/** A select cuts what is too long, and the end of an item's id counts: its words stand around it. */
function whole(select) {
  const words = h('span', { class: 'choice-words', 'aria-hidden': 'true' });
  const say = () => text(words, select.selectedOptions[0].text);
  select.addEventListener('change', say);
  say();
  return h('span', { class: 'choice' }, words, select);
}

function itemsOnTheLine() {
  const items = partsOf('section/').flatMap(([, { slot, item }]) => [slot, item]);
  return new Set(items.filter(Boolean).map((item) => item.id));
}
