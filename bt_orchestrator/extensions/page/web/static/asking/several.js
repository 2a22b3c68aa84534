/** One list that answers holds alike: no row is ticked beforehand, each answer is sent by itself. */

import { newTicket, send } from '../core/api.js';
import { children, h, keyed, show, text } from '../core/dom.js';
import { who } from '../core/me.js';
import { effectOf, wordOf } from '../core/requests.js';
import { news, part, subscribe } from '../core/store.js';
import { t, tOr } from '../core/text.js';
import { dialogButtons, openDialog } from './dialog.js';
import { askToLogIn } from './login.js';
import { outcomeWords } from './outcome.js';
import { keepReason, reasonField } from './reason.js';

/**
 * Buttons that open such lists: an element and `update(holds)`; without holds alike it takes no room.
 * @param {function(Object): string} nameOf names a hold
 */
export function severalButtons(nameOf) {
  const element = h('div', { class: 'several', hidden: true });
  const fill = keyed(
    element,
    (group) => group.kind,
    () => {
      let group = null;
      const button = h('button', { type: 'button', 'data-do': 'several', onclick: () => open() });
      const open = () => openSeveral(group.holds, nameOf);
      return {
        element: button,
        update(now) {
          group = now;
          text(button, t('several.open', { count: now.holds.length }));
        },
      };
    },
  );
  return {
    element,
    update(holds) {
      const groups = Object.groupBy(holds, (hold) => [...hold.together].sort().join(' '));
      const alike = Object.entries(groups)
        .filter(([kind, members]) => kind && members.length > 1)
        .map(([kind, members]) => ({ kind, holds: members }));
      fill(alike);
      show(element, alike.length);
    },
  };
}

async function openSeveral(holds, nameOf) {
  if ((!who().role || who().is_locked) && !(await askToLogIn())) return;
  const rows = holds.map((hold) => holdRow(hold, nameOf(hold)));
  const offers = holds[0].offers.filter((offer) => holds[0].together.includes(offer.word));
  const answers = answerField(offers);
  const reason = reasonField(offers[0].name, true);
  const warning = h('p', { class: 'field-warning', role: 'alert', hidden: true });
  const go = h('button', { type: 'button', class: 'primary', 'data-do': 'send' }, t('several.send'));
  const content = [
    h('p', { class: 'effect' }, t('several.how')),
    h('ul', { class: 'several-rows' }, ...rows.map((row) => row.element)),
    answers.element,
    reason.element,
    warning,
    dialogButtons(() => dialog.close(), go),
  ];
  let isSending = false;
  const judge = () => {
    go.disabled = isSending || news().kind !== 'fresh';
    rows.forEach((row) => row.judge());
  };
  const ends = [subscribe('news', judge), subscribe('hold/', judge)];
  const dialog = openDialog(t('several.title'), content, {
    name: 'several',
    closed: () => ends.forEach((end) => end()),
  });
  judge();
  rows[0].box.focus();

  const ask = async () => {
    const chosen = rows.filter((row) => row.box.checked && !row.box.disabled);
    const lacks = !chosen.length ? t('several.none') : !answers.value() ? t('several.which') : '';
    text(warning, lacks);
    show(warning, lacks);
    if (lacks) warning.scrollIntoView({ block: 'center' });
    if (lacks || !reason.isGiven()) return;
    isSending = true;
    judge();
    let isDone = true;
    for (const row of chosen) isDone = (await row.send(answers.value(), reason.value())) && isDone;
    keepReason(offers[0].name, reason.value());
    isSending = false;
    judge();
    if (isDone && dialog.element.open) dialog.close();
  };
  go.addEventListener('click', () => !isSending && ask());
}

/** A hold of the list: what it is, and what became of its answer. */
function holdRow(hold, name) {
  const box = h('input', { type: 'checkbox', name: 'hold', value: hold.id });
  const said = h('span', { class: 'several-said' }, tOr(`reason.${hold.reason}`, hold.reason));
  const item = h('span', { class: 'several-item' }, hold.item ?? '');
  const words = h('span', {}, h('strong', {}, name), ' ', item, ' ', said);
  let isSent = false;
  return {
    element: h('li', {}, h('label', {}, box, words)),
    box,
    judge() {
      box.disabled = isSent || !part(`hold/${hold.id}`);
      if (box.disabled && !isSent) text(said, t('several.over'));
    },
    async send(word, reason) {
      const offer = hold.offers.find((one) => one.word === word);
      const outcome = await send(offer, { reason }, newTicket(), () =>
        text(said, t('ask.unknown')),
      );
      isSent = outcome.kind === 'accepted';
      text(said, outcomeWords(outcome));
      if (outcome.kind === 'login') await askToLogIn();
      return isSent;
    },
  };
}

function answerField(offers) {
  const name = 'several-answer';
  const fields = offers.map((offer) => h('input', { type: 'radio', name, value: offer.word }));
  const element = h('fieldset', { class: 'field' }, h('legend', {}, t('several.answer')));
  children(
    element,
    element.firstChild,
    ...offers.map((offer, index) =>
      h('label', {}, fields[index], h('span', {}, h('strong', {}, wordOf(offer)), ' ', effectOf(offer))),
    ),
  );
  return { element, value: () => fields.find((one) => one.checked)?.value ?? '' };
}
