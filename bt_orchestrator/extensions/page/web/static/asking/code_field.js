/** The reasons of the plant for a stop of the line, as a field of a form. */

import { h } from '../core/dom.js';
import { part } from '../core/store.js';
import { currentLanguage, t } from '../core/text.js';

/** The name of the parameter that takes the code of a reason. */
export const CODE = 'code';

/** Tell whether the plant has reasons. */
export function hasReasons() {
  return reasons().length > 0;
}

/** Tell whether a request takes one of them. */
export function takesCode({ parameters }) {
  return hasReasons() && parameters.some((one) => one.name === CODE);
}

/** A reason in the language of the viewer; one that is not in the plant's file by its code. */
export function reasonWords(code) {
  const reason = reasons().find((one) => one.code === code);
  if (!reason) return code;
  const { words } = reason;
  return words[currentLanguage()] ?? words.en ?? Object.values(words)[0];
}

/** Make the field: what `parameterForm` expects of one. */
export function codeField({ parameters = [] }) {
  const isRequired = parameters.some((one) => one.name === CODE && one.is_required);
  const groups = new Map();
  for (const one of reasons()) groups.set(one.group, [...(groups.get(one.group) ?? []), one]);
  const options = ({ code }) => h('option', { value: code }, reasonWords(code));
  const input = h(
    'select',
    { name: CODE, required: isRequired },
    h('option', { value: '' }, isRequired ? '' : t('ask.no_code')),
    [...groups].map(([group, all]) =>
      group ? h('optgroup', { label: group }, all.map(options)) : all.map(options),
    ),
  );
  const warning = h(
    'p',
    { class: 'field-warning', role: 'alert', hidden: true },
    t('ask.field_wrong'),
  );
  input.addEventListener('input', () => {
    warning.hidden = true;
  });
  return {
    element: h(
      'div',
      { class: 'field' },
      h('label', {}, h('span', {}, t('ask.code')), input),
      warning,
    ),
    read: () => ({ value: input.value || undefined }),
    warn(isWrong) {
      warning.hidden = !isWrong;
    },
  };
}

function reasons() {
  return part('reasons') ?? [];
}
