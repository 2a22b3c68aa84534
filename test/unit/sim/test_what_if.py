"""What would become of jobs after some requests."""

from __future__ import annotations

import json
import math
import pickle
from collections.abc import Iterator
from contextlib import closing, contextmanager
from datetime import datetime, timezone
from pathlib import Path

import pytest
from fakes import glue_cell
from fakes.action_types import FakeActionTypes
from fakes.commands import SetService
from fakes.line import THREE, Line
from fakes.operator import ann

from bt_orchestrator.extensions.recipes.generating.ordered import RecipeMaker
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job, RecipeChoice, WorkOrder
from bt_orchestrator.model.judging.used_ids import FULL
from bt_orchestrator.model.keeping.snapshot import nearest, state_to_plain, state_to_text
from bt_orchestrator.model.requests import Asked, ask
from bt_orchestrator.ports import CheckedOrder, Consequence, MadeScript, Moment
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.orders.plain_order import order_from
from bt_orchestrator.script.script_file import parse_script
from bt_orchestrator.sim import what_if
from bt_orchestrator.sim.run_on import RunOn
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.sim.what_if import EngineWhatIf
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()
LINE = Line(3, seconds={'a2': 5.0})


@contextmanager
def running(until_s: float, text: str = THREE, fails: str = '') -> Iterator[Simulation]:
    line = Line(3, seconds={'a2': 5.0}, faults={'a2': fails})
    simulation = Simulation(line.cell, TYPES, MemoryStore())
    script = line.script(text)
    simulation.submit(Job(name, script, 3) for name in ('A', 'B', 'C'))
    while (due := simulation.clock.next_deadline()) is not None and due <= until_s:
        simulation.clock.advance()
        simulation.orchestrator.settle()
    yield simulation
    simulation.close()


def asked_of(
    simulation: Simulation, *requests: Asked, trees: tuple[Path, ...] = ()
) -> Consequence:
    plain = json.loads(json.dumps(state_to_plain(simulation.state)))
    moment = Moment(simulation.state.cell, plain, simulation.clock.now())
    return EngineWhatIf(moment, TYPES, trees).ask(requests)


def test_previously_used_id_is_refused_as_by_node() -> None:
    with running(1e6) as simulation:
        assert not simulation.state.jobs
        text = state_to_text(nearest(simulation.state, with_ids=True))
        now_s = simulation.clock.now()
    moment = Moment(LINE.cell, json.loads(text), now_s)
    order = Job('B', LINE.script(THREE), 1)
    run = RunOn(moment.cell, TYPES, moment.plain_state, {}, now_s)
    answer = run.orchestrator.ask(AddJobs((order,)))
    run.close()
    assert (answer.accepted, answer.message) == (
        False,
        'order B was given before; choose another id',
    )


def test_ids_that_the_node_alone_knows_are_named() -> None:
    with running(3.0) as simulation:
        simulation.state.order_ids.add('open')
        asked = ask('queue.add', ann(), orders=[WorkOrder('test', 'old', 1)])
        assert not asked_of(simulation, asked).notes
        for number in range(FULL):
            simulation.state.order_ids.add(f'old-{number}-x')
        simulation.state.order_ids.add('open')
        assert 'old-1-x' in simulation.state.order_ids
        plain = json.loads(state_to_text(nearest(simulation.state, with_ids=True)))
        moment = Moment(simulation.state.cell, plain, simulation.clock.now())
        (note,) = EngineWhatIf(moment, TYPES).ask([asked]).notes
        assert note.startswith('whether old was used before is not known here')
        used = ask('queue.add', ann(), orders=[WorkOrder('test', 'open', 1)])
        assert not EngineWhatIf(moment, TYPES).ask([used]).notes, 'it is refused'
        assert not EngineWhatIf(moment, TYPES).ask([ask('job.next', ann(), job='B')]).notes


def test_an_unknown_end_says_why() -> None:
    with running(9.0, fails='#1=abort') as simulation:
        held = asked_of(simulation)
        assert simulation.state.holds
    assert {entry.ends_s for entry in held.after} == {None}
    assert all('hold 1' in why for why in held.unknown.values())
    with running(4.0) as simulation:
        kept = asked_of(simulation, ask('job.hold', ann('lunch'), job='C'))
    assert list(kept.unknown) == ['C']
    assert kept.unknown['C'].startswith('C ')


