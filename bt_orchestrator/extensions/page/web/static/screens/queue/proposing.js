/** An order for the queue: proposed by the engine, and applied by one request. */

import { ask } from '../../asking/ask.js';
import { Refused, post } from '../../core/api.js';
import { h, show, text } from '../../core/dom.js';
import { duration, number, t } from '../../core/text.js';

/** The computation is bounded by steps, not by time. */
const WITHIN_MS = 310000;

/** Make it: a button, words below the title, `update(queued)`. */
export function proposing() {
  const button = h(
    'button',
    { type: 'button', 'data-do': 'propose', hidden: true, onclick: propose },
    t('propose.button'),
  );
  const words = h('p', { class: 'queue-proposal', role: 'status', hidden: true });

  async function propose() {
    button.disabled = true;
    say('computing', t('propose.computing'));
    try {
      const found = await post('/api/queue/propose', {}, WITHIN_MS);
      const said = [lateWords(found), changeoverWords(found), sureWords(found)];
      const how = said.filter(Boolean).join(' ');
      say(found.offer ? 'new' : 'same', found.offer ? how : `${t('propose.same')} ${how}`);
      if (found.offer) await ask(found.offer, { said: how });
    } catch (refused) {
      if (!(refused instanceof Refused)) throw refused;
      say('unknown', t('propose.cannot', { why: refused.message || t('whatif.no_answer') }));
    } finally {
      button.disabled = false;
    }
  }

  function say(kind, said) {
    words.dataset.proposal = kind;
    text(words, said);
    show(words, said);
  }

  return { button, words, update: (queued) => show(button, queued > 1) };
}

function lateWords({ late_s: now, new_late_s: then }) {
  if (!then) return t('propose.none_late');
  return t('propose.late', { then: duration(then), now: duration(now) });
}

/** Say how long setups are changed; empty: not at all. */
function changeoverWords({ changeover_s: now, new_changeover_s: then }) {
  if (!then && !now) return '';
  return t('propose.changeover', { then: duration(then), now: duration(now) });
}

/** Say what is known of better orders. */
function sureWords({ is_best: isBest, looked_at: count, orders }) {
  if (orders === 1) return t('propose.only');
  if (isBest) return t('propose.best', { orders: number(orders) });
  return t('propose.looked_at', { count: number(count), orders: number(orders) });
}
