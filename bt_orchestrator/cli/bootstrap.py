"""Builds what a verb runs from the files that the user names. Knows every class."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple, TypeVar

from bt_orchestrator.base.errors import Finding, NotRead, Refused
from bt_orchestrator.base.extending import RECIPES
from bt_orchestrator.cli.processes.bookkeeping_process import BooksProcess, StopProcess
from bt_orchestrator.cli.processes.foresight_process import ForesightProcess
from bt_orchestrator.model.cell import Approval, Cell
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.keeping.journal_place import JournalPlace
from bt_orchestrator.model.recipe import Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import (
    ActionTypes,
    Bookkeeping,
    EventSink,
    EventStore,
    Foresight,
    Generating,
    MadeScript,
    StopSearch,
)
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.lookup import find_script
from bt_orchestrator.script.orders.admission import admitted
from bt_orchestrator.script.orders.by_recipe import Maker, recipes
from bt_orchestrator.script.orders.file_findings import refuse_duplicates
from bt_orchestrator.script.orders.order_file import (
    OrderFile,
    OrderPlaces,
    bind_order,
    draft_order,
)
from bt_orchestrator.script.orders.parameter_uses import action_types
from bt_orchestrator.script.orders.terms import Wrong
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore

_T = TypeVar('_T')


class Given(NamedTuple):
    """A job, and where its order is written."""

    job: Job
    places: OrderPlaces


class Replacement(NamedTuple):
    """A file whose script takes the place of another one."""

    of: str
    """Name of the script that it is used for."""
    path: Path


class Findings:
    """Collects the mistakes of several files, in the order the files were read."""

    def __init__(self) -> None:
        self._findings: dict[Finding, None] = {}

    def of(self, read: Callable[[], _T]) -> _T | None:
        """Return what was read; None if it was refused."""
        try:
            return read()
        except Refused as refused:
            self.add(refused.findings)
            return None

    def add(self, findings: Iterable[Finding]) -> None:
        """Add mistakes; each is reported once."""
        self._findings.update(dict.fromkeys(findings))

    def refuse(self) -> None:
        """End here if there was any mistake.

        :raises Refused: with all of them
        """
        if self._findings:
            raise Refused(list(self._findings))


def installed_types() -> ActionTypes:
    """Return what the installed interface packages say; needs them, but not rclpy."""
    from bt_orchestrator.ros.types.action_types import InstalledActionTypes

    return InstalledActionTypes()


def load_cell(path: Path, types: ActionTypes) -> Cell:
    """Read a cell.

    :raises Refused: with every mistake in its file
    """
    return read_cell(path, types)


def load_scripts(
    names: Sequence[str], cell_file: Path, folders: Sequence[Path], types: ActionTypes
) -> tuple[Cell, list[Script]]:
    """Read a cell, and scripts against it.

    :raises Refused: with every mistake in all files; a script cannot be read without its cell
    """
    findings = Findings()
    cell = findings.of(partial(load_cell, cell_file, types))
    scripts = []
    for name in names:
        path = findings.of(partial(find_script, name, folders))
        if path is not None and cell is not None:
            scripts.append(findings.of(partial(_admitted, path, cell, types)))
    findings.refuse()
    assert cell is not None
    return cell, [script for script in scripts if script is not None]


def load_recipes(paths: Sequence[Path], cell_file: Path, types: ActionTypes) -> list[Recipe]:
    """Read recipes against what a cell can do.

    :raises Refused: with every mistake in all files
    """
    findings = Findings()
    cell = findings.of(partial(load_cell, cell_file, types))
    read = []
    if cell is not None and paths:
        reader = recipes().read_recipe
        read = [findings.of(partial(reader, path, cell, types)) for path in paths]
    findings.refuse()
    return [recipe for recipe in read if recipe is not None]


def load_script(
    name: str, cell_file: Path, folders: Sequence[Path], types: ActionTypes
) -> tuple[Cell, Script]:
    """Read a cell and a script without mistakes, which may still be one that gets stuck.

    :raises Refused: with every mistake in both files
    """
    findings = Findings()
    cell = findings.of(partial(load_cell, cell_file, types))
    path = findings.of(partial(find_script, name, folders))
    script = None
    if cell is not None and path is not None:
        script = findings.of(partial(read_script, path, cell, types))
    findings.refuse()
    assert cell is not None
    assert script is not None
    return cell, script


def build_foresight(cell: Cell) -> Foresight:
    """Build what forecasts the ends of jobs, in a process that starts with the first question."""
    return ForesightProcess(cell)


def build_bookkeeping(journal: JournalPlace) -> Bookkeeping:
    """Build what makes the books of a journal, in a process that starts with each work."""
    return BooksProcess(journal)


def build_stop_search(
    journal: JournalPlace, soon: Callable[[Callable[[], None]], None]
) -> StopSearch:
    """Build what looks for stops of the line, in a process that starts with each question."""
    return StopProcess(journal, soon)


def build_generating(
    cell: Cell, folders: Sequence[Path], soon: Callable[[Callable[[], None]], None]
) -> Generating:
    """Build what generates scripts, in a process that starts with the first order by recipe."""
    missing = RECIPES.missing
    return NotGenerating(missing) if missing else recipes().generating(cell, folders, soon)


def _admitted(path: Path, cell: Cell, types: ActionTypes) -> Script:
    return admitted(read_text(path), str(path), cell, types)


def load_jobs(
    orders: Sequence[Path],
    cell_file: Path,
    folders: Sequence[Path],
    types: ActionTypes,
    instead: Replacement | None = None,
    recipe_folders: Sequence[Path] = (),
) -> tuple[Cell, list[Given]]:
    """Read a cell, work orders and their scripts, and bind them to jobs.

    The script of an order by recipe is generated here.

    An order without id is called WO-1, WO-2 and so on, whatever is free.

    :param instead: used for all orders of the script that it replaces
    :param recipe_folders: in which recipes are looked up
    :raises Refused: with every mistake in all files
    """
    findings = Findings()
    cell = findings.of(partial(load_cell, cell_file, types))
    read = [findings.of(partial(draft_order, path)) for path in orders]
    files = [file for file in read if file is not None]
    findings.of(partial(refuse_duplicates, files))
    for file in files:
        findings.add(file.places.findings)
    jobs = None
    if cell is not None:
        shelf = _ScriptShelf(cell, folders, types, instead, recipe_folders)
        jobs = _bind(files, shelf, findings)
    findings.refuse()
    assert cell is not None
    assert jobs is not None
    return cell, jobs


def memory_store() -> EventStore:
    """Make a journal that is gone with the process."""
    return MemoryStore()


def build_simulation(cell: Cell, types: ActionTypes, sinks: Sequence[EventSink]) -> Simulation:
    """Build a virtual run of a cell."""
    # Without a random name, so that two runs of one line have the same trace.
    approved = replace(cell, first_piece=Approval.AUTOMATIC)  # nobody is there (6.12)
    return Simulation(approved, types, MemoryStore(history=''), sinks)


def queue(simulation: Simulation, given: Sequence[Given]) -> None:
    """Queue jobs in a virtual run, now.

    :raises Refused: the cell did not accept all of them
    """
    answers = simulation.submit(order.job for order in given)
    refused = [
        Finding(order.places.file, place.line, place.column, answer.message)
        for order, answer in zip(given, answers, strict=True)
        if not answer.accepted
        for place in [order.places.place('script')]
    ]
    if refused:
        raise Refused(refused)


class NotGenerating:
    """Generates nothing, and says what to install. Implements `ports.Generating`."""

    def __init__(self, missing: str) -> None:
        self._missing = missing

    async def make(self, *_: object) -> Sequence[MadeScript | Refused]:
        """Refuse.

        :raises NotRead: always
        """
        raise NotRead(f'an order by recipe needs an extension; {self._missing}')

    def close(self) -> None:
        """Nothing works."""


class _ScriptShelf:
    """Reads each script once, however many orders name it."""

    def __init__(
        self,
        cell: Cell,
        folders: Sequence[Path],
        types: ActionTypes,
        instead: Replacement | None,
        recipe_folders: Sequence[Path],
    ) -> None:
        self._cell = cell
        self._folders = folders
        self._types = types
        self._instead = instead
        self._recipe_folders = recipe_folders
        self._maker: Maker | None = None
        self._scripts: dict[Path, Script] = {}
        self.types_by_component = action_types(cell, types)
        self.most_items = cell.most_items

    def script_of(self, file: OrderFile) -> Script:
        """Return the script that an order names, or that is generated for it.

        :raises Refused: it cannot be found, or has mistakes; or there is none for the recipe
        """
        script = self._named_or_made(file)
        if self._instead is not None and script.name == self._instead.of:
            return self._read(self._instead.path)
        return script

    def _named_or_made(self, file: OrderFile) -> Script:
        places, recipe = file.places, file.order.recipe
        if recipe is not None:
            if missing := RECIPES.missing:
                raise Refused([places.finding(Wrong('recipe', missing, ''))])
            if self._maker is None:
                self._maker = recipes().maker(self._cell, self._types, self._recipe_folders)
            return self._maker.ordered(recipe, places)
        place = places.place('script')
        return self._read(find_script(file.order.script, self._folders, places.file, place))

    def _read(self, path: Path) -> Script:
        if path not in self._scripts:
            self._scripts[path] = read_script(path, self._cell, self._types)
        return self._scripts[path]


def _bind(files: Sequence[OrderFile], shelf: _ScriptShelf, findings: Findings) -> list[Given]:
    ids = _free_ids({file.order.order for file in files})
    given = []
    for file in files:
        job_id = file.order.order or next(ids)
        if not all(file.places.is_sure(key) for key in ('script', 'recipe', 'version', 'bind')):
            continue
        job = findings.of(partial(_job, file, job_id, shelf))
        if job is not None:
            given.append(Given(job, file.places))
    return given


def _job(file: OrderFile, job_id: str, shelf: _ScriptShelf) -> Job:
    script = shelf.script_of(file)
    types, most = shelf.types_by_component, shelf.most_items
    return bind_order(file.order, script, job_id, file.places, types, most)


def _free_ids(taken: set[str | None]) -> Iterator[str]:
    return (name for n in itertools.count(1) if (name := f'WO-{n}') not in taken)
