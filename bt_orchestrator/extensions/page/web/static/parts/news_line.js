/** How old the news are. What is old looks old: two sentences, for two different troubles. */

import { attribute, h, text } from '../core/dom.js';
import { isEmergency, wordOf } from '../core/requests.js';
import { clock, news, part, position, subscribe } from '../core/store.js';
import { at, atInZone, duration, list, t } from '../core/text.js';
import { everySecond } from '../core/tick.js';

/** Make the line: an element, `end()`. */
export function newsLine() {
  const words = h('span', { class: 'news-words' });
  const element = h('div', { class: 'news', role: 'status' }, words);
  const update = () => {
    attribute(element, 'data-news', news().kind);
    text(words, newsWords());
  };
  everySecond(element, update);
  return { element, end: subscribe('news', update) };
}

/** Say it in a few words. */
function newsWords() {
  const { kind } = news();
  const time = new Date().getTime() / 1000;
  if (kind === 'fresh') return t('news.fresh', { time: atInZone(time) });
  return t(`news.short_${kind}`);
}

/** Say what is the trouble with the news, and since when; empty: none. */
export function newsTrouble() {
  const { kind, heard, refused, full } = news();
  if (kind === 'fresh') return gapWords();
  if (full) return t('news.full');
  if (refused && kind === 'none') return t('news.refused');
  if (heard === null) return `${t(`news.${kind}`)} ${t('news.never_heard')}`;
  const since = t('news.last_heard', { time: at(heard), ago: duration(clock() - heard) });
  return `${t(`news.${kind}`)} ${since} ${t('news.old')} ${pressable()}`;
}

/** Name the commands that can be pressed on old news: those that the cell offered last. */
function pressable() {
  const words = (part('cell')?.offers ?? []).filter(isEmergency).map(wordOf);
  if (!words.length) return t('news.none_pressable');
  return t('news.pressable', { count: words.length, commands: list(words) });
}

function gapWords() {
  const { gaps } = position();
  if (!gaps.length) return '';
  const spans = gaps.map(({ first, last }) => (first === last ? `${first}` : `${first}–${last}`));
  return t('news.gaps', { spans: spans.join(', ') });
}
