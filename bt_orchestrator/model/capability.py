"""The capabilities of the components of a cell: templates of tasks, for generated scripts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

OF_TASK: Mapping[str, bool] = {'of_task': True}
"""Marks a field with values of fields of `model.script.Task`, by their names."""


@dataclass(frozen=True)
class Capability:
    """One thing that a component can do: a task, and which of its fields a recipe may name."""

    name: str
    task: str
    """Task constant of the action's Goal; a label where the type has no task field."""
    args: Mapping[str, Any] = field(default_factory=dict)
    """Goal fields that are always the same."""
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Goal field of each parameter that an operation sets."""
    gives: Mapping[str, str] = field(default_factory=dict)
    """Result field of each thing that it tells later operations."""
    needs: Mapping[str, str] = field(default_factory=dict)
    """Goal field of each thing that an earlier operation has to tell it."""
    holds: Mapping[str, int] = field(default_factory=dict)
    """Things that the device itself keeps, and for how many items; they are in no result."""
    options: Mapping[str, Any] = field(default_factory=dict, metadata=OF_TASK)
    """Values of further fields of `model.script.Task`; only of those that were written."""


@dataclass(frozen=True)
class Preparation:
    """Initialization of a component: a task of every generated script that uses it."""

    id: str
    task: str
    """Task constant, or label, as in a capability."""
    after: tuple[str, ...] = ()
    """Components, the conveyor among them, whose preparation is done before."""
    args: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict, metadata=OF_TASK)
    """Values of further fields of `model.script.Task`; only of those that were written."""
