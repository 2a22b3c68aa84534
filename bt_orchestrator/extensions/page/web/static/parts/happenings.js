/** Whether something happened to a thing since one looked last. */
import { position, recentEvents } from '../core/store.js';

const ENDS = ['task.succeeded', 'task.failed', 'task.marked_done', 'cycle.completed'];

/**
 * @param {function(Object): boolean} isMine tells whether an event belongs to the thing
 * @returns {function(): boolean} tells whether one came since the last call
 */
export function happenings(isMine) {
  let seen = position().seq;
  return () => {
    const news = recentEvents().filter((event) => event.seq > seen);
    seen = position().seq;
    return news.some(isMine);
  };
}

/** Something ended: histories are others now. */
export const isEnd = (event) => ENDS.includes(event.event);
