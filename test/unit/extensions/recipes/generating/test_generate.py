"""The verb `generate`, without ROS 2."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.glue_cell import CELL, RECIPE
from fakes.shipped import ROOT

from bt_orchestrator.base.errors import OrchestratorError, Refused
from bt_orchestrator.cli.door import instead_of_a_door
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.extensions.recipes.generating.file import NotReplaced
from bt_orchestrator.extensions.recipes.generating.verb import add_arguments, generate
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.orders.admission import admitted

TYPES = FakeActionTypes()
DECK = ROOT / 'recipes' / 'wm_100.yaml'
DECK_CELL = ROOT / 'config' / 'cell_with_capabilities.yaml'


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path('cell.yaml').write_text(CELL)
    Path('box.yaml').write_text(RECIPE)
    return tmp_path


def generated(
    *words: str | Path, recipe: Path = Path('box.yaml'), cell: Path | str = 'cell.yaml'
) -> int:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return generate(parser.parse_args([str(recipe), '--cell', str(cell), *map(str, words)]), TYPES)


def said(capsys: pytest.CaptureFixture[str], *words: str | Path, status: int = 0) -> str:
    capsys.readouterr()
    assert generated(*words) == status
    captured = capsys.readouterr()
    return captured.out + captured.err


def edit(file: str, old: str, new: str) -> None:
    text = Path(file).read_text()
    assert old in text
    Path(file).write_text(text.replace(old, new))


def test_choice_without_nominal_time_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    edit('cell.yaml', '{TASK_A: 4.0, TASK_B: 2.0}', '{TASK_B: 2.0}')
    assert generated('-o', 'script.yaml') == 0
    assert '`TASK_A` of `robot_b` has no nominal time' in capsys.readouterr().err


# --- the script -------------------------------------------------------------------------------


def test_the_script_of_the_deck(capsys: pytest.CaptureFixture[str]) -> None:
    assert generated(recipe=DECK, cell=DECK_CELL) == 0
    text = capsys.readouterr().out
    script = admitted(text, 'text', read_cell(DECK_CELL, TYPES), TYPES)
    assert script.made_from is not None
    assert (script.made_from.recipe, script.made_from.version) == ('WM-100', 1)
    assert (
        '    # label (print_label) by component_3b: the only one that can\n'
        '    - {id: label, task: TASK_A, action: /component_3b/task, '
        'args: {special_argument_1: "${params.label}"}}\n'
    ) in text


def test_equal_files_give_equal_bytes() -> None:
    outputs = set()
    for seed in ('0', '1', '4711'):
        program = (
            'import sys; sys.path[:0] = sys.argv[1:2]\n'
            'import argparse\n'
            'from fakes.action_types import FakeActionTypes\n'
            'from bt_orchestrator.extensions.recipes.generating import verb\n'
            'parser = argparse.ArgumentParser()\n'
            'verb.add_arguments(parser)\n'
            'sys.exit(verb.generate(parser.parse_args(sys.argv[2:]), FakeActionTypes()))\n'
        )
        words = [str(ROOT / 'test'), 'box.yaml', '--cell', 'cell.yaml']
        done = subprocess.run(
            [sys.executable, '-c', program, *words],
            env={**os.environ, 'PYTHONHASHSEED': seed},
            capture_output=True,
            check=True,
            timeout=60,
        )
        outputs.add(done.stdout)
    assert len(outputs) == 1


def test_why_each_operation_is_where_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, '--explain')
    assert 'box: 4 tasks in 4 sections, fits cell glue_cell\n  pace: ' in text
    assert '\noperation  section  component  capability  why\n' in text
    assert '\nglue       2        robot_a    glue        any other' in text
    assert 'makes the line slower; robot_b: +4 s\n' in text
    assert 'script: box' not in text


def test_all_that_is_known_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    answer = json.loads(said(capsys, '--json', '-o', 'script.yaml'))
    assert answer['text'] == Path('script.yaml').read_text()
    glue = next(task for task in answer['tasks'] if task['task'] == 'glue')
    assert (glue['component'], glue['alternatives']) == ('robot_a', ['robot_b'])
    assert answer['per_item_s'] == answer['pace']['per_item_s'] == 3.0
    assert answer['made_from']['version'] == 3
    assert (answer['bound_s'], answer['gap']) == (3.0, 0.0)
    assert 'prices' not in answer
    (price,) = json.loads(said(capsys, '--json', '--explain'))['prices']['glue']
    assert (price['component'], price['more_s'], price['words']) == ('robot_b', 4.0, '+4 s')


# --- files ------------------------------------------------------------------------------------


def test_a_file_is_checked_and_written_again(capsys: pytest.CaptureFixture[str]) -> None:
    assert said(capsys, '-o', 'script.yaml').startswith('script.yaml written\nbox: 4 tasks')
    assert said(capsys, '--check', 'script.yaml') == 'script.yaml is what box.yaml gives\n'
    assert said(capsys, '--diff', 'script.yaml') == ''
    edit('box.yaml', 'version: 3', 'version: 4')
    output = said(capsys, '--check', 'script.yaml', status=1)
    assert 'script.yaml is out of date: it is of version 3 of the recipe; 4 lines differ' in output
    assert '+  version: 4\n' in said(capsys, '--diff', 'script.yaml', status=1)
    edit('cell.yaml', 'TASK_A: 4.0', 'TASK_A: 4.5')
    edit('box.yaml', '{id: close, do: close}', '{id: close, do: close, retries: 1}')
    output = said(capsys, '--check', 'script.yaml', status=1)
    assert 'it is of version 3 of the recipe, the cell changed' in output
    said(capsys, '-o', 'script.yaml')
    said(capsys, '--check', 'script.yaml')
    edit('box.yaml', 'retries: 1', 'retries: 2')
    output = said(capsys, '--check', 'script.yaml', status=1)
    assert 'the recipe changed, and still calls itself version 4' in output


def test_what_was_edited_by_hand_is_not_lost(capsys: pytest.CaptureFixture[str]) -> None:
    said(capsys, '-o', 'script.yaml')
    edit('script.yaml', 'action: /robot_b/task', 'action: /robot_b/task, retries: 3')
    message = (
        'script.yaml was edited by hand (1 line differs); put them into overrides, or give '
        'another -o'
    )
    assert said(capsys, '--check', 'script.yaml', status=1) == f'{message}\n'
    with pytest.raises(NotReplaced) as refused:
        generated('-o', 'script.yaml')
    assert str(refused.value) == message
    edit('cell.yaml', 'TASK_A: 4.0', 'TASK_A: 4.5')
    with pytest.raises(NotReplaced, match='was edited by hand; put them into overrides'):
        generated('-o', 'script.yaml')
    assert 'retries: 3' in Path('script.yaml').read_text()
    Path('other.yaml').write_text('script: mine\nsections: {}\n')
    with pytest.raises(NotReplaced, match=r'other\.yaml is there and was not generated'):
        generated('-o', 'other.yaml')
    with pytest.raises(NotReplaced, match=r'cell\.yaml is there and is no script'):
        generated('-o', 'cell.yaml')
    with pytest.raises(NotReplaced, match=r'cannot write nowhere/script\.yaml: No such file'):
        generated('-o', 'nowhere/script.yaml')


def test_ends_of_lines_are_no_edit(capsys: pytest.CaptureFixture[str]) -> None:
    said(capsys, '-o', 'script.yaml')
    path = Path('script.yaml')
    path.write_bytes(path.read_bytes().replace(b'\n', b'\r\n'))
    said(capsys, '--check', 'script.yaml')


# --- overrides, outages -----------------------------------------------------------------------


def test_overrides_are_kept(capsys: pytest.CaptureFixture[str]) -> None:
    Path('box.overrides.yaml').write_text('bind: {glue: robot_b}\nset: {close: {timeout: 20.0}}\n')
    text = said(capsys, '--overrides', 'box.overrides.yaml')
    assert '# glue by robot_b: bound by override\n' in text
    assert 'task: TASK_B, action: /robot_b/task, timeout: 20.0' in text
    assert 'overrides_digest: ' in text


def test_as_little_as_possible_is_moved(capsys: pytest.CaptureFixture[str]) -> None:
    Path('box.overrides.yaml').write_text('bind: {glue: robot_b}\n')
    said(capsys, '-o', 'old.yaml', '--overrides', 'box.overrides.yaml')
    text = said(capsys, '-o', 'new.yaml', '--keep', 'old.yaml')
    assert '  0 operations elsewhere than in old.yaml, 7.0 s for each item\n' in text
    assert '  without --keep: 1 operation elsewhere, 3.0 s for each item\n' in text


def test_keeping_generated_script_changes_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    said(capsys, '-o', 'old.yaml')
    said(capsys, '-o', 'new.yaml', '--keep', 'old.yaml')
    assert Path('new.yaml').read_text() == Path('old.yaml').read_text()


def test_what_comes_of_each_outage(capsys: pytest.CaptureFixture[str]) -> None:
    lines = said(capsys, '--without-each').splitlines()
    assert lines == [
        'all in service  3.0 s per item',
        'loader          not to be made: load only there',
        'robot_a         7.0 s per item (+133 %), 1 operation elsewhere',
        'robot_b         not to be made: close only there',
        'packer          not to be made: pack only there',
    ]
    answer = json.loads(said(capsys, '--without-each', '--json'))
    (robot_a,) = (outage for outage in answer['without'] if outage['component'] == 'robot_a')
    assert (robot_a['per_item_s'], robot_a['elsewhere']) == (7.0, ['glue'])
    assert '# Without robot_a.\n' in said(capsys, '--without', 'robot_a')


# --- mistakes ---------------------------------------------------------------------------------


class Door:
    """A node that is asked, and does it."""

    def __init__(self) -> None:
        self.asked: list[Asked] = []

    def __enter__(self) -> Door:
        return self

    def __exit__(self, *_: object) -> None: ...

    def ask(self, asked: Asked) -> Answer:
        self.asked.append(asked)
        return Answer(accepted=True, message='it is released')


RELEASE = ('--release', '--reason', 'read it')


def test_what_stands_in_a_file_is_released(capsys: pytest.CaptureFixture[str]) -> None:
    door = Door()
    with instead_of_a_door(door):
        assert 'it is released' in said(capsys, '-o', 'script.yaml', *RELEASE)
        assert 'it is released' in said(capsys, '--check', 'script.yaml', *RELEASE)
        (_, asked) = door.asked
        cell = read_cell(Path('cell.yaml'), TYPES)
        script = admitted(Path('script.yaml').read_text(), 'script.yaml', cell, TYPES)
        assert asked.request.name == 'script.release_script'
        assert asked.arguments == {'script': digest(script), 'cell_digest': digest(cell)}
        edit('script.yaml', 'pack by', 'packed by')
        said(capsys, '--check', 'script.yaml', *RELEASE, status=1)
    assert len(door.asked) == 2, 'what is not what the recipe gives is not released'


@pytest.mark.parametrize(
    ('words', 'why'),
    [
        ((*RELEASE,), 'goes with -o FILE or --check FILE'),
        (('-o', 'script.yaml', '--json', *RELEASE), 'without --json'),
        (('-o', 'script.yaml', '--release'), '--release needs --reason'),
    ],
)
def test_a_release_needs_a_file_and_a_reason(words: tuple[str, ...], why: str) -> None:
    with pytest.raises(WrongUse, match=why):
        generated(*words)
    assert not Path('script.yaml').exists()


def test_why_there_is_no_script(capsys: pytest.CaptureFixture[str]) -> None:
    output = said(capsys, '--without', 'robot_b', status=1)
    assert output == 'box.yaml: `close`: only robot_b could, and it is out of service\n'
    answer = json.loads(said(capsys, '--without', 'robot_b', '--json', status=1))
    assert (answer['ok'], answer['proven']) == (False, True)
    with pytest.raises(WrongUse, match='has no component robot_x; did you mean `robot_'):
        generated('--without', 'robot_x')


def test_mistakes_in_files(capsys: pytest.CaptureFixture[str]) -> None:
    edit('box.yaml', 'do: glue', 'do: glueing')
    with pytest.raises(Refused) as refused:
        generated()
    (finding,) = refused.value.findings
    assert 'did you mean `glue`?' in str(finding)
    assert json.loads(said(capsys, '--json', status=1))['ok'] is False
    with pytest.raises(Refused, match=r'none\.yaml:1:1: the file does not exist'):
        generated(recipe=Path('none.yaml'))


# --- what is likely ---------------------------------------------------------------------------


def test_likelihood_is_written_and_keeps_script_digest(
    capsys: pytest.CaptureFixture[str],
) -> None:
    retries = 'do: glue, on_failure: continue, retries: 2'
    edit('box.yaml', 'do: glue', retries)
    plain = said(capsys)
    edit('box.yaml', retries, f'{retries}, likely: 0.2')
    text = said(capsys)
    assert 'retries: 2, likely: {fails: 0.2}}' in text
    made, before = (
        admitted(doc, 'text', read_cell(Path('cell.yaml'), TYPES), TYPES) for doc in (text, plain)
    )
    assert made.likely != before.likely
    assert digest(made) == digest(before)
    assert made.made_from is not None
    assert made.made_from.says_the_same(before.made_from)
    output = said(capsys, '--explain')
    assert '  expected: ' in output
    assert 'glue fails 20 % of its attempts' in output
    answer = json.loads(said(capsys, '--json'))
    expected = answer['pace']['expected']
    # The beat is 3 s with one attempt, and 2 s more with each further one.
    mean_s = 3.0 + 2.0 * (0.2 + 0.04)
    assert expected['per_item_s'] == pytest.approx(mean_s, abs=2 * expected['sure_s'])


GRIPPING = """\
cell: gripping_cell
release: automatic
conveyor: {sections: 3, action: /conveyor/index, task: MOVE_ONE_INDEX,
  type: bt_orchestrator_interfaces/action/Conveyor}
