"""Semantics 6.11: a script that was released is taken in place of a new one made from the same."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from fakes.commands import ReleaseScript, SetService
from fakes.operator import ann
from fakes.recipe_bench import BOX, TYPES, Bench
from fakes.script_texts import LINE, cell, script

from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.asking.recipes import RecipeOrders
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.keeping.snapshot import state_from_plain
from bt_orchestrator.model.keeping.state_text import StateText
from bt_orchestrator.model.limits import RELEASED_KEPT
from bt_orchestrator.model.requests import ask
from bt_orchestrator.ports import MadeScript
from bt_orchestrator.sim.simulation import Simulation

HERE = digest(cell())


def at(component: str, timeout: float = 9.0, **origin: str) -> MadeScript:
    """Return the script in which a component glues, as the generating process gives it."""
    keys = {'recipe': 'BOX-7', 'recipe_digest': '"aa11"', 'cell_digest': f'"{HERE}"', **origin}
    written = ', '.join(f'{name}: {value}' for name, value in keys.items())
    glue = f'{{id: glue, task: TASK_A, action: /{component}/task, timeout: {timeout}}}'
    text = f'{LINE}  3: [{glue}]\nmade_from: {{version: 1, {written}}}\n'
    read = script(text)
    return MadeScript('BOX-7', text, digest(read), read.made_from)


OLD, NEW = at('press'), at('table', generator='"99.0"')


def order(bench: Bench, name: str, given: MadeScript) -> str:
    """Order by recipe, and return what is said of it."""
    wanted = [WorkOrder('', name, 1, recipe=BOX)]
    reply = begin(bench.handler.carry_out(ask('queue.add', ann(), orders=wanted)))
    bench.give(given)
    return reply.value.message


def release(bench: Bench, made: MadeScript) -> None:
    answer = begin(bench.engine.carry_out(ReleaseScript(made.digest, ann('read it')))).value
    assert answer.accepted, answer.message


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """Give a cell whose job J ran the script OLD, which was released, and has ended."""
    bench = Bench(tmp_path)
    with closing(bench.sim):
        assert 'is not released' in order(bench, 'J', OLD)
        release(bench, OLD)
        bench.sim.run()
        assert 'J' in bench.engine.state.ended
        assert OLD.digest not in bench.engine.state.scripts
        yield bench


def test_6_11_a_newer_program_takes_the_released_script(bench: Bench) -> None:
    assert order(bench, 'K', NEW) == 'K is queued'
    taken = bench.engine.state.jobs['K'].job.script
    assert digest(taken) == OLD.digest
    assert taken.made_from == OLD.made_from
    bench.sim.run()
    assert bench.engine.state.ended['K'].progress.packed == 1


def test_6_11_after_a_restart_it_is_taken_too(bench: Bench, tmp_path: Path) -> None:
    with closing(Simulation(cell(), TYPES, bench.store)) as second:
        again = Bench(tmp_path, second)
        assert order(again, 'K', NEW) == 'K is queued'


def test_6_11_a_snapshot_keeps_it(bench: Bench) -> None:
    state = bench.engine.state
    written = StateText(state, check=True)
    assert written.go_on()
    again = state_from_plain(cell(), json.loads(written.text))
    assert again.released_scripts == state.released_scripts
    assert again.released_scripts[OLD.digest].made_from == OLD.made_from
    made_script = RecipeOrders(bench.handler._orders, bench, again)._released(NEW)
    assert isinstance(made_script, MadeScript)
    assert (made_script.digest, made_script.made_from) == (OLD.digest, OLD.made_from)


def test_6_11_a_release_in_advance_counts(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    with closing(bench.sim):
        release(bench, OLD)
        assert order(bench, 'J', OLD) == 'J is queued'
        assert order(bench, 'K', NEW) == 'K is queued'


@pytest.mark.parametrize(
    'other',
    [
        at('table', recipe_digest='"bb22"'),
        at('table', cell_digest='"bb22"'),
        at('table', overrides_digest='"bb22"'),
        at('table', without='[camera]'),
        MadeScript('BOX-7', NEW.text, NEW.digest),
    ],
    ids=['recipe', 'cell', 'overrides', 'components', 'unknown'],
)
def test_6_11_what_was_made_from_something_else_waits(bench: Bench, other: MadeScript) -> None:
    state = bench.engine.state
    orders = RecipeOrders(bench.handler._orders, bench, state)
    assert orders._released(other) is other


def test_6_11_released_new_script_is_used(bench: Bench) -> None:
    release(bench, NEW)
    assert order(bench, 'K', NEW) == 'K is queued'
    assert bench.engine.state.jobs['K'].digest == NEW.digest


def test_6_11_of_several_the_one_used_last_is_taken(bench: Bench) -> None:
    release(bench, NEW)
    order(bench, 'K', NEW)
    assert order(bench, 'L', at('press', 5.0)) == 'L is queued'
    assert bench.engine.state.jobs['L'].digest == NEW.digest
    order(bench, 'M', OLD)
    order(bench, 'N', at('press', 5.0))
    assert bench.engine.state.jobs['N'].digest == OLD.digest


def test_6_11_unreleased_script_is_not_taken(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    with closing(bench.sim):
        order(bench, 'J', OLD)
        assert 'is not released' in order(bench, 'K', NEW)
        assert bench.engine.state.jobs['K'].digest == NEW.digest


def test_6_11_release_for_other_cell_file_is_ignored(bench: Bench) -> None:
    state = bench.engine.state
    state.released[OLD.digest] = ('bb22',)
    assert RecipeOrders(bench.handler._orders, bench, state)._released(NEW) is NEW


def test_6_11_script_ordered_by_name_is_not_taken(tmp_path: Path) -> None:
    """A file that was generated may have been edited since."""
    bench = Bench(tmp_path)
    with closing(bench.sim):
        (tmp_path / 'edited.yaml').write_text(OLD.text)
        orders = [WorkOrder('edited', 'J', 1)]
        begin(bench.handler.carry_out(ask('queue.add', ann(), orders=orders)))
        release(bench, OLD)
        assert not bench.engine.state.released_scripts
        assert 'is not released' in order(bench, 'K', NEW)


def test_6_11_outage_order_takes_its_released_script(bench: Bench) -> None:
    begin(bench.engine.carry_out(SetService('camera', False, ann())))
    out = at('table', without='[camera]')
    assert 'is not released' in order(bench, 'K', out)
    release(bench, out)
    assert order(bench, 'L', at('press', 5.0, without='[camera]')) == 'L is queued'


def test_6_11_a_cell_keeps_those_that_were_used_last(bench: Bench) -> None:
    kept = bench.engine.state.released_scripts
    script_of = kept[OLD.digest]
    for number in range(RELEASED_KEPT - 1):
        kept[str(number)] = script_of
    release(bench, NEW)
    order(bench, 'K', NEW)
    assert len(kept) == RELEASED_KEPT
    assert OLD.digest not in kept
    assert [*kept][-1] == NEW.digest