def test_prioritized_job_ends_earlier_and_others_later() -> None:
    with running(4.0) as simulation:
        effect = asked_of(simulation, ask('job.next', ann(), job='C'))
        before, after = dict(effect.before), dict(effect.after)
        assert list(before) == ['A', 'B', 'C']
        assert list(after) == ['A', 'C', 'B']
        assert after['A'] == before['A']
        assert after['C'] is not None
        assert after['C'] == before['B']
        assert after['B'] == before['C']
        assert effect.refusals == ()
        # Nothing of it happens: the run itself comes to what was expected of it.
        now_s = simulation.clock.now()
        ends: dict[str, float] = {}
        while simulation.state.jobs:
            simulation.clock.advance()
            simulation.orchestrator.settle()
            for job in simulation.state.ended.values():
                ends.setdefault(job.job.id, simulation.clock.now() - now_s)
        assert ends == pytest.approx(before)


def test_lateness_uses_the_changed_due_time() -> None:
    with running(4.0) as simulation:
        now_s = simulation.clock.now()
        due = datetime.fromtimestamp(now_s + 5.0, timezone.utc).isoformat()
        effect = asked_of(simulation, ask('job.update', ann(), job='C', due=due))
    assert not effect.refusals
    assert effect.due_s == pytest.approx({'C': 5.0})
    changed = {entry.job: entry for entry in effect.changes}['C']
    assert changed.change == 'same'
    assert changed.is_late(changed.after)


def test_refusals_are_reported_and_other_requests_proceed() -> None:
    with running(4.0) as simulation:
        effect = asked_of(
            simulation,
            ask('job.resume', ann(), job='A'),
            ask('queue.add', ann(), orders=[WorkOrder('nowhere')]),
            ask('job.cancel', ann(), job='B'),
        )
        assert len(effect.refusals) == 2
        assert effect.refusals[0].startswith('job.resume: A is Running; ')
        assert effect.refusals[1].startswith('queue.add: refused with 1 finding; ')
        assert 'nowhere' in effect.refusals[1]
        assert list(dict(effect.after)) == ['A', 'C']


def test_job_kept_from_starting_has_no_end() -> None:
    with running(4.0) as simulation:
        effect = asked_of(simulation, ask('job.hold', ann(), job='B'))
        assert dict(effect.after)['B'] is None
        assert dict(effect.after)['C'] == dict(effect.before)['B']


def test_an_order_that_comes_in_between(tmp_path: Path) -> None:
    text = 'script: other\n' + THREE.replace('@a1', 'task: TASK_A, action: /a1/do').replace(
        '@a2', 'task: TASK_A, action: /a2/do'
    ).replace('@a3', 'task: TASK_A, action: /a3/do')
    (tmp_path / 'other.yaml').write_text(text)
    with running(4.0) as simulation:
        order = WorkOrder('other', 'D', 1)
        asked = ask('queue.add', ann(), orders=[order], position=1)
        effect = asked_of(simulation, asked, trees=(tmp_path,))
        assert effect.refusals == ()
        assert list(dict(effect.after)) == ['A', 'D', 'B', 'C']
        before, after = dict(effect.before), dict(effect.after)
        assert before['B'] is not None
        assert after['B'] is not None
        assert after['B'] > before['B']


def test_held_cell_has_no_forecast_until_answered() -> None:
    with running(40.0, fails='#2=abort') as simulation:
        (hold,) = simulation.state.holds
        effect = asked_of(simulation, ask('hold.skip', ann(), hold=hold))
        assert set(dict(effect.before).values()) == {None}
        assert None not in dict(effect.after).values()


