/** A command whose answer is lost: the journal says what became of it. */
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';

import { newTicket, send } from '../../bt_orchestrator/extensions/page/web/static/core/api.js';

const OFFER = { path: '/api/requests/cell.pause', body: { a: 1 } };
let asked;

beforeEach(() => {
  asked = [];
});

/** Let the page answer one thing after the other; null: the connection breaks. */
function answers(...given) {
  globalThis.fetch = async (path, { body }) => {
    asked.push([path, body && JSON.parse(body)]);
    const next = given.shift();
    if (next === null) throw new TypeError('no connection');
    const [status, told] = next;
    return { status, ok: status === 200, json: async () => told };
  };
}

test('an accepted command is told with the note of the page', async () => {
  answers([200, { message: 'paused', note: 'as operator' }]);
  const outcome = await send(OFFER, { reason: 'why' }, 't1');
  assert.deepEqual(outcome, { kind: 'accepted', message: 'paused — as operator', findings: [] });
  assert.deepEqual(asked, [[OFFER.path, { a: 1, reason: 'why', ticket: 't1' }]]);
});

test('a refusal keeps its findings', async () => {
  answers([409, { message: 'no', findings: ['f'] }]);
  assert.deepEqual(await send(OFFER, {}, 't1'), {
    kind: 'refused',
    message: 'no',
    findings: ['f'],
  });
});

test('a refusal is said in the language of the viewer', async () => {
  answers([409, { message: 'cell.reset', said: { en: '“Reset”', de: '„Zurücksetzen“' } }]);
  assert.equal((await send(OFFER, {}, 't1')).message, '“Reset”');
  answers([200, { message: 'a', said: { en: 'b' }, note: 'c' }]);
  assert.equal((await send(OFFER, {}, 't1')).message, 'b — c');
});

test('a session that is locked asks for the login', async () => {
  answers([403, { message: 'locked', why: 'locked' }]);
  assert.equal((await send(OFFER, {}, 't1')).kind, 'login');
});

test('what was not sent is not looked for', async () => {
  answers([503, { message: 'silent', is_unknown: false }]);
  assert.equal((await send(OFFER, {}, 't1')).kind, 'unsent');
  assert.equal(asked.length, 1);
});

test('a lost answer is asked of the journal', async () => {
  answers(null, [200, { found: true, accepted: true, message: 'paused' }]);
  const meanwhile = [];
  const outcome = await send(OFFER, {}, 't1', ({ kind }) => meanwhile.push(kind));
  assert.deepEqual(meanwhile, ['unknown']);
  assert.deepEqual([outcome.kind, outcome.isFromJournal], ['accepted', true]);
  assert.equal(asked[1][0], '/api/tickets/t1');
});

test('tickets differ and are 16 hexadecimal digits', () => {
  const tickets = Array.from({ length: 100 }, newTicket);
  assert.equal(new Set(tickets).size, 100);
  assert.match(tickets[0], /^[0-9a-f]{16}$/);
});
