/** What became of a command, in words. */

import { withButtons } from '../core/requests.js';
import { sentence, t } from '../core/text.js';

/**
 * Say it.
 * @param {import('../core/api.js').Outcome} outcome
 */
export function outcomeWords({ kind, message, isFromJournal }) {
  const words = t(`outcome.${kind}`);
  if (kind === 'absent') return words;
  const source = isFromJournal ? t('outcome.journal') : '';
  const lines = withButtons(message).split('\n');
  return [source, words, lines.map(sentence).join('\n')].filter(Boolean).join(' ');
}
