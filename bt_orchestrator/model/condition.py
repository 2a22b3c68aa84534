"""Conditions: what has to hold of values that are known by then (semantics 6.5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from bt_orchestrator.model.reference import (
    Reference,
    Scope,
    Template,
    as_text,
    references,
    resolve,
)

NOTHING = Template(())


@dataclass(frozen=True)
class Condition:
    """One value compared, or several conditions that all, or at least one, have to hold.

    One comparison is given; both bounds together are what a script calls `between`.
    """

    value: Template = NOTHING
    """The compared value; nothing in a condition of conditions."""
    equals: Any = True
    """Counts if no other comparison is given; true: the value is a boolean."""
    negated: bool = False
    """True for `unless`; its parts never are."""
    not_equals: Any = None
    at_least: Any = None
    """An inclusive bound: a number, or the Template of a parameter; `at_most` too."""
    at_most: Any = None
    one_of: tuple[Any, ...] = ()
    all: tuple[Condition, ...] = ()
    any: tuple[Condition, ...] = ()

    @property
    def references(self) -> Iterator[Reference]:
        """Every reference in it, in the order written."""
        yield from references((self.value, self.at_least, self.at_most))
        for part in self.parts:
            yield from part.references

    @property
    def parts(self) -> tuple[Condition, ...]:
        """The conditions that it consists of; none if it compares one value."""
        return self.all or self.any

    @property
    def comparisons(self) -> Iterator[Condition]:
        """Every condition in it that compares one value."""
        if not self.parts:
            yield self
        for part in self.parts:
            yield from part.comparisons

    @property
    def words(self) -> str:
        """The condition, in the words of a person."""
        if self.parts:
            joint = ' and ' if self.all else ' or '
            return joint.join(f'({p.words})' if p.parts else p.words for p in self.parts)
        return f'{self.value}{self._compared}'

    @property
    def _compared(self) -> str:
        if self.one_of:
            return f' one of {", ".join(map(as_text, self.one_of))}'
        if self.not_equals is not None:
            return f' is not {as_text(self.not_equals)}'
        if self.at_least is not None and self.at_most is not None:
            return f' from {self.at_least} to {self.at_most}'
        if self.at_least is not None:
            return f' at least {self.at_least}'
        if self.at_most is not None:
            return f' at most {self.at_most}'
        return '' if self.equals is True else f' = {as_text(self.equals)}'

    def __str__(self) -> str:
        return f'{"unless" if self.negated else "when"} {self.words}'


def holds(condition: Condition, scope: Scope) -> bool:
    """Tell whether a condition holds.

    :raises MissingResult: one of its values does not exist for this item, or is no finite number,
        whatever its other parts say
    """
    return _is_met(condition, scope) != condition.negated


def _is_met(condition: Condition, scope: Scope) -> bool:
    if condition.parts:
        met = [_is_met(part, scope) for part in condition.parts]  # each, for what it may lack
        return all(met) if condition.all else any(met)
    value = resolve(condition.value, scope)
    if condition.one_of:
        return value in condition.one_of
    if condition.not_equals is not None:
        return bool(value != condition.not_equals)
    low, high = (resolve(bound, scope) for bound in (condition.at_least, condition.at_most))
    if low is None and high is None:
        return bool(value == condition.equals)
    return (low is None or value >= low) and (high is None or value <= high)
