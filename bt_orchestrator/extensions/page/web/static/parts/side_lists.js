/** Components that cannot work now, flags, and nodes of the cell: short lists beside the sections. */

import { attribute, h, keyed, show, text } from '../core/dom.js';
import { part, partsOf } from '../core/store.js';
import { about, person, said, t } from '../core/text.js';
import { shape } from '../core/shape.js';

/** Make the list of components in trouble: an element and `update()`; without any it is not shown. */
export function troubleList() {
  const list = h('ul', { class: 'troubles' });
  const rows = keyed(list, (component) => component.name, troubleRow);
  const element = h(
    'section',
    { class: 'panel trouble', 'data-part': 'trouble' },
    h('h2', {}, t('overview.trouble')),
    list,
  );
  return {
    element,
    update() {
      const troubled = partsOf('component/')
        .map(([, component]) => component)
        .filter((one) => one.trouble);
      rows(troubled);
      show(element, troubled.length);
    },
  };
}

function troubleRow() {
  const link = h('a', {});
  const words = h('span', { class: 'trouble-words' });
  const element = h('li', { class: 'trouble-row' }, shape('broken'), link, words);
  return {
    element,
    update(component) {
      attribute(element, 'data-component', component.name);
      attribute(link, 'href', `#/component/${encodeURIComponent(component.name)}`);
      text(link, component.name);
      text(words, troubleWords(component));
    },
  };
}

/** Say why a component cannot work. */
export function troubleWords(component) {
  const { out_of_service: reason, out_of_service_since: since } = component;
  if (since !== null) return t('trouble.out_of_service', { reason: person(reason), time: about(since) });
  if (!component.available) return t('trouble.away', { action: component.action });
  if (component.contested) return said(component.contested_said);
  return component.state ? t('trouble.state', { state: component.state }) : t('trouble.no_state');
}

/** Make the list of flags: an element and `update()`; without any it is not shown. */
export function flagList() {
  const list = h('ul', { class: 'flags' });
  const rows = keyed(list, (flag) => flag.name, flagRow);
  const element = h(
    'section',
    { class: 'panel', 'data-part': 'flags' },
    h('h2', {}, t('overview.flags')),
    list,
  );
  return {
    element,
    update() {
      const flags = part('flags')?.flags ?? [];
      rows(flags);
      show(element, flags.length);
    },
  };
}

function flagRow() {
  const name = h('span', { class: 'flag-name' });
  const count = h('span', { class: 'flag-count' });
  const element = h('li', { class: 'flag' }, name, count);
  return {
    element,
    update(flag) {
      attribute(element, 'data-flag', flag.name);
      text(name, flag.name);
      text(count, t('overview.flag_count', flag));
    },
  };
}

/** Make the list of nodes that can run the cell; if there can be only one it is not shown. */
export function nodeList() {
  const list = h('ul', { class: 'troubles' });
  const rows = keyed(list, (node) => node.key, nodeRow);
  const element = h(
    'section',
    { class: 'panel', 'data-part': 'nodes' },
    h('h2', {}, t('overview.nodes')),
    list,
  );
  return {
    element,
    update() {
      const leadership = part('cell')?.leadership;
      rows(leadership ? nodesOf(leadership) : []);
      show(element, Boolean(leadership));
    },
  };
}

function nodesOf(leadership) {
  const standbys = leadership.standbys.map((one) => {
    const trouble = said(one.said);
    const words = t(trouble ? 'overview.standby_trouble' : 'overview.standby', { ...one, trouble });
    return { key: `${one.host} ${one.process}`, shape: trouble ? 'triangle' : 'check', words };
  });
  const none = { key: 'none', shape: 'hollow', words: t('overview.no_standby') };
  const leader = { key: 'leader', shape: 'play', words: t('overview.leader', leadership) };
  return [leader, ...(standbys.length ? standbys : [none])];
}

function nodeRow() {
  const mark = h('span', {});
  const words = h('span', { class: 'trouble-words' });
  const element = h('li', { class: 'trouble-row' }, mark, words);
  return {
    element,
    update(node) {
      attribute(element, 'data-node', node.key);
      mark.replaceChildren(shape(node.shape));
      text(words, node.words);
    },
  };
}
