/**
 * Elements without HTML strings: text stays text, so no name from the line becomes markup.
 *
 * What is shown is kept and changed in place. Nothing is drawn anew, so nothing flickers, and
 * focus and selection stay where they are.
 */

const SVG = 'http://www.w3.org/2000/svg';

/**
 * Make an element. `onclick` and the like are listeners, true is an attribute without a value, and
 * null, undefined and false are left out.
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Object<string, *>} attributes
 * @param {...*} children elements, texts, arrays of them; null and false are left out
 * @returns {HTMLElementTagNameMap[T]}
 */
export function h(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/**
 * Make an element of SVG, as `h` does for HTML.
 * @param {string} tag
 * @param {Object<string, *>} attributes
 * @param {...*} children
 * @returns {*}
 */
export function svg(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

/** @returns {*} */
function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') element.addEventListener(name.slice(2), value);
    else attribute(element, name, value);
  }
  element.append(
    ...children
      .flat(Infinity)
      .filter((child) => child !== null && child !== undefined && child !== false),
  );
  return element;
}

/** Set an attribute if it is another one now; null, undefined and false take it away. */
export function attribute(element, name, value) {
  if (value === null || value === undefined || value === false) {
    if (element.hasAttribute(name)) element.removeAttribute(name);
    return;
  }
  const text = value === true ? '' : String(value);
  if (element.getAttribute(name) !== text) element.setAttribute(name, text);
}

/** Set the text of an element if it is another one now. */
export function text(element, value) {
  const said = value === null || value === undefined ? '' : String(value);
  if (element.textContent !== said) element.textContent = said;
}

/** Show or hide an element. */
export function show(element, isShown) {
  if (element.hidden === Boolean(isShown)) element.hidden = !isShown;
}

/** Put other children into an element; those that stay are not touched. */
export function children(parent, ...wanted) {
  const list = wanted.flat(Infinity).filter(Boolean);
  for (const child of [...parent.childNodes]) if (!list.includes(child)) child.remove();
  inOrder(parent, list);
}

/**
 * Keep a list of children that belong to things by key. A thing that stays keeps its element.
 * @param {Element} parent has no other children
 * @param {function(*): (string|number)} key of a thing
 * @param {function(*): {element: Element, update: function(*): void, end?: function(): void}} make
 * @returns {function(Array): void} shows these things, in this order
 */
export function keyed(parent, key, make) {
  const views = new Map();
  return (things) => {
    const wanted = new Set(things.map((thing) => String(key(thing))));
    let left = -1;
    for (const [name, view] of views) {
      if (wanted.has(name)) continue;
      if (view.element.contains(document.activeElement)) {
        left = [...parent.children].indexOf(view.element);
      }
      view.end?.();
      view.element.remove();
      views.delete(name);
    }
    for (const thing of things) {
      const name = String(key(thing));
      if (!views.has(name)) views.set(name, make(thing));
      views.get(name).update(thing);
    }
    inOrder(
      parent,
      [...wanted].map((name) => views.get(name).element),
    );
    if (left >= 0) focusNear(parent.children[Math.min(left, parent.children.length - 1)] ?? parent);
  };
}

/**
 * Give the focus to an element, or to what it stands in: whatever takes it by `tabindex`. A button
 * beside the one that has gone would be pressed by a key that was meant for the other.
 */
export function focusNear(element) {
  let near = element;
  while (near && !(near.hasAttribute('tabindex') && near.checkVisibility())) {
    near = near.parentElement;
  }
  (near ?? document.getElementById('main')).focus({ preventScroll: true });
}

function inOrder(parent, elements) {
  const focused = /** @type {HTMLElement} */ (document.activeElement);
  let next = parent.firstChild;
  for (const element of elements) {
    if (element === next) next = next.nextSibling;
    else parent.insertBefore(element, next);
  }
  // An element that is moved loses the focus, also where it only makes room for another.
  if (focused && focused !== document.activeElement && parent.contains(focused)) {
    focused.focus({ preventScroll: true });
  }
}
