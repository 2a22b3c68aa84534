/** What became of a hold that a dialog is about, where somebody else has ended it. */

import { part, recentEvents, subscribe } from '../core/store.js';
import { person, quoted, sentence, t, tOr } from '../core/text.js';
import { note } from './notes.js';

/** Its events come a moment after the cell without it. */
const PATIENCE_MS = 2000;
/** Answers after which a hold stays. */
const STAYS = ['acknowledge', 'comment'];

/** Tell whether a hold is over; false where a dialog is about none. */
export function isOver(hold) {
  return Boolean(hold) && Boolean(part('cell')) && !part(`hold/${hold}`);
}

/** Say who decided what about a hold, or only that it is over. */
export function sayWhoEnded(hold, title) {
  const say = () => {
    clearTimeout(late);
    end();
    note('told', `${title} — ${endWords(decisionOf(hold))}`);
  };
  const late = setTimeout(say, PATIENCE_MS);
  const end = subscribe('event', () => decisionOf(hold) && say());
  if (decisionOf(hold)) say();
}

function decisionOf(hold) {
  const isMine = (event) => event.event === 'operator.decided' && event.hold === hold;
  return recentEvents().findLast((event) => isMine(event) && !STAYS.includes(event.answer));
}

function endWords(decision) {
  if (!decision) return t('ask.hold_over');
  const { named, answer, reason } = decision;
  const values = {
    who: named ? person(named, 'stands.claims') : t('stands.somebody'),
    answer: tOr(`word.hold.${answer}`, tOr(`word.cell.${answer}`, answer)),
  };
  const why = reason ? ` ${quoted(reason)}` : '';
  return `${sentence(t('ask.decided_elsewhere', values))}${why} ${t('ask.nothing_sent')}`;
}
