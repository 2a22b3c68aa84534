/** One section: its item, the whole task list with times, and what it waits for. */

import { attribute, h, keyed, show, text } from '../core/dom.js';
import { said, t } from '../core/text.js';
import { itemName } from './item_name.js';
import { reshape, shape } from '../core/shape.js';
import { room } from './room.js';
import { taskRow } from './task_row.js';

/** Make a card: an element, `update(section)`, `tick()`. */
export function sectionCard() {
  const alarm = shape('none');
  const link = h('a', { class: 'section-link' });
  const item = itemName();
  const list = h('ul', { class: 'tasks' });
  const rows = new Map();
  const tasks = keyed(
    list,
    (task) => task.id,
    (task) => keepRow(rows, task.id),
  );
  const finished = room('section-wait');
  attribute(finished.element, 'data-ordinary', true);
  const wait = room('section-wait');
  const element = h(
    'article',
    { class: 'section-card' },
    h('h2', {}, alarm, link),
    item.element,
    list,
    finished.element,
    wait.element,
  );
  return {
    element,
    tick: () => rows.forEach((row) => row.tick()),
    update(section) {
      const [foremost] = section.waits;
      const isHeld = section.holds.length > 0;
      attribute(element, 'data-section', section.number);
      attribute(element, 'data-held', isHeld);
      attribute(link, 'href', `#/section/${section.number}`);
      text(link, t('part.section', { number: section.number }));
      reshape(alarm, isHeld ? 'triangle' : 'none');
      item.update(section.item ?? section.slot);
      tasks(section.tasks);
      show(finished.element, section.finished);
      finished.say(section.finished ? t('section.finished', section.finished) : '');
      const isQuiet = !foremost || isSaidElsewhere(foremost, isHeld);
      attribute(wait.element, 'data-ordinary', isQuiet);
      attribute(wait.element, 'title', section.waits.map((one) => said(one.said)).join('\n'));
      wait.say(foremost ? cardWords(foremost, isQuiet) : '');
    },
  };
}

/** For an answer somewhere else all sections wait; the hold and the bar say it once. */
const SAID_ELSEWHERE = ['hold', 'pause', 'cell_state'];

function isSaidElsewhere(wait, isHeld) {
  return wait.is_ordinary || (!isHeld && SAID_ELSEWHERE.includes(wait.kind));
}

/** The story of a hold stands on its card; others name its number. */
function cardWords(wait, isQuiet) {
  const isBrief = isQuiet && wait.kind === 'hold' && !wait.holds?.length;
  return isBrief ? t('wait.hold', wait) : said(wait.said);
}

function keepRow(rows, id) {
  const row = taskRow();
  rows.set(id, row);
  return { ...row, end: () => rows.delete(id) };
}
