"""Scripts of orders by recipe that are generated before a run begins.

Generating runs scripts in virtual time itself, and two runs at a time are not for one process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from bt_orchestrator.errors import NotRead, Refused
from bt_orchestrator.model.jobs.order import Job, RecipeChoice, WorkOrder
from bt_orchestrator.model.requests import ADD, REQUEUE, UPDATE, Asked
from bt_orchestrator.ports import MadeScript
from bt_orchestrator.script.orders.asked import choice_of

Make = Callable[[RecipeChoice, frozenset[str]], MadeScript | Refused]
"""Generates the script of a recipe, without some components."""


class MadeBefore:
    """Knows what was generated. Implements `ports.Generating`."""

    def __init__(
        self, make: Make | None, choices: Sequence[RecipeChoice], without: frozenset[str]
    ) -> None:
        """Generate.

        :param make: None: nothing can be generated
        :param without: components that are out of service now
        """
        self._without = without
        self._made = [] if make is None else [(one, make(one, without)) for one in choices]

    async def make(
        self, choices: Sequence[RecipeChoice], without: frozenset[str]
    ) -> Sequence[MadeScript | Refused]:
        """Return the script of each.

        :raises NotRead: it was not generated, or for other components
        """
        known = self._made if without == self._without else []
        found = [next((made for one, made in known if one == choice), None) for choice in choices]
        missing = [one.words for one, made in zip(choices, found, strict=True) if made is None]
        if missing:
            raise NotRead(f'the script of {missing[0]} is not worked out here')
        return [made for made in found if made is not None]

    def close(self) -> None:
        """Nothing works."""


def choices_in(requests: Sequence[Asked], jobs: Iterable[Job] = ()) -> Iterator[RecipeChoice]:
    """Yield what scripts have to be made from for some requests, one after the other.

    :param jobs: as they are; a change may name only a part of what it makes a job from
    """
    ordered = {job.id: job.recipe for job in jobs}
    for asked in requests:
        if asked.request == ADD:
            orders: Iterable[WorkOrder] = asked.arguments['orders']
            yield from (order.recipe for order in orders if order.recipe is not None)
            ordered |= {order.order: order.recipe for order in orders if order.order}
        elif asked.request == UPDATE:
            choice, job = choice_of(asked.arguments), str(asked.arguments['job'])
            if choice is not None:
                ordered[job] = choice = choice.over(ordered.get(job))
                yield choice
        elif asked.request == REQUEUE:
            made_from = ordered.get(str(asked.arguments['job']))
            if made_from is not None:
                yield made_from
