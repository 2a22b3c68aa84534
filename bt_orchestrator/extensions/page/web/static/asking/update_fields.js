/** The fields in which a queued job is changed: filled with what it is, and only changes are sent. */

import { Refused, get } from '../core/api.js';
import { children, h } from '../core/dom.js';
import { part } from '../core/store.js';
import { t } from '../core/text.js';
import { fieldWith } from './entry.js';
import { jsonField } from './json_field.js';
import { recipeFields } from './recipe_fields.js';
import { scriptParams } from './script_params.js';
import { timeField } from './time_field.js';

const NONE = 'none';

/** By request and parameter, as `parameterForm` asks for them. */
export const UPDATE_FIELDS = {
  'job.update.quantity': (offer) => wholeField('quantity', jobOf(offer)?.quantity),
  'job.update.priority': (offer) => wholeField('priority', jobOf(offer)?.priority),
  'job.update.params': (offer) => paramFields(jobOf(offer)),
  'job.update.version': (offer) => ofRecipe(jobOf(offer)),
  'job.update.bind': () => SAID_ABOVE,
  'job.update.start': (offer) => momentField('start', jobOf(offer)?.start),
  'job.update.due': (offer) => momentField('due', jobOf(offer)?.due),
  'job.update.details': detailsField,
};

/** What another field speaks for. */
const SAID_ABOVE = { element: null, read: () => ({ value: undefined }), warn: () => {} };

function jobOf(offer) {
  return part(`job/${offer.subject}`);
}

function wholeField(name, now) {
  const field = fieldWith(
    t(`order.${name}`),
    h('input', { type: 'text', inputmode: 'numeric', name, autocomplete: 'off' }),
  );
  const before = now === undefined ? '' : String(now);
  field.input.value = before;
  return {
    element: field.element,
    read() {
      const said = field.value();
      if (said === before || said === '') return { value: undefined };
      return { value: Number(said), isWrong: !/^[-+]?\d{1,9}$/.test(said) };
    },
    warn: (isWrong) => field.warn(isWrong ? t('order.whole') : ''),
  };
}

function momentField(name, now) {
  const field = timeField(t(`order.${name}`), name, now);
  const before = field.input.value;
  return {
    element: field.element,
    read() {
      if (field.isWrong()) return { value: undefined, isWrong: true };
      if (field.input.value === before) return { value: undefined };
      return { value: field.value() || NONE };
    },
    warn: (isWrong) => field.warn(isWrong ? t('order.moment') : ''),
  };
}

function detailsField() {
  const field = jsonField(t('order.details'), 'details', t('order.details_update'));
  return {
    element: h('details', {}, h('summary', {}, t('order.details')), field.element),
    read() {
      const value = field.read();
      return {
        value,
        isWrong: value !== undefined && (typeof value !== 'object' || value === null),
      };
    },
    warn: (isWrong) => field.warn(isWrong ? t('order.json') : ''),
  };
}

/** Version and bindings of a job by recipe. Who names a recipe names all of it, so all is sent. */
function ofRecipe(job) {
  const element = h('div', { class: 'field wide' });
  let fields = null;
  let before = '';

  async function load() {
    try {
      const found = (await get('/api/recipes')).find(({ name }) => name === job.recipe);
      if (!found) return;
      fields = recipeFields(found, job.choice);
      before = JSON.stringify(fields.values());
      children(element, fields.element);
    } catch (refused) {
      if (!(refused instanceof Refused)) throw refused;
      children(element, h('p', { class: 'warn' }, refused.message || t('order.no_scripts')));
    }
  }

  if (job?.choice) load();
  return {
    element,
    read() {
      const said = fields?.values() ?? {};
      if (!fields || JSON.stringify(said) === before) return { value: undefined };
      return { value: { instead: { recipe: job.choice.recipes, ...said } } };
    },
    warn: () => {},
  };
}

/** The parameters come from the script; until they are there nothing of them is changed. */
function paramFields(job) {
  const element = h('div', { class: 'field wide' });
  let entries = null;
  let before = {};

  async function load() {
    try {
      const { parameters } = await get(`/api/scripts/${job.digest}`);
      entries = scriptParams(parameters, job.params);
      before = entries.values();
      children(element, parameters.length ? entries.element : null);
    } catch (refused) {
      if (!(refused instanceof Refused)) throw refused;
      children(element, h('p', { class: 'warn' }, refused.message || t('order.no_scripts')));
    }
  }

  if (job) load();
  return {
    element,
    read() {
      const now = entries?.values() ?? {};
      const changed = Object.entries(now).filter(([name, value]) => value !== before[name]);
      return { value: changed.length ? Object.fromEntries(changed) : undefined };
    },
    warn: () => {},
  };
}
