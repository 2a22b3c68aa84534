"""Why there is no script: the reasons that no file shows alone (others: test/data/mistakes)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from random import Random

import pytest
from fakes.planned import ENDS, cell_of, made_of, recipe_of

from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.extensions.recipes.planning.outcome import Impossible
from bt_orchestrator.extensions.recipes.planning.reach import Demand, irreducible
from bt_orchestrator.model.recipe import Overrides
from bt_orchestrator.model.script import Script

LINE = {
    **ENDS,
    'drill_a': 'section: 2, capabilities: {drill: {task: TASK_A}}',
    'press_a': 'section: 3, capabilities: {press: {task: TASK_B}}',
    'gauge_a': 'section: 2, capabilities: {measure: {task: TASK_A, holds: {depth: 1}}}',
    'fitter': 'section: 3, capabilities: {insert: {task: TASK_A, needs: {depth: none}}}',
}
BORE, FIT = '- {id: bore, do: drill}', '- {id: fit, do: press}'


def steps(*lines: str) -> str:
    """Return operations between placing an item and taking it out."""
    return '\n'.join(('- {id: place, do: put}', *lines, '- {id: box, do: pack}'))


def measured(number: int) -> str:
    """Return so many pairs of operations; a device keeps what the first of each gives."""
    pairs = (
        f'- {{id: m{n}, do: measure, after: [place]}}\n'
        f'- {{id: i{n}, do: insert, needs: {{depth: m{n}}}}}'
        for n in range(number)
    )
    return steps(*pairs)


def moved(component: str, section: int) -> dict[str, str]:
    """Return the line with a component in another section."""
    _, _, keys = LINE[component].partition(', ')
    return {**LINE, component: f'section: {section}, {keys}'}


def rejected(operation: str) -> str:
    return f'- {{id: {operation}, do: pack, runs_for: rejected, after: [bore]}}'


ROOM = ': one keeps it for one operation, for so many sections as it has room, and not in a repeat'
NOT_KEPT = (
    'no device can keep `depth` of `m0` for `i0`, and `depth` of `m1` for `i1`, and `depth` of '
    f'`m2` for `i2`{ROOM}'
)
TWO_KEPT = f'no device can keep `depth` of `m0` for `i0`, and `depth` of `m1` for `i1`{ROOM}'
TWO_OF_THREE = TWO_KEPT.replace('1', '2').replace('0', '1')

DOWN = 'items move down the belt only, and these demands contradict each other: '
BACKWARDS = (
    f'{DOWN}`bore` comes after `fit`; `fit` only at press_a in section 3; `bore` only at drill_a '
    'in section 2'
)
TOO_EARLY = (
    f'{DOWN}`place` places the item before `bore`; `place` only at feeder in section 3; `bore` '
    'only at drill_a in section 2'
)
TOO_LATE = (
    f'{DOWN}`box` takes the item out after `fit`; `fit` only at press_a in section 3; `box` only '
    'at packer in section 2'
)
TOO_FAR = (
    f'{DOWN}`i0` at most 1 section behind `m0`, whose device holds 1 `depth`: bind nearer, or it '
    'has to hold more; `m0` only at gauge_a in section 2; `i0` only at fitter in section 4'
)
CONTRADICTION = (
    'items move down the belt only, and these demands contradict each other: `dry` comes after '
    '`fit`; `bore` comes after `dry`; `fit` only at press_a in section 3; `bore` only at drill_a '
    'in section 2'
)
OUT_TWICE = 'an item that `bore` rejects is taken out twice, by `out`, `bin`'
LEAVES = {
    **moved('packer', 2),
    'press_a': 'section: 3, capabilities: {press: {task: TASK_B, requires_conveyor: false}}',
}
EARLY_BOX = steps(FIT).replace('do: pack', 'do: pack, after: [place]')
REJECTS = BORE.replace('}', ', on_failure: reject}')


@pytest.mark.parametrize(
    ('line', 'operations', 'reason'),
    [
        (LINE, steps(FIT, BORE), BACKWARDS),
        (moved('feeder', 3), steps(BORE.replace('}', ', after: []}')), TOO_EARLY),
        (LEAVES, EARLY_BOX, TOO_LATE),
        (moved('fitter', 4), measured(1), TOO_FAR),
        (LINE, measured(2), TWO_KEPT),
        ({**LINE, 'gauge_b': LINE['gauge_a']}, measured(3), NOT_KEPT),
        (LINE, measured(3), TWO_OF_THREE),
        (LINE, steps(REJECTS, rejected('out'), rejected('bin')), OUT_TWICE),
    ],
)
def test_8_5_it_is_proven_that_there_is_none(
    line: Mapping[str, str], operations: str, reason: str
) -> None:
    with pytest.raises(Impossible) as why:
        made_of(line, operations)
    assert why.value.reasons == (reason,)


def test_8_5_demands_that_contradict_each_other_are_all_named() -> None:
    """No two of the three operations contradict each other."""
    line = {
        **LINE,
        'any': 'section: [1, 2, 3, 4], workspaces: [a], capabilities: {wipe: {task: TASK_C}}',
    }
    with pytest.raises(Impossible) as why:
        made_of(line, steps(FIT, '- {id: dry, do: wipe}', BORE))
    assert why.value.reasons == (CONTRADICTION,)


def is_met(demands: Sequence[Demand], sections: tuple[int, ...]) -> bool:
    for demand in demands:
        here = sections[demand.first]
        if demand.second < 0:
            if here not in demand.sections:
                return False
        elif not here <= sections[demand.second] <= dict(demand.room).get(here, 4):
            return False
    return True


def drawn_demand(random: Random) -> Demand:
    first, second = random.sample(range(4), 2)
    if random.random() < 0.5:
        return Demand('', first, sections=tuple(random.sample(range(1, 5), random.randint(1, 3))))
    room = random.randint(0, 2)
    return Demand('', first, second, room=tuple((place, place + room) for place in range(1, 5)))


def test_8_5_contradiction_contains_only_needed_demands() -> None:
    """Tried against every way to put four pieces into four sections."""
    ways, tried = list(product(range(1, 5), repeat=4)), 0
    for seed in range(300):
        random = Random(seed)
        demands = list(dict.fromkeys(drawn_demand(random) for _ in range(9)))
        if any(is_met(demands, way) for way in ways):
            continue
        needed = irreducible(demands, pieces=4, sections=4)
        assert not any(is_met(needed, way) for way in ways)
        for demand in needed:
            others = [other for other in needed if other is not demand]
            assert any(is_met(others, way) for way in ways), (seed, demand)
        tried += 1
    assert tried > 50


@pytest.mark.parametrize(
    ('without', 'reason'),
    [
        ('press_a', '`fit`: only press_a could, and it is out of service'),
        ('conveyor', 'the conveyor is out of service, and nothing moves without it'),
    ],
)
def test_8_5_what_is_out_of_service_is_named(without: str, reason: str) -> None:
    with pytest.raises(Impossible) as why:
        made_of(LINE, steps(BORE, FIT), without=without)
    assert why.value.reasons == (reason,)


def test_8_5_bound_component_without_capability_is_named() -> None:
    cell = cell_of(LINE)
    with pytest.raises(Impossible) as why:
        generate(
            cell, recipe_of(cell, steps(BORE)), Overrides({'bore': 'press_a'}), judge=Silent()
        )
    assert why.value.reasons == (
        '`bore`: no component can do it: it is bound to press_a, which does not have `drill`',
    )


class Silent:
    """A judge for whom nothing gets to its end."""

    def pace_s(self, script: Script) -> float | None:
        return None
