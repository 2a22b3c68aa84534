/** All jobs that the journal knows, newest first, page by page. */
import { get } from '../core/api.js';
import { newestOnly } from '../core/asking.js';
import { children, h, show, text } from '../core/dom.js';
import { subscribe } from '../core/store.js';
import { at, t } from '../core/text.js';
import { jobTable } from '../parts/job_table.js';
import { inPath, itemLink } from '../parts/links.js';

const MOST = 50;

/** Show it in a root, until the function that is returned is called. */
export function mount(root) {
  const screen = new Jobs();
  root.append(screen.element);
  screen.first();
  const end = subscribe('cell', () => screen.refresh());
  return () => end();
}

class Jobs {
  constructor() {
    this.table = jobTable();
    this.older = h('button', { type: 'button', onclick: () => this.next() }, t('jobs.older'));
    this.note = h('p', { class: 'remark', role: 'status' });
    this.jobs = [];
    this.element = h(
      'div',
      { class: 'screen' },
      h('div', { class: 'screen-head' }, h('h1', {}, t('jobs.title'))),
      serialSearch(),
      this.note,
      h('section', { class: 'panel' }, this.table.element),
      this.older,
    );
  }

  /** Read the newest page again: jobs may have come, or ended. */
  async first() {
    await this.#read('', (page) => {
      const newest = new Set(page.jobs.map((job) => job.id));
      this.jobs = [...page.jobs, ...this.jobs.filter((job) => !newest.has(job.id))];
      if (this.jobs.length === page.jobs.length) this.rest = page.rest;
    });
  }

  async next() {
    await this.#read(`&after=${encodeURIComponent(this.rest)}`, (page) => {
      const known = new Set(this.jobs.map((job) => job.id));
      this.jobs = [...this.jobs, ...page.jobs.filter((job) => !known.has(job.id))];
      this.rest = page.rest;
    });
  }

  /** The list of the cell's jobs is another one: look again, soon, and once. */
  refresh() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.element.isConnected && this.first(), 500);
  }

  async #read(after, take) {
    try {
      const page = await get(`/api/jobs?most=${MOST}${after}`);
      take(page);
      text(this.note, page.is_whole ? '' : t('jobs.not_whole', { why: page.why_not }));
    } catch (refused) {
      text(this.note, refused.message || t('jobs.silent'));
    }
    show(this.note, Boolean(this.note.textContent));
    this.table.show(this.jobs);
    show(this.older, Boolean(this.rest));
  }
}

/** A field for a serial: the items that have it are linked below. */
function serialSearch() {
  const field = h('input', { type: 'search', maxlength: 200, 'aria-label': t('jobs.serial') });
  const found = h('p', { class: 'remark', role: 'status' });
  const ask = newestOnly();
  const search = (event) => {
    event.preventDefault();
    const serial = field.value.trim();
    if (!serial) return;
    const take = ({ items }) => {
      const links = items.flatMap(({ item, time }) => [itemLink(item), ` ${at(time)} `]);
      children(found, links.length ? links : [t('jobs.no_serial', { serial })]);
    };
    const fail = (refused) => text(found, refused.message || t('jobs.silent'));
    ask(() => get(`/api/serials/${inPath(serial)}`), take, fail);
  };
  return h(
    'form',
    { class: 'screen-head serial-search', role: 'search', onsubmit: search },
    h('label', {}, `${t('jobs.serial')} `, field),
    h('button', { type: 'submit' }, t('jobs.search')),
    found,
  );
}
