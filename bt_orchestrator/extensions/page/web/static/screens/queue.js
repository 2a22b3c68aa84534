/** The queue: all jobs in order, their places, and when each is expected to end. */

import { attribute, h, keyed, show, text } from '../core/dom.js';
import { onPerson } from '../core/me.js';
import { part, subscribe } from '../core/store.js';
import { t } from '../core/text.js';
import { jobRow } from './queue/job_row.js';
import { moreJobs } from './queue/more_jobs.js';
import { moving } from './queue/moving.js';
import { proposing } from './queue/proposing.js';

const GROUPS = ['line', 'queue', 'ended'];

/** Show the screen. */
export function mount(root, route) {
  const move = moving();
  const context = { move, unfolded: new Set([route.query.get('job')].filter(Boolean)) };
  const groups = Object.fromEntries(GROUPS.map((name) => [name, group(name, context)]));
  const more = moreJobs(update);
  groups.queue.element.append(more.element);
  const proposal = proposing();
  const stops = h('p', { class: 'queue-stops warn', hidden: true });
  const toOrder = h('a', { class: 'button', href: '#/order' }, t('nav.order'));
  root.append(
    h('div', { class: 'queue-head' }, h('h1', {}, t('queue.title')), stops, proposal.button, toOrder),
    proposal.words,
    ...GROUPS.map((name) => groups[name].element),
    move.tray,
  );

  function update() {
    const cell = part('cell');
    if (!cell) return;
    const listed = cell.jobs.map((id) => part(`job/${id}`)).filter(Boolean);
    const waiting = listed.filter((job) => job.position);
    more.update(waiting, cell.queued);
    const queue = [...waiting, ...more.jobs()];
    const begun = listed.filter((job) => !job.position);
    move.update(queue, cell.queued);
    proposal.update(cell.queued);
    groups.line.update(begun.filter((job) => !job.is_over));
    groups.queue.update(queue, cell.queued);
    groups.ended.update(begun.filter((job) => job.is_over).reverse());
    show(stops, cell.stop_after);
    text(stops, cell.stop_after ? t(`stands.stop_after_${cell.stop_after}`) : '');
  }

  const ends = [
    subscribe('cell', update),
    subscribe('job/', update),
    move.onChange(update),
    onPerson(update),
  ];
  update();
  return () => {
    ends.forEach((end) => end());
    GROUPS.forEach((name) => groups[name].update([]));
    more.end();
    move.end();
  };
}

function group(name, context) {
  const count = h('span', { class: 'queue-count' });
  const none = h('p', { class: 'quiet' }, t(`queue.none_${name}`));
  const list = h('ol', { class: 'queue-list', 'data-list': name });
  const id = `queue-${name}`;
  const element = h(
    'section',
    { class: 'panel queue-group', 'aria-labelledby': id },
    h('h2', { id }, t(`queue.${name}`), ' ', count),
    none,
    list,
  );
  const rows = keyed(
    list,
    (job) => job.id,
    (job) => jobRow(job.id, context),
  );
  return {
    element,
    update(jobs, whole = jobs.length) {
      rows(jobs);
      text(count, whole ? `(${whole})` : '');
      show(none, !jobs.length);
      show(list, jobs.length);
      attribute(element, 'data-count', jobs.length);
    },
  };
}
