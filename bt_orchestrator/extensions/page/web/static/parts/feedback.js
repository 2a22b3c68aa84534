/** The last feedback of the tasks that run, as small tables. */
import { children, h, keyed, show, text } from '../core/dom.js';
import { t } from '../core/text.js';
import { jsonValues } from './values.js';

/** Feedback of tasks: an element and `update(tasks)`. */
export function feedback() {
  const list = h('div');
  const nothing = h('p', { class: 'nothing' }, t('section.no_feedback'));
  const fill = keyed(list, (task) => task.id, one);
  return {
    element: h('div', { class: 'feedback' }, list, nothing),
    update(tasks) {
      const told = tasks.filter((task) => task.feedback);
      fill(told);
      show(nothing, told.length === 0);
    },
  };
}

function one() {
  const name = h('h3');
  const room = h('div');
  let before = null;
  return {
    element: h('div', {}, name, room),
    update(task) {
      text(name, task.id);
      if (task.feedback !== before) children(room, jsonValues(task.feedback));
      before = task.feedback;
    },
  };
}
