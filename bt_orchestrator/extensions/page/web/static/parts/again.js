/** Which round of its repeat, and which attempt, a task is at; empty: the first of both. */
import { t } from '../core/text.js';

export function againWords({ round, attempt }) {
  return [
    round ? t('task.round', { round: round + 1 }) : '',
    attempt > 1 ? t('task.attempt', { attempt }) : '',
  ]
    .filter(Boolean)
    .join(' · ');
}
