/** A hold where one looks at what is held: why, since when, and the answers. */
import { h, text } from '../core/dom.js';
import { at, t, tOr } from '../core/text.js';
import { itemLink, jobLink } from './links.js';
import { offers } from './offers.js';
import { shape } from './shape.js';

/** A hold: an element, `update(hold)` and `end()`. */
export function holdHere(first) {
  const why = h('strong', { class: 'alarm' });
  const about = h('p', {}, first.task ? h('strong', {}, first.task) : null, first.task ? ' ' : null, subject(first));
  const since = h('p', { class: 'quiet' });
  const buttons = offers({ about: () => t('chain.hold', { name: first.id }), label: t('chain.hold', { name: first.id }) });
  return {
    element: h('section', { class: 'panel hold-here' }, h('p', {}, shape('triangle'), ' ', why), about, since, buttons.element),
    update(hold) {
      const reason = tOr(`reason.${hold.reason}`, hold.reason);
      text(why, `${t('chain.hold', { name: hold.id })}: ${hold.message ? `${reason} (${hold.message})` : reason}`);
      const times = hold.attempts ? ` · ${t('section.attempt_of', hold)}` : '';
      text(since, `${t('section.since', { time: at(hold.since) })}${times}`);
      buttons.update(hold.offers);
    },
    end: buttons.end,
  };
}

function subject({ item, job }) {
  if (item) return itemLink(item);
  return job ? jobLink(job) : null;
}
