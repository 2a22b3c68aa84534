/** The cell at a glance: what waits for a person comes first, then the line, then the jobs. */

import { severalButtons } from '../asking/several.js';
import { attribute, h, keyed, show, text } from '../core/dom.js';
import { news, part, subscribe } from '../core/store.js';
import { t } from '../core/text.js';
import { everySecond } from '../core/tick.js';
import { beltStrip } from '../parts/belt_strip.js';
import { holdCard, holdTitle } from '../parts/hold_card.js';
import { jobRow } from '../parts/job_row.js';
import { journalKnown } from '../parts/journal_known.js';
import { sectionCard } from '../parts/section_card.js';
import { shiftCard } from '../parts/shift_card.js';
import { flagList, nodeList, troubleList } from '../parts/side_lists.js';

const MOST_JOBS = 12;
const MOST_ENDED = 2;

/** Show it. */
export function mount(root) {
  const holds = holdList();
  const belt = beltStrip();
  const sections = sectionGrid();
  const jobs = jobList();
  const troubles = troubleList();
  const flags = flagList();
  const nodes = nodeList();
  const shift = shiftCard();
  const page = h(
    'div',
    { class: 'overview' },
    holds.element,
    h('div', { class: 'overview-line' }, belt.element, sections.element),
    h(
      'div',
      { class: 'overview-side' },
      jobs.element,
      h('div', { class: 'overview-aside' }, troubles.element, shift.element, flags.element, nodes.element),
    ),
  );
  const silence = h('p', { class: 'panel' }, t('overview.nothing_heard'));
  const journal = h('div');
  const title = h('h1', { class: 'for-readers' }, t('overview.title'));
  root.append(title, silence, journal, page);
  /** @type {Array<[string[], function(): void]>} */
  const shown = [
    [['cell', 'news'], () => showWhichThereIs({ silence, journal, page })],
    [['cell', 'hold/'], holds.update],
    [['cell', 'belt', 'section/'], belt.update],
    [['cell', 'section/'], sections.update],
    [['cell', 'job/'], jobs.update],
    [['component/'], troubles.update],
    [['flags'], flags.update],
    [['cell'], nodes.update],
    [['shift'], shift.update],
  ];
  const ends = shown.flatMap(([prefixes, update]) => {
    update();
    return prefixes.map((prefix) => subscribe(prefix, update));
  });
  everySecond(page, () => [holds, belt, sections, shift].forEach((one) => one.tick()));
  return () => {
    ends.forEach((end) => end());
    holds.end();
  };
}

function showWhichThereIs({ silence, journal, page }) {
  const isHeard = Boolean(part('cell'));
  show(silence, !isHeard);
  show(page, isHeard);
  show(journal, !isHeard);
  if (isHeard || journal.firstChild || news().kind !== 'node') return;
  const known = journalKnown();
  journal.append(known.element);
  known.read();
}

function partsNamed(kind, ids = []) {
  return ids.map((id) => part(`${kind}/${id}`)).filter(Boolean);
}

function holdList() {
  const nothing = h('p', { class: 'no-holds quiet' }, t('overview.no_holds'));
  const list = h('div', { class: 'holds' });
  const cards = live(list, (hold) => hold.id, holdCard);
  const several = severalButtons(holdTitle);
  return {
    element: h(
      'section',
      {
        class: 'hold-region',
        'data-part': 'holds',
        'aria-label': t('overview.holds'),
        tabindex: -1,
      },
      nothing,
      several.element,
      list,
    ),
    tick: cards.tick,
    end: cards.end,
    update() {
      const holds = partsNamed('hold', part('cell')?.holds);
      cards.update(holds);
      several.update(holds);
      show(nothing, !holds.length);
      show(list, holds.length);
    },
  };
}

function sectionGrid() {
  const element = h('div', { class: 'sections', 'data-part': 'sections' });
  const cards = live(element, (section) => section.number, sectionCard);
  return {
    element,
    tick: cards.tick,
    update() {
      const sections = partsNamed('section', part('cell')?.sections);
      attribute(element, 'data-many', sections.length > 12);
      element.style.setProperty('--sections', `${sections.length}`);
      cards.update(sections);
    },
  };
}

function jobList() {
  const list = h('ul', { class: 'jobs' });
  const rows = keyed(list, (job) => job.id, jobRow);
  const more = h('a', { class: 'more-jobs', href: '#/queue' });
  const nothing = h(
    'p',
    { class: 'quiet' },
    t('overview.no_jobs'),
    ' ',
    h('a', { href: '#/order' }, t('nav.order')),
  );
  return {
    element: h(
      'section',
      { class: 'panel', 'data-part': 'jobs' },
      h('h2', {}, t('overview.jobs')),
      nothing,
      list,
      more,
    ),
    update() {
      const all = partsNamed('job', part('cell')?.jobs);
      const open = all.filter((job) => !job.is_over);
      const ended = all.filter((job) => job.is_over).slice(-MOST_ENDED);
      const left =
        open.length > MOST_JOBS
          ? (part('cell')?.queued ?? 0) -
            open.slice(0, MOST_JOBS).filter((job) => job.position).length
          : 0;
      rows([...open.slice(0, MOST_JOBS), ...ended]);
      show(nothing, !open.length);
      show(more, left > 0);
      text(more, t('overview.more_jobs', { count: left }));
    },
  };
}

/** A keyed list of views that also tell time. */
function live(parent, key, make) {
  const views = new Map();
  const update = keyed(parent, key, (thing) => {
    const view = make();
    let shown = null;
    views.set(key(thing), view);
    return {
      ...view,
      update(now) {
        // A part that did not change is the same object: of a hundred sections few change at once.
        if (now !== shown) view.update(now);
        shown = now;
      },
      end() {
        view.end?.();
        views.delete(key(thing));
      },
    };
  });
  return {
    update,
    tick: () => views.forEach((view) => view.tick()),
    end: () => update([]),
  };
}
