"""What becomes of a recipe: lists, flags, zones, values, initialization."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from fakes.planned import ENDS, TYPES, cell_of, lists, made_of, recipe_of

from bt_orchestrator.extensions.recipes.generating.making import moved as elsewhere
from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.extensions.recipes.planning.outcome import Impossible, Why
from bt_orchestrator.model.recipe import Overrides
from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.model.script import Dependency, Release, Repeat, RunsFor, Script, Zone
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.store.memory import MemoryStore

DRILL = {'drill_a': 'section: 2, capabilities: {drill: {task: TASK_A}}'}
PRESS = {'press_a': 'section: 3, capabilities: {press: {task: TASK_B}}'}
LINE = {**ENDS, **DRILL, **PRESS}

STEPS = """
- {id: place, do: put}
- {id: bore, do: drill}
- {id: fit, do: press}
- {id: box, do: pack}
"""


def why_not(*args: object, **more: object) -> str:
    with pytest.raises(Impossible) as why:
        made_of(*args, **more)  # type: ignore[arg-type]
    return str(why.value)


# --- lists ------------------------------------------------------------------------------------


def test_8_5_operations_go_down_the_belt() -> None:
    result = made_of(LINE, STEPS)
    assert lists(result.script) == {1: ['place'], 2: ['bore'], 3: ['fit'], 4: ['box']}
    assert result.claim.is_fastest
    assert str(result.claim) == '2.0 s for each item, proven fastest'


def test_8_5_what_needs_no_belt_leads() -> None:
    result = made_of(
        {
            **LINE,
            'fetcher': 'section: 2, '
            'capabilities: {fetch: {task: TASK_C, requires_conveyor: false}}',
        },
        STEPS + '- {id: get, do: fetch, after: []}',
    )
    assert lists(result.script)[2] == ['get', 'bore']
    assert result.script.sections[2].release is Release.END_OF_CYCLE


CLEANER = {
    **LINE,
    'cleaner': 'section: 2, capabilities: {clean: {task: TASK_C, requires_conveyor: false}}',
}


def test_8_5_trailing_task_releases_belt_early() -> None:
    result = made_of(CLEANER, STEPS + '- {id: tidy, do: clean, after: [bore]}')
    assert lists(result.script)[2] == ['bore', 'tidy']
    assert result.script.sections[2].release is Release.AFTER_LAST_CONVEYOR_TASK


@pytest.mark.parametrize('more', ['on_failure: reject', 'after: [bore]'])
def test_8_5_belt_waits_for_rejecting_or_required_tasks(more: str) -> None:
    """A trail that may reject is a mistake, and the item of one that is built on has left."""
    rejects = more.startswith('on_failure')
    steps = STEPS.replace(
        'do: press', 'do: press, after: [bore]' if rejects else 'do: press, after: [tidy]'
    )
    after = f'{more}, after: [bore]' if rejects else more
    result = made_of(CLEANER, steps + f'- {{id: tidy, do: clean, {after}}}')
    assert lists(result.script)[2] == ['bore', 'tidy']
    assert result.script.sections[2].release is Release.END_OF_CYCLE


def test_8_5_rejecting_task_does_not_trail_if_avoidable() -> None:
    result = made_of(
        {
            **CLEANER,
            'camera': 'section: 2, capabilities: {look: {task: TASK_A, requires_conveyor: false}}',
            'marker': 'section: 2, capabilities: {mark: {task: TASK_A}}',
        },
        STEPS.replace('do: press', 'do: press, after: [bore]')
        + '- {id: see, do: look, after: [bore], on_failure: reject}\n'
        + '- {id: sign, do: mark, after: [place]}\n'
        + '- {id: tidy, do: clean, after: [bore]}',
    )
    assert lists(result.script)[2] == ['bore', 'see', 'sign', 'tidy']
    assert result.script.sections[2].release is Release.AFTER_LAST_CONVEYOR_TASK


@pytest.mark.parametrize(
    ('left', 'right', 'expected'),
    [
        ('workspaces: [left], ', 'workspaces: [right], ', [[['bore'], ['fit']]]),
        ('workspaces: [left], ', 'workspaces: [left], ', ['bore', 'fit']),
        ('workspaces: [left], ', '', ['bore', 'fit']),
        ('', '', ['bore', 'fit']),
    ],
)
def test_8_5_only_different_workspaces_run_side_by_side(
    left: str, right: str, expected: list[object]
) -> None:
    result = made_of(
        {
            **ENDS,
            'drill_a': f'section: 2, {left}capabilities: {{drill: {{task: TASK_A}}}}',
            'press_a': f'section: 2, {right}capabilities: {{press: {{task: TASK_A}}}}',
        },
        STEPS.replace('do: press', 'do: press, after: [place]'),
    )
    assert lists(result.script)[2] == expected


# --- rejected items ---------------------------------------------------------------------------


def test_8_5_rejecting_task_makes_removal_run_for_all() -> None:
    assert made_of(LINE, STEPS).script.tasks['box'].runs_for is RunsFor.GOOD
    steps = STEPS.replace('do: drill', 'do: drill, on_failure: reject')
    assert made_of(LINE, steps).script.tasks['box'].runs_for is RunsFor.ALL


def test_8_5_item_rejected_after_removal_makes_plan_impossible() -> None:
    binned = {**LINE, 'bin': 'section: 2, capabilities: {drop: {task: TASK_B, qty_change: -1}}'}
    steps = STEPS.replace('do: press', 'do: press, on_failure: reject')
    text = steps.replace('- {id: fit', '- {id: out, do: drop, runs_for: rejected}\n- {id: fit')
    assert why_not(binned, text) == 'an item that `fit` rejects is never taken out'


# --- repeats ----------------------------------------------------------------------------------

JUDGED = {
    **LINE,
    'probe': 'section: [2, 3], workspaces: [probe], '
    'capabilities: {look: {task: TASK_A, gives: {ok: item_present}}}',
}
AGAIN = """
- {id: place, do: put}
- repeat:
    - {id: fit, do: press}
    - {id: see, do: look, fails_unless: "${results.see.ok}"}
  times: 2
