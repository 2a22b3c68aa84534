/** What is said of a task beside its name: why it does not go on, and which one a component has. */

import { part, partsOf } from '../core/store.js';
import { said, t, tOr } from '../core/text.js';

const AT_WORK = ['running', 'held'];
/** The word of a failure, and what its server said. */
const SAID = /^(\w+)(?: \((.*)\))?$/s;

/** Say what a task waits for, or why it failed; what a server said stays as it is. */
export function taskReason(task) {
  const hold = task.hold ? part(`hold/${task.hold}`) : null;
  if (hold) return heldWords(hold);
  if (task.waits.length) return task.waits.map((wait) => said(wait.said)).join('; ');
  const [, reason, message] = SAID.exec(task.reason) ?? [];
  return skipWords(task.reason, reason ? failureWords({ reason, message }) : task.reason);
}

/** Say why a task was skipped; others if it was not for one of the known reasons. */
export function skipWords(reason, others = reason) {
  return tOr(`item.skip_${reason.replaceAll(' ', '_')}`, others);
}

/** Say why an attempt failed, with the words of its server. */
export function failureWords({ reason, message }) {
  const why = tOr(`reason.${reason}`, reason);
  return message ? `${why} (${message})` : why;
}

/** Say why something is held. */
export function heldWords(hold) {
  return failureWords({ reason: hold.reason, message: said(hold.said) });
}

/** Name the task that a component is busy with, and of what; empty: it has none. */
export function busyWith({ name, task }) {
  const lists = [
    ...partsOf('section/').map(([, one]) => [one.tasks, one.item?.id]),
    ...partsOf('job/').map(([, one]) => [one.tasks, one.id]),
    [part('belt')?.running ?? [], ''],
  ];
  for (const [tasks, of] of lists) {
    const mine = tasks.find((one) => one.component === name && AT_WORK.includes(one.mark));
    if (mine) return of ? t('component.task_of', { task: mine.label, of }) : mine.label;
  }
  return task;
}
