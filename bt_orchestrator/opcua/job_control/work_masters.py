"""The work masters: the scripts that an order can name, with their parameters."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterable, Mapping
from pathlib import Path

from asyncua import ua

from bt_orchestrator.mes.parts import Parameter, Text, WorkMaster
from bt_orchestrator.model.script import Parameter as Declared
from bt_orchestrator.opcua.bridge import Bridge
from bt_orchestrator.opcua.job_control.structures import listed, work_master
from bt_orchestrator.script.declared import readable

LOOK_AGAIN_S = 30.0
"""Between two looks at the folders of scripts."""


class WorkMasters:
    """All calls come from the server's loop; the folders are read in another thread."""

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge
        self._in_folders: Mapping[str, WorkMaster] = {}
        self._looked_at: float | None = None
        self._value = listed([])
        self._made_from: object = None

    @property
    def is_due(self) -> bool:
        """Tell whether it is time to look again."""
        return self._looked_at is None or time.monotonic() >= self._looked_at + LOOK_AGAIN_S

    async def look(self) -> None:
        """Read the folders."""
        self._looked_at = time.monotonic()
        self._in_folders = await asyncio.to_thread(_read, tuple(self._bridge.sources.trees))

    def value(self) -> ua.Variant:
        """Return them by name: those in the folders, and those of jobs that are known."""
        scripts = self._bridge.known.scripts
        made_from = (self._looked_at, tuple(scripts))
        if made_from != self._made_from:
            heard = {one.name: _master(one.name, one.params.values()) for one in scripts.values()}
            found = {**heard, **self._in_folders}
            self._made_from = made_from
            self._value = listed([work_master(found[name]) for name in sorted(found)])
        return self._value


def _read(folders: tuple[Path, ...]) -> Mapping[str, WorkMaster]:
    return {one.name: _master(one.name, one.params.values()) for one in readable(folders)}


def _master(name: str, params: Iterable[Declared]) -> WorkMaster:
    return WorkMaster(
        name,
        parameters=tuple(
            Parameter(
                one.name,
                one.default,
                (Text(f'{one.type}, {"required" if one.required else "optional"}', 'en'),),
            )
            for one in params
        ),
    )
