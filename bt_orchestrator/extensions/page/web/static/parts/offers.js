/** Buttons for the requests that are possible now. Which there are, only the page knows. */

import { attribute, h, keyed, text } from '../core/dom.js';
import { onPerson, who, whyNot } from '../core/me.js';
import { news, subscribe } from '../core/store.js';
import { t } from '../core/text.js';
import { ask } from '../asking/ask.js';
import { effectOf, isEmergency, rolesOf, wordOf } from '../core/requests.js';
import { shape } from '../core/shape.js';

/**
 * Make buttons for offers: an element, `update(offers)` and `end()`.
 * @param {Object} options
 * @param {function(): string} [options.about] names what they are about, for the dialog
 * @param {function(): string} [options.hold] its id where they are answers: a dialog ends with it
 * @param {boolean} [options.isCompact] without the effect beside the word; the dialog says it
 * @param {string} [options.label] names the group for readers of the screen
 */
export function offers({
  about = () => '',
  hold = () => '',
  isCompact = false,
  label = '',
} = {}) {
  const element = h('div', {
    class: isCompact ? 'offers is-compact' : 'offers',
    role: 'group',
    'aria-label': label || null,
  });
  const buttons = new Set();
  const judge = () => buttons.forEach((button) => button.judge());
  const ends = [subscribe('news', judge), subscribe('cell', judge), onPerson(judge)];
  const list = keyed(
    element,
    (offer) => offer.name + offer.subject,
    () => {
      const button = offerButton(() => ({ about: about(), hold: hold() }), isCompact);
      buttons.add(button);
      return { ...button, end: () => buttons.delete(button) };
    },
  );
  return { element, update: list, end: () => ends.forEach((end) => end()) };
}

function offerButton(subject, isCompact) {
  let offer = null;
  const word = h('span', { class: 'offer-word' });
  const effect = h('span', { class: 'offer-effect' });
  const locked = shape('lock');
  const element = h(
    'button',
    { type: 'button', class: 'offer', onclick: () => ask(offer, subject()) },
    h('span', { class: 'offer-name' }, locked, word),
    isCompact ? null : effect,
  );

  function judge() {
    // Old news may offer what is no longer possible; danger does not wait for news.
    element.disabled = news().kind !== 'fresh' && !isEmergency(offer);
    const why = who().name ? whyNot(offer) : '';
    attribute(element, 'data-locked', why !== '');
    locked.style.display = why ? '' : 'none';
    const told = {
      '': () => effectOf(offer),
      role: () => t('ask.not_your_role', { roles: rolesOf(offer.roles) }),
      local: () => t('ask.in_local'),
    };
    attribute(element, 'title', told[why]());
  }

  return {
    element,
    judge,
    update(now) {
      offer = now;
      attribute(element, 'data-offer', offer.name);
      attribute(element, 'data-emergency', isEmergency(offer));
      text(word, wordOf(offer));
      text(effect, effectOf(offer));
      judge();
    },
  };
}
