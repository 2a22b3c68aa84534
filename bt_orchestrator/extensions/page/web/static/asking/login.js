/** The dialog to log in, or to unlock a locked session. */

import { Refused } from '../core/api.js';
import { dialogButtons, openDialog } from './dialog.js';
import { h, show, text } from '../core/dom.js';
import { login, unlock, who } from '../core/me.js';
import { followAgain } from '../core/store.js';
import { t, tOr } from '../core/text.js';

/**
 * Ask who sits here.
 * @param {Object} options
 * @param {boolean} [options.isAnother] somebody else than the one who is logged in
 * @returns {Promise<boolean>} whether somebody is logged in now
 */
export function askToLogIn({ isAnother = false } = {}) {
  const isLocked = who().is_locked && !isAnother;
  return new Promise((resolve) => {
    let isIn = false;
    const name = h('input', {
      name: 'username',
      autocomplete: 'username',
      autocapitalize: 'off',
      spellcheck: 'false',
      required: true,
    });
    const password = h('input', {
      name: 'password',
      type: 'password',
      autocomplete: 'current-password',
      required: true,
    });
    const warning = h('p', { class: 'field-warning', role: 'alert', hidden: true });
    const go = h(
      'button',
      { type: 'submit', class: 'primary', 'data-do': 'log-in' },
      t(isLocked ? 'login.unlock' : 'login.log_in'),
    );
    const form = h(
      'form',
      { onsubmit: submit, 'data-form': 'login' },
      isLocked ? h('p', {}, t('login.locked', { name: who().name })) : field('login.name', name),
      field('login.password', password),
      warning,
      dialogButtons(() => dialog.close(), go),
    );
    const dialog = openDialog(t(isLocked ? 'login.unlock' : 'login.title'), [form], {
      name: 'login',
      closed: () => resolve(isIn),
    });
    (isLocked ? password : name).focus();

    async function submit(event) {
      event.preventDefault();
      go.disabled = true;
      show(warning, false);
      try {
        await (isLocked ? unlock(password.value) : login(name.value.trim(), password.value));
        isIn = true;
        followAgain();
        dialog.close();
      } catch (refused) {
        if (!(refused instanceof Refused)) throw refused;
        password.value = '';
        text(warning, tOr(`login.refused_${refused.status}`, refused.message));
        show(warning, true);
        go.disabled = false;
        password.focus();
      }
    }
  });
}

function field(key, input) {
  return h('div', { class: 'field' }, h('label', {}, h('span', {}, t(key)), input));
}
