/** Begins the page: words, person, stream; and shows the screen of the address. */

import { closeDialogs } from './asking/dialog.js';
import { h } from './core/dom.js';
import { onPerson, refreshPerson, stayAwake, who } from './core/me.js';
import { news, startFollowing, subscribe } from './core/store.js';
import { preferredLanguage, t, useLanguage } from './core/text.js';
import { startTheme } from './core/theme.js';
import { topbar } from './parts/topbar.js';
import { NAVIGATION, SCREENS, routeOf } from './routes.js';

const ASK_AGAIN_MS = 30000;

let bar = null;
let unmount = () => {};
let turn = 0;

/** Draw everything in another language: it changes every word. */
async function speak(language) {
  await useLanguage(language, true);
  build();
  await showScreen();
}

function build() {
  bar?.end();
  bar = topbar(NAVIGATION, speak);
  document.getElementById('top').replaceChildren(bar.element);
}

async function showScreen() {
  const route = routeOf(location.hash);
  const mine = (turn += 1);
  let screen;
  try {
    screen = await SCREENS[route.name]();
  } catch (failed) {
    console.error(failed);
    screen = { mount: mountFailed };
  }
  if (mine !== turn) return;
  const main = document.getElementById('main');
  unmount();
  main.replaceChildren();
  main.dataset.screen = route.name;
  bar.choose(route.place);
  unmount = screen.mount(main, route) ?? (() => {});
}

function mountFailed(root) {
  const again = () => location.reload();
  root.append(
    h(
      'section',
      { class: 'panel' },
      h('p', {}, t('app.not_loaded')),
      h('button', { type: 'button', onclick: again }, t('app.reload')),
    ),
  );
}

function followPerson() {
  let before = news().kind;
  subscribe('news', () => {
    // A page that was started anew has forgotten the sessions; a refused stream wants a login.
    if (news().kind !== before || news().refused) refreshPerson().catch(() => null);
    if (news().refused && !who().role && who().looks_freely === false) location.hash = '#/login';
    before = news().kind;
  });
  setInterval(() => refreshPerson().catch(() => null), ASK_AGAIN_MS);
}

async function begin() {
  startTheme();
  await useLanguage(preferredLanguage());
  build();
  await refreshPerson().catch(() => null);
  startFollowing();
  followPerson();
  stayAwake();
  onPerson(() => document.body.setAttribute('data-role', who().role));
  addEventListener('hashchange', () => {
    closeDialogs();
    scrollTo(0, 0);
    showScreen();
    document.getElementById('main').focus({ preventScroll: true });
  });
  await showScreen();
}

begin();
