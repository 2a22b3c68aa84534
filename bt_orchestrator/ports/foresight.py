"""Forecasts of the cell that runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol


class Foresight(Protocol):
    """Forecasts when jobs end, outside the tick thread."""

    def ask(self, state: str, observed_s: Mapping[str, Mapping[str, float]], now_s: float) -> None:
        """Request a forecast from a state; returns at once. A later request replaces it.

        :param state: of `model.keeping.snapshot`, as JSON
        :param observed_s: task durations in seconds, by component and task constant
        """

    @property
    def ends_s(self) -> Mapping[str, float]:
        """When each live job will end, by the last forecast; unknown ones are left out."""

    def close(self) -> None:
        """Stop working."""
