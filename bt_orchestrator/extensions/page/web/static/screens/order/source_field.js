/** What an order is of: a script, or a recipe. */

import { children, h } from '../../core/dom.js';
import { t } from '../../core/text.js';
import { fieldWith } from '../../asking/entry.js';

const RECIPE = 'recipe/'; // the name of a script has no slash

/**
 * Make it: the field, what was chosen, and the key of an order for it.
 * @param {function(): void} changed is called when something else was chosen
 */
export function sourceField(changed) {
  const field = fieldWith(
    t('order.source'),
    h('select', { name: 'script' }, h('option', { value: '' }, t('order.choose'))),
  );
  const known = new Map();
  field.input.addEventListener('input', changed);

  function options(found, prefix, words) {
    return found.map((one) => {
      known.set(`${prefix}${one.name}`, one);
      return h('option', { value: `${prefix}${one.name}` }, words(one));
    });
  }

  return {
    field,
    chosen: () => known.get(field.value()),

    /** The key of an order, with its value. */
    value() {
      const name = field.value();
      return name.startsWith(RECIPE) ? { recipe: name.slice(RECIPE.length) } : { script: name };
    },

    /** The field that tells of a mistake in a key of an order; empty: another one does. */
    tells: (key) => (/^(recipe|version|bind)/.test(key) ? 'script' : ''),

    set(scripts, recipes) {
      known.clear();
      const named = new Map(scripts.map((one) => [one.name, one]));
      const groups = [
        ['order.scripts', options([...named.values()], '', ({ name }) => name)],
        ['order.recipes', options(recipes, RECIPE, ({ name }) => name)],
      ].filter(([, listed]) => listed.length);
      const shown =
        groups.length > 1
          ? groups.map(([title, listed]) => h('optgroup', { label: t(title) }, listed))
          : groups.flatMap(([, listed]) => listed);
      children(field.input, field.input.firstChild, shown);
      if (known.size === 1) [field.input.value] = known.keys();
      changed();
    },
  };
}