components:
  loader:
    section: 1
    action: /loader/task
    type: bt_orchestrator_interfaces/action/UnpackingArm
    capabilities: {load: {task: PLACE_AT_CONVEYOR, qty_change: 1}}
  arm:
    section: 2
    action: /arm/task
    type: bt_orchestrator_interfaces/action/Component
    setups: {gripper: [small, large]}
    changes: {gripper: {task: TASK_C, argument: special_argument_1}}
    prepare: {id: ready_arm, task: PREPARE}
    capabilities:
      lift: {task: TASK_A, setup: {gripper: large}}
      press: {task: TASK_B, setup: {gripper: small}}
  packer:
    section: 3
    action: /packer/task
    type: bt_orchestrator_interfaces/action/PackingArm
    capabilities: {pack: {task: PICK_AND_PACK, qty_change: -1, runs_for: all}}
"""
LIFTED = """\
recipe: L
version: 1
script: lifted
operations: [{id: load, do: load}, {id: lift, do: lift}, {id: pack, do: pack}]
"""


def test_generated_script_contains_capability_setups() -> None:
    Path('cell.yaml').write_text(GRIPPING)
    Path('box.yaml').write_text(LIFTED)
    assert generated('-o', 'lifted.yaml') == 0
    text = Path('lifted.yaml').read_text()
    assert 'task: TASK_A, action: /arm/task, setup: {gripper: large}}' in text
    assert 'arm.gripper.large' not in text
    cell = read_cell(Path('cell.yaml'), TYPES)
    script = admitted(text, 'lifted.yaml', cell, TYPES)
    assert [task.id for task in script.initialization] == ['ready_arm', 'arm.gripper.large']


CHANGED = """\
recipe: L
version: 1
script: changed
operations:
  - {id: load, do: load}
  - {id: lift, do: lift}
  - {id: to_small, do: take_small}
  - {id: press, do: press}
  - {id: to_large, do: take_large}
  - {id: pack, do: pack}
