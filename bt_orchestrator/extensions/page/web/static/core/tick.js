/** What has to be said anew each second, because time passes: ages and elapsed times. */

const live = new Set();

/**
 * Call a function now and every second, until its element has left the page.
 * @param {Element} element
 * @param {function(): void} say
 */
export function everySecond(element, say) {
  live.add({ element, say, wasShown: false });
  say();
}

function tick() {
  for (const one of live) {
    if (one.element.isConnected) one.wasShown = true;
    else if (one.wasShown) live.delete(one);
    if (live.has(one)) one.say();
  }
}

setInterval(tick, 1000);
