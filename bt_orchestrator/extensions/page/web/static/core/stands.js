/** Why the line stands still, or soon will: one sentence for the top of the page. */

import { part } from './store.js';
import { at, person, said, t, tOr } from './text.js';

/** Say why the cell does not work as it should; empty: it does. */
export function whyItStands(cell) {
  if (cell.journal_failure) return t('stands.journal', { why: cell.journal_failure });
  if (cell.disk_wait) return t('stands.disk', { what: cell.disk_wait });
  const reason = cell.stop_reason ? reasonWords(cell) : '';
  const after = cell.stop_after ? t(`stands.stop_after_${cell.stop_after}`) : '';
  const way = cell.waits_for
    ? t('stands.waits_for', { commands: commandWords(cell.waits_for) })
    : '';
  const cause = causeWords(cell);
  const said = [reason, cause, wishWords(cell.wish), after, way].filter(Boolean).join(' ');
  return said || tOr(`meaning.${cell.state}`, '');
}

/** Causes that the stop reason, the wish or the meaning of the state tells. */
const TOLD = ['journal', 'hold', 'pause', 'starved', 'blocked', 'order'];

/** Tell whether nothing moves for a cause that the state of the cell does not name. */
export function standsSilently({ stands, wish }) {
  return Boolean(stands) && !TOLD.includes(stands.cause) && !(wish && stands.cause === 'command');
}

/** Say why nothing moves; empty: something does, or it is told already. */
function causeWords(cell) {
  const { stands } = cell;
  if (!stands) return '';
  if (stands.cause === 'order' && cell.state === 'Execute') return t('standing.order');
  // A paused job is no stop reason of the cell.
  if (!standsSilently(cell) && !(stands.cause === 'pause' && !cell.stop_reason)) return '';
  return t('standing.why', { why: rootWords(cell) });
}

function rootWords({ stands, state }) {
  const components = stands.components.join(', ');
  const sections = stands.sections.map((number) => t('part.section', { number })).join(', ');
  const values = { ...stands, components, state: tOr(`state.${state}`, state) };
  if (stands.cause === 'other') return stands.reason;
  const why = t(`standing.${stands.cause}`, values);
  return sections ? `${sections}: ${why}` : why;
}

/** The commands of a sentence as their buttons are called. */
function commandWords(said) {
  return said.replace(/\w+/g, (word) =>
    word === 'and' ? t('stands.and') : tOr(`word.cell.${word}`, word),
  );
}

function reasonWords(cell) {
  const hold = part(`hold/${cell.holds[0]}`);
  const word = t(`stop_reason.${cell.stop_reason}`);
  if (hold) {
    const what = [holdPlace(hold), tOr(`reason.${hold.reason}`, hold.reason)]
      .filter(Boolean)
      .join(': ');
    const more =
      cell.holds.length > 1 ? ` ${t('stands.more_holds', { count: cell.holds.length - 1 })}` : '';
    // The card of a task has its message, which may be long.
    const isSaid = hold.message && !hold.task;
    return `${word}: ${what}${isSaid ? ` (${said(hold.said)})` : ''}.${more}`;
  }
  // What a person said is told by their wish.
  return cell.stop_message && !cell.wish ? `${word}: ${said(cell.stop_said)}.` : `${word}.`;
}

/** Where a hold is, and of what. */
export function holdPlace(hold) {
  const section = hold.section ? t('part.section', { number: hold.section }) : '';
  return [section, hold.label, hold.component].filter(Boolean).join(', ');
}

function wishWords(wish) {
  if (!wish) return '';
  const values = {
    who: wish.who ? person(wish.who, 'stands.claims') : t('stands.somebody'),
    command: tOr(`word.cell.${wish.command}`, wish.command),
    time: wish.time ? at(wish.time) : '',
  };
  return `${t('stands.wish', values)}${wish.reason ? `: ${wish.reason}` : ''}.`;
}
