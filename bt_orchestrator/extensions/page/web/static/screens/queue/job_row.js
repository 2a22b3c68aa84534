/** One job of the queue: how far it is, when it ends, its place, and what can be asked of it. */

import { attribute, children, h, show, text } from '../../core/dom.js';
import { may, who } from '../../core/me.js';
import { about, t } from '../../core/text.js';
import { jobBar } from '../../parts/bar.js';
import { scriptWords } from '../../parts/job_row.js';
import { makingWords } from '../../parts/making.js';
import { offers } from '../../parts/offers.js';
import { REQUEUE } from '../../parts/requeues.js';
import { shape } from '../../core/shape.js';
import { dueWords, stateWords } from './job_words.js';

/** What the row itself shows as handle and buttons; the rest is unfolded. */
const IN_ROW = ['job.next', REQUEUE];
const BY_HANDLE = 'job.move';

/** Make a row: an element, `update(job)`, `end()`. */
export function jobRow(id, context) {
  const { move, unfolded } = context;
  const place = h('span', { class: 'place' });
  const handle = h(
    'button',
    { type: 'button', class: 'handle', 'data-do': 'place' },
    shape('grip'),
    place,
  );
  const name = h('a', { href: `#/job/${id}`, class: 'job-id' }, id);
  const script = h('span', { class: 'quiet' });
  const making = h('span', { class: 'job-making' });
  const state = h('span', { class: 'job-state' });
  const bar = jobBar();
  const cells = Object.fromEntries(
    ['priority', 'start', 'due', 'ends'].map((key) => [key, cell(key)]),
  );
  const [up, down] = [
    stepButton('up', id, () => move.step(id, -1)),
    stepButton('down', id, () => move.step(id, 1)),
  ];
  const steps = h('span', { class: 'steps' }, up, down);
  const first = offers({
    about: () => id,
    isCompact: true,
    label: t('queue.commands', { job: id }),
  });
  const rest = offers({ about: () => id, label: t('queue.commands', { job: id }) });
  const params = h('p', { class: 'quiet' });
  const unfold = h(
    'button',
    {
      type: 'button',
      class: 'unfold',
      'data-do': 'unfold',
      'aria-expanded': 'false',
      'aria-label': t('queue.more', { job: id }),
      onclick: toggle,
    },
    shape('more'),
  );
  const folded = h('div', { class: 'job-folded' }, params, rest.element);
  const element = h(
    'li',
    { class: 'job-row', 'data-job': id },
    h(
      'div',
      { class: 'job-line' },
      handle,
      h('div', { class: 'job-name' }, name, script, making),
      state,
      bar.element,
      Object.values(cells).map((one) => one.element),
      h('div', { class: 'job-moves' }, steps, first.element),
      unfold,
    ),
    folded,
  );

  function toggle() {
    if (!unfolded.delete(id)) unfolded.add(id);
    fold();
  }

  function fold() {
    const isOpen = unfolded.has(id);
    show(folded, isOpen);
    attribute(unfold, 'aria-expanded', String(isOpen));
  }

  function sayDue(job) {
    const isLate = job.late_s > 0;
    cells.due.say(isLate ? [shape('triangle'), ' ', dueWords(job)] : dueWords(job));
    attribute(cells.due.element, 'class', isLate ? 'job-cell is-late' : 'job-cell');
    attribute(element, 'data-late', isLate);
  }

  function update(job) {
    const isQueued = job.position > 0;
    const canMove = job.offers.some((offer) => offer.name === BY_HANDLE);
    attribute(element, 'data-state', job.state);
    attribute(element, 'data-substate', job.substate || null);
    attribute(element, 'data-over', job.is_over);
    attribute(element, 'data-position', job.position || null);
    show(handle, isQueued);
    handle.disabled = !canMove;
    text(place, isQueued ? job.position : '');
    attribute(
      handle,
      'aria-label',
      t('queue.handle', { job: id, place: job.position, count: move.count() }),
    );
    text(script, t('queue.of_script', { script: scriptWords(job), quantity: job.quantity }));
    const made = makingWords(job);
    show(making, made);
    text(making, made);
    text(state, stateWords(job));
    bar.update(job);
    cells.priority.say(job.priority ? String(job.priority) : '');
    cells.start.say(job.start ? about(job.start) : '');
    cells.ends.say(job.ends ? about(job.ends) : job.end_unknown ? t('overview.end_unknown') : '');
    sayDue(job);
    show(steps, canMove);
    const isMine = !who().name || may(BY_HANDLE);
    for (const one of [handle, up, down]) attribute(one, 'data-locked', !isMine);
    up.disabled = job.position === 1;
    down.disabled = job.position === move.count();
    first.update(job.offers.filter((offer) => IN_ROW.includes(offer.name)));
    rest.update(
      job.offers.filter((offer) => offer.name !== BY_HANDLE && !IN_ROW.includes(offer.name)),
    );
    text(params, paramWords(job));
    fold();
    move.mark(element, job);
  }

  move.handle(handle, element, id);
  return {
    element,
    update,
    end() {
      first.end();
      rest.end();
    },
  };
}

/** The keys of the handle do the same: these are for mouse and finger. */
function stepButton(key, id, press) {
  const words = t(`queue.${key}`, { job: id });
  return h(
    'button',
    {
      type: 'button',
      class: 'icon-button',
      tabindex: -1,
      'data-do': key,
      'aria-label': words,
      title: words,
      onclick: press,
    },
    shape(key),
  );
}

function cell(key) {
  const value = h('span', { class: 'job-value' });
  const label = h('span', { class: 'job-label' }, t(`queue.${key}`));
  return {
    element: h('div', { class: 'job-cell', 'data-cell': key }, label, value),
    say(words) {
      if (typeof words === 'string') text(value, words || '–');
      else
        children(
          value,
          words.map((one) => (typeof one === 'string' ? document.createTextNode(one) : one)),
        );
    },
  };
}

function paramWords(job) {
  const said = Object.entries(job.params ?? {}).map(([name, value]) => `${name} = ${value}`);
  return said.length ? said.join(' · ') : t('queue.no_params');
}
