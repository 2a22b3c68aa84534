/**
 * Every command goes through here: who may give it, what it lacks, and what became of it.
 *
 * Abort, pause and stop have no dialog in front: one press, also on old news and in a locked
 * session. They are asked for the reason afterwards.
 */

import { newTicket, send } from '../core/api.js';
import { h } from '../core/dom.js';
import { who, whyNot } from '../core/me.js';
import { isEmergency, rolesOf, titleOf } from '../core/requests.js';
import { t } from '../core/text.js';
import { askAfterwards } from './afterwards.js';
import { openCommand } from './command.js';
import { dialogButtons, openDialog } from './dialog.js';
import { askToLogIn } from './login.js';
import { note } from './notes.js';
import { outcomeWords } from './outcome.js';
import { clock } from '../core/store.js';

/**
 * Ask for what is missing and send a request.
 * @param {Object} offer
 * @param {Object} options
 * @param {string} [options.about] names what it is about
 * @param {Object} [options.values] parameters that are known already
 * @param {string} [options.hold] id of the hold that it answers
 * @param {string} [options.said] what is to be known before, beside what it does
 * @returns {Promise<boolean>} whether it was accepted
 */
export async function ask(offer, { about = '', values = {}, hold = '', said = '' } = {}) {
  if (isEmergency(offer)) return sendAtOnce(offer, titleOf(offer, about));
  if ((!who().role || who().is_locked) && !(await askToLogIn())) return false;
  if (!whyNot(offer)) return openCommand(offer, titleOf(offer, about), values, hold, said);
  const isOther = await askForAnother(offer, titleOf(offer, about));
  return isOther ? ask(offer, { about, values, hold, said }) : false;
}

/** Say who may do it; tell whether somebody else has logged in to do it. */
async function askForAnother(offer, title) {
  const { name, role } = who();
  const roles = rolesOf(offer.roles);
  const words =
    whyNot(offer) === 'local'
      ? t('ask.in_local')
      : t('ask.not_allowed', { roles, name, role: t(`role.${role}`) });
  const isWished = await new Promise((resolve) => {
    const answer = (wish) => {
      resolve(wish);
      dialog.close();
    };
    const change = h(
      'button',
      { type: 'button', 'data-do': 'other-person', onclick: () => answer(true) },
      t('ask.other_person'),
    );
    const buttons = dialogButtons(() => answer(false), change);
    const dialog = openDialog(title, [h('p', {}, words), buttons], {
      name: 'not-allowed',
      closed: () => resolve(false),
    });
  });
  return isWished && askToLogIn({ isAnother: true });
}

/** Send without asking; what is missing is asked when it is done. */
async function sendAtOnce(offer, title, tell = note('unknown', '')) {
  const say = (kind, words) => tell(kind, `${title} — ${words}`);
  say('unknown', t('ask.sending'));
  const sentAt = clock();
  const outcome = await send(offer, { reason: '' }, newTicket(), () =>
    say('unknown', t('ask.unknown_danger')),
  );
  const isDone = outcome.kind === 'accepted';
  say(isDone ? 'accepted' : 'refused', outcomeWords(outcome));
  if (outcome.kind === 'login' && (await askToLogIn())) return sendAtOnce(offer, title, tell);
  if (isDone) askAfterwards(offer, title, sentAt);
  return isDone;
}
