/** Requests to the page: JSON there and back. */

import { said as inLanguage } from './text.js';

/** An answer that is not 200: its status and the page's sentence. Status 0: no answer came. */
export class Refused extends Error {
  constructor(status, body) {
    super(wordsOf(body) ?? body?.detail ?? '');
    this.status = status;
    this.findings = body?.findings ?? [];
    /** Nothing was sent to the cell, so nothing has to be looked for. */
    this.isUnsent = body?.is_unknown === false;
    this.isLocked = body?.why === 'locked';
  }
}

/** The sentence of an answer, in the language of the viewer where it has that. */
function wordsOf(body) {
  return (body?.said && inLanguage(body.said)) ?? body?.message;
}

const READ_MS = 20000;
const COMMAND_MS = 15000;
const LOOK_MS = 1000;
/** Until then the command may still be on its way to the journal. */
const GIVE_UP_MS = 30000;

/** Get something. */
export function get(path) {
  return request(path, { method: 'GET' }, READ_MS);
}

/** Post something; a signal takes back that somebody waits for the answer. */
export function post(path, body, within = COMMAND_MS, signal = null) {
  const headers = { 'Content-Type': 'application/json' };
  return request(path, { method: 'POST', headers, body: JSON.stringify(body) }, within, signal);
}

async function request(path, options, within, given = null) {
  const late = AbortSignal.timeout(within);
  const signal = given ? AbortSignal.any([late, given]) : late;
  let answer;
  try {
    answer = await fetch(path, { ...options, cache: 'no-store', signal });
  } catch {
    throw new Refused(0, null);
  }
  const body = await answer.json().catch(() => null);
  if (!answer.ok) throw new Refused(answer.status, body);
  return body;
}

/** A new ticket: the journal knows the command by it, also where the answer is lost. */
export function newTicket() {
  const bytes = crypto.getRandomValues(new Uint8Array(8));
  return [...bytes].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}

/**
 * @typedef {Object} Outcome
 * @property {'accepted'|'refused'|'login'|'unsent'|'unknown'|'absent'} kind 'absent': the journal does not have it
 * @property {string} message
 * @property {string[]} findings
 * @property {boolean} [isFromJournal] the answer was lost, and the journal said it
 */

/**
 * Send a command. A lost answer is no end: the journal is asked what became of the command.
 * @param {{path: string, body: Object}} offer
 * @param {Object} values parameters, reason
 * @param {string} ticket the same one again sends nothing twice
 * @param {function(Outcome): void} meanwhile is told 'unknown' once
 * @returns {Promise<Outcome>}
 */
export async function send(offer, values, ticket, meanwhile = () => {}) {
  try {
    const answer = await post(offer.path, { ...offer.body, ...values, ticket });
    // A note says, for instance, that the node does not count the role of this page's user.
    const message = [wordsOf(answer), answer.note].filter(Boolean).join(' — ');
    return { kind: 'accepted', message, findings: answer.findings ?? [] };
  } catch (refused) {
    if (!(refused instanceof Refused)) throw refused;
    if (refused.status === 401 || refused.isLocked) return said('login', refused);
    if (refused.isUnsent) return said('unsent', refused);
    if (refused.status === 0 || refused.status >= 500) {
      meanwhile(said('unknown', refused));
      return outcomeOf(ticket, refused);
    }
    return said('refused', refused);
  }
}

function said(kind, { message, findings }) {
  return { kind, message, findings };
}

/** Ask the journal until it says what became of a command, or until it surely has not taken it. */
async function outcomeOf(ticket, refused) {
  const until = performance.now() + GIVE_UP_MS;
  for (;;) {
    const found = await get(`/api/tickets/${ticket}`).catch(() => null);
    if (found?.found) {
      const kind = found.accepted ? 'accepted' : 'refused';
      return { kind, message: wordsOf(found) ?? '', findings: [], isFromJournal: true };
    }
    const hasLooked = found !== null && !found.node_silent;
    if (hasLooked && performance.now() >= until)
      return { ...said('absent', refused), isFromJournal: true };
    await new Promise((resolve) => setTimeout(resolve, LOOK_MS));
  }
}
