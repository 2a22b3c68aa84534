/** Names and messages of the behaviour tree in the viewer's language; the node tells them in English. */

import { part, partsOf } from '../core/store.js';
import { currentLanguage, t, tOr } from '../core/text.js';
import { waitWords } from '../core/waits.js';

/** The node's own names by their words here; all others are names of tasks, jobs and topics. */
const NAMES = Object.entries({
  initialization: /^initialization$/,
  belt: /^belt$/,
  section: /^section (?<name>\d+)$/,
  in_order: /^in order$/,
  parallel: /^parallel$/,
  standby: /^standby$/,
  turns: /^all turns complete$/,
  at_rest: /^belt at rest$/,
  earlier: /^earlier jobs done$/,
  after: /^after (?<name>.+)$/,
  works_on: /^works on (?<name>.+)$/,
  release: /^release conveyor$/,
  complete: /^complete cycle$/,
  next: /^next cycle$/,
  flag: /^flag (?<name>.+ [<>].*)$/,
  zone: /^zone (?<name>.+) free$/,
  retry: /^retry up to (?<name>\d+) times?$/,
  rounds: /^up to (?<number>\d+) more rounds?$/,
  unless: /^fails unless (?<name>.+)$/,
  when: /^when (?<name>.+)$/,
  except: /^unless (?<name>.+)$/,
  hold: /^hold if it fails$/,
  continue: /^continue if it fails$/,
  reject: /^reject if it fails$/,
  abort_job: /^abort the job if it fails$/,
});

/** What the node says of a behaviour that waits for nothing. */
const MESSAGES = Object.entries({
  done: /^done$/,
  marked: /^marked done: (?<reason>\w+)$/,
  skipped: /^skipped: (?<name>.+)$/,
  continued: /^failed and continued: (?<reason>\w+)$/,
  rejected: /^failed and the item rejected: (?<reason>\w+)$/,
  aborted: /^failed and the job aborted: (?<reason>\w+)$/,
  aborting: /^the job is being aborted$/,
  found: /^found (?<name>.+)$/,
  caused: /^round (?<number>\d+): (?<name>.+)$/,
  decided: /^decided$/,
  finished: /^finished with (?<name>.+)$/,
  attempt: /^attempt (?<name>\d+)$/,
  round: /^round (?<name>\d+)$/,
  running: /^running at (?<name>\S+)$/,
  failed: /^failed: (?<reason>\w+)$/,
  next_beat: /^next beat begins, the belt is empty$/,
});
/** The words of a condition; `extensions/page/web/wording.py` has the same. */
const COMPARED = Object.entries({
  when: /^when (?<value>.)/,
  except: /^unless (?<value>.)/,
  between: / from (?<low>\S+) to (?<high>\S+)/g,
  at_least: / at least (?<value>\S+)/g,
  at_most: / at most (?<value>\S+)/g,
  one_of: / one of (?<value>\S)/g,
  is_not: / is not (?<value>\S)/g,
  and: / and (?<value>\S)/g,
  or: / or (?<value>\S)/g,
});
/** Names that have a condition. */
const CONDITIONS = ['unless', 'when', 'except'];
const BETWEEN = '; ';
const AND = ', ';

/** Name a behaviour. */
export function twigName(name) {
  return currentLanguage() === 'en' ? name : said(NAMES, name);
}

/**
 * What makes a message of a behaviour one in the viewer's language, English too, which has no words
 * of programs here: waits are known as data, by their sentence; what is none, as the id of an item, stays as it is.
 * @returns {function(string): string}
 */
export function messageWords() {
  const known = new Map(allWaits().map((wait) => [wait.words, wait]));
  const parts = (sentence) => sentence.split(AND).map((one) => said(MESSAGES, one)).join(AND);
  const say = (sentence) =>
    known.has(sentence) ? waitWords(known.get(sentence)) : parts(sentence);
  // A sentence may have several parts itself.
  return (message) =>
    known.has(message) ? say(message) : message.split(BETWEEN).map(say).join(BETWEEN);
}

/** Say a condition, which is in English; its names and values stay. */
export function conditionWords(english) {
  return COMPARED.reduce(
    (words, [key, pattern]) =>
      words.replace(pattern, (...found) => t(`condition.${key}`, found.at(-1))),
    english,
  );
}

function said(words, english) {
  for (const [key, pattern] of words) {
    const found = pattern.exec(english);
    if (!found) continue;
    const { name: told = '', number = '', reason = '' } = found.groups ?? {};
    const name = CONDITIONS.includes(key) ? conditionWords(told) : told;
    return t(`twig.${key}`, { name, number, count: number, reason: tOr(`reason.${reason}`, reason) });
  }
  return english;
}

function allWaits() {
  const sections = partsOf('section/').flatMap(([, one]) => one.waits);
  const tasks = [...partsOf('section/'), ...partsOf('job/')].flatMap(([, one]) => one.tasks);
  return [
    ...sections,
    ...tasks.flatMap((task) => task.waits),
    ...(part('belt')?.waits ?? []),
    ...(part('cell')?.initialization ?? []),
  ];
}
