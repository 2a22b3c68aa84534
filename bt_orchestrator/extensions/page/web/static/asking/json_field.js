/** JSON of the customer as a field. */

import { h } from '../core/dom.js';
import { t } from '../core/text.js';
import { fieldWith } from './entry.js';

/** Make it as `fieldWith` does, with `read()`: the value, the text where it is no JSON, or undefined. */
export function jsonField(label, name, hint) {
  const field = fieldWith(
    label,
    h('textarea', { name, rows: 4, spellcheck: 'false', placeholder: t('order.details_example') }),
    hint,
  );
  return {
    ...field,
    read() {
      const said = field.value();
      if (!said) return undefined;
      try {
        return JSON.parse(said);
      } catch {
        return said;
      }
    },
  };
}
