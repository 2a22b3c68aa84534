/** The goal of manual mode. */

import { attribute, children, h, show, text } from '../core/dom.js';
import { part, shownMoment } from '../core/store.js';
import { duration, t, tOr } from '../core/text.js';
import { everySecond } from '../core/tick.js';
import { offers } from './offers.js';
import { jsonValues, values } from './values.js';

/** The task that runs, or how the last one ended. */
export function goalView() {
  const nothing = h('p', { class: 'nothing' }, t('manual.none'));
  const title = h('p', { class: 'manual-title' });
  const state = h('p', { class: 'manual-state', role: 'status' });
  const asked = h('p', { class: 'hint' });
  const cancel = offers({ label: t('manual.cancel') });
  const told = h('div', { class: 'feedback' });
  const whole = h('div', {}, title, state, cancel.element, told, asked);
  const element = h('div', { 'data-manual': '' }, nothing, whole);
  everySecond(element, () => update(part('cell')));

  function update(cell) {
    const goal = cell?.manual ?? null;
    show(nothing, !goal);
    show(whole, Boolean(goal));
    attribute(element, 'data-manual', goal?.state ?? '');
    if (!goal) return;
    const took = duration((goal.ended ?? shownMoment()) - goal.started);
    const word = tOr(`manual.${goal.state}`, tOr(`reason.${goal.state}`, goal.state));
    text(title, `${goal.task} · ${goal.component}`);
    text(state, [`${word} · ${took}`, goal.message].filter(Boolean).join(' · '));
    text(asked, t('manual.asked', { who: goal.who, why: goal.reason }));
    cancel.update(goal.ended === null && cell.manual_offers.cancel ? [cell.manual_offers.cancel] : []);
    const feedback = part(`component/${goal.component}`)?.feedback;
    const said = JSON.stringify([goal.results, goal.ended === null ? feedback : '']);
    if (told.dataset.said === said) return;
    told.dataset.said = said;
    const isTold = Object.keys(goal.results).length > 0;
    children(
      told,
      isTold ? values(goal.results) : null,
      goal.ended === null && feedback ? jsonValues(feedback) : null,
    );
  }

  return { element, update, end: () => cancel.end() };
}
