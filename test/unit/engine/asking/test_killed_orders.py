"""An order by recipe outlives its node, wherever that is killed (semantics 7.5, 8.6, 9.1)."""

from __future__ import annotations

import contextlib
import itertools
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from fakes import glue_cell
from fakes.action_types import FakeActionTypes
from fakes.operator import ann
from fakes.world import World

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.asking.handler import RequestHandler
from bt_orchestrator.engine.asking.orders import DeskHere
from bt_orchestrator.engine.asking.recipes import QueueAnew, RecipeOrders
from bt_orchestrator.extensions.recipes.generating.ordered import RecipeMaker
from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.order import RecipeChoice, WorkOrder
from bt_orchestrator.model.requests import Asked, ask
from bt_orchestrator.ports import MadeScript
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()
CELL = parse_cell(f'{glue_cell.CELL}release: automatic\n', 'cell', TYPES)
NEWER = glue_cell.RECIPE.replace('version: 3', 'version: 4').replace(
    '  - {id: pack,', '  - {id: press, do: close}\n  - {id: pack,'
)
"""It presses as well, so what was done tells which version an item was made by."""

OLD = RecipeChoice(('BOX-7',), 3)
NEW = RecipeChoice(('BOX-7',))
DAY: tuple[Asked, ...] = (
    ask('queue.add', ann(), orders=[WorkOrder('', 'A', 2, recipe=NEW)]),
    ask('queue.add', ann(), orders=[WorkOrder('', n, 1, recipe=OLD) for n in 'BC'], held=True),
    ask('component.out_of_service', ann(), component='robot_a'),
    ask('job.update', ann(), job='B', version=4),
    ask('component.in_service', ann(), component='robot_a'),
    ask('job.update', ann(), job='C', bind={'glue': 'robot_b'}),
    ask('job.release', ann(), job='B'),
    ask('job.release', ann(), job='C'),
)
"""What people ask for, one after the other, while the line runs."""

VERSIONS = {'A': 4, 'B': 4, 'C': 3}
QUANTITIES = {'A': 2, 'B': 1, 'C': 1}


PARTS = 6
"""Of the kills: each a test of its own, so that one that fails does not hide the others."""

MANY = 30
"""Commits that a day has at least."""


class Killed(BaseException):
    """The process is gone: nobody catches that."""


class MortalStore(MemoryStore):
    """A journal whose process dies at one of its commits."""

    def __init__(self, dies_at: int, *, is_kept: bool) -> None:
        """Prepare.

        :param dies_at: number of the commit; 0: never
        :param is_kept: it dies behind the commit; else before it
        """
        super().__init__()
        self.commits = 0
        self._dies_at, self._is_kept = dies_at, is_kept

    def append(self, events: Sequence[e.Event]) -> None:
        self.commits += 1
        dies = self.commits == self._dies_at
        if not dies or self._is_kept:
            super().append(events)
        if dies:
            raise Killed


class Maker:
    """Generates at once, and everything once. Implements `ports.Generating`."""

    def __init__(self, folder: Path) -> None:
        for name, text in (('old', glue_cell.RECIPE), ('new', NEWER)):
            (folder / f'{name}.yaml').write_text(text)
        self._maker = RecipeMaker(CELL, TYPES, [folder])
        self._made: dict[str, MadeScript | Refused] = {}

    async def make(
        self, choices: Sequence[RecipeChoice], without: frozenset[str]
    ) -> Sequence[MadeScript | Refused]:
        return [self._script(choice, without) for choice in choices]

    def _script(self, choice: RecipeChoice, without: frozenset[str]) -> MadeScript | Refused:
        key = f'{choice} {sorted(without)}'
        if key not in self._made:
            self._made[key] = self._maker.script(choice, without)
        return self._made[key]

    def close(self) -> None:
        """Nothing works."""


