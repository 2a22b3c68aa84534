/** The record of an item told as a story: what happened to it, in order of time. */
import { h } from '../core/dom.js';
import { at, duration, person, quoted, said, seconds, t, tOr } from '../core/text.js';
import { againWords } from './again.js';
import { componentLink, sectionLink } from './links.js';
import { shape } from '../core/shape.js';
import { skipWords } from './task_words.js';
import { values } from './values.js';

const SHAPES = {
  succeeded: 'check',
  failed: 'cross',
  running: 'play',
  skipped: 'skip',
  marked_done: 'check',
  continued: 'cross',
};

/** The story of an item as a list; `record` is the answer of /api/items/ID. */
export function story(record) {
  const entries = entriesOf(record);
  const before = pauses(entries);
  const list = entries.map((entry, place) => told(entry, before[place]));
  return h('ol', { class: 'story', 'aria-label': t('item.story') }, list);
}

/** Everything that happened, oldest first: {time, kind, …}. */
export function entriesOf({ started, ended, how, tasks, holds, decisions }) {
  const entries = [
    ...tasks.map((one) => ({ ...one, time: one.started ?? one.ended, kind: 'task' })),
    ...decisions.map((one) => ({ ...one, kind: 'decision' })),
    ...holds.map((one) => ({ ...one, kind: 'held' })),
  ];
  if (started !== null) entries.push({ time: started, kind: 'begun' });
  if (ended !== null) entries.push({ time: ended, kind: 'ended', how });
  return entries.sort((one, other) => one.time - other.time || rankOf(one) - rankOf(other));
}

/** What comes first of a moment: a task that needed no time, what it led to, and what followed. */
function rankOf({ kind, outcome, started }) {
  if (kind === 'task' && outcome === 'failed' && started === null) return 0;
  return ['begun', 'held', 'decision', 'task', 'ended'].indexOf(kind);
}

/** How long nothing had happened before each entry: seconds, or null where it is not worth a word. */
function pauses(entries) {
  let end = null;
  return entries.map(({ time, ended }) => {
    const pause = end === null ? 0 : time - end;
    end = Math.max(end ?? 0, ended ?? time);
    return pause >= 1 ? pause : null;
  });
}

function told(entry, pause) {
  return h(
    'li',
    { class: 'told', 'data-kind': entry.kind, 'data-outcome': entry.outcome ?? entry.how ?? null },
    h('time', { datetime: new Date(entry.time * 1000).toISOString() }, at(entry.time)),
    h(
      'span',
      { class: 'told-pause' },
      pause === null ? '' : t('item.after', { time: duration(pause) }),
    ),
    h('div', { class: 'told-what' }, TOLD[entry.kind](entry)),
  );
}

const TOLD = {
  begun: () => h('p', {}, t('item.begun')),
  task,
  // why a task is held stands at its attempt already
  held: ({ id, task: held, words }) =>
    h('p', {}, shape('triangle'), ' ', t('item.held', { hold: id }), held ? '' : ` (${words})`),
  decision: ({ who, what, reason }) => [
    h(
      'p',
      {},
      shape('square'),
      ' ',
      t('item.decided', { who: who ? person(who) : t('item.somebody'), what: decisionWord(what) }),
    ),
    reason ? h('p', { class: 'quote' }, reason) : null,
  ],
  ended: ({ how }) => h('p', {}, h('strong', {}, t(`item.is_${how || 'on_line'}`))),
};

/** The word of the button that was pressed. */
function decisionWord(what) {
  return tOr(`word.hold.${what}`, tOr(`word.item.${what}`, what));
}

function task(entry) {
  const { section, task: id, name, component, outcome } = entry;
  const again = againWords(entry);
  const where = section ? sectionLink(section) : null;
  const by = component ? [' · ', componentLink(component)] : null;
  return [
    h(
      'p',
      {},
      where,
      ' · ',
      h('strong', {}, id),
      name && name !== id ? ` ${name}` : '',
      by,
      again ? ` · ${again}` : '',
    ),
    h('p', { class: 'outcome' }, shape(SHAPES[outcome] ?? 'dots'), ' ', outcomeWords(entry)),
    details('item.args', entry.args),
    details('item.results', entry.results),
  ];
}

function outcomeWords({ outcome, seconds: took, reason, said: message }) {
  if (outcome === 'continued') return t(`item.policy_${reason}`);
  const word = t(`item.outcome_${outcome}`, { took: took === null ? '' : seconds(took) });
  const why = [reason && reasonWords(outcome, reason), said(message) && quoted(said(message))]
    .filter(Boolean)
    .join(' ');
  return why ? `${word}: ${why}` : word;
}

function reasonWords(outcome, reason) {
  if (outcome === 'skipped') return skipWords(reason);
  return tOr(`reason.${reason}`, reason);
}

function details(word, mapping) {
  if (!mapping || !Object.keys(mapping).length) return null;
  return h('details', {}, h('summary', {}, t(word)), values(mapping));
}
