/** What a section or a component did lately: how long tasks took, cycles, failures, time in states. */
import { get } from '../core/api.js';
import { children, h, show, text } from '../core/dom.js';
import { at, duration, number, seconds, t } from '../core/text.js';
import { failureTable } from './failures.js';
import { itemLink } from './links.js';
import { table } from './table.js';
import { timeBars } from './times.js';

const PAUSE_MS = 2000;

/**
 * @param {string} url of the history
 * @returns {History} `element`, and `read()` to call when something ended
 */
export function history(url) {
  return new History(url);
}

class History {
  constructor(url) {
    this.url = url;
    this.note = h('p', { class: 'remark', role: 'status' });
    this.tasks = taskTable();
    this.cycles = cycleTable();
    this.failures = failureTable();
    this.states = h('ul', { class: 'states' });
    const part = (word, ...shown) => h('section', { class: 'panel' }, h('h2', {}, t(word)), shown);
    this.told = h(
      'div',
      { class: 'history', hidden: true },
      part('history.tasks', h('p', { class: 'help' }, t('history.tasks_help')), this.tasks.element),
      part('history.failures', this.failures.element),
      part('history.cycles', this.cycles.element),
      part('history.states', this.states),
    );
    this.element = h('div', {}, this.note, this.told);
  }

  /** Read it again, soon; many calls are one. */
  soon() {
    this.timer ??= setTimeout(() => {
      this.timer = null;
      if (this.element.isConnected) this.read();
    }, PAUSE_MS);
  }

  async read() {
    try {
      const found = await get(this.url);
      this.#show(found);
      text(this.note, found.is_whole ? '' : t('jobs.not_whole', { why: found.why_not }));
    } catch (refused) {
      text(this.note, refused.message || t('jobs.silent'));
    }
    show(this.note, Boolean(this.note.textContent));
  }

  #show({ cycles, failures, tasks, time_in: timeIn }) {
    show(this.told, true);
    this.tasks.show(Object.entries(tasks).map(([name, one]) => ({ name, ...one })));
    this.cycles.show(cycles);
    this.failures.show(failures);
    const whole = Object.values(timeIn).reduce((sum, one) => sum + one, 0) || 1;
    const states = Object.entries(timeIn).sort(([, one], [, other]) => other - one);
    children(
      this.states,
      states.map(([state, spent]) => stateBar(state, spent, spent / whole)),
    );
  }
}

function taskTable() {
  const columns = [
    { head: t('history.task'), cell: (one) => one.name },
    { head: t('history.nominal'), cell: (one) => seconds(one.nominal_s), isNumber: true },
    { head: t('history.lately'), cell: (one) => seconds(one.lately_s), isNumber: true },
    { head: t('history.against'), cell: against, isNumber: true },
    {
      head: t('history.last'),
      cell: (one) => (one.times_s.length ? timeBars(one.times_s, one.nominal_s) : ''),
    },
  ];
  return table({
    caption: t('history.tasks'),
    columns,
    key: (one) => one.name,
    empty: t('history.no_tasks'),
  });
}

function against({ nominal_s: nominal, lately_s: lately }) {
  if (!nominal || lately === null || lately === undefined) return '';
  const percent = Math.round((lately / nominal - 1) * 100);
  return `${percent > 0 ? '+' : ''}${number(percent)} %`;
}

function cycleTable() {
  const columns = [
    { head: t('history.item'), cell: (one) => (one.item ? itemLink(one.item) : '') },
    { head: t('history.began'), cell: (one) => at(one.started) },
    { head: t('history.took'), cell: (one) => seconds(one.seconds), isNumber: true },
    { head: t('history.in_tasks'), cell: (one) => one.tasks.map(taskTime) },
  ];
  const key = (one) => `${one.item} ${one.started}`;
  return table({ caption: t('history.cycles'), columns, key, empty: t('history.no_cycles') });
}

function taskTime(task) {
  const words = `${task.task} ${seconds(task.seconds)}`;
  return h(
    'span',
    { class: 'task-time', 'data-outcome': task.outcome },
    task.outcome === 'failed' ? `✗ ${words}` : words,
  );
}

/** Whether it worked, and what its state topic said meanwhile. */
function stateWords(state) {
  const [work, ...reported] = state.split(', ');
  return [t(`history.is_${work}`), ...reported].join(', ');
}

function stateBar(state, spent, share) {
  const bar = h('span', { class: 'state-bar' });
  bar.style.width = `${share * 100}%`; // the policy forbids a style attribute
  const percent = `${number(Math.round(share * 100))} %`;
  return h(
    'li',
    {},
    h('span', {}, stateWords(state)),
    h('span', { class: 'state-room' }, bar),
    h('span', {}, duration(spent), ' · ', percent),
  );
}
