"""A typed order says the same as its texts."""

from __future__ import annotations

import pytest

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model.jobs.order import RecipeChoice, Terms, WorkOrder
from bt_orchestrator.script.orders.asked import asked_of, change_of
from bt_orchestrator.script.orders.desk import AskedOrder
from bt_orchestrator.script.orders.terms import AskedTerms


def test_an_order() -> None:
    assert asked_of(WorkOrder('boxes')) == AskedOrder('boxes', terms=AskedTerms())
    params = {'lot': 'A7', 'force': 3.5, 'dry': True, 'note': '1.5'}
    order = WorkOrder('boxes', 'WO-1', 4, params, Terms(2, 10.0, 20.5, {'lot': 7}))
    texts = {'lot': 'A7', 'force': '3.5', 'dry': 'true', 'note': '1.5'}
    terms = AskedTerms(2, 10.0, 20.5, '{"lot": 7}')
    assert asked_of(order) == AskedOrder('boxes', 'WO-1', 4, texts, terms)
    recipe = RecipeChoice(('WM-100',), 2)
    assert asked_of(WorkOrder(recipe=recipe)).recipe == recipe


def test_a_change_leaves_what_it_does_not_name() -> None:
    assert change_of({'job': 'J'}) == AskedOrder('')
    given = {'quantity': 3, 'start': '2026-05-18T06:00:00Z', 'due': 'none', 'details': {}}
    assert change_of(given) == AskedOrder('', '', 3, {}, AskedTerms(None, 1779084000.0, 0.0, '{}'))
    bind = {'insert': 'component_3a'}
    assert change_of({'job': 'J', 'bind': bind}).recipe == RecipeChoice((), None, bind)
    with pytest.raises(CommandRefused, match=r'`start` must be a date and time.*not `soon`; '):
        change_of({'start': 'soon'})
