/** One component: whether it can work, what it does now, and what it did lately. */
import { children, h, show } from '../core/dom.js';
import { mountLive } from '../core/live.js';
import { part, partsOf } from '../core/store.js';
import { t } from '../core/text.js';
import { happenings, isEnd } from '../parts/happenings.js';
import { history } from '../parts/history.js';
import { holdList } from '../parts/hold_list.js';
import { inPath, sectionLink } from '../parts/links.js';
import { shape } from '../core/shape.js';
import { offers } from '../parts/offers.js';
import { requeues } from '../parts/requeues.js';
import { troubleWords } from '../parts/side_lists.js';
import { taskList } from '../parts/task_list.js';
import { busyWith } from '../parts/task_words.js';
import { jsonValues } from '../parts/values.js';

/** Show it in a root; `route.id` is its name. */
export function mount(root, route) {
  const screen = new Component(route.id);
  const leave = mountLive(root, screen);
  screen.history.read();
  return leave;
}

class Component {
  constructor(name) {
    this.name = name;
    this.hasNews = happenings((event) => isEnd(event) && this.tasks.has(event.task));
    this.tasks = new Set(); // ids of its tasks in the scripts of now
    this.unknown = h('p', { class: 'nothing' }, t('component.unknown', { name }));
    this.trouble = h('p', { class: 'trouble' });
    this.facts = h('dl', { class: 'facts' });
    this.holds = holdList();
    this.offers = offers({ about: () => name, label: t('component.offers') });
    this.requeues = requeues();
    this.list = taskList();
    this.feedback = h('div', { class: 'feedback' });
    this.history = history(`/api/components/${inPath(name)}/history`);
    this.body = h(
      'div',
      { class: 'screen-body' },
      this.trouble,
      this.offers.element,
      this.requeues.element,
      this.holds.element,
      h(
        'div',
        { class: 'now-sides' },
        h('section', { class: 'panel' }, h('h2', {}, t('component.tasks')), this.list.element),
        h(
          'section',
          { class: 'panel' },
          h('h2', {}, t('component.about')),
          this.facts,
          h('h2', {}, t('section.feedback')),
          this.feedback,
        ),
      ),
      this.history.element,
    );
    this.element = h(
      'div',
      { class: 'screen' },
      h('div', { class: 'screen-head' }, h('h1', {}, name)),
      this.unknown,
      this.body,
    );
  }

  end() {
    this.holds.update([]);
    this.offers.end();
    this.requeues.end();
  }

  update() {
    const component = part(`component/${this.name}`);
    show(this.unknown, !component && part('cell'));
    show(this.body, component);
    if (!component) return;
    const tasks = this.#tasks();
    this.tasks = new Set(tasks.map((task) => task.id));
    const now = JSON.stringify(component);
    if (now !== this.shown) this.#show(component);
    this.shown = now;
    this.list.update(tasks);
    this.requeues.update(this.name);
    this.holds.update(
      partsOf('hold/')
        .map(([, one]) => one)
        .filter((one) => one.component === this.name),
    );
    if (this.hasNews()) this.history.soon();
  }

  /** Its tasks in the lists that are shown: of sections, of initialization, of the belt. */
  #tasks() {
    const lists = [...partsOf('section/'), ...partsOf('job/')].flatMap(
      ([, one]) => one.tasks ?? [],
    );
    const all = [...lists, ...(part('belt')?.running ?? [])].filter(
      (task) => task.component === this.name,
    );
    return [...new Map(all.map((task) => [task.id, task])).values()];
  }

  #show(component) {
    const described = part('line')?.components.find((one) => one.name === this.name);
    children(
      this.trouble,
      component.trouble ? [shape('broken'), h('span', {}, ` ${troubleWords(component)}`)] : [],
    );
    this.offers.update(component.offers);
    show(this.trouble, Boolean(component.trouble));
    const sections = component.sections.flatMap((number) => [sectionLink(number), ' ']);
    const facts = [
      [
        'ready',
        t(
          component.available
            ? component.ready
              ? 'component.is_ready'
              : 'component.is_not_ready'
            : 'component.is_away',
        ),
      ],
      ['state', component.state],
      ['setups', setupWords(component.setups)],
      ['task', component.task && busyWith(component)],
      ['sections', sections.length ? sections : t('component.no_section')],
      ['action', component.action],
      ['type', described?.type],
    ];
    const told = facts.filter(([, value]) => value);
    children(
      this.facts,
      told.map(([name, value]) =>
        h('div', {}, h('dt', {}, t(`component.${name}`)), h('dd', {}, value)),
      ),
    );
    children(
      this.feedback,
      component.feedback
        ? jsonValues(component.feedback)
        : h('p', { class: 'nothing' }, t('section.no_feedback')),
    );
  }
}

/** Name the setups of a component with their values; empty: it has none. */
function setupWords(setups) {
  return Object.entries(setups)
    .map(([name, value]) => `${name}: ${value || t('component.setup_unknown')}`)
    .join(', ');
}
