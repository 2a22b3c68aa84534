/**
 * The reason of abort, pause and stop, asked for when they are done.
 *
 * The same command once more carries it to the record; it changes nothing while the first one
 * stands. Once the cell has gone on it would stop it again, so then it is not sent. A pause with a
 * reason takes the place of the one without, whose stop has that reason too.
 */

import { newTicket, send } from '../core/api.js';
import { codeField, hasReasons } from './code_field.js';
import { dialogButtons, openDialog } from './dialog.js';
import { h } from '../core/dom.js';
import { who } from '../core/me.js';
import { note } from './notes.js';
import { keepReason, reasonField } from './reason.js';
import { part, partsOf, subscribe } from '../core/store.js';
import { at, t } from '../core/text.js';

/** So long what was done may take until the page has heard of it. */
const NEWS_MS = 3000;

/** Ask why something was done. */
export function askAfterwards(offer, title, doneAt) {
  const code = hasReasons() ? codeField(offer) : null;
  const chosen = () => code.read().value;
  const reason = reasonField(offer.name, true, code && chosen);
  const record = h(
    'button',
    { type: 'button', class: 'primary', 'data-do': 'send', onclick: keep },
    t('ask.record'),
  );
  const dialog = openDialog(
    title,
    [
      h('p', { class: 'effect' }, t('ask.why_afterwards', { time: at(doneAt) })),
      code?.element ?? '',
      reason.element,
      dialogButtons(() => dialog.close(), record),
    ],
    { name: 'reason-afterwards' },
  );
  dialog.element.querySelector('select, textarea').focus();

  async function keep() {
    if (!reason.isGiven()) return;
    const given = { reason: reason.value(), ...(code ? { code: chosen() } : {}) };
    dialog.close();
    keepReason(offer.name, reason.typed());
    const isOffered = () => part('cell')?.offers.some((one) => one.name === offer.name);
    await heard(() => !isOffered() || myPause());
    const pause = isOffered() ? myPause() : null;
    if (isOffered() && !pause) return note('refused', t('ask.too_late'));
    const outcome = await send(offer, given, newTicket());
    // An offer that was gone is refused, with its reason on record.
    if (pause && outcome.kind === 'accepted') await send(pause.offers[0], given, newTicket());
    return outcome;
  }
}

/** Wait until the news say something: whoever types fast is ahead of them. */
async function heard(isSo) {
  if (isSo()) return;
  let end = () => {};
  await new Promise((resolve) => {
    end = subscribe('', () => isSo() && resolve());
    setTimeout(resolve, NEWS_MS);
  });
  end();
}

/** The newest pause of the person here; undefined: there is none. */
function myPause() {
  const mine = partsOf('hold/')
    .map(([, hold]) => hold)
    .filter((hold) => hold.is_pause && hold.owner === who().name);
  return mine.sort((one, other) => other.id - one.id)[0];
}
