"""The scripts that the page can reach: in folders, from events, from the journal."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from bt_orchestrator.doors.known import Known
from bt_orchestrator.errors import Refused
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.records import Wanted
from bt_orchestrator.model.script import Parameter, Script
from bt_orchestrator.script.declared import Declared, declared, script_files
from bt_orchestrator.web.archive.archive import Archive, Look
from bt_orchestrator.web.archive.scanning import events

_Stamp = tuple[int, int]
"""Time of the last change, and size: a file with the same ones is not read again."""


class Shelf:
    """All calls come from the loop's thread; folders and the journal are read in others."""

    def __init__(
        self,
        known: Known,
        archive: Archive,
        trees: Sequence[Path],
        ask_moment: Callable[[], Awaitable[None]],
    ) -> None:
        """Prepare; nothing is read.

        :param ask_moment: has what a moment tells put into `known`, as far as the node answers
        """
        self._known = known
        self._archive = archive
        self._trees = trees
        self._ask_moment = ask_moment
        self._read: dict[Path, tuple[_Stamp, Declared | None]] = {}

    async def listed(self) -> list[dict[str, Any]]:
        """Return all scripts that an order can name, with their parameters."""
        here = {one.name: one for one in await asyncio.to_thread(self._in_folders)}
        digests = {script.name: digest for digest, script in self._known.scripts.items()}
        listed = [
            _listed(one.name, digests.get(one.name, ''), one.params.values(), one.quantity)
            for one in here.values()
        ]
        listed += [
            _listed(script.name, digest, script.params.values(), script.quantity)
            for digest, script in self._known.scripts.items()
            if script.name not in here and digests[script.name] == digest
        ]
        return sorted(listed, key=lambda one: str(one['name']))

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

    def _in_folders(self) -> list[Declared]:
        """Read the folders; what cannot be read is left out, and an order tells why."""
        found = {path: self._declared(path) for path in script_files(self._trees)}
        self._read = {path: one for path, one in found.items() if one is not None}
        return [one for _, one in self._read.values() if one is not None]

    def _declared(self, path: Path) -> tuple[_Stamp, Declared | None] | None:
        try:
            about = path.stat()
        except OSError:
            return None
        stamp = (about.st_mtime_ns, about.st_size)
        known = self._read.get(path)
        if known is not None and known[0] == stamp:
            return known
        try:
            return stamp, declared(path)
        except Refused:
            return stamp, None


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
            'name': one.name,
            'type': one.type,
            'meaning': '',
            'default': to_plain(one.default),
            'choices': [],
            'minimum': None,
            'maximum': None,
            'is_required': one.required,
        }
        for one in params
    ]


def _listed(
    name: str, digest: str, params: Iterable[Parameter], quantity: int | None
) -> dict[str, Any]:
    return {
        'name': name,
        'digest': digest,
        'parameters': parameters(params),
        'quantity': quantity,
    }
