/** The words about a job: its state, and its due date. */

import { clock } from '../../core/store.js';
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

/** Say how long, to the minute: seconds would only make it restless. */
function roughly(seconds) {
  if (seconds >= 3600) return duration(seconds);
  return t('queue.minutes', { count: number(Math.ceil(seconds / 60)) });
}

/** Say when it is due, and by how much that is missed. */
export function dueWords({ due, ends, is_over: isOver }) {
  if (!due) return { words: '', isLate: false };
  const late = (isOver ? 0 : Math.max(ends ?? 0, clock())) - due;
  if (late <= 0) return { words: about(due), isLate: false };
  const isPast = clock() > due;
  const key = isPast ? 'queue.overdue' : 'queue.late';
  return { words: t(key, { time: about(due), by: roughly(late) }), isLate: true };
}
