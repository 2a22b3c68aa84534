/** Screens that show parts of the cell: they follow every part until they are left. */
import { subscribe } from './store.js';

/**
 * Put a screen into the page; returns what takes it out.
 * @param {Element} root
 * @param {{element: Element, update: function(): void, end: function(): void}} screen
 */
export function mountLive(root, screen) {
  root.append(screen.element);
  screen.update();
  const end = subscribe('', () => screen.update());
  return () => {
    end();
    screen.end();
  };
}
