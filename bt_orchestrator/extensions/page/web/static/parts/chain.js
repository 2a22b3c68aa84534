/** The way from a part that waits to the root cause, as the node tells it, with links on it. */
import { h } from '../core/dom.js';
import { part, partsOf } from '../core/store.js';
import { said, t, tOr } from '../core/text.js';
import { inPath } from './links.js';
import { troubleWords } from './side_lists.js';
import { busyWith, heldWords } from './task_words.js';

/** Kinds of links that tell what is wrong with a component itself. */
const TROUBLES = ['out_of_service', 'readiness'];

/** The name of a part for a person: 'section/3' is Section 3. */
export function partName(key) {
  const [kind, name] = apart(key);
  return t(`chain.${kind}`, { name });
}

/** Several parts in few words: sections that follow each other as one span. */
export function partNames(keys) {
  const numbers = keys
    .filter((key) => key.startsWith('section/'))
    .map((key) => Number(apart(key)[1]));
  const spans = [];
  for (const number of numbers.sort((one, other) => one - other)) {
    if (spans.at(-1)?.last === number - 1) spans.at(-1).last = number;
    else spans.push({ first: number, last: number });
  }
  const listed = spans
    .map(({ first, last }) => (first === last ? first : `${first}–${last}`))
    .join(', ');
  const sections = listed
    ? [t('chain.sections', { count: numbers.length, numbers: listed })]
    : [];
  return [...sections, ...keys.filter((key) => !key.startsWith('section/')).map(partName)].join(
    '; ',
  );
}

/** The screen of a part; empty: it has none of its own. */
export function partScreen(key) {
  const [kind, name] = apart(key);
  const screens = { section: '#/section/', component: '#/component/', job: '#/job/' };
  if (kind === 'hold') return '#/overview';
  return kind in screens ? `${screens[kind]}${inPath(name)}` : '';
}

/** The parts of the drawing that belong to a part of the cell. */
export function drawnParts(key) {
  const [kind, name] = apart(key);
  if (kind === 'section') return [`section.${name}`];
  if (kind === 'belt' || kind === 'initialization') return [kind];
  const task = kind === 'component' ? taskOf(name) : part(key)?.task;
  return task ? [`task.${task}`] : [];
}

/** The id of the task that a component works on, or stands still at. */
function taskOf(component) {
  const lists = [...partsOf('section/'), ...partsOf('job/')].map(([, one]) => one.tasks ?? []);
  const running = part('belt')?.running ?? [];
  const isMine = (task) => task.component === component && ['running', 'held'].includes(task.mark);
  return [...lists.flat(), ...running].find(isMine)?.id;
}

/** Why one part waits for the next, in the viewer's language as far as it is data. */
export function linkWords(link) {
  if (link.said && link.kind !== 'hold') return said(link.said);
  if (link.to?.startsWith('hold/')) return t('wait.hold', { name: apart(link.to)[1] });
  const component = link.kind === 'task' ? part(link.to || link.part) : null;
  if (component?.task)
    return t('why.works', { component: component.name, task: busyWith(component) });
  const troubled = TROUBLES.includes(link.kind) ? part(link.part) : null;
  return troubled?.trouble ? `${troubled.name}: ${troubleWords(troubled)}` : link.words;
}

/** The chain as a list: each part, and why it waits for the next one. */
export function chainList(chain) {
  const steps = chain.links.map((link) =>
    h('li', {}, nameLink(link.part), h('span', { class: 'because' }, linkWords(link))),
  );
  const { root } = chain;
  const isNew = root.part !== chain.links.at(-1).part;
  const end = isNew ? h('li', { class: 'root' }, nameLink(root.part), rootWords(root)) : null;
  if (!isNew) steps.at(-1).classList.add('root');
  return h(
    'ol',
    { class: 'chain', 'aria-label': t('why.chain', { part: partName(chain.part) }) },
    steps,
    end,
  );
}

/** What a root cause is, and what has to happen. */
export function causeWords(root) {
  const hold = part(root.part)?.offers && root.kind === 'hold' ? part(root.part) : null;
  const what = hold ? holdWords(hold) : linkWords({ ...root, to: root.part });
  return `${what}. ${tOr(`why.do_${root.kind}`, t('why.do_other'))}`;
}

function holdWords(hold) {
  const place = hold.section ? t('part.section', { number: hold.section }) : '';
  const named = [place, hold.task, hold.item].filter(Boolean).join(', ');
  return `${named}: ${heldWords(hold)}`;
}

function rootWords(root) {
  return h('span', { class: 'because' }, h('strong', {}, t('why.root')), ' ', causeWords(root));
}

/** The name of a part, as a way to its screen if it has one. */
export function nameLink(key) {
  const to = partScreen(key);
  return to ? h('a', { href: to }, partName(key)) : h('span', { class: 'part' }, partName(key));
}

function apart(key) {
  const at = key.indexOf('/');
  return at < 0 ? [key, ''] : [key.slice(0, at), key.slice(at + 1)];
}
