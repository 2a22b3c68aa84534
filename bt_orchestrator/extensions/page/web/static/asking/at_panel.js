/** Tells the node that somebody is at this panel, while a task of manual mode runs that began here. */

import { post } from '../core/api.js';
import { part } from '../core/store.js';

/** The node cancels the task after 2 s without a sign. */
const EVERY_MS = 500;

let timer = 0;

/**
 * Begin, once the task was accepted. It ends with the task, with this page, and while it is hidden.
 * @param {number} before when the task before this one was started; 0: there was none
 */
export function stayAtPanel(before) {
  clearInterval(timer);
  const tell = () => {
    const cell = part('cell');
    const isOver = (cell?.manual?.started ?? 0) > before && cell.manual.ended !== null;
    if (isOver || cell?.unit_mode !== 'manual') clearInterval(timer);
    else if (!document.hidden) post('/api/at_panel', {}, 4 * EVERY_MS).catch(() => null);
  };
  timer = setInterval(tell, EVERY_MS);
  tell();
}