- {id: box, do: pack}
"""


def test_8_5_repeated_operations_form_one_step() -> None:
    result = made_of(JUDGED, AGAIN)
    assert result.script.repeats == (Repeat(('fit', 'see'), 2),)
    (step,) = result.script.sections[3].steps
    assert [[task.id for task in track] for track in step.tracks] == [['fit', 'see']]
    assert result.made['see'].why is Why.ONLY


def test_8_5_repeated_operations_need_one_common_section() -> None:
    far = {**JUDGED, 'probe': JUDGED['probe'].replace('[2, 3]', '2')}
    assert why_not(far, AGAIN) == 'no section has components for all of `fit`, `see`, which repeat'


def test_8_5_what_a_device_keeps_is_not_repeated() -> None:
    steps = MEASURE.replace(
        '- {id: fit, do: press, needs: {depth: gauge_it}}',
        '- repeat:\n'
        '    - {id: fit, do: press, needs: {depth: gauge_it}}\n'
        '    - {id: see, do: look, fails_unless: "${results.see.ok}"}',
    )
    assert why_not({**MEASURED, 'probe': JUDGED['probe']}, steps) == (
        'no device can keep `depth` of `gauge_it` for `fit`: one keeps it for one operation, for '
        'so many sections as it has room, and not in a repeat'
    )


# --- what sections share ----------------------------------------------------------------------


def test_8_5_a_workspace_of_two_sections_is_a_zone() -> None:
    result = made_of(
        {
            **ENDS,
            'drill_a': 'section: 2, workspaces: [table], capabilities: {drill: {task: TASK_A}}',
            'press_a': 'section: 3, workspaces: [table], capabilities: {press: {task: TASK_A}}',
        },
        STEPS,
    )
    assert result.script.zones == (Zone('table', ('bore', 'fit')),)
    assert result.claim.pace.not_counted == ('waits for zone table',)
    assert result.claim.judged_s is not None
    assert result.claim.judged_s >= result.claim.pace.per_item_s


MEASURED = {
    **ENDS,
    'gauge': 'section: 2, capabilities: {measure: {task: TASK_A, holds: {depth: 1}}}',
    'press_a': 'section: 3, capabilities: {press: {task: TASK_A, needs: {depth: none}}}',
}
MEASURE = """
- {id: place, do: put}
- {id: gauge_it, do: measure}
- {id: fit, do: press, needs: {depth: gauge_it}}
- {id: box, do: pack}
"""


def test_8_5_flag_is_named_after_data_holding_device() -> None:
    script = made_of(MEASURED, MEASURE).script
    assert script.dependencies == (Dependency('gauge', 'gauge_it', 'fit', 1),)
    assert script.tasks['fit'].args == {}


def test_8_5_the_search_binds_near_enough() -> None:
    """The quicker press is too far from the gauge."""
    two = {
        **MEASURED,
        'press_b': 'section: 4, durations: {TASK_A: 0.1}, '
        'capabilities: {press: {task: TASK_A, needs: {depth: none}}}',
    }
    result = made_of(two, MEASURE)
    assert result.made['fit'].component == 'press_a'
    assert result.made['fit'].why is Why.ONLY


def test_8_5_each_data_holding_device_has_own_flag() -> None:
    """Two devices that keep data, one behind the other."""
    cell = {
        **ENDS,
        'gauge': 'section: 2, capabilities: {measure: {task: TASK_A, holds: {depth: 1}}}',
        'sink': 'section: 3, capabilities: {press: {task: TASK_A, needs: {depth: none}}, '
        'note: {task: TASK_B, holds: {mark: 1}}}',
        'reader': 'section: 4, capabilities: {read: {task: TASK_C, needs: {mark: none}}}',
    }
    steps = """
    - {id: place, do: put}
    - {id: gauge_it, do: measure}
    - {id: noted, do: note}
    - {id: fit, do: press, needs: {depth: gauge_it}}
    - {id: seen, do: read, needs: {mark: noted}}
    - {id: box, do: pack}
    """
    result = made_of(cell, steps)
    assert {dependency.flag for dependency in result.script.dependencies} == {'gauge', 'sink'}


ARM = {
    **ENDS,
    'arm': 'section: [2, 3], workspaces: [arm], '
    'capabilities: {drill: {task: TASK_A}, press: {task: TASK_B}}',
}


class Says:
    """A judge who always says the same."""

    def __init__(self, seconds: float | None) -> None:
        self._s = seconds

    def pace_s(self, script: Script) -> float | None:
        return self._s


@pytest.mark.parametrize(('split_s', 'expected'), [(2.5, 1), (9.0, 2), (None, 2)])
def test_8_5_the_engine_decides_where_sections_share_something(
    split_s: float | None, expected: int
) -> None:
    """On paper it is quicker to share the arm: 2 s an item, and 3 s if it stays where it is."""
    result = made_of(ARM, STEPS, judge=Says(split_s))
    work = [tasks for number, tasks in lists(result.script).items() if number in {2, 3}]
    assert max(map(len, work)) == expected
    assert result.claim.per_item_s == (split_s if expected == 1 else 3.0)
    assert not result.claim.is_fastest  # the one that is quicker on paper is not


# --- values -----------------------------------------------------------------------------------


def test_8_5_results_are_named_as_the_component_calls_them() -> None:
    script = made_of(
        {
            **ENDS,
            'scale': 'section: 2, capabilities: '
            '{weigh: {task: TASK_A, gives: {kg: measurement, ok: item_present}}}',
            'press_a': 'section: 3, capabilities: '
            '{press: {task: TASK_B, args: {special_argument_1: hard}, '
            'needs: {kg: special_argument_2}}}',
        },
        """
        - {id: place, do: put}
        - {id: w, do: weigh, fails_unless: {value: "${results.w.kg}", at_least: 2.0}}
        - {id: fit, do: press, needs: {kg: w}, when: "${results.w.ok}"}
        - {id: box, do: pack}
        """,
    ).script
    args = {name: str(value) for name, value in script.tasks['fit'].args.items()}
    assert args == {
        'special_argument_1': 'hard',
        'special_argument_2': '${results.w.measurement}',
    }
    assert str(script.tasks['fit'].condition) == 'when ${results.w.item_present}'
    verdict = script.tasks['w'].fails_unless
    assert verdict is not None
    assert verdict.words == '${results.w.measurement} at least 2.0'


@pytest.mark.parametrize(
    ('capability', 'operation'),
    [
        ('{task: READ, gives: {code: serial}}', 'do: read, identifies: code'),
        ('{task: READ, identifies: serial}', 'do: read'),
    ],
)
def test_8_5_serial_is_field_of_reading_component(capability: str, operation: str) -> None:
    """A recipe calls it by what the capability gives; a capability by the field."""
    eye = 'type: bt_orchestrator_interfaces/action/Reader'
    result = made_of(
        {**LINE, 'eye': f'section: 2, {eye}, capabilities: {{read: {capability}}}'},
        STEPS + f'- {{id: look, {operation}, after: place}}',
    )
    assert result.script.tasks['look'].identifies == ('serial',)


def test_8_5_lots_are_those_of_the_recipe() -> None:
    cell = cell_of(LINE)
    made = recipe_of(cell, STEPS, 'lots: {box: "${order.id}"}\n')
    script = generate(cell, made, judge=PaceJudge(cell, TYPES, MemoryStore)).script
    assert script.lots == {'box': Template((Reference('order', 'id'),))}


def test_8_5_used_preparations_bring_their_predecessors() -> None:
    script = made_of(
        {
            **LINE,
            'drill_a': f'{DRILL["drill_a"]}, prepare: {{id: ready, task: PREPARE, after: gantry}}',
            'gantry': 'section: 3, prepare: {id: park, task: PREPARE, after: conveyor}',
            'idle': 'section: 3, prepare: {id: unused, task: PREPARE}',
        },
        STEPS,
    ).script
    assert [task.id for task in script.initialization] == ['home', 'ready', 'park']
    order = [(edge.upstream, edge.downstream) for edge in script.initialization_dependencies]
    assert order == [('park', 'ready'), ('home', 'park')]


# --- what an engineer decides -----------------------------------------------------------------

TWICE = {
    **LINE,
    'drill_b': 'section: 3, durations: {TASK_A: 0.5}, capabilities: {drill: {task: TASK_A}}',
}


def test_8_5_overrides_bind_set_and_order() -> None:
    steps = STEPS.replace('do: press', 'do: press, after: [place]')
    free = made_of(TWICE, steps)
    assert free.made['bore'].component == 'drill_a'
    assert free.made['bore'].why is Why.PACE
    assert free.made['bore'].alternatives == ('drill_b',)
    text = 'bind: {bore: drill_b}\nset: {bore: {timeout: 7.0}}\norder: [[fit, bore]]'
    result = made_of(TWICE, steps, overrides=text)
    assert result.made['bore'].component == 'drill_b'
    assert result.made['bore'].why is Why.OVERRIDE
    assert result.script.tasks['bore'].timeout_s == 7.0
    assert lists(result.script)[3] == ['fit', 'bore']


def test_8_5_orders_that_contradict_the_recipe_are_told() -> None:
    cell = cell_of(TWICE)
    order = Overrides(order=(('fit', 'bore'),))
    with pytest.raises(Impossible) as why:
        generate(cell, recipe_of(cell, STEPS), order, judge=Says(1.0))
    assert (
        str(why.value)
        == 'operations wait for each other: bore, fit, bore; remove one of the waits'
    )


def test_8_5_alternative_replaces_component_out_of_service() -> None:
    result = made_of(TWICE, STEPS, without='drill_a')
    assert result.made['bore'].component == 'drill_b'
    reason = why_not(TWICE, STEPS, without='drill_a drill_b')
    assert reason == '`bore`: only drill_a or drill_b could, and they are out of service'
    assert why_not(LINE, STEPS, without='press_a') == (
        '`fit`: only press_a could, and it is out of service'
    )


def test_8_5_script_is_kept_as_far_as_possible() -> None:
    """Without it the drill that spreads the load is taken again."""
    old = made_of(TWICE, STEPS, overrides='bind: {bore: drill_b}').script
    anew, kept = made_of(TWICE, STEPS), made_of(TWICE, STEPS, keep=old)
    assert anew.made['bore'].component == 'drill_a'
    assert kept.made['bore'].component == 'drill_b'
    assert kept.made['bore'].why is Why.KEPT
    assert elsewhere(old, kept) == ()
    moved = made_of(TWICE, STEPS, keep=old, without='drill_b')
    assert elsewhere(old, moved) == ('bore',)


def test_8_5_a_kept_script_keeps_its_components() -> None:
    twins = {**LINE, 'drill_b': LINE['drill_a']}
    old = made_of(twins, STEPS, overrides='bind: {bore: drill_b}').script
    assert made_of(twins, STEPS).made['bore'].component == 'drill_a'
    assert made_of(twins, STEPS, keep=old).made['bore'].component == 'drill_b'


# --- the same in every run --------------------------------------------------------------------

DIGEST = """
from fakes.drawn.recipes import DrawnRecipe
from bt_orchestrator.model.codec import digest
from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.extensions.recipes.planning.outcome import NotMade
from mixes.drawn import mix

class Judge:
    def pace_s(self, script):
        return float(len(script.zones))

for seed in range(12):
    drawn = DrawnRecipe(seed)
    try:
        made = generate(drawn.cell, drawn.recipe, judge=Judge())
        print(digest(made.script), made.claim, *made.made.values())
    except NotMade as why:
        print(why)
for line in [mix(13)] + [mix(4)] * 4:
    made = generate(line.cell, line.recipe, judge=Judge())
    print(digest(made.script), made.claim, *made.made.values())
"""


def test_8_5_equal_inputs_give_equal_scripts_whatever_the_hashes() -> None:
    paths = os.pathsep.join(str(Path(__file__).parents[4 + up]) for up in (0, 1))

    def printed(hash_seed: str) -> str:
        env = {**os.environ, 'PYTHONHASHSEED': hash_seed, 'PYTHONPATH': paths}
        done = subprocess.run(
            [sys.executable, '-c', DIGEST], env=env, capture_output=True, text=True, check=True
        )
        return done.stdout

    texts = {printed(seed) for seed in ('0', '1', '4711')}
    (text,) = texts
    assert len({*text.splitlines()[-4:]}) == 1, 'twelve runs in all'
