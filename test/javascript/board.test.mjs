/** What a tab knows of the cell: events once each, gaps told, parts as the node has them. */
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Board } from '../../bt_orchestrator/extensions/page/web/static/core/board.js';

function begun(after = 5) {
  const board = new Board();
  board.begin({ history: 'h', after, node: '/cell' });
  return board;
}

const records = (...numbers) => numbers.map((seq) => ({ seq }));

test('an event that comes twice is told once', () => {
  const board = begun();
  assert.deepEqual(board.happened({ history: 'h', records: records(6, 7) }), records(6, 7));
  assert.deepEqual(board.happened({ history: 'h', records: records(7, 8) }), records(8));
  assert.equal(board.twice, 1);
  assert.equal(board.cursor, 'h:8');
});

test('events that did not come are a gap', () => {
  const board = begun();
  board.happened({ history: 'h', records: records(9) });
  board.lost({ first: 10, last: 12 });
  board.begin({ history: 'h', after: 14, node: '/cell' });
  assert.deepEqual(board.gaps, [
    { first: 6, last: 8 },
    { first: 10, last: 12 },
    { first: 13, last: 14 },
  ]);
});

test('another history begins anew and its old events count for nothing', () => {
  const board = begun();
  board.lost({ first: 6, last: 7 });
  assert.equal(board.begin({ history: 'other', after: 0, node: '/cell' }), true);
  assert.deepEqual([board.gaps, board.cursor], [[], 'other:0']);
  assert.deepEqual(board.happened({ history: 'h', records: records(8) }), []);
});

test('a stream that was opened anew tells all parts', () => {
  const board = begun();
  board.take({ version: 1, set: { cell: 1, 'hold/1': 2 }, gone: [] });
  assert.deepEqual([...board.take({ version: 2, set: { belt: 3 }, gone: ['hold/1'] })].sort(), [
    'belt',
    'hold/1',
  ]);
  board.opened();
  board.take({ version: 9, set: { cell: 4 }, gone: [] });
  assert.deepEqual([...board.parts], [['cell', 4]]);
});
