/** The parameters of a request as fields. Which there are, and of which kind, the page says. */

import { attribute, h } from '../core/dom.js';
import { who } from '../core/me.js';
import { meaningOf } from '../core/requests.js';
import { t } from '../core/text.js';
import { UPDATE_FIELDS } from './update_fields.js';
import { beltField } from './belt_field.js';
import { CODE, codeField, hasReasons } from './code_field.js';

/** Parameters that the page asks for in its own way, by request and name. */
const SPECIAL = {
  'cell.clear.belt': beltField,
  'cell.production.belt': beltField,
  ...UPDATE_FIELDS,
};

/**
 * Make the fields of an offer: an element and `values()`; null where an entry is missing or wrong,
 * which is shown. `sofar()` is the same and shows nothing. `isOptional`: nothing has to be said.
 * What need not be said is folded away.
 */
export function parameterForm(offer) {
  const given = offer.body ?? {};
  const open = offer.parameters.filter(
    (one) => !(one.name in given) && isMine(one) && (one.name !== CODE || hasReasons()),
  );
  const fields = open.map((one) => ({ parameter: one, ...fieldOf(offer, one) }));
  const isPlain = ({ parameter }) =>
    parameter.is_required ||
    parameter.name === CODE ||
    `${offer.name}.${parameter.name}` in SPECIAL;
  const folded = fields.filter((field) => !isPlain(field));
  const element = h(
    'div',
    { class: 'form' },
    fields.filter(isPlain).map((field) => field.element),
    folded.length
      ? h(
          'details',
          {},
          h('summary', {}, t('ask.more')),
          folded.map((field) => field.element),
        )
      : null,
  );
  return {
    element,
    isOptional: !fields.some(isPlain),
    values: () => valuesOf(fields),
    sofar: () => valuesOf(fields, true),
  };
}

function isMine(parameter) {
  return !parameter.roles || parameter.roles.includes(who().role);
}

function valuesOf(fields, isQuiet = false) {
  const values = {};
  let isFine = true;
  for (const { parameter, read, warn } of fields) {
    const { value, isWrong } = read();
    const isMissing = value === undefined && parameter.is_required;
    if (!isQuiet) warn(isWrong || isMissing);
    isFine &&= !(isWrong || isMissing);
    if (value === undefined) continue;
    // A field may speak for other parameters too: what the belt is, instead of as it was shown.
    if (value?.instead) Object.assign(values, value.instead);
    else values[parameter.name] = value;
  }
  return isFine ? values : null;
}

function fieldOf(offer, parameter) {
  const special = SPECIAL[`${offer.name}.${parameter.name}`];
  if (special) return special(offer);
  if (parameter.name === CODE) return codeField(offer);
  /** @type {{input: HTMLElement, read: function(*): *}} */
  const { input, read } = inputOf(parameter);
  const warning = h(
    'p',
    { class: 'field-warning', role: 'alert', hidden: true },
    t('ask.field_wrong'),
  );
  const label = h('label', {}, h('span', {}, meaningOf(offer, parameter)), input);
  attribute(input, 'name', parameter.name);
  return {
    element: h('div', { class: 'field' }, label, warning),
    read: () => read(input),
    warn(isWrong) {
      warning.hidden = !isWrong;
      attribute(input, 'aria-invalid', isWrong ? 'true' : null);
    },
  };
}

function inputOf({ kind, choices }) {
  if (choices.length) {
    const options = ['', ...choices].map((one) => h('option', { value: one }, one));
    return { input: h('select', {}, options), read: readText };
  }
  if (kind === 'whole number')
    return {
      input: h('input', { type: 'number', step: 1, inputmode: 'numeric' }),
      read: readWhole,
    };
  if (kind === 'yes or no')
    return {
      input: h('input', { type: 'checkbox' }),
      read: ({ checked }) => ({ value: checked || undefined }),
    };
  if (kind === 'values by name')
    return {
      input: h('textarea', { rows: 3, placeholder: t('ask.values_hint') }),
      read: readValues,
    };
  if (kind === 'texts')
    return {
      input: h('textarea', { rows: 3 }),
      read: ({ value }) => ({ value: lines(value) }),
    };
  return { input: h('input', { type: 'text' }), read: readText };
}

function readText({ value }) {
  return { value: value.trim() || undefined };
}

function readWhole({ value, validity }) {
  if (value === '') return { value: undefined, isWrong: validity.badInput };
  return { value: Number(value), isWrong: !Number.isInteger(Number(value)) };
}

/** Read lines of `name = value`; a value is JSON if it can be read so, else text. */
function readValues({ value }) {
  const pairs = lines(value)?.map((line) => line.split(/=(.*)/s).map((part) => part.trim()));
  if (!pairs) return { value: undefined };
  if (pairs.some(([name, said]) => !name || said === undefined))
    return { value: undefined, isWrong: true };
  return { value: Object.fromEntries(pairs.map(([name, said]) => [name, plain(said)])) };
}

function plain(said) {
  try {
    return JSON.parse(said);
  } catch {
    return said;
  }
}

function lines(value) {
  const all = value
    .split('\n')
    .map((line) => line.trim())
    .filter(Boolean);
  return all.length ? all : undefined;
}
