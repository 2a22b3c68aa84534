/** Jobs of the past as a table: what became of each, and how long it took. */

import { h } from '../core/dom.js';
import { at, duration, number, t } from '../core/text.js';
import { scriptWords } from './job_row.js';
import { jobLink } from './links.js';
import { table } from './table.js';

/** @type {Array<[string, function(*): *, string?]>} */
const COLUMNS = [
  ['job', (job) => jobLink(job.id)],
  ['status', (job) => t(`job.is_${job.status}`)],
  ['packed', (job) => packed(job)],
  ['script', (job) => scriptWords(job)],
  ['queued', (job) => at(job.queued)],
  ['ended', (job) => at(job.ended)],
  ['took', (job) => took(job), 'number'],
];

/** A table of jobs: an element and `show(jobs)`. */
export function jobTable() {
  const columns = COLUMNS.map(([name, cell, kind]) => ({
    head: t(`jobs.${name}`),
    cell,
    isNumber: kind === 'number',
  }));
  return table({
    caption: t('jobs.title'),
    columns,
    key: (job) => `${job.id}@${job.queued}`,
    empty: t('jobs.nothing'),
  });
}

function packed({ counts, quantity }) {
  const good = t('jobs.of', { packed: number(counts.packed), quantity: number(quantity) });
  const lost = bad(counts);
  return [h('div', {}, good), lost ? h('div', { class: 'alarm' }, lost) : ''];
}

function took({ started, ended }) {
  return started === null || ended === null ? '' : duration(ended - started);
}

/** Say how many items were bad, by kinds. */
export function bad(counts) {
  const kinds = ['rejected', 'missing', 'nonconforming'].filter((kind) => counts[kind]);
  return kinds.map((kind) => t(`bar.${kind}`, { count: counts[kind] })).join(', ');
}
