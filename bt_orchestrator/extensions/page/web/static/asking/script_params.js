/** The parameters of a script as fields: types, choices, ranges and defaults are the script's. */

import { h } from '../core/dom.js';
import { number, t } from '../core/text.js';
import { fieldWith } from './entry.js';

/**
 * Make the fields: an element, `fields` by name, and `values()`: texts of those that were filled in.
 * @param {Object[]} parameters as /api/scripts tells them
 * @param {Object<string, *>} values what they are now
 */
export function scriptParams(parameters, values = {}) {
  const fields = new Map(parameters.map((one) => [one.name, paramField(one, values[one.name])]));
  const element = h(
    'div',
    { class: 'form script-params' },
    [...fields.values()].map((field) => field.element),
  );
  return {
    element,
    fields,
    values: () =>
      Object.fromEntries(
        [...fields]
          .map(([name, field]) => [name, field.value()])
          .filter(([, value]) => value !== ''),
      ),
  };
}

function paramField(parameter, value) {
  const input = inputOf(parameter);
  input.name = `params.${parameter.name}`;
  input.value = value === undefined || value === null ? '' : String(value);
  const label = parameter.is_required
    ? t('order.required', { name: parameter.name })
    : parameter.name;
  return fieldWith(label, input, hintOf(parameter));
}

function inputOf({ type, choices, is_required: isRequired, default: standard }) {
  const said = choices?.length ? choices.map(String) : type === 'bool' ? ['true', 'false'] : null;
  if (said) {
    const none = isRequired ? t('order.choose') : t('order.default', { value: words(standard) });
    return h(
      'select',
      {},
      h('option', { value: '' }, none),
      said.map((one) => h('option', { value: one }, words(one))),
    );
  }
  const mode = { int: 'numeric', float: 'decimal' }[type] ?? 'text';
  return h('input', {
    type: 'text',
    inputmode: mode,
    autocomplete: 'off',
    'aria-required': isRequired ? 'true' : null,
    placeholder: isRequired ? null : words(standard),
  });
}

function words(value) {
  return t(`order.${value}`) === `order.${value}` ? String(value ?? '') : t(`order.${value}`);
}

function hintOf({ type, meaning, minimum, maximum, is_required: isRequired, default: standard }) {
  const said = [meaning, t(`order.type_${type}`)];
  const isBound = (value) => value !== null && value !== undefined;
  if (isBound(minimum) && isBound(maximum))
    said.push(t('order.between', { minimum: number(minimum), maximum: number(maximum) }));
  else if (isBound(minimum)) said.push(t('order.at_least', { minimum: number(minimum) }));
  else if (isBound(maximum)) said.push(t('order.at_most', { maximum: number(maximum) }));
  if (!isRequired) said.push(t('order.else_default', { value: words(standard) }));
  return said.filter(Boolean).join(' · ');
}
