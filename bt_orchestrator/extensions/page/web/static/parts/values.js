/** Values of devices as small tables: feedback, arguments, results. */
import { h } from '../core/dom.js';

const DEEPEST = 3;

/** A mapping as a list of names and values; deeper ones stand inside. */
export function values(mapping) {
  return h('dl', { class: 'values' }, rows(mapping, 1));
}

/** A text that is one JSON object, as feedback is; text that is none stays as it is. */
export function jsonValues(said) {
  try {
    const read = JSON.parse(said);
    if (read && typeof read === 'object') return values(read);
  } catch {
    // no JSON: a device may say anything
  }
  return h('code', {}, said);
}

function rows(mapping, depth) {
  return Object.entries(mapping).map(([name, value]) =>
    h('div', {}, h('dt', {}, name), h('dd', {}, shown(value, depth))),
  );
}

function shown(value, depth) {
  if (typeof value === 'string') return value;
  const isMapping = value && typeof value === 'object' && !Array.isArray(value);
  if (isMapping && depth < DEEPEST) return h('dl', { class: 'values' }, rows(value, depth + 1));
  return JSON.stringify(value);
}
