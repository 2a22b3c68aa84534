/** The form of an order. What is right in it, the page says: here is only what was entered. */

import { h, children } from '../../core/dom.js';
import { said, t } from '../../core/text.js';
import { fieldWith } from '../../asking/entry.js';
import { jsonField } from '../../asking/json_field.js';
import { recipeFields } from '../../asking/recipe_fields.js';
import { scriptParams } from '../../asking/script_params.js';
import { timeField } from '../../asking/time_field.js';
import { newOrderId } from './order_id.js';
import { sourceField } from './source_field.js';

/**
 * Make it: an element, `value()`, `warn(findings)` and what fills it.
 * @param {function(): void} changed is called for each entry
 * @param {function(): void} left is called when a field is left for the first time
 */
export function orderForm(changed, left) {
  const source = sourceField(choose);
  const quantity = fieldWith(
    t('order.quantity'),
    h('input', { type: 'text', inputmode: 'numeric', name: 'quantity', autocomplete: 'off' }),
  );
  const order = fieldWith(
    t('order.id'),
    h('input', { type: 'text', name: 'order', autocomplete: 'off', spellcheck: 'false' }),
    t('order.id_hint'),
  );
  const priority = fieldWith(
    t('order.priority'),
    h('input', {
      type: 'text',
      inputmode: 'numeric',
      name: 'priority',
      autocomplete: 'off',
      placeholder: '0',
    }),
    t('order.priority_hint'),
  );
  const start = timeField(t('order.start'), 'start');
  const due = timeField(t('order.due'), 'due');
  const details = jsonField(t('order.details'), 'details', t('order.details_hint'));
  const position = fieldWith(
    t('order.position'),
    h('input', { type: 'number', name: 'position', min: 1, step: 1, inputmode: 'numeric' }),
  );
  const held = h('input', { type: 'checkbox', name: 'held' });
  const firstPiece = h('input', { type: 'checkbox', name: 'first_piece' });
  const ofRecipe = h('div', {});
  const params = h('div', { class: 'order-params' });
  const touched = new Set();
  let entries = scriptParams([]);
  let recipe = null;

  const element = h(
    'div',
    { class: 'order-parts' },
    group(
      'order.what',
      source.field.element,
      ofRecipe,
      quantity.element,
      params,
      check(firstPiece, t('order.first_piece')),
    ),
    group('order.when', priority.element, start.element, due.element),
    h(
      'div',
      {},
      group(
        'order.where',
        position.element,
        check(held, t('order.held')),
      ),
      group(
        'order.more',
        order.element,
        h('details', {}, h('summary', {}, t('order.details')), details.element),
      ),
    ),
  );
  element.addEventListener('input', changed);
  element.addEventListener('focusout', ({ target }) => {
    const { name } = /** @type {HTMLInputElement} */ (target);
    if (!name || touched.has(name)) return;
    touched.add(name);
    left();
  });
  order.input.value = newOrderId();

  function choose() {
    const chosen = source.chosen();
    recipe = chosen?.versions ? recipeFields(chosen, undefined, chooseVersion) : null;
    children(ofRecipe, recipe?.element ?? null);
    ask((recipe?.version() ?? chosen)?.parameters ?? []);
    quantity.input.placeholder = chosen?.quantity ?? '';
  }

  function chooseVersion() {
    ask(recipe.version().parameters, entries.values());
  }

  function ask(parameters, values = {}) {
    entries = scriptParams(parameters, values);
    children(params, entries.element);
  }

  const fields = () =>
    new Map([
      ['script', source.field],
      ...(recipe?.fields ?? []),
      ['quantity', quantity],
      ['order', order],
      ['priority', priority],
      ['start', start],
      ['due', due],
      ['details', details],
      ['position', position],
      ...[...entries.fields].map(([name, field]) => [`params.${name}`, field]),
    ]);

  /** What is wrong with a number in words of the page; the checker would tell of keys of a file. */
  function plainMistake(name) {
    const entered = { quantity, priority, position }[name]?.value();
    if (entered === '' && name === 'quantity') return t('order.quantity_missing');
    return entered && typeof whole(entered) !== 'number' ? t('order.whole') : '';
  }

  function value() {
    const written = {
      ...source.value(),
      ...recipe?.values(),
      order: order.value(),
      quantity: whole(quantity.value()),
      priority: whole(priority.value()),
      start: start.value(),
      due: due.value(),
      details: details.read(),
    };
    const filled = Object.fromEntries(
      Object.entries(written).filter(([, one]) => one !== '' && one !== undefined),
    );
    const given = entries.values();
    if (Object.keys(given).length) filled.params = given;
    if (firstPiece.checked) filled.first_piece = true;
    return { order: filled, position: Number(position.value()) || null, held: held.checked };
  }

  return {
    element,
    value,

    /** Show what is wrong; of entries that nobody has touched yet, only when everything is checked. */
    warn(findings, isAll) {
      const known = fields();
      const words = new Map();
      for (const { field, what, said: told } of findings) {
        const name = known.has(field) ? field : source.tells(field);
        const all = [words.get(name), told ? said(told) : what];
        words.set(name, plainMistake(name) || all.filter(Boolean).join('. '));
      }
      for (const [name, field] of known)
        field.warn(isAll || touched.has(name) ? (words.get(name) ?? '') : '');
      return words.get('') ?? '';
    },

    focusMistake: () => element.querySelector('[aria-invalid="true"]')?.focus(),

    setSources: source.set,

    setQueued(queued) {
      position.input.placeholder = t('order.by_urgency', { place: queued + 1 });
    },

    /** Be ready for another order like this one. */
    another() {
      order.input.value = newOrderId();
      source.field.input.focus();
      touched.clear();
    },
  };
}

function check(box, words) {
  return h('div', { class: 'field' }, h('label', { class: 'check' }, box, h('span', {}, words)));
}

function group(title, ...fields) {
  return h('fieldset', { class: 'order-group' }, h('legend', {}, t(title)), ...fields);
}

/** A whole number where it is one; else the text, and the page says what is wrong with it. */
function whole(said) {
  return /^[-+]?\d{1,15}$/.test(said) ? Number(said) : said;
}
