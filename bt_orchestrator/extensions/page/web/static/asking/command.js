/** The dialog of a command: what it does, its parameters, the reason, and what became of it. */

import { newTicket, send } from '../core/api.js';
import { h, show } from '../core/dom.js';
import { effectOf, wordOf } from '../core/requests.js';
import { news, subscribe } from '../core/store.js';
import { t } from '../core/text.js';
import { CODE, takesCode } from './code_field.js';
import { dialogButtons, openDialog } from './dialog.js';
import { parameterForm } from './form.js';
import { holdButton } from './hold_button.js';
import { isOver, sayWhoEnded } from './hold_over.js';
import { askToLogIn } from './login.js';
import { note } from './notes.js';
import { outcomeWords } from './outcome.js';
import { keepReason, reasonField } from './reason.js';
import { whatIf } from './what_if.js';

/**
 * Open the dialog.
 * @param {Object} offer
 * @param {string} title
 * @param {Object} known parameters that are not asked for
 * @param {string} [hold] id of the hold that it answers: the dialog is closed when it is over
 * @param {string} [said] what is to be known before, beside what it does
 * @returns {Promise<boolean>} whether the command was accepted, when the dialog is closed
 */
export function openCommand(offer, title, known, hold = '', said = '') {
  return new Promise((resolve) => new Command(offer, title, known, hold, said, resolve).open());
}

class Command {
  constructor(offer, title, known, hold, said, done) {
    this.offer = offer;
    this.title = title;
    this.known = known;
    this.hold = hold;
    this.said = said;
    this.done = done;
    this.form = parameterForm({ ...offer, body: { ...offer.body, ...known } });
    const chosen = takesCode(offer) ? () => this.form.sofar()?.[CODE] : null;
    this.reason = reasonField(offer.name, offer.why === 'first', chosen);
    this.ahead = offer.foresee ? whatIf(offer.foresee) : null;
    this.answer = answerView();
    this.go = this.#sendButton();
    this.ticket = newTicket();
    this.isSending = false;
    this.isAccepted = false;
  }

  open() {
    const content = [
      h('p', { class: 'effect' }, effectOf(this.offer)),
      this.said ? h('p', { class: 'said-before' }, this.said) : '',
      this.form.element,
      this.ahead?.element ?? '',
      this.reason.element,
      this.answer.element,
      dialogButtons(() => this.dialog.close(), this.go),
    ];
    const ends = [
      subscribe('news', () => this.#judge()),
      subscribe('hold/', () => this.#leaveIfOver()),
    ];
    this.dialog = openDialog(this.title, content, {
      name: this.offer.name,
      closed: () => {
        ends.forEach((end) => end());
        this.ahead?.end();
        this.done(this.isAccepted);
      },
    });
    this.#judge();
    this.dialog.element.querySelector('select, input, textarea, summary').focus();
    this.form.element.addEventListener('input', () => this.#lookAhead());
    this.#lookAhead();
    this.#leaveIfOver();
  }

  /** Somebody else has answered the hold: nothing is left to decide here. */
  #leaveIfOver() {
    if (this.isSending || !this.dialog.element.open || !isOver(this.hold)) return;
    this.dialog.close();
    sayWhoEnded(this.hold, this.title);
  }

  #sendButton() {
    const word = wordOf(this.offer);
    const isReady = () => !this.isSending && this.form.values() !== null && this.reason.isGiven();
    if (this.offer.is_confirmed) {
      return holdButton(word, t('ask.hold_down'), isReady, () => this.#send());
    }
    const press = () => isReady() && this.#send();
    const kind = { type: 'button', class: 'primary', 'data-do': 'send' };
    return h('button', { ...kind, onclick: press }, word);
  }

  /** Commands go while the news are fresh: what is shown may be over otherwise. */
  #judge() {
    this.go.disabled = this.isSending || news().kind !== 'fresh';
  }

  #lookAhead() {
    const values = this.form.sofar();
    const isNothing = !values || (!this.form.isOptional && !Object.keys(values).length);
    this.ahead?.ask(isNothing ? null : { ...this.known, ...values });
  }

  async #send() {
    this.#setSending(true);
    this.answer.say('sending', t('ask.sending'));
    const values = { ...this.known, ...this.form.values(), reason: this.reason.value() };
    const outcome = await send(this.offer, values, this.ticket, () =>
      this.answer.say('unknown', t('ask.unknown')),
    );
    if (outcome.kind === 'accepted') {
      this.isAccepted = true;
      keepReason(this.offer.name, this.reason.typed());
      this.dialog.close();
    }
    // The page keeps its answer to a ticket. What the journal does not have goes again under the
    // same one, so that nothing is done twice; what was refused would only be refused again.
    if (outcome.kind !== 'absent') this.ticket = newTicket();
    this.answer.say(outcome.kind, outcomeWords(outcome), outcome.findings);
    if (!this.dialog.element.open) this.#note(outcome);
    else if (outcome.kind === 'login') await askToLogIn();
    this.#setSending(false);
    this.#leaveIfOver();
  }

  #setSending(isSending) {
    this.isSending = isSending;
    this.#judge();
  }

  #note(outcome) {
    const kind = this.isAccepted ? 'accepted' : 'refused';
    note(kind, `${this.title} — ${outcomeWords(outcome)}`);
  }
}

function answerView() {
  const element = h('div', { class: 'answer', role: 'alert', hidden: true });
  return {
    element,
    say(kind, words, findings = []) {
      const items = findings.map((one) => h('li', {}, String(one)));
      element.dataset.answer = kind;
      element.replaceChildren(h('p', {}, words));
      if (items.length) element.append(h('ul', {}, items));
      show(element, true);
    },
  };
}
