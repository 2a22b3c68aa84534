"""Constructors and copies of frozen facts (model/frozen.py)."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import FrozenInstanceError, dataclass, field, replace

import pytest

from bt_orchestrator.model.frozen import changed, made_at_once, worked_out


@dataclass(frozen=True)
class _Plain:
    name: str
    number: int = 3
    notes: Mapping[str, int] = field(default_factory=dict)


@made_at_once
@dataclass(frozen=True)
class _Quick:
    name: str
    number: int = 3
    notes: Mapping[str, int] = field(default_factory=dict)


@made_at_once
@dataclass(frozen=True, kw_only=True)
class _ByName:
    seq: int = 0
    task: str
    notes: Mapping[str, int] = field(default_factory=dict)

    @worked_out
    def words(self) -> list[str]:
        """The task in words."""
        return [self.task]


def test_the_constructor_takes_the_same_arguments() -> None:
    assert inspect.signature(_Quick.__init__) == inspect.signature(_Plain.__init__)
    assert vars(_Quick('a', 4, {'b': 1})) == vars(_Plain('a', 4, {'b': 1}))
    assert vars(_Quick('a')) == {'name': 'a', 'number': 3, 'notes': {}}
    assert vars(_ByName(task='a')) == {'seq': 0, 'task': 'a', 'notes': {}}


def test_wrong_arguments_are_refused() -> None:
    with pytest.raises(TypeError):
        _Quick()  # type: ignore[call-arg]
    with pytest.raises(TypeError):
        _ByName(1, 'a')  # type: ignore[call-arg]


def test_defaults_are_not_shared() -> None:
    assert _Quick('a').notes is not _Quick('a').notes


def test_facts_stay_frozen_and_equal() -> None:
    fact = _Quick('a')
    with pytest.raises(FrozenInstanceError):
        fact.number = 4  # type: ignore[misc]
    assert fact == _Quick('a') != _Quick('b')


def test_a_copy_has_the_changes() -> None:
    assert changed(_Quick('a'), number=4) == replace(_Quick('a'), number=4)


def test_a_property_is_worked_out_once() -> None:
    fact = _ByName(task='a')
    assert fact.words is fact.words
