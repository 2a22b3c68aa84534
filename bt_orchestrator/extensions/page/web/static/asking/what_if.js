/** What would become of every job: asked before a command is sent, shown as a table. */

import { Refused, post } from '../core/api.js';
import { children, h } from '../core/dom.js';
import { withButtons } from '../core/requests.js';
import { whyItStands } from '../core/stands.js';
import { part } from '../core/store.js';
import { about, duration, said, t } from '../core/text.js';
import { shape } from '../core/shape.js';

const WITHIN_MS = 75000;
const WAIT_MS = 400;
const UNCHANGED = ['same', 'never'];
/** Jobs that end as before are folded away where there are more of them. */
const FEW = 8;

/**
 * Make the table of a command: an element, `ask(values)`, `end()`.
 * @param {{name: string, arguments: Object}} command as its offer says
 */
export function whatIf(command) {
  const element = h('section', {
    class: 'what-if',
    'aria-live': 'polite',
    'aria-label': t('whatif.title'),
  });
  let turn = 0;
  let timer = 0;
  let asking = new AbortController();

  /** Ask what these values would lead to; null: some are missing still. */
  function ask(values) {
    const mine = forget();
    if (values === null) return say('missing', t('whatif.missing'));
    const wait = turn === 1 ? 0 : WAIT_MS;
    timer = setTimeout(() => compute(mine, values), wait);
    return say('computing', t('whatif.computing'));
  }

  /** Nobody waits for what was asked before: the page need not compute it. */
  function forget() {
    clearTimeout(timer);
    asking.abort();
    asking = new AbortController();
    return (turn += 1);
  }

  async function compute(mine, values) {
    const commands = [{ name: command.name, arguments: { ...command.arguments, ...values } }];
    try {
      const found = await post('/api/what-if', { commands }, WITHIN_MS, asking.signal);
      if (mine === turn) show(found);
    } catch (refused) {
      if (!(refused instanceof Refused)) throw refused;
      if (mine === turn)
        say('unknown', t('whatif.cannot', { why: refused.message || t('whatif.no_answer') }));
    }
  }

  function say(kind, words) {
    element.dataset.whatIf = kind;
    children(
      element,
      heading(),
      h('p', { class: 'what-if-words' }, kind === 'unknown' ? shape('triangle') : null, words),
    );
  }

  function show(found) {
    // What is behind the jobs that are computed is not there for the computation.
    if (found.left_out && found.refusals.length)
      return say('unknown', t('whatif.too_long', { count: found.left_out }));
    element.dataset.whatIf = found.refusals.length ? 'refused' : 'known';
    const rows = found.jobs;
    const changed = rows.filter((row) => !UNCHANGED.includes(row.change));
    const same = rows.filter((row) => UNCHANGED.includes(row.change));
    const isKnown = !rows.every((row) => row.change === 'never');
    children(
      element,
      heading(),
      found.refusals_said.map((one) => {
        const words = t('whatif.refused', { why: withButtons(said(one)) });
        return h('p', { class: 'what-if-refusal' }, shape('triangle'), words);
      }),
      h('p', { class: 'what-if-words' }, summary(rows)),
      isKnown && (changed.length || same.length <= FEW)
        ? table(same.length <= FEW ? rows : changed)
        : null,
      isKnown && same.length > FEW
        ? h(
            'details',
            {},
            h('summary', {}, t('whatif.same_count', { count: same.length })),
            table(same),
          )
        : null,
      reasons(found).map((words) => h('p', { class: 'what-if-why hint' }, words)),
      found.notes.map((note) => h('p', { class: 'hint' }, note)),
      found.left_out
        ? h('p', { class: 'hint' }, t('whatif.left_out', { count: found.left_out }))
        : null,
    );
  }

  return { element, ask, end: forget };
}

function heading() {
  return h('h3', {}, t('whatif.title'));
}

/** Why ends are unknown: the same reason is said once, with the jobs that it is of. */
function reasons({ unknown }) {
  const names = Object.keys(unknown);
  const ofJob = (why) => names.some((job) => why.startsWith(`${job} `));
  // What keeps all jobs is why the cell stands: the page says it in its own words.
  const cell = part('cell');
  const isOfAll = (why) => why.en === cell?.stands?.reason || !ofJob(why.en);
  const words = (why) => (cell && isOfAll(why) && whyItStands(cell)) || said(why);
  const jobs = Object.groupBy(names, (job) => words(unknown[job]));
  return Object.entries(jobs).map(([why, names]) =>
    t('whatif.why', { jobs: names.join(', '), why: withButtons(why.replace(/\.$/, '')) }),
  );
}

function summary(rows) {
  if (rows.length && rows.every((row) => row.change === 'never')) return t('whatif.none_known');
  const count = (change) => rows.filter((row) => row.change === change).length;
  const words = ['later', 'earlier', 'gone', 'open', 'never']
    .filter(count)
    .map((change) => t(`whatif.count_${change}`, { count: count(change) }));
  const missed = rows.filter((row) => row.is_late && !row.was_late);
  if (missed.length)
    words.push(
      t('whatif.count_missed', {
        count: missed.length,
        jobs: missed.map((row) => row.job).join(', '),
      }),
    );
  return words.length ? `${words.join('; ')}.` : t('whatif.nothing');
}

function table(rows) {
  const heads = ['job', 'before', 'after', 'change', 'due'].map((name) =>
    h('th', { scope: 'col' }, t(`whatif.${name}`)),
  );
  return h(
    'div',
    { class: 'table-scroll', tabindex: 0, role: 'group', 'aria-label': t('whatif.title') },
    h('table', {}, h('thead', {}, h('tr', {}, heads)), h('tbody', {}, rows.map(line))),
  );
}

function line(row) {
  const { job, change } = row;
  return h(
    'tr',
    { 'data-job': job, 'data-change': change, 'data-by': row.by_s?.toFixed(1), 'data-late': row.is_late },
    h('th', { scope: 'row' }, job),
    h('td', {}, endWords(row.before)),
    h('td', {}, endWords(row.after)),
    h('td', { class: 'what-if-change' }, changeWords(row)),
    h('td', {}, dueWords(row)),
  );
}

function endWords(ends) {
  if (ends === undefined) return '–';
  return ends === null ? t('whatif.unknown_end') : about(ends);
}

function changeWords({ change, by_s: by }) {
  if (change !== 'later' && change !== 'earlier') return t(`whatif.is_${change}`);
  const sign = change === 'later' ? '+' : '−';
  return `${sign}${duration(Math.abs(by))} ${t(`whatif.is_${change}`)}`;
}

function dueWords(row) {
  if (!row.due) return '';
  if (!row.is_late)
    return row.was_late ? t('whatif.due_met', { time: about(row.due) }) : about(row.due);
  const by = t('whatif.due_missed', { time: about(row.due), by: duration(row.after - row.due) });
  return [shape('triangle'), ` ${by}`];
}
