/** Connects this tab to the stream: through the worker of all tabs, or else directly. */

import { openStream } from './source.js';

const JOIN_MS = 3000;

/**
 * Follow the stream until the tab is closed.
 * @param {function(): string} cursor
 * @param {function(string, Object): void} tell
 * @returns {{again: function(): void}}
 */
export function follow(cursor, tell) {
  let way = null;
  const direct = () => {
    way?.end();
    way = ofThisTab(cursor, tell);
  };
  way = ofAllTabs(tell, direct) ?? ofThisTab(cursor, tell);
  return { again: () => way.again() };
}

/** Join the worker; null: this browser has none. */
function ofAllTabs(tell, instead) {
  if (typeof SharedWorker === 'undefined') return null;
  let worker = null;
  let timer = 0;

  function join() {
    worker = new SharedWorker('/static/core/worker.js', {
      type: 'module',
      name: 'bt_orchestrator',
    });
    worker.addEventListener('error', instead);
    worker.port.addEventListener('message', ({ data }) => {
      clearTimeout(timer);
      if (data.kind !== 'joined') tell(data.kind, data.data);
    });
    worker.port.start();
    timer = setTimeout(instead, JOIN_MS);
  }

  function leave() {
    clearTimeout(timer);
    worker?.port.postMessage('bye');
    worker?.port.close();
    worker = null;
  }

  function comeBack(event) {
    if (event.persisted) join();
  }

  try {
    join();
  } catch {
    return null;
  }
  addEventListener('pagehide', leave);
  addEventListener('pageshow', comeBack);
  return {
    again: () => worker?.port.postMessage('again'),
    end: () => {
      leave();
      removeEventListener('pagehide', leave);
      removeEventListener('pageshow', comeBack);
    },
  };
}

/** A stream of this tab alone, closed while nobody looks: connections are few. */
function ofThisTab(cursor, tell) {
  let stream = null;

  function look() {
    if (document.hidden) {
      stream?.close();
      stream = null;
    } else {
      stream ??= openStream(cursor, tell);
    }
  }

  document.addEventListener('visibilitychange', look);
  look();
  return {
    again: () => stream?.again(),
    end: () => {
      document.removeEventListener('visibilitychange', look);
      stream?.close();
    },
  };
}
