/**
 * The stream of the page: one EventSource that never gives up.
 *
 * An EventSource ends for good on any answer but 200, and an open connection proves nothing: after
 * a cut cable it stays open for minutes. So here it is closed and opened anew when the beat is missing.
 */

const KINDS = ['begin', 'parts', 'happened', 'gap', 'beat', 'full'];
const SILENCE_MS = 5000;
const FIRST_WAIT_MS = 15000;
const AGAIN_MS = 2000;

/**
 * Open the stream.
 * @param {function(): string} cursor where to go on, HISTORY:SEQ; empty: from now
 * @param {function(string, Object): void} tell one message: its kind and data
 * @returns {{again: function(): void, close: function(): void}} `again` opens it anew at once
 */
export function openStream(cursor, tell) {
  let source = null;
  let timer = 0;

  function open() {
    close();
    const after = cursor();
    tell('opened', {});
    source = new EventSource(`/api/stream${after ? `?after=${encodeURIComponent(after)}` : ''}`);
    for (const kind of KINDS) source.addEventListener(kind, (event) => heard(kind, event));
    source.addEventListener('error', failed);
    // Before the first status only comments come, and those are not told to a script.
    wait(FIRST_WAIT_MS);
  }

  function heard(kind, event) {
    wait(SILENCE_MS);
    tell(kind, JSON.parse(event.data));
  }

  function failed() {
    // The browser's own attempts would ask for the first cursor again: the address holds it.
    tell(source.readyState === EventSource.CLOSED ? 'refused' : 'cut', {});
    source.close();
    wait(AGAIN_MS);
  }

  function wait(milliseconds) {
    clearTimeout(timer);
    timer = setTimeout(open, milliseconds);
  }

  function close() {
    clearTimeout(timer);
    source?.close();
    source = null;
  }

  open();
  return { again: open, close };
}
