/** Requests in words. The page sends them in English; the words of other languages stand here. */

import { quoted, sentence, t, tOr } from './text.js';

/** The word on a button. */
export function wordOf(offer) {
  return tOr(`word.${offer.name}`, offer.word.replaceAll('_', ' '));
}

/** The title of a dialog about a request. */
export function titleOf(offer, about) {
  return about ? `${wordOf(offer)}: ${about}` : wordOf(offer);
}

/** What a request does, as a sentence. */
export function effectOf(offer) {
  return sentence(tOr(`effect.${offer.name}`, offer.effect));
}

/** What a parameter means. */
export function meaningOf(offer, parameter) {
  return sentence(tOr(`parameter.${offer.name}.${parameter.name}`, parameter.meaning));
}

/** Verbs of the command line, and answers, where the node names them in a sentence. */
const VERB =
  /\b(?:bt-orchestrator (?:(?:cell|component) )?([a-z-]+)(?: [^;,.()]*)?|(remove-item) \S+|(mark_done|abort_job)\b|(?<=\b(?:with|say) )([a-z_]+)\b(?! \d))/g;
const KINDS = ['cell', 'item', 'component', 'script', 'hold'];

/** A message of the node, with the words of the buttons here in place of verbs of the command line. */
export function withButtons(message) {
  return message.replace(VERB, (said, verb, item, answer, plain) => {
    const name = (verb ?? item ?? answer ?? plain).replaceAll('-', '_');
    const kind = KINDS.find((one) => tOr(`word.${one}.${name}`, ''));
    return kind ? quoted(t(`word.${kind}.${name}`)) : said;
  });
}

/** Roles in words. */
export function rolesOf(roles) {
  return roles.map((role) => t(`role.${role}`)).join(', ');
}

/** Abort, pause and stop: one press, also on old news, and the reason afterwards. */
export function isEmergency(offer) {
  return offer.why === 'afterwards';
}
