/** Why the line stands still, or soon will: one sentence for the top of the page. */

import { part } from '../core/store.js';
import { at, t, tOr } from '../core/text.js';

/** Say why the cell does not work as it should; empty: it does. */
export function whyItStands(cell) {
  if (cell.journal_failure) return t('stands.journal', { why: cell.journal_failure });
  if (cell.disk_wait) return t('stands.disk', { what: cell.disk_wait });
  const reason = cell.stop_reason ? reasonWords(cell) : '';
  const after = cell.stop_after ? t(`stands.stop_after_${cell.stop_after}`) : '';
  const way = cell.waits_for
    ? t('stands.waits_for', { commands: commandWords(cell.waits_for) })
    : '';
  const said = [reason, wishWords(cell.wish), after, way].filter(Boolean).join(' ');
  return said || tOr(`meaning.${cell.state}`, '');
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
    return `${word}: ${what}${hold.message ? ` (${hold.message})` : ''}.${more}`;
  }
  // What a person said is told by their wish.
  return cell.stop_message && !cell.wish ? `${word}: ${cell.stop_message}.` : `${word}.`;
}

/** Where a hold is, and of what. */
export function holdPlace(hold) {
  const section = hold.section ? t('part.section', { number: hold.section }) : '';
  return [section, hold.label, hold.component].filter(Boolean).join(', ');
}

function wishWords(wish) {
  if (!wish) return '';
  const values = {
    who: wish.who || t('stands.somebody'),
    command: tOr(`word.cell.${wish.command}`, wish.command),
    time: wish.time ? at(wish.time) : '',
  };
  return `${t('stands.wish', values)}${wish.reason ? `: ${wish.reason}` : ''}.`;
}
