/** What something waits for, in words. The node says it in English; here it is made from its data. */

import { currentLanguage, t } from './text.js';

/** Kinds of waits that say more when they name somebody. */
const KEYS = [
  { kind: 'job', by: 'name', key: 'job_named' },
  { kind: 'component', by: 'task', key: 'component_task' },
  { kind: 'zone', by: 'task', key: 'zone_task' },
];

/** Say one wait. */
export function waitWords(wait) {
  if (currentLanguage() === 'en' && wait.words) return wait.words;
  const sections = wait.sections.map((number) => t('part.section', { number })).join(', ');
  const key = KEYS.find((one) => one.kind === wait.kind && wait[one.by])?.key ?? wait.kind;
  const holder = [wait.task, sections].filter(Boolean).join(', ');
  return t(`wait.${key}`, { name: wait.name, task: wait.task, sections, holder });
}

/** The waits that matter, or else the first of the ordinary ones: one line. */
export function foremostWait(waits) {
  return waits.find((wait) => !wait.is_ordinary) ?? waits[0] ?? null;
}
