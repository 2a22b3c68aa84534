/** Manual mode: an engineer at a panel chooses a component and runs one task of it. */

import { newTicket, send } from '../core/api.js';
import { attribute, children, h, show, text } from '../core/dom.js';
import { mountLive } from '../core/live.js';
import { onPerson, who, whyNot } from '../core/me.js';
import { rolesOf } from '../core/requests.js';
import { shape } from '../core/shape.js';
import { news, part, partsOf } from '../core/store.js';
import { t } from '../core/text.js';
import { stayAtPanel } from '../asking/at_panel.js';
import { fieldWith } from '../asking/entry.js';
import { askToLogIn } from '../asking/login.js';
import { outcomeWords } from '../asking/outcome.js';
import { keepReason, reasonField } from '../asking/reason.js';
import { goalView } from '../parts/manual_goal.js';
import { offers } from '../parts/offers.js';

/** Requests that lead here, and away again. */
const ABOUT_MODE = /^cell\.(local|manual|production)$/;

/** Show it in a root; `?component=NAME` chooses one. */
export function mount(root, route) {
  return mountLive(root, new Manual(route.query.get('component') ?? ''));
}

class Manual {
  constructor(component) {
    this.mode = h('p', { class: 'manual-mode' });
    this.offers = offers({ label: t('manual.mode') });
    this.form = new TaskForm(component);
    this.goal = goalView();
    this.body = h(
      'div',
      { class: 'now-sides' },
      h('section', { class: 'panel' }, h('h2', {}, t('manual.task')), this.form.element),
      h('section', { class: 'panel' }, h('h2', {}, t('manual.last')), this.goal.element),
    );
    this.element = h(
      'div',
      { class: 'screen manual' },
      h('div', { class: 'screen-head' }, h('h1', {}, t('nav.manual'))),
      this.mode,
      this.offers.element,
      this.body,
    );
    this.endPerson = onPerson(() => this.update());
  }

  end() {
    this.endPerson();
    this.offers.end();
    this.goal.end();
  }

  update() {
    const cell = part('cell');
    const isManual = cell?.unit_mode === 'manual';
    text(this.mode, t(isManual ? 'manual.is_manual' : 'manual.is_not'));
    this.offers.update((cell?.offers ?? []).filter((offer) => ABOUT_MODE.test(offer.name)));
    show(this.body, isManual);
    this.form.update(cell);
    this.goal.update(cell);
  }
}

