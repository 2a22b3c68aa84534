/** Who sits here: name, role, what they may do, and whether the session is locked. */

import { get, post } from './api.js';
import { part } from './store.js';

/** @type {Object<string, *>} */
const NOBODY = { name: '', role: '', how: '', is_locked: false, may: {}, languages: [] };
/** So often at most. */
const AWAKE_MS = 30000;
const listeners = new Set();
let me = NOBODY;

/** The person of this browser's session; without one, name and role are empty. */
export function who() {
  return me;
}

/** Tell whether the person may send a request, by its name. */
export function may(request) {
  return Boolean(me.may?.[request]);
}

/**
 * Tell why the person may not send an offered request now; empty: they may.
 * @param {Object} offer
 * @returns {'' | 'role' | 'local'}
 */
export function whyNot(offer) {
  if (!may(offer.name)) return 'role';
  const isElsewhere = offer.moves && part('cell')?.control === 'local' && !me.is_panel;
  return isElsewhere ? 'local' : '';
}

/** Call a function whenever the person changes, or the lock. */
export function onPerson(callback) {
  listeners.add(callback);
  return () => listeners.delete(callback);
}

/** Ask the page who sits here. */
export async function refreshPerson() {
  become(await get('/api/me'));
  return me;
}

/** Log in; throws the page's answer where it is refused. */
export async function login(name, password) {
  become(await post('/api/login', { name, password }));
}

/** End the session. */
export async function logout() {
  await post('/api/logout', {});
  become({ ...NOBODY, languages: me.languages });
  await refreshPerson().catch(() => null);
}

/** Lock the session: looking goes on, and the emergency commands. */
export async function lock() {
  await post('/api/lock', {});
  await refreshPerson();
}

/** Unlock it with the password. */
export async function unlock(password) {
  await post('/api/unlock', { password });
  await refreshPerson();
}

/** Tell the page while somebody is there, so that the session is not locked meanwhile. */
export function stayAwake() {
  let told = -AWAKE_MS;
  const tell = () => {
    const isSession = me.role && !me.is_locked && me.how === 'page login';
    if (!isSession || performance.now() - told < AWAKE_MS) return;
    told = performance.now();
    post('/api/active', {}).catch(() => null);
  };
  for (const sign of ['pointerdown', 'keydown'])
    addEventListener(sign, tell, { capture: true, passive: true });
}

function become(person) {
  const isSame = sign(person) === sign(me);
  me = person;
  if (!isSame) for (const callback of [...listeners]) callback();
}

/**
 * What matters of a person here: the time that is left of the session changes with every look.
 * @param {Object<string, *>} person
 */
function sign({
  name,
  role,
  how,
  is_locked: isLocked,
  is_panel: isPanel,
  looks_freely: looksFreely,
}) {
  return JSON.stringify([name, role, how, isLocked, isPanel, looksFreely]);
}
