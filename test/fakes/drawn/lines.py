"""Lines nobody wrote by hand: a cell, scripts, orders, faults, operators, durations.

Everything is built so that it is a valid line (nothing is drawn and thrown away): the only thing
that `check` may refuse is a deadlock.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence

from fakes.drawn.cells import SECONDS, draw_cell, lasting
from fakes.drawn.links import add_setup
from fakes.drawn.plan import (
    MOST_SECTIONS,
    Draw,
    Moment,
    Order,
    Plan,
    Row,
    Traits,
    chance,
    tasks_of,
)
from fakes.drawn.scripts import DrawnScript
from hypothesis import strategies as st

ANY = Traits()
MOMENTS = (0.13, 3.71, 17.93, 61.57)
OF_SETUPS = (0, 1, 2, 3, 4, 5, 9, 10, 11, 11, 11, 12, 13, 13, 14, 14, 16, 19, 28, 28, 28, 28, 28)
"""Choices of an operator after which setups are others or not known, and of one who answers and
starts."""
PRIORITIES = (0, 0, 3, 5, -1)
STARTS = st.sampled_from((None, None, 0.0371, 9.0373, 45.0379))
"""At no moment at which anything else happens: what comes first then is open."""


@st.composite
def lines(draw: Draw, traits: Traits = ANY) -> Plan:
    """Draw a line."""
    size = min(draw(st.integers(1, traits.most_sections)), draw(st.integers(2, MOST_SECTIONS)))
    cell = draw_cell(draw, size, traits)
    scripts = [DrawnScript(draw, 'script_0', size, cell, traits).whole()]
    if traits.short:
        add_setup(draw, scripts[0])
    if draw(st.booleans()):
        scripts.append(DrawnScript(draw, 'script_1', size, cell, traits).whole())
    if draw(st.integers(0, 3)) == 0:
        scripts.append(_variant(draw, scripts[0]))
    orders = _short_orders(draw) if traits.short else _orders(draw, scripts)
    first = len(orders) if draw(st.booleans()) else 1
    choices = st.sampled_from(OF_SETUPS) if traits.setups else st.integers(0, 27)
    moment = st.builds(Moment, st.sampled_from(MOMENTS), choices)
    moments = draw(st.lists(moment, min_size=8 * traits.setups, max_size=10 + 6 * traits.setups))
    drawn = draw(st.lists(st.sampled_from((*SECONDS, 40.0)), max_size=5)) if traits.tied else []
    rebuilds = draw(st.frozensets(st.integers(1, 80), max_size=6))
    return Plan(
        cell=cell,
        scripts=tuple(scripts),
        orders=orders[:first],
        later=orders[first:],
        moments=tuple(moments),
        seconds=tuple(lasting(cell, drawn)),
        rebuilds=rebuilds,
    )


def _orders(draw: Draw, scripts: Sequence[Row]) -> tuple[Order, ...]:
    count = draw(st.integers(1, 4))
    chosen = [scripts[draw(st.integers(0, len(scripts) - 1))]['script'] for _ in range(count)]
    return tuple(_order(draw, f'J{n}', name) for n, name in enumerate(chosen))


def _order(draw: Draw, name: str, script: str) -> Order:
    quantity, by_recipe = draw(st.integers(1, 4)), chance(draw, 60)
    if not chance(draw, 70):
        return Order(name, script, quantity, by_recipe=by_recipe)
    priority = draw(st.sampled_from(PRIORITIES))
    return Order(name, script, quantity, priority, draw(STARTS), by_recipe)


def _short_orders(draw: Draw) -> tuple[Order, ...]:
    """Draw several orders of one item, so that sections prepare for one after the other."""
    setups = draw(st.sampled_from(((0.0, 1.0, 0.0), (1.0, 1.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0))))
    return tuple(Order(f'J{n}', 'script_0', 1, setup=setup) for n, setup in enumerate(setups))


def _variant(draw: Draw, script: Row) -> Row:
    """Return a script of another name that shares the flags of one, and moves at other times."""
    variant = copy.deepcopy(script)
    variant['script'] = 'script_2'
    for listed in variant['sections'].values():
        if isinstance(listed, dict) and draw(st.booleans()):
            listed['release_conveyor'] = 'end_of_cycle'
        for task in tasks_of(listed['tasks'] if isinstance(listed, dict) else listed):
            if task.get('qty_change', 0) == 0 and chance(draw, 30):
                task.pop('when', None)
                task['retries'] = 1
    return variant
