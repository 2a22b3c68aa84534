/** One section: what it does now, with feedback and holds, and what it did lately. */
import { children, h, show, text } from '../core/dom.js';
import { mountLive } from '../core/live.js';
import { part, partsOf } from '../core/store.js';
import { said, t } from '../core/text.js';
import { feedback } from '../parts/feedback.js';
import { happenings, isEnd } from '../parts/happenings.js';
import { history } from '../parts/history.js';
import { holdList } from '../parts/hold_list.js';
import { componentLink, itemLink, jobLink, sectionLink } from '../parts/links.js';
import { offers } from '../parts/offers.js';
import { troubleWords } from '../parts/side_lists.js';
import { taskList } from '../parts/task_list.js';

/** Show it in a root; `route.id` is its number. */
export function mount(root, route) {
  const screen = new Section(Number(route.id));
  const leave = mountLive(root, screen);
  screen.history.read();
  return leave;
}

class Section {
  constructor(number) {
    this.number = number;
    this.hasNews = happenings((event) => isEnd(event) && event.section === number);
    this.unknown = h('p', { class: 'nothing' }, t('section.unknown', { number }));
    this.about = h('p', { class: 'about' });
    this.holds = holdList();
    this.waits = h('ul', { class: 'waits' });
    this.tasks = taskList();
    this.finished = h('h3');
    this.finishedTasks = taskList();
    this.finishedBox = h('div', {}, this.finished, this.finishedTasks.element);
    this.feedback = feedback();
    this.offers = offers({
      about: () => [t('part.section', { number }), this.slot?.id].filter(Boolean).join(', '),
      label: t('section.offers'),
    });
    this.components = h('ul', { class: 'links' });
    this.history = history(`/api/sections/${number}/history`);
    this.before = h('span');
    this.after = h('span');
    this.body = h(
      'div',
      { class: 'screen-body' },
      this.about,
      this.holds.element,
      h(
        'div',
        { class: 'now-sides' },
        h(
          'section',
          { class: 'panel' },
          h('h2', {}, t('section.now')),
          this.waits,
          this.tasks.element,
          this.finishedBox,
          this.offers.element,
        ),
        h(
          'section',
          { class: 'panel' },
          h('h2', {}, t('section.feedback')),
          this.feedback.element,
          h('h2', {}, t('section.components')),
          this.components,
        ),
      ),
      this.history.element,
    );
    this.element = h(
      'div',
      { class: 'screen' },
      h(
        'div',
        { class: 'screen-head' },
        h('h1', {}, t('part.section', { number })),
        h(
          'div',
          { class: 'beside', role: 'group', 'aria-label': t('section.beside') },
          this.before,
          this.after,
        ),
      ),
      this.unknown,
      this.body,
    );
  }

  end() {
    this.offers.end();
    this.holds.update([]);
  }

  update() {
    const section = part(`section/${this.number}`);
    show(this.unknown, !section && part('cell'));
    show(this.body, section);
    if (!section) return;
    const now = JSON.stringify([section, part('line')]);
    if (now !== this.shown) this.#show(section);
    this.shown = now;
    this.holds.update(section.holds.map((id) => part(`hold/${id}`)).filter(Boolean));
    if (this.hasNews()) this.history.soon();
  }

  #show(section) {
    this.slot = section.slot;
    this.#beside(part('cell')?.sections ?? []);
    children(this.about, aboutOf(section));
    children(
      this.waits,
      section.waits.map((wait) => h('li', { 'data-ordinary': wait.is_ordinary }, said(wait.said))),
    );
    this.tasks.update(section.tasks);
    this.#showFinished(section);
    this.feedback.update(section.tasks);
    this.offers.update(section.offers ?? []);
    show(this.offers.element, section.offers?.length);
    const here = partsOf('component/')
      .map(([, one]) => one)
      .filter((one) => one.sections.includes(this.number));
    children(
      this.components,
      here.map((one) =>
        h('li', {}, componentLink(one.name), ' ', one.trouble ? troubleWords(one) : one.state),
      ),
    );
  }

  /** While a cycle is in hand, the list above is that of the next item. */
  #showFinished({ finished, item }) {
    show(this.finishedBox, finished && item);
    if (!finished) return;
    text(this.finished, t('section.finished', finished));
    this.finishedTasks.update(finished.tasks);
  }

  #beside(numbers) {
    const to = (number, sign) =>
      numbers.includes(number) ? h('span', {}, sign, ' ', sectionLink(number)) : [];
    children(this.before, to(this.number - 1, '←'));
    children(this.after, to(this.number + 1, '→'));
  }
}

function aboutOf({ slot, item, job, finished }) {
  const there = slot
    ? [
        t('section.slot'),
        ' ',
        itemLink(slot.id),
        slot.present ? '' : ` (${t('section.empty_position')})`,
      ]
    : t('section.slot_empty');
  const work = item
    ? [t('section.works_on'), ' ', itemLink(item.id), ' · ', jobLink(job)]
    : finished
      ? t('section.finished', finished)
      : t('section.no_cycle');
  const bad = slot?.rejected ? t('section.rejected') : '';
  return [h('span', {}, there), h('span', {}, work), bad ? h('strong', {}, bad) : null];
}
