/** The list of alarms: what waited for people, the last first, and which came most. */
import { get } from '../core/api.js';
import { newestOnly } from '../core/asking.js';
import { h, show, text } from '../core/dom.js';
import { subscribe } from '../core/store.js';
import { at, duration, number, said, t, tOr } from '../core/text.js';
import { itemLink, jobLink } from '../parts/links.js';
import { table } from '../parts/table.js';

const KINDS = ['hold', 'emergency', 'contest', 'silent', 'refused'];

/** Show it in a root, until the function that is returned is called. */
export function mount(root) {
  const list = alarmTable();
  const often = countTable();
  const note = h('p', { class: 'remark', role: 'status' });
  const kind = h(
    'select',
    { 'aria-label': t('alarms.kind'), onchange: read },
    h('option', { value: '' }, t('alarms.all')),
    KINDS.map((name) => h('option', { value: name }, t(`alarms.is_${name}`))),
  );
  const open = h('input', { type: 'checkbox', onchange: read });
  const element = h(
    'div',
    { class: 'screen' },
    h('div', { class: 'screen-head' }, h('h1', {}, t('alarms.title'))),
    h(
      'div',
      { class: 'screen-head' },
      h('label', {}, `${t('alarms.kind')} `, kind),
      h('label', {}, open, ` ${t('alarms.open')}`),
    ),
    note,
    h('section', { class: 'panel' }, list.element),
    h('section', { class: 'panel' }, h('h2', {}, t('alarms.often')), often.element),
  );
  const ask = newestOnly();
  let timer = 0;

  function read() {
    const query = new URLSearchParams({ kind: kind.value, open: open.checked ? '1' : '' });
    const fail = (refused) => say(refused.message || t('jobs.silent'));
    return ask(() => get(`/api/alarms?${query}`), take, fail);
  }

  function take(page) {
    const lacks = page.is_whole ? '' : t('jobs.not_whole', { why: page.why_not });
    say([page.is_cut ? t('alarms.cut') : '', lacks].filter(Boolean).join(' '));
    list.show(page.alarms);
    often.show(page.counts);
  }

  function say(words) {
    text(note, words);
    show(note, Boolean(words));
  }

  root.append(element);
  read();
  const end = subscribe('cell', () => {
    clearTimeout(timer);
    timer = setTimeout(() => element.isConnected && read(), 500);
  });
  return () => {
    clearTimeout(timer);
    end();
  };
}

function alarmTable() {
  const columns = [
    { head: t('alarms.raised'), cell: (one) => at(one.raised) },
    { head: t('alarms.what'), cell: whatOf },
    { head: t('alarms.where'), cell: whereOf },
    { head: t('alarms.acknowledged'), cell: (one) => by(one.acknowledged, one.acknowledged_by) },
    { head: t('alarms.answered'), cell: answerOf },
    { head: t('alarms.cleared'), cell: (one) => at(one.cleared) || t('alarms.stands') },
    { head: t('alarms.lasted'), cell: (one) => duration(one.seconds), isNumber: true },
  ];
  const key = (one) => `${one.kind} ${one.key} ${one.raised}`;
  return table({ caption: t('alarms.title'), columns, key, empty: t('alarms.none') });
}

function countTable() {
  const columns = [
    { head: t('alarms.what'), cell: (one) => h('span', {}, countWords(one)) },
    { head: t('alarms.times'), cell: (one) => number(one.times), isNumber: true },
  ];
  const key = (one) => `${one.kind} ${one.about} ${one.reason}`;
  return table({ caption: t('alarms.often'), columns, key, empty: t('alarms.none') });
}

function countWords({ kind, about, reason }) {
  const why = reason && tOr(`reason.${reason}`, reason);
  return [t(`alarms.is_${kind}`), about, why].filter(Boolean).join(', ');
}

function whatOf({ kind, key, reason, said: message, controller_said: words, count }) {
  const name = kind === 'refused' ? [key, count > 1 ? `× ${number(count)}` : ''] : [];
  const why = reason ? tOr(`reason.${reason}`, reason) : '';
  const controller = words && t('reason.controller_says', { words });
  const head = [t(`alarms.is_${kind}`), ...name, why].filter(Boolean).join(', ');
  const more = [controller, said(message)].filter(Boolean).join('; ');
  return [h('div', {}, head), more ? h('div', { class: 'quiet' }, more) : ''];
}

function whereOf({ component, section, item, task, job }) {
  const place = section === null ? '' : t('part.section', { number: section });
  const words = [component, place, task].filter(Boolean).join(', ');
  const thing = item ? itemLink(item) : job ? jobLink(job) : '';
  return [h('div', {}, words), thing];
}

function answerOf({ kind, answered, answer, who, why, remarks }) {
  if (kind === 'refused') return who;
  const word = answer ? tOr(`word.hold.${answer}`, answer) : '';
  const said = [word, by(answered, who)].filter(Boolean).join(' ');
  const notes = [why, ...remarks].filter(Boolean);
  return [
    ...(said ? [h('div', {}, said)] : []),
    ...notes.map((one) => h('div', { class: 'quiet' }, one)),
  ];
}

function by(time, who) {
  return time === null ? '' : t('alarms.by', { who: who ?? '', time: at(time) });
}
