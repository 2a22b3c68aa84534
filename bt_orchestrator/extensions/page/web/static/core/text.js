/** Every word that is shown, in the language of the viewer; times in the viewer's zone. */

export const LANGUAGES = { en: 'English', de: 'Deutsch' };
const LOCALES = { en: 'en-GB', de: 'de-DE' };
const REMEMBERED = 'bt_orchestrator.language';

let language = 'en';
let strings = {};

/** The language in use. */
export function currentLanguage() {
  return language;
}

/** The language that was chosen here, or else the first of the browser's that there is. */
export function preferredLanguage() {
  const chosen = localStorage.getItem(REMEMBERED);
  const wanted = [chosen, ...navigator.languages.map((one) => one.slice(0, 2))];
  return wanted.find((one) => one in LANGUAGES) ?? 'en';
}

/** Use a language from now on, and remember it if somebody chose it. */
export async function useLanguage(wanted, isChosen = false) {
  const answer = await fetch(`/static/strings/${wanted}.json`);
  if (!answer.ok) throw new Error(`the words of ${wanted} did not come: ${answer.status}`);
  strings = await answer.json();
  language = wanted;
  document.documentElement.lang = wanted;
  if (isChosen) localStorage.setItem(REMEMBERED, wanted);
}

/** Tell whether there are words for a key. */
export function has(key) {
  return typeof found(key) === 'string';
}

/**
 * Return the words for a key, for instance 'overview.holds'.
 * @param {string} key group and name
 * @param {Object<string, *>} values for the places in braces; `count` chooses one or other
 */
export function t(key, values = {}) {
  let words = found(key);
  if (words && typeof words === 'object') {
    words = words[new Intl.PluralRules(LOCALES[language]).select(values.count)] ?? words.other;
  }
  if (typeof words !== 'string') return key;
  return words.replace(/\{(\w+)\}/g, (place, name) => values[name] ?? place);
}

/** Return the words for a key, or other words where there are none: names that customers give. */
export function tOr(key, otherwise, values = {}) {
  return has(key) ? t(key, values) : otherwise;
}

function found(key) {
  const at = key.indexOf('.');
  return strings[key.slice(0, at)]?.[key.slice(at + 1)];
}

/** Words that the node has in each language. */
export function said(words) {
  return words[language];
}

/**
 * Words that begin with a person. The node says in English that a name is only claimed.
 * @param {string} key of the words for such a name
 */
export function person(words, key = 'login.claims') {
  return words.replace(/^somebody who claims to be ([^:]+)/, (_, name) => t(key, { name }));
}

/** Words in quotation marks. */
export function quoted(words) {
  return t('unit.quoted', { words });
}

/** Words as a sentence begins. */
export function sentence(words) {
  const isName = /^[^\s;,:]*[\d_/]/.test(words); // of a component, a job or an item
  return isName ? words : words.charAt(0).toLocaleUpperCase(LOCALES[language]) + words.slice(1);
}

/** Say several words as one list: Pause, Stop and Abort. */
export function list(words) {
  return new Intl.ListFormat(LOCALES[language]).format(words);
}

/** Say a number. */
export function number(value) {
  return value.toLocaleString(LOCALES[language]);
}

/** Say a part of a whole in whole percent, as more or less. */
export function percent(part) {
  return Math.round(part * 100).toLocaleString(LOCALES[language], { signDisplay: 'always' });
}

/** Say a part of a whole; a dash: not known. */
export function ratio(part) {
  if (part === null || part === undefined) return '–';
  const digits = { minimumFractionDigits: 1, maximumFractionDigits: 1 };
  return t('unit.percent', { value: (part * 100).toLocaleString(LOCALES[language], digits) });
}

/** Say when: the time alone if it is today. */
export function at(epoch) {
  if (epoch === null || epoch === undefined) return '';
  const moment = new Date(epoch * 1000);
  /** @type {Intl.DateTimeFormatOptions} */
  const time = { hour: '2-digit', minute: '2-digit', second: '2-digit' };
  const isToday = moment.toDateString() === new Date().toDateString();
  /** @type {Intl.DateTimeFormatOptions} */
  const day = isToday ? {} : { day: '2-digit', month: '2-digit', year: 'numeric' };
  return moment.toLocaleString(LOCALES[language], { ...day, ...time });
}

/** Say when to the minute: what is expected is not known to the second. */
export function about(epoch) {
  if (epoch === null || epoch === undefined) return '';
  const moment = new Date(epoch * 1000);
  const isToday = moment.toDateString() === new Date().toDateString();
  /** @type {Intl.DateTimeFormatOptions} */
  const day = isToday ? {} : { weekday: 'short', day: '2-digit', month: '2-digit' };
  return moment.toLocaleString(LOCALES[language], { ...day, hour: '2-digit', minute: '2-digit' });
}

/** Say when, with the zone. */
export function atInZone(epoch) {
  return `${at(epoch)} ${zone(epoch)}`;
}

/** The viewer's zone for programs, for instance Europe/Berlin; in a path. */
export function readersZone() {
  return encodeURIComponent(new Intl.DateTimeFormat().resolvedOptions().timeZone);
}

/** The viewer's zone by name at a moment, for instance CET or UTC. */
export function zone(epoch = Date.now() / 1000) {
  const format = new Intl.DateTimeFormat(LOCALES[language], { timeZoneName: 'short' });
  const parts = format.formatToParts(new Date(epoch * 1000));
  return parts.find((part) => part.type === 'timeZoneName').value;
}

/** Say how long: two units at most. */
export function duration(seconds) {
  if (seconds === null || seconds === undefined) return '';
  const whole = Math.max(0, Math.round(seconds));
  if (whole < 60) return t('time.s', { s: whole });
  const two = (value) => String(value).padStart(2, '0');
  if (whole < 3600) return t('time.min', { min: Math.floor(whole / 60), s: two(whole % 60) });
  const minutes = Math.floor(whole / 60);
  if (minutes < 1440) return t('time.h', { h: Math.floor(minutes / 60), min: two(minutes % 60) });
  return t('time.d', { d: Math.floor(minutes / 1440), h: Math.floor((minutes % 1440) / 60) });
}

/** Say how much longer something took; less has a minus, and what is no whole second has no sign. */
export function difference(seconds) {
  return `${seconds <= -0.5 ? '−' : ''}${duration(Math.abs(seconds))}`;
}

/** Say how long something takes so far, as a stopwatch does: narrow, and to the second. */
export function stopwatch(value) {
  const whole = Math.max(0, Math.floor(value));
  const two = (part) => String(part).padStart(2, '0');
  if (whole < 60) return String(whole);
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${minutes}:${two(whole % 60)}`;
  return `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(whole % 60)}`;
}

/** Say how long a task took or takes: tenths where they matter. */
export function seconds(value) {
  if (value === null || value === undefined) return '';
  if (value >= 60) return duration(value);
  const digits = value < 10 ? 1 : 0;
  const said = value.toLocaleString(LOCALES[language], {
    minimumFractionDigits: digits,
    maximumFractionDigits: digits,
  });
  return t('time.s', { s: said });
}