def test_two_runs_are_compared_only_where_both_finish(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second run is slow, and comes to the end of fewer jobs."""
    with running(4.0) as simulation:
        whole = dict(asked_of(simulation).before)
        between_s = sum(filter(None, (whole['A'], whole['B']))) / 2
        given_up = iter([math.inf, simulation.clock.now() + between_s])

        class Slow(RunOn):
            def go_on(self, until: float) -> float:
                super().go_on(until)
                return next(given_up)

        monkeypatch.setattr(what_if, 'RunOn', Slow)
        effect = asked_of(simulation)
        assert dict(effect.before) == {'A': whole['A'], 'B': None, 'C': None}
        assert effect.after == effect.before


OTHER = 'script: other\nparams: {n: {type: int, default: 1}}\n' + THREE.replace(
    '@a1', 'task: TASK_A, action: /a1/do'
).replace('@a2', 'task: TASK_A, action: /a2/do').replace('@a3', 'task: TASK_A, action: /a3/do')


def checked(
    simulation: Simulation, trees: tuple[Path, ...], order: dict[str, object]
) -> CheckedOrder:
    plain = json.loads(json.dumps(state_to_plain(simulation.state)))
    moment = Moment(simulation.state.cell, plain, simulation.clock.now())
    return EngineWhatIf(moment, TYPES, trees, any_path=False).check(order)


def test_an_order_is_checked_before_anybody_gives_it(tmp_path: Path) -> None:
    (tmp_path / 'other.yaml').write_text(OTHER)
    (tmp_path / 'broken.yaml').write_text('script: broken\nsections: 7\n')
    good: dict[str, object] = {'script': 'other', 'order': 'D', 'quantity': 1}
    with running(4.0) as simulation:

        def of(**change: object) -> CheckedOrder:
            return checked(simulation, (tmp_path,), {**good, **change})

        assert of() == CheckedOrder(True, '')
        assert [flaw.field for flaw in of(quantity='x').wrong] == ['quantity']
        assert [flaw.field for flaw in of(params={'n': 'x'}).wrong] == ['params.n']
        several = of(order='D/1', quantity=10**9, params={'n': 'x'})
        assert sorted(flaw.field for flaw in several.wrong) == ['order', 'params.n', 'quantity']
        unread = of(order='D/1', script='broken')
        assert [flaw.field for flaw in unread.wrong] == ['order']
        used = of(order='B')
        assert not used.accepted
        assert [flaw.field for flaw in used.wrong] == ['order']
        broken = of(script='broken')
        assert not broken.accepted
        assert broken.message.startswith('the script is refused with')
        elsewhere = of(script='elsewhere')
        assert (elsewhere.accepted, elsewhere.is_checked) == (True, False)
        assert 'there is no script' in elsewhere.message
        outside = of(script='/etc/passwd')
        assert not outside.is_checked
        assert 'not in a folder' in outside.message
        assert list(simulation.state.jobs) == ['A', 'B', 'C'], 'nothing was queued'


def test_order_with_id_of_existing_job_is_refused() -> None:
    with running(4.0) as simulation:
        script = simulation.state.jobs['A'].job.script
        engine = simulation.orchestrator
        again = AddJobs((Job('A', script, 1),), ann())
        refusal = engine.ask(again).message
        plain = json.loads(state_to_text(nearest(simulation.state)))
        moment = Moment(simulation.state.cell, plain, simulation.clock.now())
    with closing(RunOn(moment.cell, TYPES, plain, {}, moment.now_s)) as run:
        answer = run.orchestrator.ask(again)
    assert not answer.accepted
    assert answer.message == refusal == 'order A was given before; choose another id'


# --- orders by recipe -------------------------------------------------------------------------


@pytest.fixture(scope='module')
def glued(tmp_path_factory: pytest.TempPathFactory) -> Glued:
    folder = tmp_path_factory.mktemp('recipes')
    text = glue_cell.RECIPE.replace('operations:', 'params: {n: {type: int}}\noperations:')
    (folder / 'box.yaml').write_text(text)
    return Glued(folder)


class Glued:
    """A cell that makes boxes by a recipe."""

    def __init__(self, recipes: Path) -> None:
        self.recipes = recipes
        self.cell = parse_cell(glue_cell.CELL, 'cell', TYPES)
        self.maker = RecipeMaker(self.cell, TYPES, [recipes])

    def what_if(self, *lost: str) -> EngineWhatIf:
        """Ask from a moment in which some components are out of service."""
        with closing(Simulation(self.cell, TYPES, MemoryStore())) as simulation:
            for name in lost:
                simulation.orchestrator.ask(SetService(name, in_service=False, by=ann()))
            return self.at(simulation)

    def at(self, simulation: Simulation) -> EngineWhatIf:
        """Ask from the moment of a run."""
        plain = json.loads(json.dumps(state_to_plain(simulation.state)))
        moment = Moment(self.cell, plain, simulation.clock.now())
        return EngineWhatIf(moment, TYPES, (), (self.recipes,), make=self.maker.script)

    def with_jobs(self, *quantities: int) -> EngineWhatIf:
        """Ask from a moment at which the first of some jobs is on the line."""
        choice = RecipeChoice(('BOX-7',))
        made = self.maker.script(choice, frozenset())
        assert isinstance(made, MadeScript)
        script = parse_script(made.text, made.name, self.cell, TYPES)
        with closing(Simulation(self.cell, TYPES, MemoryStore())) as simulation:
            pairs = zip('ABC', quantities, strict=False)
            jobs = [Job(name, script, number, {'n': 1}, recipe=choice) for name, number in pairs]
            simulation.submit(jobs)
            simulation.orchestrator.settle()
            return self.at(simulation)

    def made_without(self, component: str) -> str:
        """Return the digest of the script without a component."""
        made = self.maker.script(RecipeChoice(('BOX-7',)), frozenset({component}))
        assert isinstance(made, MadeScript)
        return made.digest


BOX: dict[str, object] = {'recipe': 'BOX-7', 'order': 'D', 'quantity': 1, 'params': {'n': 1}}


def test_an_order_by_recipe_is_generated_and_checked(glued: Glued) -> None:
    assert glued.what_if().check(BOX) == CheckedOrder(True, '')


def sent(*requests: Asked) -> tuple[Asked, ...]:
    """Return requests as the process gets them that works it out."""
    received: tuple[Asked, ...] = pickle.loads(pickle.dumps(requests))
    return received


def test_recipe_orders_from_another_process_are_generated(glued: Glued) -> None:
    orders = [order_from(BOX)]
    effect = glued.what_if().ask(sent(ask('queue.add', ann(), orders=orders)))
    assert effect.refusals == ()
    assert [job.job for job in effect.after] == ['D']
    change = ask('job.update', ann(), job='D', recipe=['BOX-7'])
    both = sent(ask('queue.add', ann(), orders=orders, held=True), change)
    assert glued.what_if().ask(both).refusals == ()


def test_rest_of_job_exists_only_in_the_run(glued: Glued) -> None:
    choice = RecipeChoice(('BOX-7',))
    made = glued.maker.script(choice, frozenset())
    assert isinstance(made, MadeScript)
    script = parse_script(made.text, made.name, glued.cell, TYPES)
    with closing(Simulation(glued.cell, TYPES, MemoryStore())) as simulation:
        simulation.submit([Job('A', script, 8, {'n': 1}, recipe=choice)])
        simulation.orchestrator.settle()
        what_if = glued.at(simulation)
    effect = what_if.ask(sent(ask('job.requeue', ann(), job='A')))
    assert effect.refusals == ()
    assert [job.job for job in effect.after] == ['A', 'A-rest']
    (refused,) = what_if.ask([ask('job.requeue', ann(), job='B')]).refusals
    assert refused.startswith('job.requeue: there is no job B')


@pytest.mark.parametrize(
    ('change', 'field', 'what'),
    [
        ({'params': {'n': 'x'}}, 'params.n', 'whole number'),
        ({'params': {}}, 'params.n', 'missing'),
        ({'version': 9}, 'version', 'recipe BOX-7 has no version 9; there is 3'),
        ({'bind': {'glue': 'nobody'}}, 'bind.glue', 'there is no component `nobody`'),
        ({'bind': {'close': 'robot_a'}}, 'bind.close', '`robot_a` does not have `close`'),
    ],
)
def test_recipe_order_mistakes_appear_at_their_fields(
    glued: Glued, change: dict[str, object], field: str, what: str
) -> None:
    verdict = glued.what_if().check({**BOX, **change})
    assert not verdict.accepted
    ((where, reason, _),) = verdict.wrong
    assert where == field
    assert what in reason


@pytest.mark.parametrize(
    ('change', 'fields'),
    [
        ({'order': 'a/b', 'priority': 'high'}, {'order', 'priority', 'params.n'}),
        ({'version': 9, 'quantity': 0}, {'version', 'quantity', 'params.n'}),
        ({'version': 'x', 'bind': {'glue': 'nobody'}}, {'version', 'bind.glue', 'params.n'}),
        ({'recipe': [], 'order': 'a/b'}, {'recipe', 'order'}),
    ],
)
def test_recipe_order_mistakes_are_all_reported_at_once(
    glued: Glued, change: dict[str, object], fields: set[str]
) -> None:
    verdict = glued.what_if().check({**BOX, 'params': {'n': 'x'}, **change})
    assert not verdict.accepted
    assert sorted(mistake.field for mistake in verdict.wrong) == sorted(fields)


def test_unknown_recipe_is_left_to_the_node(glued: Glued) -> None:
    verdict = glued.what_if().check({**BOX, 'recipe': 'BOX-8'})
    assert (verdict.accepted, verdict.is_checked) == (True, False)
    assert verdict.message == 'there is no recipe BOX-8 here'


def test_a_recipe_with_mistakes_is_told_in_short(glued: Glued) -> None:
    wrong = glue_cell.RECIPE.replace('BOX-7', 'LID-1').replace('do: close', 'do: clse')
    (glued.recipes / 'lid.yaml').write_text(wrong)
    verdict = glued.what_if().check({**BOX, 'recipe': 'LID-1'})
    assert (verdict.accepted, verdict.wrong) == (False, ())
    assert verdict.message.startswith('the recipe is refused with 1 finding: ')
    assert 'lid.yaml:7:21: no component has the capability `clse`' in verdict.message


def test_generation_omits_components_out_of_service(glued: Glued) -> None:
    assert glued.what_if('robot_a').check(BOX).accepted
    verdict = glued.what_if('robot_b').check(BOX)
    assert [mistake.field for mistake in verdict.wrong] == ['recipe']
    assert 'only robot_b could, and it is out of service' in verdict.wrong[0].what


def test_end_of_recipe_order_is_forecast(glued: Glued) -> None:
    order = order_from(BOX)
    effect = glued.what_if().ask([ask('queue.add', ann(), orders=[order])])
    assert effect.refusals == ()
    assert [name for name, _ in effect.after] == ['D']
    lost = ask('component.out_of_service', ann(), component='robot_a')
    effect = glued.what_if().ask([lost, ask('queue.add', ann(), orders=[order])])
    assert effect.refusals == (), 'generated without robot_a'
    lost = ask('component.out_of_service', ann(), component='robot_b')
    effect = glued.what_if().ask([lost, ask('queue.add', ann(), orders=[order])])
    assert 'only robot_b could, and it is out of service' in effect.refusals[0]


def outage(component: str) -> Asked:
    return ask('component.out_of_service', ann(), component=component)


def test_queued_jobs_are_made_anew_in_an_outage(glued: Glued) -> None:
    effect = glued.with_jobs(2, 3).ask([outage('robot_a')])
    assert effect.refusals == ()
    assert effect.unknown == {
        'A': 'A needs robot_a, which is out of service',
        'B': 'B waits for the release of its script',
    }
    released = ask('script.release_script', ann(), script=glued.made_without('robot_a'))
    effect = glued.with_jobs(2, 3).ask([released, outage('robot_a')])
    assert effect.unknown['B'] == 'A needs robot_a, which is out of service'
    requeue = ask('job.requeue', ann(), job='A')
    effect = glued.with_jobs(2, 3).ask([released, outage('robot_a'), requeue])
    assert effect.refusals == ()
    assert [entry.job for entry in effect.after] == ['A', 'A-rest', 'B']
    assert effect.unknown['A-rest'] == 'A needs robot_a, which is out of service'


def test_job_that_cannot_be_regenerated_says_why(glued: Glued) -> None:
    effect = glued.with_jobs(2, 3).ask([outage('robot_b')])
    assert effect.refusals == ()
    assert 'only robot_b could, and it is out of service' in effect.unknown['B']


def test_job_with_its_rest_is_compared_to_original(glued: Glued) -> None:
    effect = glued.with_jobs(8).ask([ask('job.requeue', ann(), job='A')])
    (note,) = effect.notes
    ends = dict(effect.after)['A-rest'], dict(effect.before)['A']
    assert None not in ends
    assert note == (
        f'A with A-rest ends in {ends[0]:.1f} s; without the requeue, A ends in {ends[1]:.1f} s'
    )


def test_version_change_keeps_recipe_of_job(
    glued: Glued,
) -> None:
    wanted = [
        ask('queue.add', ann(), orders=[order_from(BOX)]),
        ask('job.update', ann(), job='D', version=3),
    ]
    assert glued.what_if().ask(wanted).refusals == ()
    wanted.append(ask('job.update', ann(), job='D', bind={'glue': 'nobody'}))
    (refusal,) = glued.what_if().ask(wanted).refusals
    assert 'there is no component `nobody`' in refusal


def test_jobs_blocked_by_component_outage_have_no_end() -> None:
    with running(4.0) as simulation:
        effect = asked_of(simulation, ask('component.out_of_service', ann(), component='a2'))
        assert effect.refusals == ()
        assert None not in dict(effect.before).values()
        assert dict(effect.after) == dict.fromkeys('ABC')
