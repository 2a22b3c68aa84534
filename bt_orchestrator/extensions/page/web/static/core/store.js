/**
 * What this tab knows of the cell, and how fresh it is.
 *
 * News are 'fresh'; or old, because the 'page' does not answer, or the cell's 'node' is silent; or
 * 'none' has come yet. `<body data-…>` says the same for tests.
 */

import { Board } from './board.js';
import { follow } from './stream.js';

const SILENT_S = 3;
const KEPT_EVENTS = 1000;

const board = new Board();
const listeners = new Set();
const freshness = { kind: 'none', heard: null, refused: false, full: false };
const events = [];
let stream = null;
let lastBeat = null;
let clockAhead = 0;

/** A part by key, for instance part('section/3'); undefined: there is none. */
export function part(key) {
  return board.parts.get(key);
}

/** The parts whose key begins so, by key. */
export function partsOf(prefix) {
  return [...board.parts].filter(([key]) => key.startsWith(prefix));
}

/** The newest events that were seen here, oldest first. */
export function recentEvents() {
  return events;
}

/** History and number of the newest event, and spans of events that did not come. */
export function position() {
  return { history: board.history, seq: board.seq, gaps: board.gaps };
}

/** How fresh the news are: kind, when the cell was last heard (seconds), refused, full. */
export function news() {
  return freshness;
}

/** Seconds since the epoch, by the clock of the page's computer: ages are told by one clock. */
export function clock() {
  return Date.now() / 1000 + clockAhead;
}

/** The moment that the parts show: what runs is not known to go on while nothing is heard of it. */
export function shownMoment() {
  return freshness.kind === 'fresh' ? clock() : Math.min(clock(), freshness.heard ?? clock());
}

/**
 * Call a function whenever parts change whose key begins so; also 'news' (how fresh they are),
 * 'event' (something happened), and '' (anything).
 * @returns {function(): void} ends it
 */
export function subscribe(prefix, callback) {
  const listener = { prefix, callback };
  listeners.add(listener);
  return () => listeners.delete(listener);
}

/** Follow the cell from now on. */
export function startFollowing() {
  stream = follow(() => board.cursor, take);
  setInterval(judge, 500);
}

/** Ask for the stream at once where it was refused: somebody has logged in. */
export function followAgain() {
  if (freshness.refused) stream.again();
}

const TAKES = {
  opened() {
    board.opened();
    return [];
  },
  begin(data) {
    if (board.begin(data)) events.length = 0;
    freshness.refused = false;
    freshness.full = false;
    if (data.now !== undefined) beat(data);
    return ['news'];
  },
  parts: (data) => [...board.take(data)],
  happened(data) {
    const fresh = board.happened(data);
    for (const record of fresh) {
      record.named = data.names?.[record.seq] ?? '';
      document.body.dataset.seq = record.seq;
    }
    events.push(...fresh);
    events.splice(0, events.length - KEPT_EVENTS);
    return fresh.length ? ['event'] : [];
  },
  gap(data) {
    board.lost(data);
    return ['news'];
  },
  beat(data) {
    beat(data);
    return [];
  },
  full() {
    freshness.full = true;
    return ['news'];
  },
  refused() {
    freshness.refused = true;
    return ['news'];
  },
  cut: () => [],
};

function take(kind, data) {
  const gapsBefore = board.gaps.length;
  const changed = TAKES[kind](data);
  if (board.gaps.length !== gapsBefore) changed.push('news');
  mark();
  tell(changed);
  judge();
}

function beat({ silent_s: silent, now }) {
  lastBeat = performance.now();
  clockAhead = now - Date.now() / 1000;
  freshness.heard = board.history ? now - silent : null;
  freshness.silent = silent >= SILENT_S;
}

function judge() {
  const kind = kindNow();
  if (kind === freshness.kind) return;
  freshness.kind = kind;
  mark();
  tell(['news']);
}

function kindNow() {
  if (lastBeat === null) return 'none';
  if (performance.now() - lastBeat >= SILENT_S * 1000) return 'page';
  return freshness.silent ? 'node' : 'fresh';
}

function mark() {
  /** @type {Object<string, *>} */
  const marks = document.body.dataset;
  marks.history = board.history;
  marks.first = board.first;
  marks.seq = board.seq;
  marks.version = board.version;
  marks.twice = board.twice;
  marks.gaps = board.gaps.map(({ first, last }) => `${first}-${last}`).join(' ');
  marks.news = freshness.kind;
}

function tell(changed) {
  for (const { prefix, callback } of [...listeners]) {
    if (changed.some((key) => key.startsWith(prefix))) callback();
  }
}
