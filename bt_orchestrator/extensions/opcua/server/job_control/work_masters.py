"""The work masters: the scripts and recipes that an order can name, with their parameters."""

from __future__ import annotations

from collections.abc import Iterable

from asyncua import ua

from bt_orchestrator.extensions.opcua.server.bridge import Bridge
from bt_orchestrator.extensions.opcua.server.job_control.structures import listed, work_master
from bt_orchestrator.model.script import Parameter as Declared
from bt_orchestrator.script.orders.by_recipe import DeclaredVersion
from bt_orchestrator.view.report.isa95.parts import Parameter, Text, WorkMaster


class WorkMasters:
    """The value of `WorkMaster`; it is made anew when another one is known."""

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge
        self._value = listed([])
        self._made_from: object = None

    def value(self) -> ua.Variant:
        """Return them by name: those in the folders, and the scripts of jobs that are known."""
        files, scripts = self._bridge.orderable, self._bridge.known.scripts
        made_from = (files.looked_at, tuple(scripts))
        if made_from != self._made_from:
            heard = {one.name: _master(one.name, one.params.values()) for one in scripts.values()}
            read = {
                name: _master(name, one.params.values()) for name, one in files.scripts.items()
            }
            recipes = {name: _of_recipe(one.newest) for name, one in files.recipes.items()}
            found = {**heard, **recipes, **read}
            self._made_from = made_from
            self._value = listed([work_master(found[name]) for name in sorted(found)])
        return self._value


def _of_recipe(one: DeclaredVersion) -> WorkMaster:
    return _master(one.name, one.params.values(), f'recipe, version {one.version}')


def _master(name: str, params: Iterable[Declared], about: str = '') -> WorkMaster:
    return WorkMaster(
        name,
        about,
        tuple(
            Parameter(
                one.name,
                one.default,
                (Text(f'{one.type}, {"required" if one.required else "optional"}', 'en'),),
            )
            for one in params
        ),
    )
