/** One hold: where, what and why, and each answer with its consequence. */

import { attribute, children, h, show, text } from '../core/dom.js';
import { withButtons } from '../core/requests.js';
import { shownMoment } from '../core/store.js';
import { at, duration, said, t, tOr } from '../core/text.js';
import { offers } from './offers.js';
import { reshape, shape } from '../core/shape.js';
import { holdPlace } from '../core/stands.js';
import { jsonValues } from './values.js';

/** Make a card: an element, `update(hold)`, `tick()`, `end()`. */
export function holdCard() {
  let hold = null;
  let fed = '';
  const drawn = shape('triangle');
  const place = h('h2', { class: 'hold-place' });
  const why = h('p', { class: 'hold-why' });
  const message = h('p', { class: 'hold-message' });
  const last = h('div', { class: 'hold-feedback' });
  const facts = h('p', { class: 'hold-facts' });
  const item = h('a', { class: 'hold-item' });
  const answers = offers({
    about: () => aboutHold(hold),
    hold: () => hold.id,
    label: t('overview.answers'),
  });
  const element = h(
    'article',
    { class: 'hold', tabindex: -1 },
    h(
      'div',
      { class: 'hold-said' },
      h('div', { class: 'hold-head' }, drawn, place),
      why,
      message,
      h('details', { class: 'hold-last' }, h('summary', {}, t('overview.last_feedback')), last),
      h('p', { class: 'hold-foot' }, item, facts),
    ),
    answers.element,
  );

  function tick() {
    text(facts, factWords(hold));
  }

  return {
    element,
    tick,
    end: answers.end,
    update(now) {
      hold = now;
      attribute(element, 'data-hold', hold.id);
      attribute(element, 'data-pause', hold.is_pause);
      reshape(drawn, hold.is_pause ? 'pause' : 'triangle');
      text(place, holdTitle(hold));
      text(why, tOr(`reason.${hold.reason}`, hold.reason));
      text(message, saidOf(hold));
      attribute(message, 'title', saidOf(hold));
      show(last.parentElement, hold.last_feedback);
      if (hold.last_feedback !== fed) children(last, jsonValues(hold.last_feedback || '{}'));
      fed = hold.last_feedback;
      show(item, hold.item);
      if (hold.item)
        attribute(item, 'href', `#/item/${hold.item.split('/').map(encodeURIComponent).join('/')}`);
      text(item, hold.item ?? '');
      answers.update(hold.offers);
      tick();
    },
  };
}

/** Where it is, and of what. */
export function holdTitle(hold) {
  if (hold.is_pause) return t('part.cell');
  if (hold.section) return holdPlace(hold);
  const place = hold.job ? t('part.initialization') : t('part.belt');
  return [place, holdPlace(hold)].filter(Boolean).join(', ');
}

/** The words of the controller first, then those of the node, and what the status topic says. */
function saidOf(hold) {
  const controller =
    hold.controller_said && t('reason.controller_says', { words: hold.controller_said });
  const topic = hold.topic_says && t('reason.topic_says', { words: hold.topic_says });
  return [controller, withButtons(said(hold.said)), topic].filter(Boolean).join('; ');
}

/** For dialogs: the card is under them. */
function aboutHold(hold) {
  return [holdTitle(hold), hold.item].filter(Boolean).join(', ');
}

function factWords(hold) {
  const attempt = hold.attempt
    ? t('overview.attempt', {
        attempt: hold.attempt,
        attempts: Math.max(hold.attempts, hold.attempt),
      })
    : '';
  const since = t('topbar.since', {
    time: at(hold.since),
    duration: duration(shownMoment() - hold.since),
  });
  return [attempt, since, t('overview.hold_number', { id: hold.id })].filter(Boolean).join(' · ');
}