"""
CHANGES = """\
      take_small: {task: TASK_C, args: {special_argument_1: small}, runs_for: all}
      take_large: {task: TASK_C, args: {special_argument_1: large}, runs_for: all}
"""


def test_operations_may_change_the_setup_between_others(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A change in the middle of a script is an ordinary task, in a recipe as well."""
    press = '      press: {task: TASK_B, setup: {gripper: small}}\n'
    Path('cell.yaml').write_text(GRIPPING.replace(press, press + CHANGES))
    Path('box.yaml').write_text(CHANGED)
    text = said(capsys)
    script = admitted(text, 'changed.yaml', read_cell(Path('cell.yaml'), TYPES), TYPES)
    assert [task.id for task in script.sections[2].tasks] == [
        *('lift', 'to_small', 'press', 'to_large')
    ]
    assert [task.change.on_demand for task in script.initialization if task.change] == [
        *(False, True)
    ]


def test_conflicting_setups_of_component_are_refused() -> None:
    Path('cell.yaml').write_text(GRIPPING)
    Path('box.yaml').write_text(LIFTED.replace('{id: pack', '{id: press, do: press}, {id: pack'))
    with pytest.raises(
        OrchestratorError, match='`lift` needs gripper large of `arm`, and `press`'
    ):
        generated('-o', 'lifted.yaml')
    assert not Path('lifted.yaml').exists()
