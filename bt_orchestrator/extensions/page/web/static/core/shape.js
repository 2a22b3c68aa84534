/** Shapes: each state has one of its own, so that colour never has to tell it. */

import { svg } from './dom.js';

/** Paths in a square of 16. */
const PATHS = {
  play: 'M4 2.5v11l9.5-5.5z',
  quiet: 'M3 7h10v2H3z',
  square: 'M3 3h10v10H3z',
  octagon: 'M5.2 1h5.6L15 5.2v5.6L10.8 15H5.2L1 10.8V5.2zM7 4v5h2V4zm0 6.5v2h2v-2z',
  triangle: 'M8 1.2 15.4 14.6H.6zM7.1 6v4.4h1.8V6zm0 5.4v1.8h1.8v-1.8z',
  pause: 'M4 3h3v10H4zm5 0h3v10H9z',
  check: 'M6.3 13 1.8 8.5 3.2 7l3.1 3.1L12.8 3.6 14.2 5z',
  cross: 'M4 2.6 8 6.6l4-4L13.4 4l-4 4 4 4-1.4 1.4-4-4-4 4L2.6 12l4-4-4-4z',
  skip: 'M2 3v10l5.5-5zm6 0v10l5.5-5z',
  dots: 'M2 7h2.4v2.4H2zm4.8 0h2.4v2.4H6.8zm4.8 0H14v2.4h-2.4z',
  ring: 'M8 2a6 6 0 1 0 0 12A6 6 0 0 0 8 2zm0 2a4 4 0 1 1 0 8 4 4 0 0 1 0-8z',
  again:
    'M8 2.5a5.5 5.5 0 1 0 5.4 6.6h-2a3.6 3.6 0 1 1-1-3.6L8.3 7.6H14V1.9l-2.2 2.2A5.5 5.5 0 0 0 8 2.5z',
  broken:
    'M1 3.2 2.4 1.8l11.8 11.8-1.4 1.4zM8 12a1.3 1.3 0 1 0 .01 0zM3.4 7.8 4.8 9.2A5 5 0 0 1 7 7.9L5.4 6.3a7 7 0 0 0-2 1.5z',
  lock: 'M4 7V5a4 4 0 1 1 8 0v2h1v8H3V7zm2 0h4V5a2 2 0 1 0-4 0z',
  item: 'M2.5 4.5 8 1.5l5.5 3v7L8 14.5l-5.5-3z',
  hollow: 'M2 2h3v1.6H3.6V5H2zm9 0h3v3h-1.6V3.6H11zM2 11h1.6v1.4H5V14H2zm10.4 0H14v3h-3v-1.6h1.4z',
  grip: 'M5 2h2v2H5zm4 0h2v2H9zM5 7h2v2H5zm4 0h2v2H9zm-4 5h2v2H5zm4 0h2v2H9z',
  up: 'M8 3 14 10.6H2z',
  down: 'M8 13 2 5.4h12z',
  more: 'M2 4 8 10.4 14 4v2.8L8 13 2 6.8z',
  none: '',
};

/**
 * Draw a shape; words stand beside it, so readers of the screen skip it.
 * @param {keyof PATHS} name
 */
export function shape(name) {
  const path = svg('path', { d: PATHS[name] ?? '', 'fill-rule': 'evenodd' });
  return svg(
    'svg',
    { class: 'shape', viewBox: '0 0 16 16', 'aria-hidden': 'true', 'data-shape': name },
    path,
  );
}

/** Change a shape into another one. */
export function reshape(element, name) {
  if (element.dataset.shape === name) return;
  element.dataset.shape = name;
  element.firstChild.setAttribute('d', PATHS[name] ?? '');
}
