/** The belt: its slots in the direction of travel, what stands in each, and whether it moves. */

import { attribute, h, keyed, text } from '../core/dom.js';
import { part, shownMoment } from '../core/store.js';
import { said, seconds, t } from '../core/text.js';
import { itemName, jobOf } from './item_name.js';
import { reshape, shape } from '../core/shape.js';

/** So many slots need more than one row. */
const MANY = 20;

/** Make the strip: an element, `update()`, `tick()`. */
export function beltStrip() {
  const drawn = shape('quiet');
  const word = h('strong', { class: 'belt-word' });
  const why = h('span', { class: 'belt-why one-line' });
  const list = h('ol', { class: 'slots' });
  const slots = keyed(list, ({ section }) => section.number, slotView);
  const element = h(
    'section',
    { class: 'belt panel', 'data-part': 'belt', 'aria-label': t('part.belt') },
    h('p', { class: 'belt-line' }, drawn, word, why),
    list,
  );

  function tick() {
    const belt = part('belt');
    if (belt) text(word, beltWords(belt));
  }

  return {
    element,
    tick,
    update() {
      const belt = part('belt');
      const sections = (part('cell')?.sections ?? [])
        .map((number) => part(`section/${number}`))
        .filter(Boolean);
      const jobs = new Set(sections.filter(({ slot }) => slot).map(({ slot }) => jobOf(slot)));
      slots(sections.map((section) => ({ section, isNamed: jobs.size > 1 })));
      attribute(list, 'data-many', sections.length > MANY);
      attribute(list, 'data-jobs', jobs.size > 1);
      if (!belt) return;
      const wait = belt.moving ? null : belt.waits[0];
      attribute(element, 'data-moving', belt.moving);
      reshape(drawn, shapeOf(belt));
      attribute(why, 'data-ordinary', wait?.is_ordinary ?? true);
      text(why, wait ? said(wait.said) : '');
      tick();
    },
  };
}

/** A move whose goal is gone, cancelled for instance, has left the belt somewhere. */
function isBetween(belt) {
  return belt.moving && !belt.running.length;
}

function shapeOf(belt) {
  if (isBetween(belt)) return 'dots';
  return belt.moving ? 'play' : 'quiet';
}

function beltWords(belt) {
  if (isBetween(belt)) return t('overview.belt_between');
  if (!belt.moving) return t('overview.belt_rests');
  const move = belt.running[0];
  return move?.started
    ? t('overview.belt_moves_since', { elapsed: seconds(shownMoment() - move.started) })
    : t('overview.belt_moves');
}

function slotView() {
  const number = h('span', { class: 'slot-number' });
  const item = itemName({ isShort: true });
  const more = h('span', { class: 'for-readers' });
  const link = h('a', { class: 'slot-link' }, number, item.element, more);
  const element = h('li', { class: 'slot' }, link);
  return {
    element,
    update({ section, isNamed }) {
      attribute(element, 'data-slot', section.number);
      attribute(element, 'data-held', section.holds.length > 0);
      attribute(link, 'href', `#/section/${section.number}`);
      text(more, slotWords(section));
      text(number, section.number);
      item.update(section.slot, isNamed);
    },
  };
}

function slotWords({ number, slot, holds }) {
  const where = t('part.section', { number });
  const held = holds.length ? t('mark.held') : '';
  const empty = slot?.present === false ? t('item_state.missing') : '';
  return [where, slot?.id ?? t('overview.empty_slot'), empty, held].filter(Boolean).join(', ');
}
