/** Attempts that failed, as a table. */
import { at, said, t, tOr } from '../core/text.js';
import { itemLink } from './links.js';
import { table } from './table.js';

/** A table of them: an element and `show(failures)`. */
export function failureTable() {
  const columns = [
    { head: t('failure.time'), cell: (one) => at(timeOf(one)) },
    { head: t('failure.item'), cell: (one) => (one.item ? itemLink(one.item) : '') },
    { head: t('failure.task'), cell: (one) => one.task },
    { head: t('failure.attempt'), cell: (one) => one.attempt, isNumber: true },
    { head: t('failure.reason'), cell: (one) => tOr(`reason.${one.reason}`, one.reason) },
    { head: t('failure.message'), cell: wordsOf },
  ];
  const key = (one) => `${timeOf(one)} ${one.item} ${one.task} ${one.attempt}`;
  return table({ caption: t('failure.title'), columns, key, empty: t('failure.nothing') });
}

/** What the controller said, and what the node says of it. */
function wordsOf({ controller_said: words, said: message }) {
  const controller = words && t('reason.controller_says', { words });
  return [controller, said(message)].filter(Boolean).join('; ');
}

/** When it failed: records of jobs and of sections name it differently. */
function timeOf({ time, ended }) {
  return time ?? ended;
}
