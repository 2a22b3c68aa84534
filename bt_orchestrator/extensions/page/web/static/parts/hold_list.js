/** The holds of one thing as cards, as on the overview. */
import { h, keyed } from '../core/dom.js';
import { everySecond } from '../core/tick.js';
import { holdCard } from './hold_card.js';

/** A list of holds: an element and `update(holds)`; with none of them it takes no room. */
export function holdList() {
  const element = h('div', { class: 'holds' });
  const update = keyed(
    element,
    (hold) => hold.id,
    () => {
      const card = holdCard();
      everySecond(card.element, () => card.element.isConnected && card.tick());
      return card;
    },
  );
  return { element, update };
}
