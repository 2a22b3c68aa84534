/** Words and times in the language of the viewer, from the files of the page. */
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';

import { outcomeWords } from '../../bt_orchestrator/extensions/page/web/static/asking/outcome.js';
import { withButtons } from '../../bt_orchestrator/extensions/page/web/static/core/requests.js';
import * as text from '../../bt_orchestrator/extensions/page/web/static/core/text.js';

const STATIC = new URL('../../bt_orchestrator/extensions/page/web', import.meta.url);
globalThis.document = { documentElement: {} };
globalThis.fetch = async (path) => {
  const file = await readFile(`${STATIC.pathname}${path}`, 'utf-8');
  return { ok: true, json: async () => JSON.parse(file) };
};

test('a count chooses the word', async () => {
  await text.useLanguage('en');
  const words = [1, 3].map((count) => text.t('shift.more', { count, lost: '5 s' }));
  assert.deepEqual(words, ['and 1 more, 5 s', 'and 3 more, 5 s together']);
});

test('a name of a customer stays, and a key without words shows itself', () => {
  assert.equal(text.tOr('reason.of_acme', 'of_acme'), 'of_acme');
  assert.equal(text.t('nobody.knows'), 'nobody.knows');
});

test('durations have two units at most', () => {
  const said = [59.4, 61, 3600, 90061].map(text.duration);
  assert.deepEqual(said, ['59 s', '1 min 01 s', '1 h 00 min', '1 d 1 h']);
  assert.deepEqual([5, 65, 3661].map(text.stopwatch), ['5', '1:05', '1:01:01']);
  assert.deepEqual([text.duration(null), text.seconds(null), text.at(null)], ['', '', '']);
});

test('a difference has a sign only where it has seconds', () => {
  const said = [12.2, 0.4, -0.4, -0.6, -90].map(text.difference);
  assert.deepEqual(said, ['12 s', '0 s', '0 s', '−1 s', '−1 min 30 s']);
});

test('numbers and words are German on a German page', async () => {
  await text.useLanguage('de');
  assert.equal(text.person('somebody who claims to be ann: worn'), 'ann (Name ungeprüft): worn');
  assert.equal(text.person('ann: worn'), 'ann: worn');
  assert.equal(text.quoted('Nein'), '„Nein“');
  assert.equal(text.seconds(1.25), '1,3 s');
  assert.equal(text.said({ en: 'done', de: 'fertig' }), 'fertig');
});

test('verbs of the command line become words of buttons', async () => {
  await text.useLanguage('en');
  const said = withButtons('was it placed? mark_done if it was, else say retry');
  assert.equal(
    said,
    `was it placed? “${text.t('word.hold.mark_done')}” if it was, else say ` +
      `“${text.t('word.hold.retry')}”`,
  );
  assert.equal(withButtons('the arm says nothing'), 'the arm says nothing');
});

test('a sentence begins with a capital letter, unless it begins with a name', async () => {
  await text.useLanguage('de');
  const said = ['übergabe fehlt', 'picker_a: außer Betrieb', 'wo-1/3 ist auf dem Band', 'picker ist weg'];
  assert.deepEqual(said.map(text.sentence), [
    'Übergabe fehlt',
    'picker_a: außer Betrieb',
    'wo-1/3 ist auf dem Band',
    'Picker ist weg',
  ]);
});

test('each line of an answer is a sentence', async () => {
  await text.useLanguage('en');
  const message = 'component_2a is out of service\npassed in the queue: WO-2';
  const said = outcomeWords({ kind: 'accepted', message });
  assert.equal(said, 'Done. component_2a is out of service\nPassed in the queue: WO-2');
});
