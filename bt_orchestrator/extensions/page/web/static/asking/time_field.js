/** A moment as a field: date and time in the viewer's zone, which is named. */

import { h, text } from '../core/dom.js';
import { t, zone } from '../core/text.js';
import { fieldWith } from './entry.js';

/**
 * Make the field as `fieldWith` does; `value()` is text with the zone, or '' where none is given.
 * @param {string} label
 * @param {string} name
 * @param {?number} epoch the moment now
 */
export function timeField(label, name, epoch = null) {
  const field = fieldWith(label, h('input', { type: 'datetime-local', name, step: 60 }), '…');
  const { input, hint } = field;
  input.value = epoch ? localText(epoch) : '';
  const say = () =>
    text(hint, t('order.in_zone', { zone: zone(epochOf(input.value) ?? undefined) }));
  input.addEventListener('input', say);
  say();
  return { ...field, value: () => textOf(input.value), isWrong: () => input.validity.badInput };
}

function epochOf(local) {
  const moment = new Date(local).getTime();
  return Number.isNaN(moment) ? null : moment / 1000;
}

/** YYYY-MM-DDTHH:MM in the viewer's zone. */
function localText(epoch) {
  const moment = new Date(epoch * 1000);
  return new Date(moment.getTime() - moment.getTimezoneOffset() * 60000).toISOString().slice(0, 16);
}

/** The same with the zone's offset of that day: 2026-05-18T06:00:00+02:00. */
function textOf(local) {
  const epoch = epochOf(local);
  if (epoch === null) return '';
  const minutes = -new Date(epoch * 1000).getTimezoneOffset();
  const two = (value) => String(Math.floor(Math.abs(value))).padStart(2, '0');
  return `${localText(epoch)}:00${minutes < 0 ? '-' : '+'}${two(minutes / 60)}:${two(minutes % 60)}`;
}
