"""Conditions of tasks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fakes.drawn.plan import Draw, Row, chance
from hypothesis import strategies as st


def draw_condition(draw: Draw, read: str) -> Any:
    """Draw a condition on what an earlier task measured and saw, perhaps on the item too."""
    if not chance(draw, 60):
        return f'${{results.{read}.item_present}}'
    weighed: Row = {'value': f'${{results.{read}.measurement}}', **_bounds(draw, (0.0, 2.5, 7.5))}
    if not chance(draw, 40):
        return weighed
    parts = [weighed, draw_comparison(draw, '${item.number}')]
    if chance(draw, 50):
        parts.reverse()
    return {draw(st.sampled_from(('all', 'any'))): parts}


def draw_verdict(draw: Draw, own: str, readable: Sequence[str]) -> Any:
    """Draw a verdict of a task on what it measured and saw itself, perhaps on others too."""
    verdict = draw_condition(draw, own)
    if not readable or not chance(draw, 20):
        return verdict
    other = f'${{results.{draw(st.sampled_from(readable))}.item_present}}'
    return {draw(st.sampled_from(('all', 'any'))): [verdict, other]}


def draw_comparison(draw: Draw, value: str) -> Row:
    """Draw a comparison of a whole number."""
    numbers = st.integers(1, 3)
    kind = draw(st.sampled_from(('equals', 'equals', 'not_equals', 'one_of', 'bounds')))
    if kind == 'one_of':
        return {'value': value, kind: sorted(draw(st.sets(numbers, min_size=1)))}
    operand = _bounds(draw, (1, 2, 3)) if kind == 'bounds' else {kind: draw(numbers)}
    return {'value': value, **operand}


def _bounds(draw: Draw, numbers: tuple[float, ...]) -> Row:
    kind = draw(st.sampled_from(('at_least', 'at_most', 'between')))
    low, high = draw(st.sampled_from(numbers)), draw(st.sampled_from(numbers))
    return {kind: sorted((low, high)) if kind == 'between' else low}
