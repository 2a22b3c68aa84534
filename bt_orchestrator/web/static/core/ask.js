/**
 * The dialog of a command: what it does, its parameters, the reason, and what became of it.
 *
 * Abort, pause and stop have no dialog in front: one press, also on old news and in a locked
 * session. They are asked for the reason afterwards.
 */

import { askAfterwards } from './afterwards.js';
import { newTicket, send } from './api.js';
import { dialogButtons, openDialog } from './dialog.js';
import { h, show, text } from './dom.js';
import { parameterForm } from './form.js';
import { holdButton } from './hold_button.js';
import { askToLogIn } from './login.js';
import { may, who } from './me.js';
import { note } from './notes.js';
import { keepReason, reasonField } from './reason.js';
import { effectOf, isEmergency, rolesOf, wordOf } from './requests.js';
import { news, subscribe } from './store.js';
import { sentence, t } from './text.js';
import { whatIf } from '../parts/what_if.js';

/**
 * Ask for what is missing and send a request.
 * @param {Object} offer
 * @param {Object} options
 * @param {string} [options.about] names what it is about
 * @param {Object} [options.values] parameters that are known already
 * @returns {Promise<boolean>} whether it was accepted
 */
export async function ask(offer, { about = '', values = {} } = {}) {
  if (isEmergency(offer)) return sendAtOnce(offer, about);
  if ((!who().role || who().is_locked) && !(await askToLogIn())) return false;
  if (!may(offer.name)) return sayNotAllowed(offer, about, values);
  return new Promise((resolve) => openAsking(offer, about, values, resolve));
}

function title(offer, about) {
  return about ? `${wordOf(offer)}: ${about}` : wordOf(offer);
}

async function sayNotAllowed(offer, about, values) {
  const words = t('ask.not_allowed', { roles: rolesOf(offer.roles), name: who().name, role: t(`role.${who().role}`) });
  const other = await new Promise((resolve) => {
    const change = h('button', { type: 'button', 'data-do': 'other-person', onclick: () => answer(true) }, t('ask.other_person'));
    const dialog = openDialog(title(offer, about), [h('p', {}, words), dialogButtons(() => answer(false), change)], {
      name: 'not-allowed',
      closed: () => resolve(false),
    });
    const answer = (wish) => {
      resolve(wish);
      dialog.close();
    };
  });
  return other && (await askToLogIn({ isAnother: true })) ? ask(offer, { about, values }) : false;
}

function openAsking(offer, about, known, done) {
  const form = parameterForm({ ...offer, body: { ...offer.body, ...known } });
  const reason = reasonField(offer.name, offer.why === 'first');
  let ticket = newTicket();
  const answer = h('div', { class: 'answer', role: 'alert', hidden: true });
  const go = offer.is_confirmed ? holdButton(wordOf(offer), t('ask.hold_down'), isReady, act) : pressButton(offer, () => isReady() && act());
  const ahead = offer.foresee ? whatIf(offer.foresee) : null;
  let accepted = false;
  let isSending = false;
  const judge = () => {
    go.disabled = isSending || news().kind !== 'fresh';
  };
  const unsubscribe = subscribe('news', judge);
  const dialog = openDialog(
    title(offer, about),
    [h('p', { class: 'effect' }, effectOf(offer)), form.element, ahead?.element ?? '', reason.element, answer, dialogButtons(() => dialog.close(), go)],
    { name: offer.name, closed },
  );
  judge();
  if (form.isEmpty) reason.focus();
  else dialog.element.querySelector('select, input, textarea, summary').focus();
  form.element.addEventListener('input', lookAhead);
  lookAhead();

  function lookAhead() {
    const values = form.sofar();
    const isNothing = !values || (!form.isEmpty && !Object.keys(values).length);
    ahead?.ask(isNothing ? null : { ...known, ...values });
  }

  function closed() {
    ahead?.end();
    unsubscribe();
    done(accepted);
  }

  function isReady() {
    return !isSending && form.values() !== null && reason.isGiven();
  }

  async function act() {
    isSending = true;
    judge();
    say('sending', t('ask.sending'), []);
    const values = { ...known, ...form.values(), reason: reason.value() };
    const outcome = await send(offer, values, ticket, () => say('unknown', t('ask.unknown'), []));
    isSending = false;
    accepted = outcome.kind === 'accepted';
    if (accepted) {
      keepReason(offer.name, values.reason);
      dialog.close();
    }
    if (!dialog.element.open) return noteOutcome(offer, about, outcome);
    // The page keeps its answer to a ticket. What the journal does not have goes again under the same
    // one, so that nothing is done twice; what was refused would only be refused again.
    if (outcome.kind !== 'absent') ticket = newTicket();
    if (outcome.kind === 'login') await askToLogIn();
    judge();
    return say(outcome.kind, outcomeWords(outcome), outcome.findings);
  }

  function say(kind, words, findings) {
    show(answer, true);
    answer.dataset.answer = kind;
    text(answer, '');
    answer.append(h('p', {}, words), findings.length ? h('ul', {}, findings.map((one) => h('li', {}, String(one)))) : '');
  }
}

function pressButton(offer, press) {
  return h('button', { type: 'button', class: 'primary', onclick: press, 'data-do': 'send' }, wordOf(offer));
}

function outcomeWords(outcome) {
  const words = t(`outcome.${outcome.kind}`);
  const source = outcome.isFromJournal ? `${t('outcome.journal')} ` : '';
  return outcome.message ? `${source}${words} ${sentence(outcome.message)}` : `${source}${words}`;
}

function noteOutcome(offer, about, outcome) {
  const kind = outcome.kind === 'accepted' ? 'accepted' : 'refused';
  note(kind, `${title(offer, about)} — ${outcomeWords(outcome)}`);
}

/** Send without asking; what is missing is asked when it is done. */
async function sendAtOnce(offer, about, say = note('unknown', '')) {
  say('unknown', `${title(offer, about)} — ${t('ask.sending')}`);
  const sentAt = Date.now() / 1000;
  const outcome = await send(offer, { reason: '' }, newTicket(), () => say('unknown', `${title(offer, about)} — ${t('ask.unknown_danger')}`));
  if (outcome.kind === 'login') {
    say('refused', `${title(offer, about)} — ${t('outcome.login')}`);
    return (await askToLogIn()) ? sendAtOnce(offer, about, say) : false;
  }
  say(outcome.kind === 'accepted' ? 'accepted' : 'refused', `${title(offer, about)} — ${outcomeWords(outcome)}`);
  if (outcome.kind === 'accepted') askAfterwards(offer, title(offer, about), sentAt);
  return outcome.kind === 'accepted';
}
