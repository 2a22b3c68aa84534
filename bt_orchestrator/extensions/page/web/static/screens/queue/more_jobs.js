/** The jobs of a long queue that the status does not list, by pages. */

import { Refused, get } from '../../core/api.js';
import { h, show, text } from '../../core/dom.js';
import { recentEvents, subscribe } from '../../core/store.js';
import { t } from '../../core/text.js';

const SETTLE_MS = 1000;

/**
 * Make them: a button, `jobs()`, `update(listed, queued)`, `end()`.
 * @param {function(): void} changed is called when there are others
 */
export function moreJobs(changed) {
  const button = h('button', { type: 'button', 'data-do': 'more-jobs', onclick: () => load(true) });
  const trouble = h('p', { class: 'warn', role: 'status', hidden: true });
  const element = h('div', { class: 'queue-more', hidden: true }, button, trouble);
  let listed = [];
  let queued = 0;
  let pages = [];
  let seen = '';
  let timer = 0;
  let lastSeen = 0;
  const unsubscribe = subscribe('event', happened);

  const jobs = () => pages.flat().filter((job) => !listed.some((one) => one.id === job.id));

  function update(now, whole) {
    listed = now;
    queued = whole;
    say();
    const key = `${whole} ${now.map((job) => job.id).join(' ')}`;
    if (key !== seen) again();
    seen = key;
  }

  /** Read the pages again soon: they are not sent by themselves. */
  function again() {
    if (!pages.length) return;
    clearTimeout(timer);
    timer = setTimeout(() => load(false), SETTLE_MS);
  }

  function happened() {
    const news = recentEvents().filter(
      (record) => record.seq > lastSeen && record.event.startsWith('job.'),
    );
    lastSeen = recentEvents().at(-1)?.seq ?? lastSeen;
    if (news.length) again();
  }

  function say() {
    const left = queued - listed.length - jobs().length;
    show(element, left > 0 || pages.length);
    show(button, left > 0);
    text(button, t('queue.more_jobs', { count: left }));
  }

  /** Read the pages again, and one more if that was asked for. */
  async function load(isMore) {
    button.disabled = true;
    try {
      const wanted = pages.length + (isMore ? 1 : 0);
      const found = [];
      for (let after = listed.at(-1)?.id; after && found.length < wanted;) {
        const page = await get(`/api/queue?after=${encodeURIComponent(after)}`);
        found.push(page.jobs);
        after = page.rest;
      }
      pages = found;
      show(trouble, false);
    } catch (refused) {
      if (!(refused instanceof Refused)) throw refused;
      text(trouble, refused.message || t('queue.more_failed'));
      show(trouble, true);
    }
    button.disabled = false;
    say();
    changed();
  }

  return {
    element,
    jobs,
    update,
    end() {
      unsubscribe();
      clearTimeout(timer);
    },
  };
}
