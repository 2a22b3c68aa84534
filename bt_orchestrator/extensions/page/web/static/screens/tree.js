/** The behaviour tree of the node, asked for only while it is shown. */
import { h, show, text } from '../core/dom.js';
import { get } from '../core/api.js';
import { repeat } from '../core/asking.js';
import { currentLanguage, t } from '../core/text.js';
import { count } from '../parts/branches.js';
import { treeView } from '../parts/tree_view.js';

const PAUSE_MS = 1000;

/** Show it in a root, until the function that is returned is called. */
export function mount(root) {
  const screen = new Tree();
  root.append(screen.element);
  return () => screen.end();
}

class Tree {
  constructor() {
    this.view = treeView(t('tree.title'));
    this.note = h('p', { class: 'nothing', role: 'status' }, t('tree.asking'));
    this.panel = h('section', { class: 'panel', hidden: true }, this.view.element);
    this.size = h('span', { class: 'help' });
    const button = (word, isOpen) =>
      h('button', { type: 'button', onclick: () => this.view.all(isOpen) }, t(word));
    this.element = h(
      'div',
      { class: 'screen' },
      h(
        'div',
        { class: 'screen-head' },
        h('h1', {}, t('tree.title')),
        this.size,
        button('tree.open_all', true),
        button('tree.fold_all', false),
      ),
      h('p', { class: 'help' }, t('tree.help')),
      this.note,
      this.panel,
    );
    this.version = '';
    this.end = repeat(() => this.#ask(), PAUSE_MS);
  }

  async #ask() {
    try {
      const after = this.version === '' ? '' : `&after=${this.version}`;
      this.#take(await get(`/api/tree?language=${currentLanguage()}${after}`));
    } catch {
      this.version = '';
      this.#say(t('tree.silent'));
    }
  }

  #take({ version, tree }) {
    this.version = version ?? '';
    if (!tree) {
      if (!this.view.tree) this.#say(t('tree.asking'));
      return;
    }
    this.view.show(tree);
    show(this.panel, true);
    text(this.size, t('tree.size', { count: count(tree) }));
    this.#say('');
  }

  #say(words) {
    text(this.note, words);
    show(this.note, Boolean(words));
  }
}
