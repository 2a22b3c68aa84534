/**
 * One stream for all tabs of this browser: HTTP/1.1 allows six connections to one page, so the
 * seventh tab with a stream of its own would hang, and the sixth could give no command.
 */

import { Board } from './board.js';
import { openStream } from './source.js';

const board = new Board();
const tabs = new Set();
let stream = null;

function tell(kind, data) {
  if (kind === 'opened') board.opened();
  else if (kind === 'begin') board.begin(data);
  else if (kind === 'parts') board.take(data);
  else if (kind === 'happened') board.happened(data);
  else if (kind === 'gap') board.lost(data);
  for (const tab of tabs) tab.postMessage({ kind, data });
}

/** A tab that comes later is told what is known, as if its stream began now. */
function catchUp(tab) {
  if (!board.history) return;
  const { history, seq, version, node } = board;
  tab.postMessage({
    kind: 'begin',
    data: { history, after: seq, version, node, is_catching_up: true },
  });
  tab.postMessage({
    kind: 'parts',
    data: { version, set: Object.fromEntries(board.parts), gone: [] },
  });
}

function leave(tab) {
  tabs.delete(tab);
  if (tabs.size) return;
  stream?.close();
  stream = null;
}

self.addEventListener('connect', (/** @type {MessageEvent} */ event) => {
  const tab = event.ports[0];
  tab.addEventListener('message', ({ data }) => {
    if (data === 'bye') leave(tab);
    else if (data === 'again') stream?.again();
  });
  tab.start();
  tab.postMessage({ kind: 'joined', data: {} });
  catchUp(tab);
  tabs.add(tab);
  stream ??= openStream(() => board.cursor, tell);
});
