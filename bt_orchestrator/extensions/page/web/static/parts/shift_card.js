/** The account of the shift that runs: OEE with its factors, what was made, and what was lost. */

import { attribute, h, keyed, show, text } from '../core/dom.js';
import { part, shownMoment } from '../core/store.js';
import { about, currentLanguage, difference, duration, number, ratio, seconds, t, tOr } from '../core/text.js';

const sheet = (name) => `/api/shift/${name}.html?language=${currentLanguage()}`;
const FACTORS = ['availability', 'performance', 'quality'];
const MOST_LOSSES = 6;
const SHORT_S = 2;

/** Make the card: an element, `update()`, and `tick()`; where no shifts are known it is not shown. */
export function shiftCard() {
  const name = h('h2', {});
  const when = h('span', { class: 'shift-when quiet' });
  const report = h('a', { class: 'button', href: sheet('report'), download: '' }, t('shift.report'));
  const days = h('a', { class: 'button', href: sheet('days'), download: '' }, t('shift.days'));
  const more = h('a', { class: 'button', href: '#/shift' }, t('shift.more_of_it'));
  const files = h('span', { class: 'shift-files' }, more, report, days);
  const target = h('span', { class: 'shift-target quiet' });
  const oee = h('strong', { class: 'shift-oee', 'data-figure': 'oee' });
  const factors = FACTORS.map(factor);
  const made = h('p', { class: 'shift-made' });
  const stopped = h('p', { class: 'shift-stopped' });
  const losses = lossList();
  const note = h('p', { class: 'remark' });
  const figures = h(
    'div',
    {},
    h(
      'div',
      { class: 'shift-figures' },
      h('p', { class: 'shift-whole' }, h('span', {}, t('shift.oee')), oee, target),
      factors.map((one) => one.element),
    ),
    made,
    stopped,
    losses.element,
  );
  const element = h(
    'section',
    { class: 'panel shift', 'data-part': 'shift' },
    h('div', { class: 'shift-head' }, name, when, files),
    figures,
    note,
  );
  const tick = () => sayStopped(stopped, part('shift'));
  return {
    element,
    tick,
    update() {
      const shift = part('shift');
      show(element, shift);
      if (!shift) return;
      const isKnown = shift.shift !== null;
      attribute(element, 'data-shift', shift.shift);
      attribute(element, 'data-runs', isKnown && shift.runs);
      attribute(element, 'aria-busy', shift.is_reading ? 'true' : null);
      text(name, isKnown ? t('shift.title', { name: shift.shift }) : t('shift.none'));
      [figures, when, files].forEach((one) => show(one, isKnown));
      const lacks = isKnown ? lackWords(shift) : noneWords(shift);
      text(note, lacks);
      show(note, lacks);
      if (!isKnown) return;
      text(when, whenWords(shift));
      text(oee, ratio(shift.oee));
      show(target, shift.targets.oee);
      text(target, t('shift.target', { target: ratio(shift.targets.oee) }));
      factors.forEach((one) => one.update(shift));
      text(made, madeWords(shift));
      losses.update(shift);
      tick();
    },
  };
}

function factor(name) {
  const value = h('strong', { 'data-figure': name });
  const full = h('span', { class: 'share-full' });
  const element = h(
    'p',
    { class: 'shift-factor' },
    h('span', {}, t(`shift.${name}`)),
    value,
    h('span', { class: 'share', 'aria-hidden': 'true' }, full),
  );
  return {
    element,
    update(shift) {
      text(value, ratio(shift[name]));
      share(full, shift[name] ?? 0);
    },
  };
}

function lossList() {
  const list = h('ul', { class: 'losses' });
  const more = h('p', { class: 'quiet' });
  const rows = keyed(list, (one) => one.loss, lossRow);
  const title = h('h3', {}, t('shift.lost'));
  return {
    element: h('div', {}, title, list, more),
    update(shift) {
      const found = [...shift.losses].sort((one, other) => other.seconds - one.seconds);
      const shown = found.slice(0, MOST_LOSSES);
      const most = shown[0]?.seconds || 1;
      rows(shown.map((one) => ({ ...one, share: one.seconds / most })));
      show(title, shown.length);
      const rest = found.slice(MOST_LOSSES);
      show(more, rest.length);
      const lost = duration(rest.reduce((sum, one) => sum + one.seconds, 0));
      text(more, t('shift.more', { count: rest.length, lost }));
    },
  };
}

function lossRow({ loss }) {
  const full = h('span', { class: 'share-full' });
  const lost = h('span', { class: 'loss-time' });
  const element = h(
    'li',
    { class: 'loss', 'data-loss': loss },
    h('span', {}, t(`loss.${loss}`)),
    h('span', { class: 'share', 'aria-hidden': 'true' }, full),
    lost,
  );
  return {
    element,
    update(one) {
      text(lost, difference(one.seconds));
      share(full, one.share);
    },
  };
}

function whenWords({ runs, end, next }) {
  if (runs) return t('shift.until', { time: about(end) });
  const ended = t('shift.ended', { time: about(end) });
  return next
    ? `${ended}; ${t('shift.next', { name: next.shift, time: about(next.begin) })}`
    : ended;
}

function madeWords(shift) {
  const made = t('shift.made', { produced: number(shift.produced), good: number(shift.good) });
  if (!shift.produced) return made;
  const rate = t('shift.rate', { rate: seconds(shift.per_item_s) });
  const pace = shift.pace_s === null ? '' : t('shift.pace', { pace: seconds(shift.pace_s) });
  return [made, rate, pace].filter(Boolean).join(' · ');
}

function noneWords(shift) {
  return shift.is_reading ? t('shift.reading') : shift.why_not;
}

function lackWords(shift) {
  const said = [];
  if (!shift.has_pace) said.push(t('shift.no_pace'));
  if (shift.lack) said.push(t(`shift.lack_${shift.lack}`));
  if (shift.damaged) said.push(t('shift.damaged', { count: shift.damaged }));
  said.push(...shift.clock_set.map(clockWords), ...shift.breaks.map(breakWords));
  if (shift.why_not) said.push(t('jobs.not_whole', { why: shift.why_not }));
  return said.join(' ');
}

function clockWords({ seconds: by, before, after }) {
  const way = by < 0 ? 'shift.clock_back' : 'shift.clock_forward';
  return t(way, { by: duration(Math.abs(by)), before: about(before), after: about(after) });
}

function breakWords({ begin, end, usual_s: usual }) {
  const took = duration(end - begin);
  return t('shift.break', { begin: about(begin), end: about(end), took, usual: duration(usual) });
}

/** Say what the time is lost to now; not what is over before anybody has read it. */
function sayStopped(element, shift) {
  const stopped = shift?.stopped;
  const since = stopped ? shownMoment() - stopped.since : 0;
  const isSaid = since >= SHORT_S;
  show(element, isSaid);
  if (!isSaid) return;
  const word = tOr(`shift.now_${stopped.loss}`, t(`loss.${stopped.loss}`));
  const what = [word, stopped.component].filter(Boolean).join(', ');
  attribute(element, 'data-loss-now', stopped.loss);
  text(element, t('shift.now', { what, time: about(stopped.since), lost: duration(since) }));
}

function share(element, value) {
  element.style.width = `${Math.max(0, Math.min(1, value)) * 100}%`;
}