/** Which component does what, with which arguments, and why. */
class TaskForm {
  constructor(component) {
    this.wanted = component;
    this.component = fieldWith(
      t('manual.component'),
      h('select', { name: 'component', onchange: () => this.#choose() }),
      t('manual.component_hint'),
    );
    this.room = h('div', { class: 'form' });
    this.hold = h('select', { name: 'hold' });
    this.holdField = fieldWith(t('manual.hold'), this.hold, t('manual.hold_hint'));
    this.reason = reasonField('component.run_task', true);
    this.lock = shape('lock');
    this.go = h(
      'button',
      { type: 'submit', class: 'primary', 'data-do': 'run' },
      this.lock,
      ` ${t('manual.start')}`,
    );
    this.said = h('p', { class: 'order-said', role: 'status' });
    this.whose = h('p', { class: 'hint' });
    this.element = h(
      'form',
      { novalidate: true, onsubmit: (event) => this.#send(event) },
      this.component.element,
      this.room,
      this.holdField.element,
      this.reason.element,
      h('div', { class: 'order-buttons' }, this.said, this.whose, this.go),
    );
    this.fields = [];
    this.isSending = false;
  }

  update(cell) {
    this.offer = cell?.manual_offers?.run ?? null;
    const described = part('line')?.components ?? [];
    const names = described.map((one) => one.name).join(' ');
    if (names !== this.names) {
      this.names = names;
      children(
        this.component.input,
        described.map(({ name }) =>
          h('option', { value: name, selected: name === this.wanted }, name),
        ),
      );
      this.#choose();
    }
    this.#showHolds();
    this.#judge(cell);
  }

  get chosen() {
    return this.component.input.value;
  }

  /** Ask for the task of a component, and the fields of its goal. */
  #choose() {
    const described = part('line')?.components.find((one) => one.name === this.chosen);
    const tasks = described?.tasks ?? [];
    const choice = tasks.length
      ? h(
          'select',
          { name: 'task' },
          tasks.map((name) => h('option', { value: name }, name)),
        )
      : h('input', { name: 'task', type: 'text', autocomplete: 'off', spellcheck: 'false' });
    this.task = fieldWith(t('manual.task'), choice);
    this.fields = Object.entries(described?.goal_fields ?? {}).map(([name, type]) => ({
      name,
      type,
      ...fieldWith(name, inputOf(name, type), type),
    }));
    children(
      this.room,
      this.task.element,
      this.fields.map((field) => field.element),
    );
    this.#showHolds();
  }

  /** Offer the holds of tasks at this component: one of them may keep it. */
  #showHolds() {
    const holds = partsOf('hold/')
      .map(([, hold]) => hold)
      .filter((hold) => hold.task && hold.task !== 'manual');
    const told = holds.map(({ id, words }) => `${id} ${words}`).join('\n');
    show(this.holdField.element, holds.length);
    if (told === this.toldHolds) return;
    this.toldHolds = told;
    children(
      this.hold,
      h('option', { value: '' }, t('manual.no_hold')),
      holds.map(({ id, words }) => h('option', { value: id }, `${id}: ${words}`)),
    );
  }

  /** The button waits for fresh news, and for the end of the task before. */
  #judge(cell) {
    const isBusy = Boolean(cell?.manual) && cell.manual.ended === null;
    this.go.disabled = this.isSending || isBusy || !this.offer || news().kind !== 'fresh';
    const why = this.offer && who().name ? whyNot(this.offer) : '';
    attribute(this.go, 'data-locked', why !== '');
    this.lock.style.display = why ? '' : 'none';
    const words = {
      '': '',
      role: () => t('ask.not_your_role', { roles: rolesOf(this.offer.roles) }),
      local: () => t('manual.at_panel'),
    };
    text(this.whose, why ? words[why]() : '');
  }

  async #send(event) {
    event.preventDefault();
    if (this.go.disabled || !this.reason.isGiven()) return;
    if ((!who().role || who().is_locked) && !(await askToLogIn())) return;
    const before = part('cell').manual?.started ?? 0;
    const args = this.#args();
    this.isSending = true;
    this.#say('computing', t('ask.sending'));
    const given = {
      component: this.chosen,
      task: this.task.value(),
      ...(Object.keys(args).length ? { args } : {}),
      ...(this.hold.value ? { hold: this.hold.value } : {}),
      reason: this.reason.value(),
    };
    const outcome = await send(this.offer, given, newTicket());
    this.isSending = false;
    const isAccepted = outcome.kind === 'accepted';
    if (isAccepted) {
      keepReason('component.run_task', given.reason);
      stayAtPanel(before);
    }
    this.#say(isAccepted ? 'fine' : 'wrong', outcomeWords(outcome));
    this.update(part('cell'));
  }

  #say(kind, words) {
    attribute(this.said, 'data-check', kind);
    text(this.said, words);
  }

  #args() {
    const filled = this.fields.filter((field) => field.value() !== '');
    return Object.fromEntries(filled.map((field) => [field.name, read(field.value(), field.type)]));
  }
}

function inputOf(name, type) {
  if (type === 'boolean')
    return h(
      'select',
      { name: `args.${name}` },
      ['', 'true', 'false'].map((one) => h('option', { value: one }, one)),
    );
  const isNumber = /^u?int|^float|^double/.test(type) && !type.includes('[');
  return h('input', {
    type: 'text',
    name: `args.${name}`,
    inputmode: isNumber ? 'decimal' : 'text',
    autocomplete: 'off',
    spellcheck: 'false',
  });
}

/** A text stays text; numbers, lists and messages are JSON. What is none, the node refuses in words. */
function read(said, type) {
  if (/^w?string(<=\d+)?$/.test(type)) return said;
  try {
    return JSON.parse(said);
  } catch {
    return said;
  }
}
