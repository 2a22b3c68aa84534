/** The ways to the screen of a thing. Ids may hold anything but a slash; that of an item has one. */
import { h } from '../core/dom.js';
import { t } from '../core/text.js';

/** An id in a path; its slashes stay slashes. */
export function inPath(id) {
  return String(id).split('/').map(encodeURIComponent).join('/');
}

const link = (screen, id, words) => h('a', { href: `#/${screen}/${inPath(id)}` }, words);

export const sectionLink = (number) => link('section', number, t('part.section', { number }));
export const componentLink = (name) => link('component', name, name);
export const jobLink = (id) => link('job', id, id);
export const itemLink = (id) => link('item', id, id);