class Node:
    """A process: what it keeps in memory is gone with it."""

    def __init__(self, world: World, maker: Maker) -> None:
        self._world = world
        self._calls: list[Callable[[], object]] = []
        self.engine = world.orchestrator()
        state = self.engine.state
        desk = DeskHere(CELL, TYPES, (), state)
        self.handler = RequestHandler(self.engine, TYPES, RecipeOrders(desk, maker, state))
        self.engine.add_sink(QueueAnew(self.handler, state, self._calls.append))

    def asked(self, request: Asked) -> None:
        """Carry out a request; one that was carried out before is refused, or changes nothing."""
        begin(self.handler.carry_out(request))
        self._settle()

    def go(self, steps: int) -> None:
        """Let the line run."""
        self._settle()
        for _ in range(steps):
            if not self._world.clock.advance():
                return
            self._settle()

    def _settle(self) -> None:
        self.engine.settle()
        while self._calls:
            self._calls.pop(0)()
            self.engine.settle()


def through_the_day(store: MortalStore, maker: Maker) -> Node:
    """Give all requests; if the node dies, the one without an answer is given to the next."""
    world = World(CELL, store)
    node = Node(world, maker)
    left = list(DAY)
    while True:
        try:
            node.go(2)
            while left:
                node.asked(left[0])
                left.pop(0)
                node.go(3)
                lacking = {job.job.id: job.unavailable for job in node.engine.state.queue}
                assert not any(lacking.values()), f'not made anew: {lacking}'
            node.go(1000)
        except Killed:
            with contextlib.suppress(Killed):
                node.engine.close()
            node = Node(world, maker)
        else:
            return node


def works_of(store: MortalStore) -> Counter[tuple[str | None, str]]:
    """Return how many times each task of each item was done."""
    return Counter(
        (event.item, event.task)
        for event in store.read()
        if isinstance(event, e.TaskSucceeded) and event.item
    )


@pytest.fixture(scope='module')
def maker(tmp_path_factory: pytest.TempPathFactory) -> Maker:
    return Maker(tmp_path_factory.mktemp('recipes'))


def expected_works() -> Counter[tuple[str | None, str]]:
    tasks = {3: ('load', 'glue', 'close', 'pack'), 4: ('load', 'glue', 'close', 'press', 'pack')}
    return Counter(
        (f'{job}/{number + 1}', task)
        for job, version in VERSIONS.items()
        for number in range(QUANTITIES[job])
        for task in tasks[version]
    )


def assert_right(node: Node, store: MortalStore, message: str) -> None:
    """Check that nothing is lost, twice, made by another version, or where it must not be."""
    state = node.engine.state
    assert works_of(store) == expected_works(), message
    assert not state.jobs, message
    made = {name: (job.recipe_version, job.progress.packed) for name, job in state.ended.items()}
    assert made == {name: (VERSIONS[name], QUANTITIES[name]) for name in VERSIONS}, message
    queued = Counter(record.job for record in store.read() if isinstance(record, e.JobQueued))
    assert queued == Counter([*VERSIONS]), message
    is_out = False
    for event in store.read():
        if isinstance(event, (e.ComponentOutOfService, e.ComponentInService)):
            is_out = isinstance(event, e.ComponentOutOfService)
        elif isinstance(event, e.TaskStarted):
            assert not (is_out and event.component == 'robot_a'), message


@pytest.mark.parametrize('part', range(PARTS))
@pytest.mark.parametrize('is_kept', [False, True])
def test_8_6_kill_at_any_commit_makes_each_order_once(
    maker: Maker, *, is_kept: bool, part: int
) -> None:
    for commit in itertools.count(part + 1, PARTS):
        store = MortalStore(commit, is_kept=is_kept)
        node = through_the_day(store, maker)
        label = f'killed {"behind" if is_kept else "before"} commit {commit}'
        assert_right(node, store, label)
        node.engine.close()
        if store.commits < commit:
            break
    assert commit > MANY
