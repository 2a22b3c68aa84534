"""Orders by recipe: their scripts are generated first, then they are read as all others are."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.engine.asking.handler import OrderReading
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.jobs.releases import released_before
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Generating, MadeScript
from bt_orchestrator.script.orders.desk import MadeScripts, Reading, Wanted
from bt_orchestrator.script.writing.script_text import write_script


class RecipeOrders:
    """Reads orders, with scripts that are generated for them. Implements `handler.OrderReading`.

    Whoever names scripts does not wait for those who name recipes: a request with recipes gives
    its turn away while they are generated. Then it is read as a whole, and is queued against the
    queue as it is then.
    """

    def __init__(self, orders: OrderReading, generating: Generating, state: CellState) -> None:
        self._orders = orders
        self._generating = generating
        self._state = state

    @asynccontextmanager
    async def read(self, wanted: Wanted | Callable[[], Wanted]) -> AsyncIterator[Reading]:
        """Read them in their turn; that of the next ones comes when the block has ended.

        :raises NotRead: says why nothing was read
        """
        made: MadeScripts = ()
        while True:
            async with self._orders.read(_with(made, wanted)) as reading:
                choices = [one for one in reading.choices if one is not None]
                if not choices:
                    yield reading
                    return
            # More than once only if the job that is to be changed was changed meanwhile.
            made = await self._made(choices)

    async def _made(self, choices: Sequence[RecipeChoice]) -> MadeScripts:
        """Return what is made, without what is out of service when it is done.

        A script that was released for the same is taken in its place (semantics 6.11).
        """
        different = [one for at, one in enumerate(choices) if one not in choices[:at]]
        while True:
            without = frozenset(self._state.out_of_service)
            made = await self._generating.make(different, without)
            if without == frozenset(self._state.out_of_service):
                return tuple(zip(different, map(self._released, made), strict=True))

    def _released(self, made: MadeScript | Refused) -> MadeScript | Refused:
        if isinstance(made, Refused) or made.made_from is None:
            return made
        before = released_before(self._state, made.made_from, made.digest)
        if before is None:
            return made
        text = write_script(before, None)
        return MadeScript(made.name, text, digest(before), before.made_from)


def _with(
    made: MadeScripts, wanted: Wanted | Callable[[], Wanted]
) -> Wanted | Callable[[], Wanted]:
    """Return orders with the scripts made for them; a job is changed in its state at its turn."""
    if callable(wanted):
        as_it_is = wanted
        return lambda: replace(as_it_is(), made=made)
    return replace(wanted, made=made)
