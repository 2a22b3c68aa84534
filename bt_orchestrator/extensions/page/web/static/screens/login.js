/** To log in, as a screen: for commands, and for looking where that is not free. */

import { h } from '../core/dom.js';
import { askToLogIn } from '../asking/login.js';
import { onPerson, who } from '../core/me.js';
import { t } from '../core/text.js';

/** Show it; somebody who is logged in goes on to the overview. */
export function mount(root) {
  const go = () => askToLogIn();
  root.append(
    h(
      'section',
      { class: 'panel narrow' },
      h('h1', {}, t('login.title')),
      h('p', {}, t(who().looks_freely ? 'login.why_free' : 'login.why')),
      h(
        'button',
        { type: 'button', class: 'primary', 'data-do': 'log-in', onclick: go },
        t('login.log_in'),
      ),
    ),
  );
  return onPerson(() => {
    if (who().role) location.hash = '#/overview';
  });
}
