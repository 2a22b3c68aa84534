/** The bar above every screen: how the cell is, why, what can be done now, and how old this is. */

import { get } from '../core/api.js';
import { attribute, h, show, text } from '../core/dom.js';
import { isEmergency } from '../core/requests.js';
import { news, part, shownMoment, subscribe } from '../core/store.js';
import { at, duration, said, t, tOr } from '../core/text.js';
import { everySecond } from '../core/tick.js';
import { newsLine, newsTrouble } from './news_line.js';
import { offers } from './offers.js';
import { personMenu } from './person_menu.js';
import { room } from './room.js';
import { reshape, shape } from '../core/shape.js';
import { standsSilently, whyItStands } from '../core/stands.js';

const SHAPES = { working: 'play', quiet: 'ring', stopped: 'square', trouble: 'triangle' };
const LATER = /^cell\.(stop_after_|local$|remote$|manual$)/;

/**
 * Make the bar: an element, `choose(screen)` and `end()`.
 * @param {Array<{name: string, href: string}>} screens those with a place in the navigation
 * @param {function(string): void} speak is called with another language
 */
export function topbar(screens, speak) {
  const state = stateBlock();
  const commands = commandBlock();
  const person = personMenu(speak);
  const links = screens.map(({ name, href }) =>
    h('a', { href, 'data-screen': name }, t(`nav.${name}`)),
  );
  const link = (screen) => links.find((one) => one.dataset.screen === screen);
  showWithPlant(link('cells'));
  const endManual = subscribe('cell', () => showManual(link('manual')));
  showManual(link('manual'));
  const nav = h('nav', { 'aria-label': t('nav.label') }, links);
  const element = h(
    'div',
    { class: 'topbar' },
    h('div', { class: 'top-row' }, state.element, commands.element),
    h('div', { class: 'nav-row' }, nav, person.element),
  );
  return {
    element,
    choose(screen) {
      for (const link of links)
        attribute(link, 'aria-current', link.dataset.screen === screen ? 'page' : null);
    },
    end() {
      for (const one of [state, commands, person]) one.end();
      endManual();
    },
  };
}

/** The screen of cells has a place only where the page has the database of a plant. */
function showWithPlant(link) {
  show(link, false);
  get('/api/cells')
    .then(({ has_plant }) => show(link, has_plant))
    .catch(() => show(link, true)); // it says why it is empty
}

/** The screen of manual mode has a place while the line is in local: others cannot use it. */
function showManual(link) {
  const cell = part('cell');
  show(link, cell?.control === 'local' || cell?.unit_mode === 'manual');
}

function stateBlock() {
  const drawn = shape('ring');
  const name = h('span', { class: 'cell-name' });
  const word = h('strong', { class: 'state-word' });
  const since = h('span', { class: 'state-since' });
  const local = h('span', { class: 'in-local' });
  const unsafe = h('span', { class: 'unsafe' });
  const why = room('state-why');
  const element = h(
    'div',
    { class: 'state', 'data-part': 'cell' },
    drawn,
    h('div', { class: 'state-line' }, name, word, local, unsafe, since),
    why.element,
  );

  function update() {
    const cell = part('cell');
    showKind(element, drawn, cell);
    text(name, cell?.name ?? '');
    showLocal(local, cell);
    showUnsafe(unsafe, cell);
    text(word, cell ? stateWords(cell) : t('news.waiting'));
    text(since, cell ? sinceWords(sinceWhen(cell)) : '');
    why.say(newsTrouble() || (cell ? whyItStands(cell) : ''));
    document.title = cell
      ? `${tOr(`state.${cell.state}`, cell.state)} · ${cell.name}`
      : 'bt_orchestrator';
  }

  const ends = ['cell', 'hold/', 'news'].map((prefix) => subscribe(prefix, update));
  everySecond(element, update);
  return { element, end: () => ends.forEach((end) => end()) };
}

/** Show the kind of the state as a colour and a shape; it is broken without news. */
function showKind(element, drawn, cell) {
  const kind = cell?.state_kind ?? 'unknown';
  attribute(element, 'data-kind', kind);
  attribute(element, 'data-state', cell?.state ?? '');
  attribute(element, 'data-news', news().kind);
  reshape(drawn, news().kind === 'fresh' ? (SHAPES[kind] ?? 'ring') : 'broken');
}

/** Show that the line is in local, or even in manual. */
function showLocal(element, cell) {
  const isLocal = cell?.control === 'local';
  const isManual = cell?.unit_mode === 'manual';
  show(element, isLocal || isManual);
  text(element, isManual ? t('topbar.in_manual') : isLocal ? t('topbar.in_local') : '');
  attribute(element, 'title', isLocal ? t('ask.in_local') : null);
}

/** Show why the safety input is not ready; without one, or with `ready`, there is nothing to show. */
function showUnsafe(element, cell) {
  const isUnsafe = Boolean(cell?.safety) && cell.safety !== 'ready';
  show(element, isUnsafe);
  text(element, isUnsafe ? t('topbar.unsafe', { why: said(cell.safety_said) }) : '');
}

/** Since when the word of the state is true. */
function sinceWhen(cell) {
  return standsSilently(cell) ? cell.stands.since : cell.since;
}

function sinceWords(when) {
  return t('topbar.since', { time: at(when), duration: duration(shownMoment() - when) });
}

function stateWords(cell) {
  const state = standsSilently(cell) ? t('standing.state') : tOr(`state.${cell.state}`, cell.state);
  return news().kind === 'fresh' ? state : t('news.last_known', { state });
}

function commandBlock() {
  const now = offers({ isCompact: true, label: t('topbar.commands') });
  const later = offers({ label: t('topbar.later') });
  const menu = h(
    'details',
    { class: 'menu later', 'data-menu': 'later' },
    h('summary', {}, t('topbar.later')),
    h('div', { class: 'menu-body' }, later.element),
  );
  const line = newsLine();
  const element = h(
    'div',
    { class: 'commands' },
    h('div', { class: 'command-row' }, menu, now.element),
    h(
      'div',
      { class: 'under-commands' },
      line.element,
      h('p', { class: 'no-estop' }, t('topbar.no_estop')),
    ),
  );

  function update() {
    const offered = part('cell')?.offers ?? [];
    const stopsLater = offered.filter((offer) => LATER.test(offer.name));
    const others = offered.filter((offer) => !LATER.test(offer.name));
    // Danger has its place at the edge, whatever else there is.
    now.update([...others.filter((offer) => !isEmergency(offer)), ...others.filter(isEmergency)]);
    later.update(stopsLater);
    show(menu, stopsLater.length);
  }

  menu.addEventListener('click', ({ target }) => {
    if (/** @type {Element} */ (target).closest('button')) menu.open = false;
  });
  const end = subscribe('cell', update);
  update();
  return {
    element,
    end() {
      end();
      now.end();
      later.end();
      line.end();
    },
  };
}
