/** Of an order by recipe: which version is made, and who does what several components can do. */

import { children, h } from '../core/dom.js';
import { t } from '../core/text.js';
import { fieldWith } from './entry.js';

/**
 * Make the fields: an element, `fields` by key of an order, `version()` as it is chosen, and
 * `values()`: the keys of an order that were chosen.
 * @param {Object} recipe as /api/recipes tells it
 * @param {{version: ?number, bind: Object<string, string>}} choice what was chosen before
 * @param {function(): void} changed is called when another version was chosen
 */
export function recipeFields(recipe, choice = { version: null, bind: {} }, changed = () => {}) {
  const version = fieldWith(t('order.version'), versionInput(recipe.versions, choice.version));
  const chosen = () => recipe.versions.find((one) => String(one.version) === version.value());
  const now = () => chosen() ?? recipe.versions.at(-1);
  const list = h('div', { class: 'form script-params' });
  const who = h(
    'details',
    { class: 'order-bind', open: Object.keys(choice.bind).length > 0 },
    h('summary', {}, t('order.bind')),
    h('p', { class: 'hint' }, t('order.bind_hint')),
    list,
  );
  let binds = new Map();

  function fill(bound) {
    binds = new Map(alternatives(now(), bound).map((one) => [one.operation, bindField(one, who)]));
    for (const [operation, field] of binds) field.input.value = bound[operation] ?? '';
    children(
      list,
      [...binds.values()].map((field) => field.element),
    );
    who.hidden = !binds.size;
  }

  const bound = () =>
    Object.fromEntries(
      [...binds]
        .map(([operation, field]) => [operation, field.value()])
        .filter(([, one]) => one !== ''),
    );

  version.input.addEventListener('input', () => {
    fill(bound());
    changed();
  });
  fill(choice.bind);
  return {
    element: h('div', { class: 'order-recipe' }, version.element, who),
    version: now,
    get fields() {
      return new Map(
        /** @type {Array<[string, Object]>} */ ([
          ['version', version],
          ...[...binds].map(([operation, field]) => [`bind.${operation}`, field]),
        ]),
      );
    },
    values() {
      const bind = bound();
      return {
        ...(chosen() ? { version: chosen().version } : {}),
        ...(Object.keys(bind).length ? { bind } : {}),
      };
    },
  };
}

function versionInput(versions, before) {
  const newest = versions.at(-1).version;
  const input = h(
    'select',
    { name: 'version' },
    h('option', { value: '' }, t('order.newest', { version: newest })),
    [...versions].reverse().map(({ version }) => h('option', { value: version }, version)),
  );
  input.value = before ?? '';
  return input;
}

/** What can be chosen, and what was chosen before, even if it cannot be any more. */
function alternatives({ bind }, bound) {
  const listed = bind.map(({ operation, components }) => ({
    operation,
    components: [...new Set([...components, bound[operation] ?? components[0]])],
  }));
  const known = new Set(bind.map(({ operation }) => operation));
  const others = Object.entries(bound).filter(([operation]) => !known.has(operation));
  return [
    ...listed,
    ...others.map(([operation, component]) => ({ operation, components: [component] })),
  ];
}

function bindField({ operation, components }, around) {
  const field = fieldWith(
    operation,
    h(
      'select',
      { name: `bind.${operation}` },
      h('option', { value: '' }, t('order.free')),
      components.map((one) => h('option', { value: one }, one)),
    ),
  );
  return {
    ...field,
    warn(words) {
      if (words) around.open = true;
      field.warn(words);
    },
  };
}
