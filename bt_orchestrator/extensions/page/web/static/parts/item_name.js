/** An item, or the empty position where one should be: a shape and its number. */

import { attribute, h, text } from '../core/dom.js';
import { t } from '../core/text.js';
import { reshape, shape } from '../core/shape.js';

/** Make it: an element and `update(item)`; null: nothing is there. A short one has no job unless `isNamed`. */
/** The job of an item, whose id is JOB/NUMBER. */
export const jobOf = (item) => item.id.slice(0, Math.max(item.id.lastIndexOf('/'), 0));

export function itemName({ isShort = false } = {}) {
  const drawn = shape('none');
  const job = h('span', { class: 'item-job one-line' });
  const number = h('span', { class: 'item-number' });
  const name = h('span', { class: 'item-id' }, job, number);
  const state = h('span', { class: 'item-state' });
  const element = h('span', { class: 'item' }, drawn, name, state);
  return {
    element,
    update(item, isNamed = !isShort) {
      const kind = kindOf(item);
      attribute(element, 'data-item', item?.id ?? '');
      attribute(element, 'data-item-kind', kind);
      attribute(
        element,
        'title',
        item ? [item.id, wordOf(kind)].filter(Boolean).join(' · ') : t('overview.empty_slot'),
      );
      reshape(drawn, SHAPES[kind]);
      const at = item?.id.lastIndexOf('/') ?? -1;
      text(job, item && isNamed ? item.id.slice(0, Math.max(at, 0)) : '');
      text(
        number,
        item
          ? item.id.slice(isNamed ? Math.max(at, 0) : at + 1)
          : isShort
            ? ''
            : t('overview.empty_slot'),
      );
      text(state, isShort ? '' : wordOf(kind));
    },
  };
}

const SHAPES = {
  none: 'none',
  good: 'item',
  missing: 'hollow',
  rejected: 'cross',
  nonconforming: 'triangle',
};

function kindOf(item) {
  if (!item) return 'none';
  if (!item.present) return 'missing';
  if (item.rejected) return 'rejected';
  return item.nonconforming.length ? 'nonconforming' : 'good';
}

function wordOf(kind) {
  return kind === 'none' || kind === 'good' ? '' : t(`item_state.${kind}`);
}
