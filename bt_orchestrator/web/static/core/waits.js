/** What something waits for, in words. The node says it in English; here it is made from its data. */

import { part } from './store.js';
import { currentLanguage, list, t, tOr } from './text.js';

/** Kinds of waits that say more when they name somebody. */
const KEYS = [
  { kind: 'job', by: 'name', key: 'job_named' },
  { kind: 'component', by: 'task', key: 'component_task' },
  { kind: 'zone', by: 'task', key: 'zone_task' },
];

/** What a line that is to run empty still does. */
const AFTER = ['item', 'job'];

/** Of more sections than these only their number is said. */
const FEW = 3;

/** Of a hold the node says the reason as programs have it, in one word. */
const ABOUT_HOLDS = ['hold', 'pause'];

/** Say one wait. */
export function waitWords(wait) {
  if (ABOUT_HOLDS.includes(wait.kind)) return holdWords(wait);
  if (currentLanguage() === 'en' && wait.words && wait.sections.length <= FEW) return wait.words;
  if (wait.kind === 'cell_state') return stateWords(wait.name);
  const sections = sectionWords(wait.sections);
  const key = KEYS.find((one) => one.kind === wait.kind && wait[one.by])?.key ?? wait.kind;
  const holder = [wait.task, sections].filter(Boolean).join(', ');
  return t(`wait.${key}`, { name: wait.name, task: wait.task, sections, holder });
}

function holdWords({ kind, name, holds = [] }) {
  if (holds.length) return t('wait.holds', { names: list(holds) });
  const hold = part(`hold/${name}`);
  if (!hold?.task) return t(`wait.${kind}`, { name });
  const reason = tOr(`reason.${hold.reason}`, hold.reason);
  return t('wait.hold_of', { name, task: hold.label, reason });
}

/** The state in which nothing starts; or that the line runs empty, after an item or a job. */
function stateWords(name) {
  if (AFTER.includes(name)) return t('wait.stop_after');
  return t('wait.cell_state', { name: tOr(`state.${name}`, name) });
}

function sectionWords(numbers) {
  const named = numbers.slice(0, FEW).map((number) => t('part.section', { number }));
  const more = numbers.length - named.length;
  return [...named, more > 0 ? t('wait.more_sections', { count: more }) : '']
    .filter(Boolean)
    .join(', ');
}

/** The waits that matter, or else the first of the ordinary ones: one line. */
export function foremostWait(waits) {
  return waits.find((wait) => !wait.is_ordinary) ?? waits[0] ?? null;
}
