/** The check of an order by the page, while it is written and before it is sent. */

import { Refused, post } from '../../core/api.js';
import { askToLogIn } from '../../asking/login.js';
import { onPerson, who } from '../../core/me.js';
import { attribute, text } from '../../core/dom.js';
import { said as inLanguage, t } from '../../core/text.js';

const WAIT_MS = 600;
const WITHIN_MS = 60000;

/** Make it: `later()` after an entry, `now()` (whether it may be sent), `end()`. */
export function checking(form, said) {
  let timer = 0;
  let turn = 0;
  let asking = new AbortController();
  const end = onPerson(() => later());

  function later() {
    clearTimeout(timer);
    turn += 1;
    timer = setTimeout(() => check(false), WAIT_MS);
  }

  function say(kind, words) {
    attribute(said, 'data-check', kind);
    text(said, words);
  }

  async function check(isAll) {
    const mine = (turn += 1);
    const { order } = form.value();
    if (!order.script && !order.recipe) {
      const rest = isAll ? [{ field: 'script', what: t('order.script_missing') }] : [];
      form.warn(rest, isAll);
      say('open', isAll ? t('order.mend') : '');
      return false;
    }
    if (!who().role) {
      say('open', t('order.log_in'));
      return false;
    }
    say('computing', t('order.checking'));
    asking.abort();
    asking = new AbortController();
    try {
      const found = await post('/api/orders/check', { order }, WITHIN_MS, asking.signal);
      if (mine === turn) judge(found, isAll);
      return mine === turn && found.accepted;
    } catch (refused) {
      if (!(refused instanceof Refused)) throw refused;
      if (mine === turn)
        say('unknown', t('order.not_checked', { why: refused.message || t('whatif.no_answer') }));
      // The cell checks it again: an order that cannot be checked here may be given all the same.
      return refused.status === 0 || refused.status >= 500;
    }
  }

  function judge(found, isAll) {
    const rest = form.warn(found.findings, isAll);
    if (found.accepted && found.is_checked) say('fine', t('order.fine'));
    else if (found.accepted)
      say('unknown', t('order.not_checked', { why: inLanguage(found.said) }));
    else if (rest) say('wrong', rest);
    else if (found.findings.length)
      say('open', isAll ? t('order.mend') : t('order.open', { count: found.findings.length }));
    else say('wrong', inLanguage(found.said));
  }

  return {
    later,
    async now() {
      clearTimeout(timer);
      if (!who().role && !(await askToLogIn())) return false;
      return check(true);
    },
    end() {
      clearTimeout(timer);
      turn += 1;
      end();
    },
  };
}
