/** What happened to one item. */
import { get } from '../core/api.js';
import { children, h, show, text } from '../core/dom.js';
import { subscribe } from '../core/store.js';
import { duration, readersZone, t } from '../core/text.js';
import { happenings } from '../parts/happenings.js';
import { inPath, jobLink } from '../parts/links.js';
import { scriptWords } from '../parts/job_row.js';
import { story } from '../parts/story.js';

const PAUSE_MS = 1000;

/** Show it in a root; `route.id` is the id of the item. */
export function mount(root, route) {
  const screen = new Item(route.id);
  root.append(screen.element);
  screen.read();
  const end = subscribe('event', () => screen.happened());
  return () => end();
}

class Item {
  constructor(id) {
    this.id = id;
    this.hasNews = happenings((event) => event.item === id);
    this.about = h('p', { class: 'about' });
    this.note = h('p', { class: 'remark', role: 'status' });
    this.story = h('section', { class: 'panel' });
    const path = `/api/items/${inPath(id)}`;
    const link = (word, href, download) =>
      h('a', { class: 'button', href, download, hidden: true }, t(word));
    this.downloads = [
      link('item.document', `${path}/record.html?zone=${readersZone()}`, ''),
      link('item.download', path, `${id.replaceAll('/', '-')}.json`),
    ];
    this.element = h(
      'div',
      { class: 'screen' },
      h('div', { class: 'screen-head' }, h('h1', {}, t('item.title', { item: id })), this.downloads),
      this.about,
      this.note,
      this.story,
    );
  }

  async read() {
    try {
      this.#show(await get(`/api/items/${inPath(this.id)}`));
    } catch (refused) {
      const isUnknown = refused.status === 404;
      text(this.note, isUnknown ? t('item.unknown') : refused.message || t('jobs.silent'));
    }
    for (const one of [...this.downloads, this.story]) show(one, Boolean(this.before));
    show(this.note, Boolean(this.note.textContent));
  }

  /** Something happened; if it was to this item, its record is longer now. */
  happened() {
    if (!this.hasNews()) return;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.element.isConnected && this.read(), PAUSE_MS);
  }

  #show(record) {
    text(this.note, record.is_whole ? '' : t('jobs.not_whole', { why: record.why_not }));
    const { job } = record;
    const took =
      record.ended === null || record.started === null
        ? ''
        : duration(record.ended - record.started);
    children(
      this.about,
      jobLink(job),
      h('span', {}, scriptWords(record)),
      h('strong', {}, t(`item.is_${record.how || 'on_line'}`)),
      took ? h('span', {}, took) : null,
      record.serial ? h('span', {}, t('item.serial', { serial: record.serial })) : null,
      ...Object.entries(record.lots).map(([name, lot]) => h('span', {}, `${name}: ${lot}`)),
      record.rejected ? h('span', {}, t('item.rejected', { why: record.rejected })) : null,
    );
    const now = JSON.stringify(record);
    if (now !== this.before) children(this.story, story(record));
    this.before = now;
  }
}
