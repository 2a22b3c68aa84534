/** A new order: a script or a recipe, its parameters and terms; checked while it is written, then queued. */

import { Refused, get } from '../core/api.js';
import { ask } from '../asking/ask.js';
import { attribute, h, show, text } from '../core/dom.js';
import { may, onPerson, who } from '../core/me.js';
import { rolesOf } from '../core/requests.js';
import { shape } from '../core/shape.js';
import { part, subscribe } from '../core/store.js';
import { t } from '../core/text.js';
import { checking } from './order/checking.js';
import { orderForm } from './order/form.js';

/** Show the screen. */
export function mount(root) {
  const said = h('p', { class: 'order-said', role: 'status' });
  const done = h('p', { class: 'order-done', role: 'status', hidden: true });
  const form = orderForm(changed, () => check.later());
  const lock = shape('lock');
  const go = h(
    'button',
    { type: 'submit', class: 'primary', 'data-do': 'order' },
    lock,
    ` ${t('order.go')}`,
  );
  const whose = h('p', { class: 'hint' });
  const whole = h(
    'form',
    { class: 'order-form', novalidate: true, onsubmit: send },
    form.element,
    h('div', { class: 'order-buttons' }, said, whose, go),
  );
  const check = checking(form, said);
  let isChecked = false;
  root.append(h('section', { class: 'panel order' }, h('h1', {}, t('order.title')), done, whole));

  function changed() {
    show(done, false);
    check.later();
  }

  async function send(event) {
    event.preventDefault();
    if (isChecked) return null;
    // A button that is disabled meanwhile would lose the focus.
    isChecked = true;
    const isFine = await check.now();
    isChecked = false;
    if (!isFine) return form.focusMistake();
    const { order, position, held } = form.value();
    const offer = part('cell')?.add;
    if (!offer) return text(said, t('order.no_cell'));
    const values = {
      orders: [order],
      ...(position ? { position } : {}),
      ...(held ? { held } : {}),
    };
    // Everything was said in the form: the dialog asks for nothing but the reason.
    if (!(await ask({ ...offer, parameters: [] }, { about: order.order, values }))) return null;
    done.replaceChildren(
      t('order.done', { job: order.order }),
      ' ',
      h('a', { href: `#/queue?job=${encodeURIComponent(order.order)}` }, t('order.to_queue')),
    );
    show(done, true);
    return form.another();
  }

  /** Who may not give orders sees it before the form is filled in. */
  function judge() {
    const offer = part('cell')?.add;
    const isMine = !offer || !who().name || may(offer.name);
    attribute(go, 'data-locked', !isMine);
    lock.style.display = isMine ? 'none' : '';
    text(whose, isMine ? '' : t('ask.not_your_role', { roles: rolesOf(offer.roles) }));
  }

  function update() {
    form.setQueued(part('cell')?.queued ?? 0);
    judge();
  }

  load(form, said);
  const ends = [subscribe('cell', update), onPerson(judge)];
  update();
  return () => {
    check.end();
    ends.forEach((end) => end());
  };
}

async function load(form, said) {
  try {
    form.setSources(...(await Promise.all([get('/api/scripts'), get('/api/recipes')])));
  } catch (refused) {
    if (!(refused instanceof Refused)) throw refused;
    text(said, refused.message || t('order.no_scripts'));
  }
}
