"""The solver: whole numbers, bounds, limits, and what is said where it is missing."""

from __future__ import annotations

import sys
from itertools import product
from pathlib import Path
from random import Random

import pytest
from fakes.planned import ENDS, made_of

from bt_orchestrator.extensions.recipes.planning.outcome import Impossible, NotFound
from bt_orchestrator.extensions.recipes.planning.solver import VERSION, Answer, Model

ROOT = Path(__file__).parents[5]


def knapsack(seed: int) -> tuple[Model, dict[int, int]]:
    """Return numbers to choose from so that they add up to half of their sum, and the costs."""
    random, model = Random(seed), Model()
    numbers = {model.variable(): random.randint(10**5, 10**6) for _ in range(40)}
    model.equal(numbers, sum(numbers.values()) // 2)
    return model, {number: random.randint(1, 99) for number in numbers}


def three_rows(seed: int) -> tuple[Model, list[int], int]:
    """Return works, each of which is done in one of three rows, and how long the longest is."""
    random, model = Random(seed), Model()
    works = [random.randint(100, 999) for _ in range(9)]
    chosen = [[model.variable() for _ in range(3)] for _ in works]
    longest = model.variable(sum(works))
    for row in range(3):
        work = {choice[row]: work for choice, work in zip(chosen, works, strict=True)}
        model.at_most({**work, longest: -1}, 0)
    for choice in chosen:
        model.one_of(choice)
    return model, works, longest


def least_of(works: list[int]) -> int:
    """Try everything."""
    return min(
        max(sum(w for w, at in zip(works, rows, strict=True) if at == row) for row in range(3))
        for rows in product(range(3), repeat=len(works))
    )


def test_8_5_rows_that_contradict_each_other_have_no_answer() -> None:
    model = Model()
    first, other = model.variable(), model.variable()
    model.at_least({first: 1, other: 1}, 2)
    model.at_most({first: 1, other: 1}, 1)
    assert model.minimise({first: 1}, nodes=10) is None


def test_8_5_exhausted_search_is_not_called_impossible() -> None:
    model, cost = knapsack(1)
    with pytest.raises(NotFound) as why:
        model.minimise(cost, nodes=0)
    assert not isinstance(why.value, Impossible)
    assert why.value.reasons == ('not found within 0 nodes; not proven impossible',)


def test_8_5_unproven_answer_has_lower_bound() -> None:
    """Numbers are parted into two heaps that differ as little as can be."""
    random, model = Random(3), Model()
    twice = {model.variable(): 2 * random.randint(10**3, 10**4) for _ in range(30)}
    apart = model.variable(10**6)
    model.at_least({**twice, apart: 1}, sum(twice.values()) // 2)
    model.at_most({**twice, apart: -1}, sum(twice.values()) // 2)
    one_heap = sum(twice.values()) // 2
    begin = Answer([*([0] * 30), one_heap], one_heap, 0)
    answer = model.minimise({apart: 1}, 0, begin)
    assert answer is not None
    assert answer.bound < answer.cost <= one_heap


@pytest.mark.parametrize(('question_nodes', 'is_proven'), [(0, False), (1000, True)])
def test_8_5_questions_prove_what_a_short_search_leaves_open(
    question_nodes: int, is_proven: bool
) -> None:
    """The longest of three rows of work is to be as short as possible."""
    model, works, longest = three_rows(8)
    size = model.size
    begin = Answer([*([1, 0, 0] * 9), sum(works)], sum(works), 0)
    answer = model.least(longest, 0, question_nodes, begin)
    assert answer is not None
    least = least_of(works)
    assert answer.bound <= least <= answer.cost == answer.values[longest]
    assert (answer.bound == answer.cost) is is_proven
    assert model.size == size


@pytest.mark.parametrize('seed', [8, 9, 12])
def test_8_5_a_question_in_steps_has_the_same_answer(seed: int) -> None:
    model, works, longest = three_rows(seed)
    least, size = least_of(works), model.size
    assert model._asked(longest, least - 1, 5000, in_steps=True) is None
    answer = model._asked(longest, least, 5000, in_steps=True)
    assert answer is not None
    assert answer.values[longest] == least
    assert model._is_met(answer.values)
    assert {*answer.values[:-1]} == {0, 1}
    assert model.size == size


def test_8_5_open_question_is_asked_in_steps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[tuple[int, bool]] = []
    ask = Model._asked

    def noted(
        model: Model, variable: int, most: int, nodes: int, *, in_steps: bool
    ) -> Answer | None:
        asked.append((most, in_steps))
        return ask(model, variable, most, nodes, in_steps=in_steps)

    monkeypatch.setattr(Model, '_asked', noted)
    model, works, longest = three_rows(12)
    begin = Answer([*([1, 0, 0] * 9), sum(works)], sum(works), 0)
    answer = model.least(longest, 0, 10, begin)
    assert answer is not None
    assert answer.bound <= least_of(works) <= answer.cost
    first = next(number for number, (_, in_steps) in enumerate(asked) if in_steps)
    assert asked[first - 1] == (asked[first][0], False), 'the same one again'
    assert all(in_steps for _, in_steps in asked[first:])


def test_8_5_rows_can_be_forgotten() -> None:
    model = Model()
    variable = model.variable(7)
    size = model.size
    model.at_least({variable: 1}, 5)
    assert [answer.cost for answer in [model.minimise({variable: 1}, 10)] if answer] == [5]
    model.forget(size)
    assert [answer.cost for answer in [model.minimise({variable: 1}, 10)] if answer] == [0]


def test_8_5_without_highs_planning_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'highspy', None)
    with pytest.raises(NotFound) as why:
        made_of(ENDS, '- {id: place, do: put}\n- {id: box, do: pack}')
    (reason,) = why.value.reasons
    assert f"pip install 'highspy=={VERSION}'" in reason


def test_all_name_the_same_release_of_highs() -> None:
    for file in ('setup.py', 'scripts/requirements/recipes.txt', 'docs/recipes.md'):
        assert f'highspy=={VERSION}' in (ROOT / file).read_text(), file


def test_8_5_nothing_is_printed(capfd: pytest.CaptureFixture[str]) -> None:
    """A script may be printed to the same stream."""
    model = Model()
    model.minimise({model.variable(): 1}, 100)
    assert capfd.readouterr() == ('', '')
