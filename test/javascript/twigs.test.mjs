/** Conditions of the behaviour tree in the language of the viewer. */
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';

import * as text from '../../bt_orchestrator/extensions/page/web/static/core/text.js';
import { conditionWords, twigName } from '../../bt_orchestrator/extensions/page/web/static/parts/twig_words.js';

const STATIC = new URL('../../bt_orchestrator/extensions/page/web', import.meta.url);
globalThis.document = { documentElement: {} };
globalThis.fetch = async (path) => {
  const file = await readFile(`${STATIC.pathname}${path}`, 'utf-8');
  return { ok: true, json: async () => JSON.parse(file) };
};

test('names of behaviours are German, and their values stay', async () => {
  await text.useLanguage('de');
  assert.equal(twigName('up to 1 more round'), 'bis zu 1 weitere Runde');
  assert.equal(twigName('up to 2 more rounds'), 'bis zu 2 weitere Runden');
  const bounds = '${results.weigh.measurement} from 4.8 to 5.4';
  assert.equal(
    twigName(`fails unless ${bounds}`),
    'misslingt, außer: ${results.weigh.measurement} von 4.8 bis 5.4',
  );
  assert.equal(twigName('when ${a} at least 2'), 'wenn ${a} mindestens 2');
  assert.equal(conditionWords('${a} is not 2 or ${b}'), '${a} nicht 2 oder ${b}');
});
