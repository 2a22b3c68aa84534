/** One job: how far it is, its items, what failed, and its results to take along. */
import { get } from '../core/api.js';
import { children, h, show, text } from '../core/dom.js';
import { part, subscribe } from '../core/store.js';
import { at, duration, t } from '../core/text.js';
import { jobBar } from '../parts/bar.js';
import { failureTable } from '../parts/failures.js';
import { inPath, itemLink, jobLink } from '../parts/links.js';
import { anewWords } from '../parts/making.js';
import { jobStateWords, recipeWords } from '../parts/job_row.js';
import { offers } from '../parts/offers.js';
import { table } from '../parts/table.js';
import { values } from '../parts/values.js';
import { bad } from '../parts/job_table.js';

const PAUSE_MS = 1000;

/** Show it in a root; `route.id` is the id of the job. */
export function mount(root, route) {
  const screen = new Job(route.id);
  root.append(screen.element);
  screen.live();
  screen.read();
  const end = subscribe(`job/${route.id}`, () => screen.live());
  return () => {
    end();
    screen.offers.end();
  };
}

class Job {
  constructor(id) {
    this.id = id;
    this.url = `/api/jobs/${inPath(id)}`;
    this.bar = jobBar();
    this.offers = offers({ about: () => t('chain.job', { name: id }), label: t('job.offers') });
    this.about = h('dl', { class: 'facts' });
    this.params = h('div');
    this.note = h('p', { class: 'remark', role: 'status' });
    this.items = itemTable();
    this.failures = failureTable();
    this.downloads = this.#downloads();
    this.body = h(
      'div',
      { class: 'screen-body', hidden: true },
      h('section', { class: 'panel' }, h('h2', {}, t('job.about')), this.about, this.params),
      h('section', { class: 'panel' }, h('h2', {}, t('failure.title')), this.failures.element),
      h('section', { class: 'panel' }, h('h2', {}, t('job.items')), this.items.element),
    );
    this.element = h(
      'div',
      { class: 'screen' },
      h(
        'div',
        { class: 'screen-head' },
        h('h1', {}, t('chain.job', { name: id })),
        this.downloads,
      ),
      this.bar.element,
      this.offers.element,
      this.note,
      this.body,
    );
  }

  /** What the cell tells of it now; a job that ended long ago has no part. */
  live() {
    const job = part(`job/${this.id}`);
    show(this.bar.element, job);
    show(this.offers.element, job?.offers.length);
    if (!job) return;
    this.bar.update(job);
    this.offers.update(job.offers);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.element.isConnected && this.read(), PAUSE_MS);
  }

  async read() {
    try {
      this.#show(await get(this.url));
    } catch (refused) {
      const isUnknown = refused.status === 404;
      text(this.note, isUnknown ? t('job.unknown') : refused.message || t('jobs.silent'));
      show(this.note, true);
    }
  }

  #downloads() {
    const link = (kind) =>
      h(
        'a',
        { class: 'button', href: `${this.url}/items.${kind}`, download: true },
        t(`job.${kind}`),
      );
    return h('span', { class: 'downloads', hidden: true }, link('csv'), link('json'));
  }

  #show({ job, items, failures, is_whole: isWhole, why_not: whyNot }) {
    text(this.note, isWhole ? '' : whyNot);
    show(this.note, !isWhole);
    show(this.body, true);
    show(this.downloads, true);
    this.items.show(items);
    this.failures.show(failures);
    const now = part(`job/${this.id}`);
    const facts = [
      ['status', now && !now.is_over ? jobStateWords(now) : t(`job.is_${job.status}`)],
      ['reason', job.reason],
      ['script', job.script],
      ['recipe', recipeWords(job)],
      ['rest_of', job.rest_of && jobLink(job.rest_of)],
      ['making', anewWords(part(`job/${this.id}`) ?? {})],
      ['quantity', job.quantity],
      ['queued', at(job.queued)],
      ['started', at(job.started)],
      ['ended', at(job.ended)],
      ['took', job.seconds === null ? '' : duration(job.seconds)],
      ['packed', job.counts.packed],
      ['bad', bad(job.counts)],
    ];
    const told = facts.filter(([, value]) => value !== '' && value !== null && value !== undefined);
    children(
      this.about,
      told.map(([name, value]) => h('div', {}, h('dt', {}, t(`job.${name}`)), h('dd', {}, value))),
    );
    const params = Object.keys(job.params ?? {}).length;
    children(this.params, params ? [h('h3', {}, t('job.params')), values(job.params)] : []);
  }
}

function itemTable() {
  const columns = [
    { head: t('job.item'), cell: (item) => itemLink(item.id) },
    { head: t('job.serial'), cell: (item) => item.serial ?? '' },
    { head: t('job.how'), cell: (item) => t(`item.is_${item.how || 'on_line'}`) },
    { head: t('job.started'), cell: (item) => at(item.started) },
    {
      head: t('job.took'),
      cell: (item) => (item.seconds === null ? '' : duration(item.seconds)),
      isNumber: true,
    },
    { head: t('job.nonconforming'), cell: (item) => item.nonconforming.join(', ') },
    { head: t('job.results'), cell: (item) => results(item.results) },
  ];
  return table({
    caption: t('job.items'),
    columns,
    key: (item) => item.id,
    empty: t('job.no_items'),
  });
}

function results(found) {
  const tasks = Object.entries(found ?? {});
  if (!tasks.length) return '';
  return h('details', {}, h('summary', {}, t('job.tasks', { count: tasks.length })), values(found));
}
