/** Asking more than once: which answer counts, and when the next question is asked. */
import assert from 'node:assert/strict';
import { mock, test } from 'node:test';

import {
  newestOnly,
  repeat,
} from '../../bt_orchestrator/extensions/page/web/static/core/asking.js';

/** Questions that are answered by hand, in any order. */
function questions() {
  const told = [];
  const ask = newestOnly();
  const begin = (name) => {
    let answer;
    const asked = new Promise((yes, no) => (answer = { yes, no }));
    const over = ask(
      () => asked,
      (found) => told.push(`${name}: ${found}`),
      (refused) => told.push(`${name} failed: ${refused}`),
    );
    return { ...answer, over };
  };
  return { told, begin };
}

test('an answer that comes after that of a later question is dropped', async () => {
  const { told, begin } = questions();
  const [all, holds] = [begin('all'), begin('holds')];
  holds.yes(2);
  await holds.over;
  all.yes(9);
  await all.over;
  assert.deepEqual(told, ['holds: 2']);
});

test('an answer that a later question waits behind is dropped, and so is a failure', async () => {
  const { told, begin } = questions();
  const [first, second, third] = [begin('first'), begin('second'), begin('third')];
  first.yes(1);
  second.no('silent');
  await Promise.all([first.over, second.over]);
  assert.deepEqual(told, []);
  third.no('silent');
  await third.over;
  assert.deepEqual(told, ['third failed: silent']);
});

test('it is asked again after the answer, and not while nobody looks', async () => {
  mock.timers.enable({ apis: ['setTimeout'] });
  const page = new EventTarget();
  globalThis.document = Object.assign(page, { hidden: false });
  const show = (isShown) => {
    page.hidden = !isShown;
    page.dispatchEvent(new Event('visibilitychange'));
  };
  let asked = 0;
  let answer;
  const end = repeat(() => new Promise((resolve) => (asked++, (answer = resolve))), 1000);
  const pass = async (milliseconds) => {
    mock.timers.tick(milliseconds);
    await Promise.resolve();
  };
  await pass(0);
  await pass(5000);
  assert.equal(asked, 1); // the answer is awaited
  answer();
  await pass(0);
  await pass(999);
  assert.equal(asked, 1);
  await pass(1);
  assert.equal(asked, 2);
  answer();
  await pass(0);
  show(false);
  await pass(5000);
  assert.equal(asked, 2);
  show(true);
  await pass(0);
  assert.equal(asked, 3);
  end();
  answer();
  await pass(5000);
  show(true);
  await pass(5000);
  assert.equal(asked, 3);
  mock.timers.reset();
});
