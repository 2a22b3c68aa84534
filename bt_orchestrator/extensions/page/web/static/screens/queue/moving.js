/**
 * Giving a queued job another place: by drag, by keys on its handle, and by buttons.
 *
 * All three only choose a place. It is marked in the list, which itself does not change; nothing is
 * asked of the cell before somebody has seen what would become of the others.
 */

import { ask } from '../../asking/ask.js';
import { attribute, h, show, text } from '../../core/dom.js';
import { t } from '../../core/text.js';
import { draggable } from './dragging.js';

const KEYS = {
  ArrowUp: -1,
  ArrowDown: 1,
  PageUp: -10,
  PageDown: 10,
  Home: -Infinity,
  End: Infinity,
};

/** Make it: `tray` (an element that says what is chosen), and what rows need. */
export function moving() {
  const words = h('span', { class: 'tray-words', role: 'status' });
  const go = h('button', { type: 'button', class: 'primary', 'data-do': 'move', onclick: confirm });
  const leave = h(
    'button',
    { type: 'button', 'data-do': 'leave-place', onclick: put },
    t('queue.leave'),
  );
  const tray = h('div', { class: 'tray', hidden: true }, words, leave, go);
  const listeners = new Set();
  let jobs = [];
  let queued = 0;
  /** The job that is to be moved, and its new place; null: none. */
  let lifted = null;

  const jobOf = (id) => jobs.find((job) => job.id === id);
  const moveOffer = (job) => job?.offers.find((offer) => offer.name === 'job.move');

  function choose(id, place, isSeen = false) {
    const job = jobOf(id);
    if (!moveOffer(job)) return;
    lifted = { id, place: Math.max(1, Math.min(queued, place)) };
    said();
    if (!isSeen) document.querySelector('[data-drop]')?.scrollIntoView({ block: 'nearest' });
  }

  function step(id, delta) {
    const from = lifted?.id === id ? lifted.place : jobOf(id)?.position;
    if (from) choose(id, from + delta);
  }

  function put() {
    const id = lifted?.id;
    lifted = null;
    said();
    focusHandle(id);
  }

  async function confirm() {
    if (!lifted) return;
    const { id, place } = lifted;
    const job = jobOf(id);
    if (place === job.position) return put();
    const isMoved = await ask(moveOffer(job), {
      about: t('queue.move_about', { job: id, place }),
      values: { position: place },
    });
    if (lifted?.id === id && isMoved) put();
    return focusHandle(id);
  }

  function said() {
    const job = lifted && jobOf(lifted.id);
    show(tray, job);
    if (job) {
      text(
        words,
        t('queue.chosen', { job: job.id, from: job.position, to: lifted.place, count: queued }),
      );
      text(go, t('queue.move_to', { place: lifted.place }));
      go.disabled = lifted.place === job.position;
    }
    for (const listener of listeners) listener();
  }

  function keys(event, id) {
    if (event.key in KEYS) step(id, KEYS[event.key]);
    else if (event.key === 'Escape' && lifted) put();
    else if ((event.key === 'Enter' || event.key === ' ') && lifted?.id === id) confirm();
    else return;
    event.preventDefault();
  }

  return {
    tray,
    step,
    count: () => queued,

    /** Know the queue as it is now. */
    update(now, whole) {
      jobs = now;
      queued = whole;
      if (lifted && !moveOffer(jobOf(lifted.id))) {
        lifted = null;
        show(tray, false);
      } else if (lifted && lifted.place > queued) lifted.place = queued;
    },

    /** Make a row's handle movable. */
    handle(handle, row, id) {
      handle.addEventListener('keydown', (event) => keys(event, id));
      handle.addEventListener('click', () => lifted?.id !== id && choose(id, jobOf(id).position));
      draggable(handle, row, {
        over: (place) => choose(id, place, true),
        drop: confirm,
        leave: put,
      });
    },

    /** Mark a row: the one that is moved, and the one where it would stand. */
    mark(row, job) {
      const isLifted = lifted?.id === job.id;
      const from = lifted && jobOf(lifted.id)?.position;
      const isTarget = lifted && job.position === lifted.place && !isLifted;
      attribute(row, 'data-lifted', isLifted);
      attribute(row, 'data-drop', isTarget ? (lifted.place < from ? 'before' : 'after') : null);
    },

    /** Call a function when another place is chosen. */
    onChange(callback) {
      listeners.add(callback);
      return () => listeners.delete(callback);
    },

    end() {
      lifted = null;
      listeners.clear();
    },
  };
}

function focusHandle(id) {
  if (id) document.querySelector(`[data-job="${CSS.escape(id)}"] [data-do="place"]`)?.focus();
}
