/** Why the line stands: the line as a picture, and the reasons beside it. */
import { attribute, children, h, keyed, show, text } from '../core/dom.js';
import { mountLive } from '../core/live.js';
import { part, partsOf } from '../core/store.js';
import { t } from '../core/text.js';
import {
  causeWords,
  chainList,
  drawnParts,
  linkWords,
  nameLink,
  partName,
  partNames,
} from '../parts/chain.js';
import { picture } from '../parts/picture.js';
import { requeues } from '../parts/requeues.js';
import { shape } from '../core/shape.js';

/** Show it in a root; `route.id` names the part whose chain is open. */
export function mount(root, route) {
  return mountLive(root, new Why(route));
}

class Why {
  constructor(route) {
    this.chosen = route.id ?? '';
    this.picture = picture((name) => this.#picked(name));
    this.note = h('p', { class: 'help', role: 'status' });
    this.reasons = h('ul', { class: 'reasons' });
    this.fill = keyed(
      this.reasons,
      (chain) => chain.part,
      () => this.#reason(),
    );
    this.causes = h('ul', { class: 'causes' });
    this.fillCauses = keyed(this.causes, (cause) => `${cause.part} ${cause.kind}`, makeCause);
    this.nothing = h('p', { class: 'nothing' }, t('why.nothing'));
    this.scripts = h('select', { 'aria-label': t('why.script'), onchange: () => this.#draw() });
    this.noScript = h('p', { class: 'nothing' }, t('why.no_script'));
    this.element = h(
      'div',
      { class: 'screen why' },
      h('div', { class: 'screen-head' }, h('h1', {}, t('why.title')), this.scripts),
      h(
        'div',
        { class: 'why-sides' },
        h(
          'section',
          { class: 'panel why-causes', 'aria-labelledby': 'why-causes' },
          h('h2', { id: 'why-causes' }, t('why.causes')),
          this.causes,
          this.nothing,
        ),
        h(
          'section',
          { class: 'panel why-picture', 'aria-label': t('why.picture') },
          this.picture.element,
          this.noScript,
        ),
        h(
          'section',
          { class: 'panel why-reasons', 'aria-labelledby': 'why-reasons' },
          h('h2', { id: 'why-reasons' }, t('why.reasons')),
          this.note,
          this.reasons,
        ),
      ),
    );
  }

  update() {
    this.chains = part('why')?.chains ?? [];
    this.fill(this.chains);
    this.fillCauses(part('why')?.causes ?? []);
    show(this.nothing, this.chains.length === 0);
    this.#listScripts();
    const gravest = part('why')?.causes.find((cause) => !cause.is_ordinary);
    this.picture.beginAt(gravest ? (drawnParts(gravest.part)[0] ?? '') : '');
    this.#draw();
    this.#mark();
  }

  end() {
    this.picture.end();
    this.fillCauses([]);
  }

  #listScripts() {
    const jobs = partsOf('job/')
      .map(([, job]) => job)
      .filter((job) => job.digest);
    const known = new Map(jobs.map((job) => [job.digest, job.script]));
    const now = [...this.scripts.options].map((one) => one.value);
    if (now.join() === [...known.keys()].join()) return;
    const before = this.scripts.value;
    children(
      this.scripts,
      [...known].map(([digest, name]) => h('option', { value: digest }, name)),
    );
    if (known.has(before)) this.scripts.value = before;
    show(this.scripts, known.size > 1);
    show(this.picture.element, known.size > 0);
    show(this.noScript, known.size === 0);
  }

  #draw() {
    this.picture.show(this.scripts.value);
  }

  #reason() {
    const name = h('strong');
    const words = h('span', { class: 'because' });
    const button = h(
      'button',
      { type: 'button', class: 'reason', onclick: () => this.#choose(button.dataset.part) },
      name,
      words,
    );
    const way = h('div', { class: 'way' });
    let before = '';
    return {
      element: h('li', {}, button, way),
      update: (chain) => {
        button.dataset.part = chain.part;
        text(name, partName(chain.part));
        text(words, linkWords(chain.links[0]));
        const isOpen = chain.part === this.chosen;
        attribute(button, 'aria-expanded', String(isOpen));
        const now = isOpen ? JSON.stringify(chain) : '';
        if (now !== before) children(way, isOpen ? chainList(chain) : []);
        before = now;
      },
    };
  }

  /** Open the chain of a part, or fold it. One that waits again later is open again. */
  #choose(key) {
    this.chosen = this.chosen === key ? '' : key;
    this.fill(this.chains);
    this.#mark();
  }

  #mark() {
    const chain = this.chains.find((one) => one.part === this.chosen);
    const way = chain ? chain.links.flatMap((link) => drawnParts(link.part)) : [];
    const [root = ''] = chain ? drawnParts(chain.root.part) : [];
    this.picture.mark([...way, ...(root ? [root] : [])], root);
    if (chain && this.shown !== this.chosen) this.picture.lookAt(root || way[0]);
    this.shown = this.chosen;
  }

  /** A part of the picture was clicked: show why its part of the cell waits. */
  #picked(name) {
    const key = this.#keyOf(name);
    if (!key) return;
    const waits = this.chains.some((one) => one.part === key);
    text(this.note, waits ? '' : t('why.not_waiting', { part: partName(key) }));
    if (!waits) return;
    this.chosen = '';
    this.#choose(key);
    this.reasons.querySelector(`[data-part="${key}"]`)?.focus();
  }

  /** The part of the cell that a part of the drawing belongs to; empty: none, as the legend. */
  #keyOf(name) {
    const section = /^(?:section|slot)\.(\d+)(?:\.|$)/.exec(name);
    if (section) return `section/${section[1]}`;
    if (/^belt\b/.test(name) || name === 'task.index') return 'belt';
    if (name === 'initialization') return name;
    const holds = ([, one]) => one.tasks?.some((task) => name === `task.${task.id}`);
    const found = partsOf('section/').find(holds);
    if (found) return found[0];
    return partsOf('job/').some(holds) ? 'initialization' : '';
  }
}

/** A root cause: what it is, what has to happen, and all that waits for it. */
function makeCause(first) {
  const what = h('span');
  const waiting = h('span', { class: 'quiet' });
  const lost = /^component\/(.*)$/.exec(first.kind === 'out_of_service' ? first.part : '')?.[1];
  const ways = lost ? requeues() : null;
  const element = h(
    'li',
    {},
    first.is_ordinary ? null : shape('triangle'),
    h('div', {}, nameLink(first.part), what, waiting, ways?.element),
  );
  return {
    element,
    update(cause) {
      attribute(element, 'data-ordinary', String(cause.is_ordinary));
      text(what, causeWords(cause));
      text(waiting, t('why.waiting', { parts: partNames(cause.waiting) }));
      ways?.update(lost);
    },
    end: () => ways?.end(),
  };
}
