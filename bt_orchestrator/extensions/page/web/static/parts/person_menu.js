/** Who sits here, and how they like to see the page: log in and out, lock, language, light or dark. */

import { children, h, text } from '../core/dom.js';
import { askToLogIn } from '../asking/login.js';
import { lock, logout, onPerson, who } from '../core/me.js';
import { part, subscribe } from '../core/store.js';
import { LANGUAGES, currentLanguage, t } from '../core/text.js';
import { THEMES, currentTheme, useTheme } from '../core/theme.js';
import { shape } from '../core/shape.js';

/**
 * Make the menu: an element, `end()`.
 * @param {function(string): void} speak is called with another language
 */
export function personMenu(speak) {
  const words = h('span', { class: 'person-words' });
  const locked = shape('lock');
  const summary = h('summary', {}, locked, words);
  const actions = h('div', { class: 'menu-actions' });
  const access = h('p', { class: 'ros-access' });
  const element = h(
    'details',
    { class: 'menu person', 'data-menu': 'person' },
    summary,
    h('div', { class: 'menu-body' }, actions, languageChoice(speak), themeChoice(), access),
  );

  function update() {
    const { name, role, is_locked: isLocked, how } = who();
    locked.style.display = isLocked ? '' : 'none';
    text(
      words,
      role ? `${name || t('login.this_computer')} · ${t(`role.${role}`)}` : t('login.nobody'),
    );
    const isSession = Boolean(role) && how !== 'this computer';
    children(
      actions,
      !role && action('log-in', 'login.log_in', askToLogIn),
      isLocked && action('unlock', 'login.unlock', askToLogIn),
      isSession && !isLocked && action('lock', 'login.lock', lock),
      isSession && action('log-out', 'login.log_out', logout),
      role && action('other-person', 'login.other', () => askToLogIn({ isAnother: true })),
    );
  }

  function action(name, key, act) {
    const press = () => {
      element.open = false;
      act();
    };
    return h('button', { type: 'button', 'data-do': name, onclick: press }, t(key));
  }

  element.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape' || !element.open) return;
    element.open = false;
    summary.focus();
  });
  element.addEventListener('focusout', (event) => {
    const next = /** @type {Node} */ (event.relatedTarget);
    if (next && !element.contains(next)) element.open = false;
  });
  const showAccess = () => text(access, accessWords(part('cell')));
  const ends = [onPerson(update), subscribe('cell', showAccess)];
  update();
  showAccess();
  return { element, end: () => ends.forEach((end) => end()) };
}

/** Whether the node knows who gives commands over ROS. */
function accessWords(cell) {
  if (!cell?.signed_commands) return '';
  if (cell.signed_commands === 'required') return t('login.signed');
  return t('login.unauthenticated', { role: t(`role.${cell.unauthenticated_role}`) });
}

function languageChoice(speak) {
  const options = Object.entries(LANGUAGES).map(([code, name]) =>
    h('option', { value: code, lang: code, selected: code === currentLanguage() }, name),
  );
  const choice = h(
    'select',
    { 'data-do': 'language', onchange: () => speak(choice.value) },
    options,
  );
  return h('label', { class: 'menu-choice' }, h('span', {}, t('menu.language')), choice);
}

function themeChoice() {
  const options = THEMES.map((theme) =>
    h('option', { value: theme, selected: theme === currentTheme() }, t(`theme.${theme}`)),
  );
  const choice = h(
    'select',
    { 'data-do': 'theme', onchange: () => useTheme(choice.value) },
    options,
  );
  return h('label', { class: 'menu-choice' }, h('span', {}, t('menu.theme')), choice);
}
