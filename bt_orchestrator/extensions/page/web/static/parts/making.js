/** How a job came to its script: whose rest it is, without what it was made, what it lacks. */

import { percent, seconds, t } from '../core/text.js';

/** Say it all in one line; empty: it was ordered so. */
export function makingWords(job) {
  if (job.is_over) return ''; // nothing is to come of it
  const rest = job.rest_of ? t('job.is_rest_of', { job: job.rest_of }) : '';
  const lacks = job.position ? [] : job.unavailable; // that of a queued job is its state
  const needs = lacks.length ? t('job.needs', { names: lacks.join(', ') }) : '';
  return [rest, anewWords(job), needs].filter(Boolean).join(', ');
}

/** Say without what it was made anew, and the pace since; empty: it was not. */
export function anewWords({ anew }) {
  if (!anew) return '';
  const { without, back, per_item_s: now, slower } = anew;
  const key = without.length ? 'anew_without' : back.length ? 'anew_with' : 'anew';
  const what = t(`job.${key}`, { names: [...without, ...back].join(', ') });
  if (!now) return what;
  const isOther = Math.round(slower * 100) !== 0;
  const said = { what, time: seconds(now), slower: percent(slower) };
  return t(isOther ? 'job.at_other_pace' : 'job.at_pace', said);
}
