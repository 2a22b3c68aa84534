/** Dragging a row of the queue by its handle, with mouse, pen or finger. */

const STARTS_PX = 6;
const EDGE_PX = 60;
const SCROLL_PX = 12;

/**
 * Let a row be dragged. The list stays as it is; the row only follows the pointer.
 * @param {HTMLButtonElement} handle
 * @param {HTMLElement} row
 * @param {Object} tell
 * @param {function(number): void} tell.over the place under the pointer
 * @param {function(): void} tell.drop
 * @param {function(): void} tell.leave Escape, or the pointer was taken away
 */
export function draggable(handle, row, tell) {
  let start = null;
  let isDragged = false;

  function begin(event) {
    if (event.button !== 0 || handle.disabled) return;
    start = { y: event.clientY, scroll: scrollY };
    handle.setPointerCapture(event.pointerId);
  }

  function go(event) {
    if (!start) return;
    const way = event.clientY - start.y + scrollY - start.scroll;
    if (!isDragged && Math.abs(way) < STARTS_PX) return;
    isDragged = true;
    row.classList.add('is-dragged');
    row.style.transform = `translateY(${way}px)`;
    scrollAtEdge(event.clientY);
    const place = placeAt(row, event.clientY);
    if (place) tell.over(place);
  }

  function end(then) {
    if (!start) return;
    start = null;
    row.classList.remove('is-dragged');
    row.style.transform = '';
    if (isDragged) then();
    // The click that follows is a part of the drag.
    setTimeout(() => {
      isDragged = false;
    });
  }

  handle.addEventListener('pointerdown', begin);
  handle.addEventListener('pointermove', go);
  handle.addEventListener('pointerup', () => end(tell.drop));
  handle.addEventListener('pointercancel', () => end(tell.leave));
  handle.addEventListener('keydown', (event) => event.key === 'Escape' && end(tell.leave));
  handle.addEventListener('click', (event) => isDragged && event.stopImmediatePropagation(), true);
}

/** The place of the row under the pointer; null: there is none. */
function placeAt(row, y) {
  const rows = [...row.parentElement.children].filter((one) => one !== row);
  const under = rows.find((one) => {
    const { top, bottom } = one.getBoundingClientRect();
    return y >= top && y < bottom;
  });
  if (under) return Number(under.dataset.position) || null;
  const all = rows.map((one) => Number(one.dataset.position)).filter(Boolean);
  if (!all.length) return null;
  const { top } = rows[0].getBoundingClientRect();
  const { bottom } = rows.at(-1).getBoundingClientRect();
  if (y < top) return Math.min(...all, Number(row.dataset.position));
  return y >= bottom ? Math.max(...all, Number(row.dataset.position)) : null;
}

function scrollAtEdge(y) {
  if (y < EDGE_PX) scrollBy(0, -SCROLL_PX);
  else if (y > innerHeight - EDGE_PX) scrollBy(0, SCROLL_PX);
}
