/** What the journal knows while nothing was heard of the cell yet: when it ends, and the last jobs. */

import { get } from '../core/api.js';
import { h, show, text } from '../core/dom.js';
import { at, t } from '../core/text.js';
import { jobTable } from './job_table.js';

const MOST = 12;

/** Make it: an element and `read()`; a page without a journal shows nothing of it. */
export function journalKnown() {
  const last = h('p', { class: 'remark' });
  const jobs = jobTable();
  const element = h(
    'section',
    { class: 'panel', 'data-part': 'journal', hidden: true },
    h('h2', {}, t('overview.journal')),
    last,
    jobs.element,
    h('p', {}, h('a', { class: 'more-jobs', href: '#/jobs' }, t('jobs.title'))),
  );
  return {
    element,
    async read() {
      const found = await Promise.all([get('/api/events?most=1'), get(`/api/jobs?most=${MOST}`)])
        .catch(() => null); // no journal, or the page is silent: the top bar says so
      if (!found) return;
      const [{ records: [newest] }, page] = found;
      text(last, newest ? t('overview.journal_ends', { time: at(newest.time) }) : t('jobs.nothing'));
      jobs.show(page.jobs);
      show(element, true);
    },
  };
}
