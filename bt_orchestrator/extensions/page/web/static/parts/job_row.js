/** One job in the overview: its state, its bar, and when it will be done. */

import { attribute, h, show, text } from '../core/dom.js';
import { part } from '../core/store.js';
import { about, said, t, tOr } from '../core/text.js';
import { jobBar } from './bar.js';
import { makingWords } from './making.js';

const MADE = ['done', 'marked_done', 'skipped', 'continued'];

/** Make a row: an element and `update(job)`. */
export function jobRow() {
  const link = h('a', { class: 'job-link' });
  const script = h('span', { class: 'job-script' });
  const state = h('span', { class: 'job-word' });
  const count = h('span', { class: 'job-count' });
  const ends = h('span', { class: 'job-ends' });
  const bar = jobBar();
  const making = h('p', { class: 'job-making' });
  const piece = h('a', { class: 'job-making' });
  const preparing = h('p', { class: 'job-preparing' });
  const element = h(
    'li',
    { class: 'job' },
    h('div', { class: 'job-head' }, link, script, state, count, ends),
    bar.element,
    making,
    piece,
    preparing,
  );
  return {
    element,
    update(job) {
      attribute(element, 'data-job', job.id);
      attribute(element, 'data-state', job.state);
      attribute(element, 'data-substate', job.substate);
      attribute(element, 'data-waits', job.position > 0);
      attribute(link, 'href', `#/job/${encodeURIComponent(job.id)}`);
      text(link, job.id);
      text(script, scriptWords(job));
      text(state, jobStateWords(job));
      text(ends, endWords(job));
      attribute(ends, 'title', job.end_unknown ? said(job.end_unknown_said) : null);
      const waits = job.position > 0;
      text(count, waits ? t('overview.items', { count: job.quantity }) : '');
      show(bar.element, !waits);
      bar.update(job);
      const made = makingWords(job);
      show(making, made);
      text(making, made);
      const asked = pieceWords(job);
      show(piece, asked);
      text(piece, asked);
      if (asked) attribute(piece, 'href', pieceAddress(job.first_piece));
      const prepared = preparingWords(job);
      show(preparing, prepared);
      text(preparing, prepared);
    },
  };
}

/** Say when a job will have ended, or that it cannot be known. */
function endWords({ ends, end_unknown: unknown, position }) {
  if (ends) return t('overview.ends', { time: about(ends) });
  return unknown && !position ? t('overview.end_unknown') : '';
}

/** Name the script of a job, and the recipe that it was generated from. */
export function scriptWords(job) {
  return job.recipe ? t('job.made_from', { script: job.script, recipe: recipeWords(job) }) : job.script;
}

/** Name the recipe of a job, and its version; empty: its script comes from none. */
export function recipeWords({ recipe, recipe_version: version }) {
  return recipe && version ? t('job.of_version', { recipe, version }) : recipe;
}

/** Say the state of a job, and whether it is being ended. */
export function jobStateWords(job) {
  if (isPassed(job)) return passedWords(job);
  if (job.awaits_start && job.state === 'AllowedToStart') {
    return t('job_state.early', { time: about(job.start) });
  }
  const key = job.substate ? `${job.state}/${job.substate}` : job.state;
  const word = tOr(`job_state.${key}`, key);
  return job.ending ? `${word}, ${t(`job_state.${job.ending}`)}` : word;
}

/** Tell whether the queue passes it for its script, or a component that is out of service. */
export function isPassed({ state, unavailable, awaits_release: isUnreleased }) {
  return state === 'NotAllowedToStart' && (isUnreleased || unavailable.length > 0);
}

/** Say that its script is not released, and which components it lacks. */
export function passedWords({ unavailable, awaits_release: isUnreleased }) {
  const names = unavailable.join(', ');
  if (!isUnreleased) return t('job_state.unavailable', { names });
  return t(names ? 'job_state.unreleased_unavailable' : 'job_state.unreleased', { names });
}

/** Say for the approval of which first piece it waits; empty: for none. */
export function pieceWords({ first_piece: item, first_piece_state: state, is_over: isOver }) {
  if (!item || isOver || state === 'approved') return '';
  return t('overview.piece', { item, how: t(`overview.piece_${state || 'on_line'}`) });
}

/** Its record has the measured values. */
function pieceAddress(item) {
  return `#/item/${item.split('/').map(encodeURIComponent).join('/')}`;
}

/** Say how far the initialization is; empty: there is none, or it is over. */
function preparingWords(job) {
  const open = job.tasks.filter((task) => !MADE.includes(task.mark));
  if (!open.length || job.position > 1) return '';
  const busy = open
    .filter((task) => task.mark !== 'new')
    .map((task) => `${task.name || task.id} ${t(`mark.${task.mark}`)}`);
  const count = t('overview.prepared', {
    done: job.tasks.length - open.length,
    all: job.tasks.length,
  });
  const [wait] = part('cell')?.initialization ?? [];
  return [count, ...busy, wait && said(wait.said)].filter(Boolean).join(' · ');
}
