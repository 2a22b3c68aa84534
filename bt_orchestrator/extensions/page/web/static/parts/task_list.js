/** A whole task list: each task with its mark, its component, its time against the expected one. */
import { attribute, children, h, keyed, show, text } from '../core/dom.js';
import { t } from '../core/text.js';
import { everySecond } from '../core/tick.js';
import { componentLink } from './links.js';
import { mark } from './mark.js';
import { againWords } from './again.js';
import { timeWords } from './task_row.js';
import { taskReason } from './task_words.js';

/** A list of tasks: an element and `update(tasks)`. */
export function taskList() {
  const list = h('ol', { class: 'task-list' });
  const nothing = h('p', { class: 'nothing' }, t('section.no_tasks'));
  const fill = keyed(list, (task) => task.id, makeTask);
  return {
    element: h('div', {}, list, nothing),
    update(tasks) {
      fill(tasks);
      show(list, tasks.length > 0);
      show(nothing, tasks.length === 0);
    },
  };
}

function makeTask() {
  const state = mark();
  const name = h('strong');
  const constant = h('span', { class: 'quiet' });
  const component = h('span');
  const time = h('span', { class: 'task-elapsed' });
  const reason = h('span', { class: 'task-reason' });
  const element = h(
    'li',
    {},
    state.element,
    h('span', {}, name, ' ', constant),
    component,
    time,
    reason,
  );
  let task = null;
  const sayTime = () =>
    task && text(time, [againWords(task), timeWords(task)].filter(Boolean).join(' · '));
  everySecond(element, sayTime);
  return {
    element,
    update(now) {
      task = now;
      state.update(task.mark);
      text(name, task.id);
      text(constant, task.name === task.id ? '' : task.name);
      if (component.textContent !== task.component)
        children(component, componentLink(task.component));
      attribute(element, 'data-track', task.track > 1 ? task.track : null);
      const why = taskReason(task);
      text(reason, why);
      show(reason, why);
      sayTime();
    },
  };
}
