"""The scripts and recipes that the page can reach: in folders, from events, from the journal."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Iterator
from typing import Any

from bt_orchestrator.extensions.page.web.archive.archive import Archive, Look, events
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.script import Parameter, Script
from bt_orchestrator.ports.doors.known import Known
from bt_orchestrator.script.declared import OrderFiles
from bt_orchestrator.script.orders.by_recipe import DeclaredRecipe, DeclaredVersion


class Shelf:
    """All calls come from the loop's thread; folders and the journal are read in others."""

    def __init__(
        self,
        known: Known,
        archive: Archive,
        files: OrderFiles,
        ask_moment: Callable[[], Awaitable[None]],
    ) -> None:
        """Prepare; nothing is read.

        :param files: what orders can name
        :param ask_moment: has what a moment tells put into `known`, as far as the node answers
        """
        self._known = known
        self._archive = archive
        self._files = files
        self._ask_moment = ask_moment

    async def listed(self) -> list[dict[str, Any]]:
        """Return all scripts that an order can name, with their parameters."""
        here = {script.name: script for script in await asyncio.to_thread(self._files.scripts)}
        digests = {script.name: digest for digest, script in self._known.scripts.items()}
        listed = [
            _listed(
                script.name, digests.get(script.name, ''), script.params.values(), script.quantity
            )
            for script in here.values()
        ]
        listed += [
            _listed(script.name, digest, script.params.values(), script.quantity)
            for digest, script in self._known.scripts.items()
            if script.name not in here and digests[script.name] == digest
        ]
        return sorted(listed, key=lambda entry: str(entry['name']))

    async def recipes(self) -> list[dict[str, Any]]:
        """Return all recipes that an order can name, each with its versions, the newest last."""
        recipes = await asyncio.to_thread(self._files.recipes)
        cell = await self.cell() if recipes else None
        return [_recipe(recipe, cell) for recipe in recipes]

    async def script(self, digest: str) -> Script | None:
        """Return a script by its digest; None: it is not known here.

        :raises JournalUnusable: the journal cannot be read
        """
        known = self._known.scripts.get(digest)
        if known is None:
            known = await self._archive.read(lambda look: _loaded(look, digest))
            if known is not None:
                self._known.scripts[digest] = known
        return known

    async def cell(self) -> Cell | None:
        """Return the cell; None: the node does not tell it now."""
        if self._known.cell is None:
            await self._ask_moment()
        return self._known.cell


def _loaded(look: Look, digest: str) -> Script | None:
    """Return a script from the journal."""
    wanted = Wanted(events=(e.ScriptLoaded.event,), newest_first=True)
    for event in events(look, wanted, lambda text: digest in text):
        if isinstance(event, e.ScriptLoaded) and event.digest == digest:
            return event.definition
    return None


def parameters(params: Iterable[Parameter]) -> list[dict[str, Any]]:
    """Return parameters for a form."""
    return [
        {
            'name': param.name,
            'type': param.type,
            'meaning': '',
            'default': to_plain(param.default),
            'choices': [],
            'minimum': None,
            'maximum': None,
            'is_required': param.required,
        }
        for param in params
    ]


def _recipe(recipe: DeclaredRecipe, cell: Cell | None) -> dict[str, Any]:
    return {
        'name': recipe.name,
        'versions': [
            {
                'version': version.version,
                'parameters': parameters(version.params.values()),
                'bind': list(_choices(version, cell)),
            }
            for version in recipe.versions
        ],
    }


def _choices(recipe: DeclaredVersion, cell: Cell | None) -> Iterator[dict[str, Any]]:
    """Yield the operations that several components can do, as far as the cell is known."""
    for operation, does in recipe.operations.items():
        able = [
            component.name
            for component in (cell.components.values() if cell else ())
            if not component.capabilities.keys().isdisjoint(does)
        ]
        if len(able) > 1:
            yield {'operation': operation, 'components': able}


def _listed(
    name: str, digest: str, params: Iterable[Parameter], quantity: int | None
) -> dict[str, Any]:
    return {
        'name': name,
        'digest': digest,
        'parameters': parameters(params),
        'quantity': quantity,
    }
