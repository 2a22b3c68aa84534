/** The cell at a glance: what is held comes first, then the line, then the jobs. */

import { h, text } from '../core/dom.js';
import { subscribe } from '../core/store.js';
import { t } from '../core/text.js';

/** Show it. */
export function mount(root) {
  const title = h('h1', { class: 'for-readers' });
  root.append(title);
  text(title, t('overview.title'));
  return subscribe('cell', () => {});
}
