/** One task in a list: its mark, its name, and how long it takes against what is expected. */

import { attribute, h, text } from '../core/dom.js';
import { shownMoment } from '../core/store.js';
import { seconds, stopwatch, t } from '../core/text.js';
import { againWords } from './again.js';
import { mark } from './mark.js';
import { taskReason } from './task_words.js';
import { reshape, shape } from '../core/shape.js';

/** Make a row: an element, `update(task)`, and `tick()` for the time that passes. */
export function taskRow() {
  const drawn = mark();
  const name = h('span', { class: 'task-name one-line' });
  const late = shape('none');
  const timeWord = h('span', {});
  const time = h('span', { class: 'task-clock' }, late, timeWord);
  const element = h('li', { class: 'task' }, drawn.element, name, time);
  let task = null;

  function tick() {
    text(timeWord, timeWords(task));
  }

  return {
    element,
    tick,
    update(now) {
      task = now;
      attribute(element, 'data-task', task.id);
      attribute(element, 'data-mark', task.mark);
      attribute(element, 'title', titleOf(task));
      drawn.update(task.mark);
      text(name, task.label);
      attribute(time, 'data-late', task.is_late);
      attribute(time, 'title', task.is_late ? t('task.late') : null);
      reshape(late, task.is_late ? 'triangle' : 'none');
      tick();
    },
  };
}

/** Say how long a running task takes, of what is expected; of others only that. */
export function timeWords(task) {
  const expected = task.expected_s ? seconds(task.expected_s) : '';
  if (task.mark !== 'running' || !task.started)
    return task.mark === 'new' || task.mark === 'waiting' ? expected : '';
  const elapsed = shownMoment() - task.started;
  return expected
    ? t('task.of', { elapsed: stopwatch(elapsed), expected })
    : seconds(Math.floor(elapsed));
}

function titleOf(task) {
  const again = againWords(task);
  return [task.id, task.name, task.component, t(`mark.${task.mark}`), again, taskReason(task)]
    .filter(Boolean)
    .join(' · ');
}
