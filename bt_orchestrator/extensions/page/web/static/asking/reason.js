/** The reason of a command. Reasons that were given lately can be given again by one press. */

import { children, h } from '../core/dom.js';
import { t } from '../core/text.js';
import { reasonWords } from './code_field.js';

const LONGEST = 2000;
const KEPT = 4;
const KEY = 'bt_orchestrator.reasons';

/**
 * Make the field: an element, `value()`, and `isGiven()`, which shows where it is missing.
 * @param {string} request
 * @param {boolean} isNeeded
 * @param {(function(): string|undefined)|null} chosen the code of the plant's reason that is
 *   chosen beside it, which is enough; null: none can be
 */
export function reasonField(request, isNeeded, chosen = null) {
  const isRequired = isNeeded && !chosen;
  const field = h('textarea', {
    rows: 2,
    maxlength: LONGEST,
    name: 'reason',
    required: isRequired,
    'aria-required': isRequired,
  });
  const warning = h(
    'p',
    { class: 'field-warning', role: 'alert', hidden: true },
    t('ask.reason_missing'),
  );
  const again = lately(request).map((words) =>
    h('button', { type: 'button', class: 'chip', onclick: () => choose(words) }, words),
  );
  const kind = isRequired ? 'reason' : isNeeded ? 'reason_or_code' : 'reason_optional';
  const label = t(`ask.${kind}`);
  const element = h('div', { class: 'field' }, h('label', {}, h('span', {}, label), field));
  children(element, element.firstChild, h('div', { class: 'chips' }, again), warning);

  function choose(words) {
    field.value = words;
    warning.hidden = true;
    field.focus();
  }

  field.addEventListener('input', () => {
    warning.hidden = true;
  });
  return {
    element,
    focus: () => field.focus(),
    typed: () => field.value.trim(),
    value: () => field.value.trim() || (isNeeded && chosen?.() ? reasonWords(chosen()) : ''),
    isGiven() {
      const isFine = !isNeeded || this.value() !== '';
      warning.hidden = isFine;
      if (!isFine) field.focus();
      return isFine;
    },
  };
}

/** Keep a reason that was accepted, so that it can be given again. */
export function keepReason(request, words) {
  if (!words) return;
  const all = kept();
  all[request] = [words, ...lately(request).filter((one) => one !== words)].slice(0, KEPT);
  localStorage.setItem(KEY, JSON.stringify(all));
}

function lately(request) {
  return kept()[request] ?? [];
}

function kept() {
  try {
    return JSON.parse(localStorage.getItem(KEY)) ?? {};
  } catch {
    return {};
  }
}
