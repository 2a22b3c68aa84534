/**
 * A behaviour tree that keys and screen readers can walk (the tree pattern of ARIA), one line a
 * behaviour; what somebody opened or folded stays so while the tree changes.
 */
import { attribute, h, keyed, show, text } from '../core/dom.js';
import { t } from '../core/text.js';
import { linesOf, pathsOf } from './branches.js';

const SIGNS = { running: '▶', success: '✓', failure: '✗', invalid: '·' };

/**
 * @param {string} label names the tree for a screen reader
 * @returns {TreeView}
 */
export function treeView(label) {
  return new TreeView(label);
}

class TreeView {
  constructor(label) {
    this.element = h('div', {
      role: 'tree',
      class: 'tree',
      'aria-label': label,
      onkeydown: (event) => this.#key(event),
      onclick: (event) => this.#click(event),
    });
    this.fill = keyed(this.element, (line) => line.path, makeLine);
    this.chosen = new Map(); // path: whether somebody opened it
    this.lines = [];
    this.current = 'root'; // the line that Tab comes to
  }

  /** Show a tree in place of the one before. */
  show(tree) {
    this.tree = tree;
    this.lines = linesOf(tree, this.chosen);
    if (!this.lines.some((line) => line.path === this.current)) this.current = 'root';
    this.fill(
      this.lines.map((line) => ({ ...line, isCurrent: line.path === this.current })),
    );
  }

  /** Open or fold every branch. */
  all(isOpen) {
    if (!this.tree) return;
    this.chosen = new Map(pathsOf(this.tree).map((path) => [path, isOpen || path === 'root']));
    this.show(this.tree);
  }

  #click(event) {
    const item = event.target.closest('[role=treeitem]');
    if (!item) return;
    const line = this.lines[[...this.element.children].indexOf(item)];
    this.current = line.path;
    if (line.isOpen === null) this.show(this.tree);
    else this.#open(line, !line.isOpen);
    this.#focus();
  }

  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const here = this.lines.findIndex((line) => line.path === this.current);
    const line = this.lines[here];
    const steps = {
      ArrowDown: () => this.#go(here + 1),
      ArrowUp: () => this.#go(here - 1),
      Home: () => this.#go(0),
      End: () => this.#go(this.lines.length - 1),
      ArrowRight: () =>
        line.isOpen === false ? this.#open(line, true) : line.isOpen && this.#go(here + 1),
      ArrowLeft: () => (line.isOpen ? this.#open(line, false) : this.#up(line)),
      Enter: () => line.isOpen !== null && this.#open(line, !line.isOpen),
      ' ': () => line.isOpen !== null && this.#open(line, !line.isOpen),
    };
    if (!line || !steps[event.key]) return;
    event.preventDefault();
    steps[event.key]();
    this.#focus();
  }

  #go(place) {
    const line = this.lines[Math.min(Math.max(place, 0), this.lines.length - 1)];
    this.current = line.path;
    this.show(this.tree);
  }

  #up(line) {
    if (line.parent) this.#go(this.lines.findIndex((one) => one.path === line.parent));
  }

  #open(line, isOpen) {
    this.chosen.set(line.path, isOpen);
    this.show(this.tree);
  }

  #focus() {
    this.element.querySelector('[tabindex="0"]')?.focus();
  }
}

function makeLine() {
  const [fold, sign, word, name, message] = ['fold', 'sign', 'word', 'name', 'message'].map(
    (part) => h('span', { class: `twig-${part}` }),
  );
  for (const drawn of [fold, sign]) drawn.setAttribute('aria-hidden', 'true');
  const element = h('div', { role: 'treeitem', class: 'twig' }, fold, sign, name, word, message);
  return {
    element,
    update(line) {
      const { branch } = line;
      text(fold, { true: '▾', false: '▸', null: '' }[line.isOpen]);
      text(sign, SIGNS[branch.status] ?? '?');
      text(word, t(`tree.${branch.status}`));
      text(name, branch.name);
      text(message, branch.message);
      show(message, Boolean(branch.message));
      element.style.setProperty('--level', `${line.level - 1}`); // the policy forbids a style attribute
      attribute(element, 'data-status', branch.status);
      attribute(element, 'tabindex', line.isCurrent ? 0 : -1);
      attribute(element, 'aria-level', line.level);
      attribute(element, 'aria-posinset', line.place);
      attribute(element, 'aria-setsize', line.among);
      attribute(element, 'aria-expanded', line.isOpen === null ? null : String(line.isOpen));
      attribute(element, 'aria-selected', String(Boolean(line.isCurrent)));
    },
  };
}
