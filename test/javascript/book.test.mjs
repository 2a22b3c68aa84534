/** What a tab knows of the cell: events once each, gaps told, parts as the node has them. */
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Book } from '../../bt_orchestrator/extensions/page/web/static/core/book.js';

function begun(after = 5) {
  const book = new Book();
  book.begin({ history: 'h', after, node: '/cell' });
  return book;
}

const records = (...numbers) => numbers.map((seq) => ({ seq }));

test('an event that comes twice is told once', () => {
  const book = begun();
  assert.deepEqual(book.happened({ history: 'h', records: records(6, 7) }), records(6, 7));
  assert.deepEqual(book.happened({ history: 'h', records: records(7, 8) }), records(8));
  assert.equal(book.twice, 1);
  assert.equal(book.cursor, 'h:8');
});

test('events that did not come are a gap', () => {
  const book = begun();
  book.happened({ history: 'h', records: records(9) });
  book.lost({ first: 10, last: 12 });
  book.begin({ history: 'h', after: 14, node: '/cell' });
  assert.deepEqual(book.gaps, [
    { first: 6, last: 8 },
    { first: 10, last: 12 },
    { first: 13, last: 14 },
  ]);
});

test('another history begins anew and its old events count for nothing', () => {
  const book = begun();
  book.lost({ first: 6, last: 7 });
  assert.equal(book.begin({ history: 'other', after: 0, node: '/cell' }), true);
  assert.deepEqual([book.gaps, book.cursor], [[], 'other:0']);
  assert.deepEqual(book.happened({ history: 'h', records: records(8) }), []);
});

test('a stream that was opened anew tells all parts', () => {
  const book = begun();
  book.take({ version: 1, set: { cell: 1, 'hold/1': 2 }, gone: [] });
  assert.deepEqual([...book.take({ version: 2, set: { belt: 3 }, gone: ['hold/1'] })].sort(), [
    'belt',
    'hold/1',
  ]);
  book.opened();
  book.take({ version: 9, set: { cell: 4 }, gone: [] });
  assert.deepEqual([...book.parts], [['cell', 4]]);
});
