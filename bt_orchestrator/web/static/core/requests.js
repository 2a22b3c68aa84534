/** Requests in words. The page sends them in English; the words of other languages stand here. */

import { t, tOr } from './text.js';

/** The word on a button. */
export function wordOf(offer) {
  return tOr(`word.${offer.name}`, offer.word.replaceAll('_', ' '));
}

/** What a request does. */
export function effectOf(offer) {
  return tOr(`effect.${offer.name}`, offer.effect);
}

/** What a parameter means. */
export function meaningOf(offer, parameter) {
  return tOr(`parameter.${offer.name}.${parameter.name}`, parameter.meaning);
}

/** Roles in words. */
export function rolesOf(roles) {
  return roles.map((role) => t(`role.${role}`)).join(', ');
}

/** Abort, pause and stop: one press, also on old news, and the reason afterwards. */
export function isEmergency(offer) {
  return offer.why === 'afterwards';
}
