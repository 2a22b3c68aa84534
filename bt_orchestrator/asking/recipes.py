"""Orders by recipe: their scripts are generated first, then they are read as all others are."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace

from bt_orchestrator.asking.handler import OrderReading
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Generating
from bt_orchestrator.script.orders.desk import Made, Reading, Wanted


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
        async with self._orders.read(wanted) as reading:
            choices = reading.choices
            if not any(choices):
                yield reading
                return
        made = await self._made(choices)
        again = _with(made, wanted)
        async with self._orders.read(again) as reading:
            yield reading

    async def _made(self, choices: Sequence[RecipeChoice | None]) -> tuple[Made, ...]:
        """Return what is made for each order, without what is out of service when it is done."""
        different: list[RecipeChoice] = []
        for choice in choices:
            if choice is not None and choice not in different:
                different.append(choice)
        while True:
            without = frozenset(self._state.out_of_service)
            made = await self._generating.make(different, without)
            if without == frozenset(self._state.out_of_service):
                break
        return tuple(None if one is None else made[different.index(one)] for one in choices)


def _with(
    made: tuple[Made, ...], wanted: Wanted | Callable[[], Wanted]
) -> Wanted | Callable[[], Wanted]:
    """Return orders with what was made for them; a job is changed as it is at its turn."""
    if callable(wanted):
        as_it_is = wanted
        return lambda: replace(as_it_is(), made=made)
    return replace(wanted, made=made)
