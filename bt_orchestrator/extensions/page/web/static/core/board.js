/**
 * The news of one cell put together: parts by key, and how far the events have come.
 *
 * The worker and each tab keep one; a tab that opens later gets the worker's as one piece.
 */
export class Board {
  constructor() {
    this.parts = new Map();
    this.history = '';
    this.version = 0;
    this.seq = 0;
    /** The first event that is told here, if it comes. */
    this.first = 1;
    this.node = '';
    /** Numbers of events that came twice, and spans that did not come. */
    this.twice = 0;
    this.gaps = [];
    this.takesWhole = false;
  }

  /** A stream was opened: the first parts that it tells are all that there are. */
  opened() {
    this.takesWhole = true;
  }

  /** The events of a history begin. Numbers of another one mean nothing here. */
  begin({ history, after, node, is_catching_up: isCatchingUp = false }) {
    const isNew = history !== this.history || isCatchingUp;
    if (isNew) {
      this.history = history;
      this.seq = after;
      this.first = after + 1;
      this.gaps = [];
      this.twice = 0;
    } else if (after > this.seq) {
      this.gaps.push({ first: this.seq + 1, last: after });
      this.seq = after;
    }
    this.node = node;
    this.takesWhole ||= isCatchingUp;
    return isNew;
  }

  /** Take changed parts; return the keys that changed. */
  take({ version, set, gone }) {
    const changed = new Set(Object.keys(set));
    const leaving = this.takesWhole
      ? [...this.parts.keys()].filter((key) => !changed.has(key))
      : gone;
    for (const key of leaving) {
      this.parts.delete(key);
      changed.add(key);
    }
    for (const [key, value] of Object.entries(set)) this.parts.set(key, value);
    this.takesWhole = false;
    this.version = version;
    return changed;
  }

  /** Take events; return those that are new, each exactly once. */
  happened({ history, records }) {
    if (history !== this.history) return [];
    const news = [];
    for (const record of records) {
      if (record.seq <= this.seq) {
        this.twice += 1;
        continue;
      }
      if (record.seq > this.seq + 1) this.gaps.push({ first: this.seq + 1, last: record.seq - 1 });
      this.seq = record.seq;
      news.push(record);
    }
    return news;
  }

  /** Events are lost for good: say so, and go on behind them. */
  lost({ first, last }) {
    this.gaps.push({ first: Math.max(first, this.seq + 1), last });
    this.seq = Math.max(this.seq, last);
  }

  /** Where a stream has to go on; empty: from now. */
  get cursor() {
    return this.history ? `${this.history}:${this.seq}` : '';
  }
}
