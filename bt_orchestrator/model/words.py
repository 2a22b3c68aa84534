"""A sentence of the node as facts, from which each language can word it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Words:
    """The facts of one sentence."""

    kind: str
    """Which sentence it is."""
    values: Mapping[str, str] = field(default_factory=dict)
    """What it names."""
