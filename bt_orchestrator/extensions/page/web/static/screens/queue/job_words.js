/** The words about a job: its state, and its due date. */

import { isPassed, passedWords } from '../../parts/job_row.js';
import { about, duration, number, t, tOr } from '../../core/text.js';

/** Say its state; one that ends says how. */
export function stateWords(job) {
  const { state, substate, ending, awaits_start: isEarly, start } = job;
  if (isPassed(job)) return passedWords(job);
  if (ending) return t(`job_state.${ending}`);
  if (isEarly && state === 'AllowedToStart') return t('job_state.early', { time: about(start) });
  const whole = [state, substate].filter(Boolean).join('/');
  return tOr(`job_state.${whole}`, whole);
}

/** Say how many minutes, or hours and minutes. */
function roughly(seconds) {
  if (seconds >= 3600) return duration(seconds);
  return t('queue.minutes', { count: number(seconds / 60) });
}

/** Say when it is due, and by how much that is missed. */
export function dueWords({ due, late_s: late, is_overdue: isOverdue }) {
  if (!late) return due ? about(due) : '';
  return t(isOverdue ? 'queue.overdue' : 'queue.late', { time: about(due), by: roughly(late) });
}
