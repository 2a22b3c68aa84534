/** How long something took lately, as small bars with the nominal time as a line. */
import { svg } from '../core/dom.js';
import { seconds, t } from '../core/text.js';

const WIDTH = 7;
const HEIGHT = 30;

/**
 * @param {number[]} times oldest first
 * @param {number|null} nominal
 */
export function timeBars(times, nominal) {
  const most = Math.max(...times, nominal ?? 0) || 1;
  const y = (time) => HEIGHT - (time / most) * HEIGHT;
  const bars = times.map((time, place) =>
    svg('rect', { x: place * WIDTH, y: y(time), width: WIDTH - 2, height: HEIGHT - y(time) }),
  );
  const line = nominal
    ? svg('line', { x1: 0, x2: times.length * WIDTH, y1: y(nominal), y2: y(nominal) })
    : null;
  const words = t('history.times', {
    count: times.length,
    least: seconds(Math.min(...times)),
    most: seconds(Math.max(...times)),
  });
  return svg(
    'svg',
    {
      class: 'times',
      role: 'img',
      'aria-label': words,
      viewBox: `0 -1 ${Math.max(times.length, 1) * WIDTH} ${HEIGHT + 2}`,
      width: times.length * WIDTH,
      height: HEIGHT + 2,
    },
    svg('title', {}, words),
    bars,
    line,
  );
}
