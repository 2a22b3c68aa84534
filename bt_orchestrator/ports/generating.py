"""Scripts of orders by recipe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.script import MadeFrom


class MadeScript(NamedTuple):
    """A script that was generated for an order by recipe."""

    name: str
    """As findings call it."""
    text: str
    digest: str = ''
    made_from: MadeFrom | None = None
    """None: not known."""


class Generating(Protocol):
    """Generates the scripts of orders by recipe, outside the tick thread."""

    async def make(
        self, choices: Sequence[RecipeChoice], without: frozenset[str]
    ) -> Sequence[MadeScript | Refused]:
        """Return the script of each, or why there is none. Only replies are awaited.

        :param without: components that are out of service
        :raises NotRead: says why nothing could be generated
        """

    def close(self) -> None:
        """Stop working."""
