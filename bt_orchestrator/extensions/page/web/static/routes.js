/** The screens by the first word of the address behind `#/`; each is loaded when it is needed. */

export const SCREENS = {
  overview: () => import('./screens/overview.js'),
  queue: () => import('./screens/queue.js'),
  order: () => import('./screens/order.js'),
  manual: () => import('./screens/manual.js'),
  section: () => import('./screens/section.js'),
  component: () => import('./screens/component.js'),
  why: () => import('./screens/why.js'),
  tree: () => import('./screens/tree.js'),
  cells: () => import('./screens/cells.js'),
  alarms: () => import('./screens/alarms.js'),
  shift: () => import('./screens/shift.js'),
  jobs: () => import('./screens/jobs.js'),
  job: () => import('./screens/job.js'),
  item: () => import('./screens/item.js'),
  login: () => import('./screens/login.js'),
};

const IN_NAVIGATION = [
  'overview',
  'queue',
  'order',
  'manual',
  'why',
  'alarms',
  'tree',
  'jobs',
  'cells',
];

/** Those with a place in the navigation. */
export const NAVIGATION = IN_NAVIGATION.filter((name) => name in SCREENS).map((name) => ({
  name,
  href: `#/${name}`,
}));

/** Which place of the navigation a screen belongs to. */
const BELONGS = {
  section: 'overview',
  component: 'overview',
  shift: 'overview',
  job: 'jobs',
  item: 'jobs',
};

/**
 * @typedef {Object} Route
 * @property {string} name of the screen
 * @property {string} id the rest of the path, decoded: item ids contain slashes
 * @property {URLSearchParams} query what stands behind a question mark
 * @property {string} place in the navigation
 */

/**
 * Read the address.
 * @param {string} hash for instance #/item/WO-1/3
 * @returns {Route}
 */
export function routeOf(hash) {
  const [path, query = ''] = hash.replace(/^#\/?/, '').split('?');
  const [first, ...rest] = path.split('/');
  const name = first in SCREENS ? first : 'overview';
  return {
    name,
    id: rest.map(decodeURIComponent).join('/'),
    query: new URLSearchParams(query),
    place: BELONGS[name] ?? name,
  };
}
