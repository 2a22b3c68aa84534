/** What something waits for, in words. The node says it in English; here it is made from its data. */

import { currentLanguage, t } from './text.js';

/** Say one wait. */
export function waitWords(wait) {
  if (currentLanguage() === 'en' && wait.words) return wait.words;
  const sections = wait.sections.map((number) => t('part.section', { number })).join(', ');
  const key = wait.kind === 'job' && wait.name ? 'job_named' : wait.kind;
  return t(`wait.${key}`, { name: wait.name, task: wait.task, sections });
}

/** The waits that matter, or else the first of the ordinary ones: one line. */
export function foremostWait(waits) {
  return waits.find((wait) => !wait.is_ordinary) ?? waits[0] ?? null;
}
