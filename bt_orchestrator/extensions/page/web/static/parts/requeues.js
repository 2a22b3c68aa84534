/** Jobs on the line that can be made anew: without a component that is away, or with one that is back. */

import { h, keyed, show } from '../core/dom.js';
import { partsOf } from '../core/store.js';
import { t } from '../core/text.js';
import { jobLink } from './links.js';
import { offers } from './offers.js';

export const REQUEUE = 'job.requeue';

/** Make the list of them for a component: an element, `update(component)`, `end()`. */
export function requeues() {
  const element = h('ul', { class: 'requeues' });
  const fill = keyed(element, (job) => job.id, makeRow);
  return {
    element,
    update(component) {
      const jobs = partsOf('job/')
        .map(([, job]) => job)
        .filter((job) => job.changed_by.includes(component) && offersOf(job).length);
      fill(jobs);
      show(element, jobs.length > 0);
    },
    end: () => fill([]),
  };
}

function offersOf(job) {
  return job.offers.filter((offer) => offer.name === REQUEUE);
}

function makeRow({ id }) {
  const name = t('chain.job', { name: id });
  const buttons = offers({ about: () => name, label: t('queue.commands', { job: id }) });
  return {
    element: h('li', {}, jobLink(id), buttons.element),
    update: (job) => buttons.update(offersOf(job)),
    end: () => buttons.end(),
  };
}
