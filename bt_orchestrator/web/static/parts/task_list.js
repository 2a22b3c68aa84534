/** A whole task list: each task with its mark, its component, its time against the expected one. */
import { attribute, children, h, keyed, show, text } from '../core/dom.js';
import { clock } from '../core/store.js';
import { seconds, t, tOr } from '../core/text.js';
import { everySecond } from '../core/tick.js';
import { componentLink } from './links.js';
import { mark } from './mark.js';

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
  const element = h('li', {}, state.element, h('span', {}, name, ' ', constant), component, time, reason);
  let task = null;
  const sayTime = () => task && text(time, timeWords(task));
  everySecond(element, sayTime);
  return {
    element,
    update(now) {
      task = now;
      state.update(task.mark);
      text(name, task.id);
      text(constant, task.name === task.id ? '' : task.name);
      if (component.textContent !== task.component) children(component, componentLink(task.component));
      attribute(element, 'data-track', task.track > 1 ? task.track : null);
      text(reason, task.mark === 'held' ? tOr(`reason.${task.reason}`, task.reason) : task.reason);
      show(reason, Boolean(task.reason));
      sayTime();
    },
  };
}

function timeWords({ mark: name, started, expected_s: expected, attempt }) {
  const again = attempt > 1 ? t('section.attempt', { attempt }) : '';
  if (name !== 'running' || started === null) {
    return [again, expected === null ? '' : t('section.expected', { time: seconds(expected) })].filter(Boolean).join(' · ');
  }
  const elapsed = seconds(Math.max(clock() - started, 0));
  const against = expected === null ? elapsed : t('section.elapsed', { elapsed, expected: seconds(expected) });
  return [again, against].filter(Boolean).join(' · ');
}
