/** The stops of the shift one by one, each with its reason, and the time of each reason. */

import { ask } from '../asking/ask.js';
import { hasReasons, reasonWords } from '../asking/code_field.js';
import { h, show, text } from '../core/dom.js';
import { may, who } from '../core/me.js';
import { wordOf } from '../core/requests.js';
import { part } from '../core/store.js';
import { about, duration, number, ratio, t } from '../core/text.js';
import { table } from './table.js';

/** Make both lists: an element and `update()`. */
export function stopList() {
  const stops = stopTable();
  const reasons = reasonTable();
  const note = h('p', { class: 'remark', role: 'status' });
  const element = h(
    'div',
    { class: 'screen stops' },
    note,
    h('section', { class: 'panel' }, h('h2', {}, t('shift.stops_of')), stops.element),
    h('section', { class: 'panel' }, h('h2', {}, t('shift.by_reason')), reasons.element),
  );
  return {
    element,
    update() {
      const known = part('stops');
      show(element, known);
      if (!known) return;
      const open = known.not_classified;
      const said = [
        open ? `${t('shift.share_open', { share: ratio(open) })}.` : '',
        known.is_cut ? t('shift.longest', { count: number(known.stops.length) }) : '',
        hasReasons() ? '' : t('shift.no_file'),
      ];
      text(note, said.filter(Boolean).join(' '));
      show(note, note.textContent);
      stops.show(known.stops.map((one) => ({ ...one, offer: known.offer, person: who().name })));
      reasons.show(known.reasons);
    },
  };
}

function stopTable() {
  const columns = [
    { head: t('shift.stop_from'), cell: (one) => about(one.begin) },
    { head: t('shift.stop_to'), cell: (one) => endOf(one) },
    { head: t('shift.stop_lost'), cell: (one) => lostOf(one), isNumber: true },
    { head: t('shift.stop_why'), cell: whyOf },
    { head: t('shift.stop_reason'), cell: (one) => [...reasonOf(one), buttonOf(one)] },
  ];
  const caption = t('shift.stops_of');
  return table({ caption, columns, key: (one) => one.stop, empty: t('shift.no_stops') });
}

function endOf({ end }) {
  return end === null ? t('shift.stop_stands') : about(end);
}

function lostOf({ seconds }) {
  return seconds === null ? '' : duration(seconds);
}

function whyOf({ loss, detail, component }) {
  const more = detail.includes(component) ? detail : `${component}, ${detail}`;
  return [h('div', {}, t(`loss.${loss}`)), more ? h('div', { class: 'quiet' }, more) : ''];
}

function reasonOf({ code, by, why }) {
  if (!code) return [h('div', { class: 'not-classified' }, t('shift.not_classified'))];
  const said = [by, why].filter(Boolean).join(': ');
  return [h('div', { 'data-code': code }, reasonWords(code)), said ? small(said) : ''];
}

function small(words) {
  return h('div', { class: 'quiet' }, words);
}

function buttonOf({ stop, offer, begin, loss }) {
  if (!hasReasons()) return '';
  const subject = `${t(`loss.${loss}`)}, ${about(begin)}`;
  const press = () => ask(offer, { about: subject, values: { stop } });
  const isMine = !who().name || may(offer.name);
  const look = { type: 'button', onclick: press, 'data-offer': offer.name, 'data-stop': stop };
  return h('button', { ...look, 'data-locked': isMine ? null : 'true' }, wordOf(offer));
}

function reasonTable() {
  const columns = [
    { head: t('shift.stop_reason'), cell: nameOf },
    { head: t('shift.stop_times'), cell: (one) => number(one.times), isNumber: true },
    { head: t('shift.stop_lost'), cell: (one) => duration(one.seconds), isNumber: true },
  ];
  const caption = t('shift.by_reason');
  return table({ caption, columns, key: (one) => one.code ?? '', empty: t('shift.no_stops') });
}

function nameOf({ code }) {
  return code ? reasonWords(code) : t('shift.not_classified');
}
