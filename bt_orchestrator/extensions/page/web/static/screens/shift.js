/** The shift in detail: why items were not good, what was done again, who made and lost what. */
import { get } from '../core/api.js';
import { newestOnly } from '../core/asking.js';
import { h, show, text } from '../core/dom.js';
import { onPerson } from '../core/me.js';
import { part, subscribe } from '../core/store.js';
import { currentLanguage, duration, number, ratio, t, tOr } from '../core/text.js';
import { stopList } from '../parts/stop_list.js';
import { table } from '../parts/table.js';

const OWNERS = ['product', 'job', 'component'];
const BY_SCRIPT = ['on_failure', 'retries', 'repeat'];
const SOON_MS = 500;
const WRITTEN = { ratio, count: number, seconds: duration };

/** Show it in a root, until the function that is returned is called. */
export function mount(root) {
  const title = h('h1', {}, t('shift.none'));
  const made = h('p', {});
  const note = h('p', { class: 'remark', role: 'status' });
  const by = h(
    'select',
    { 'aria-label': t('shift.by'), onchange: read },
    OWNERS.map((name) => h('option', { value: name }, t(`shift.by_${name}`))),
  );
  const days = h('a', { class: 'button', download: '' }, t('shift.days'));
  const parts = partTable();
  const stops = stopList();
  const causes = causeTable();
  const values = valueTable();
  const owners = h('div', { 'data-part': 'owners' });
  const panels = h(
    'div',
    {},
    made,
    panel('shift.parts', parts.element),
    panel('shift.causes', causes.element),
    panel('shift.measured', values.element),
    h(
      'section',
      { class: 'panel' },
      h('h2', {}, t('shift.figures')),
      h('div', { class: 'screen-head' }, h('label', {}, `${t('shift.by')} `, by), days),
      owners,
    ),
  );
  const element = h(
    'div',
    { class: 'screen' },
    h('div', { class: 'screen-head' }, title),
    note,
    stops.element,
    panels,
  );
  const ask = newestOnly();
  let timer = 0;

  function read() {
    days.href = `/api/shift/days.html?by=${by.value}&language=${currentLanguage()}`;
    const both = ['/api/shift', `/api/shift/by/${by.value}`];
    const fail = (refused) => say(refused.message || t('jobs.silent'));
    return ask(() => Promise.all(both.map(get)), take, fail);
  }

  function take([account, rows]) {
    text(title, t('shift.title', { name: part('shift')?.shift ?? '' }));
    text(made, yieldWords(account));
    parts.show(partRows(account));
    causes.show(account.scrap_and_rework);
    values.show(account.measured);
    owners.replaceChildren(...ownerList(rows.groups));
    say('');
  }

  function say(words) {
    text(note, words);
    show(note, Boolean(words));
    show(panels, !words);
  }

  root.append(element);
  read();
  stops.update();
  const ends = ['stops', 'reasons'].map((name) => subscribe(name, stops.update));
  ends.push(onPerson(stops.update));
  const end = subscribe('shift', () => {
    clearTimeout(timer);
    timer = setTimeout(() => element.isConnected && read(), SOON_MS);
  });
  return () => {
    clearTimeout(timer);
    end();
    ends.forEach((one) => one());
  };
}

function panel(title, ...content) {
  return h('section', { class: 'panel' }, h('h2', {}, t(title)), ...content);
}

function yieldWords({ quantities, first_pass_yield: share }) {
  const { produced, good, first_pass: passed } = quantities;
  const made = t('shift.made', { produced: number(produced), good: number(good) });
  if (passed === null || share === null) return made;
  return `${made} · ${t('shift.first_pass', { count: number(passed), share: ratio(share) })}`;
}

function partRows({ loss_parts: parts, own_fault_classes: classes }) {
  const times = Object.entries(parts).map(([name, seconds]) => ({ name, seconds, times: null }));
  const counted = ['micro_stops', 'breakdowns'].map((name) => ({ name, ...classes[name] }));
  return [...times, ...counted].filter((one) => one.seconds);
}

function partTable() {
  const columns = [
    { head: t('shift.what'), cell: (one) => t(`figure.${one.name}`) },
    { head: t('shift.times'), cell: (one) => orDash(one.times, number), isNumber: true },
    { head: t('shift.time'), cell: (one) => duration(one.seconds), isNumber: true },
  ];
  const key = (one) => one.name;
  return table({ caption: t('shift.parts'), columns, key, empty: t('shift.nothing') });
}

function causeTable() {
  const columns = [
    { head: t('shift.what'), cell: effectOf },
    { head: t('shift.why'), cell: whyOf },
    { head: t('shift.decision'), cell: decisionOf },
    { head: t('shift.times'), cell: (one) => number(one.times), isNumber: true },
  ];
  const key = (one) =>
    JSON.stringify([one.effect, one.decision, one.product, one.task, one.component, one.reason, one.bound]);
  return table({ caption: t('shift.causes'), columns, key, empty: t('shift.nothing') });
}

function effectOf({ effect, product }) {
  return [h('div', {}, t(`flaw.${effect}`)), h('div', { class: 'quiet' }, product)];
}

function decisionOf({ decision }) {
  if (BY_SCRIPT.includes(decision)) return t('shift.the_script');
  return tOr(`word.hold.${decision}`, t('shift.a_person'));
}

function whyOf({ task, component, reason, bound }) {
  const about = [task, component].filter(Boolean).join(', ');
  const why = [reason && tOr(`reason.${reason}`, reason), bound].filter(Boolean).join(': ');
  return [h('div', {}, about), why ? h('div', { class: 'quiet' }, why) : ''];
}

function valueTable() {
  const columns = [
    { head: t('shift.value'), cell: valueOf },
    { head: t('shift.times'), cell: (one) => number(one.times), isNumber: true },
    { head: t('shift.below'), cell: (one) => number(one.below), isNumber: true },
    { head: t('shift.above'), cell: (one) => number(one.above), isNumber: true },
    { head: t('shift.spread'), cell: spreadOf, isNumber: true },
  ];
  const key = (one) =>
    JSON.stringify([one.product, one.task, one.component, one.value, one.at_least, one.at_most]);
  return table({ caption: t('shift.measured'), columns, key, empty: t('shift.nothing') });
}

function valueOf({ task, value, component, product }) {
  const about = [component, product].filter(Boolean).join(', ');
  return [h('div', {}, `${task} ${value}`), h('div', { class: 'quiet' }, about)];
}

function spreadOf({ least, mean, greatest, at_least: low, at_most: high }) {
  const bounds = t('shift.bounds', { low: orDash(low, number), high: orDash(high, number) });
  const spread = [least, mean, greatest].map(number).join(' / ');
  return [h('div', {}, spread), h('div', { class: 'quiet' }, bounds)];
}

/** Make the list of the products, jobs or components, each with its figures. */
function ownerList(groups) {
  const owners = groups.map(({ name, rows }) =>
    h(
      'section',
      { class: 'owner' },
      h('h3', {}, name),
      h('dl', { class: 'owner-figures' }, rows.map(figureOf)),
    ),
  );
  return owners.length ? owners : [h('p', { class: 'nothing' }, t('shift.nothing'))];
}

function figureOf({ name, unit, together }) {
  const value = orDash(together, WRITTEN[unit]);
  return h('div', {}, h('dt', {}, t(`figure.${name}`)), h('dd', {}, value));
}

function orDash(value, write) {
  return value === null || value === undefined ? '–' : write(value);
}
