/** Asking the page more than once: only the newest question counts, or again and again. */

/**
 * Make a way to ask in which only the newest question counts. An answer that comes after that of a
 * later question is dropped, and so is its failure.
 * @returns {function(function(): Promise<*>, function(*): void, function(*): void): Promise<void>}
 *   asks, and shows the answer or says why there is none
 */
export function newestOnly() {
  let newest = 0;
  return async (ask, show, fail) => {
    const mine = ++newest;
    const [tell, found] = await ask().then(
      (answer) => [show, answer],
      (refused) => [fail, refused],
    );
    if (mine === newest) tell(found);
  };
}

/**
 * Ask at once, and then each time so long after the last answer; not while nobody looks.
 * @param {function(): Promise<void>} ask
 * @param {number} pauseMs
 * @returns {function(): void} ends it
 */
export function repeat(ask, pauseMs) {
  let timer;
  let isOver = false;
  const again = (wait) => {
    clearTimeout(timer);
    if (!isOver && !document.hidden) timer = setTimeout(() => ask().then(later), wait);
  };
  const later = () => again(pauseMs);
  const look = () => again(0);
  document.addEventListener('visibilitychange', look);
  look();
  return () => {
    isOver = true;
    clearTimeout(timer);
    document.removeEventListener('visibilitychange', look);
  };
}
