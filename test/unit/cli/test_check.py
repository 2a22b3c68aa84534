"""The verb `check`, without ROS 2."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.glue_cell import CELL as GLUE_CELL
from fakes.glue_cell import RECIPE
from fakes.line import Line, expanded, with_section
from fakes.script_texts import CELL
from fakes.script_texts import LINE as GOOD_ONLY
from fakes.shipped import REFERENCE_CELL, ROOT, STUCK, TREES

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.cli.check import add_arguments, check

GEAR_MOTOR = ROOT / 'recipes' / 'gear_motor.yaml'
GEAR_MOTOR_CELL = ROOT / 'config' / 'gear_motor_cell.yaml'
TYPES = FakeActionTypes()
LINE = GOOD_ONLY.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
FITS = 'fits cell reference_cell'
WAITS = 'waits for zone shared_table not counted'
CIRCLE = 'assemble + inspect + index move (flag camera_read)'


def checked(*words: str | Path, cell: Path = REFERENCE_CELL) -> int:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return check(parser.parse_args([*map(str, words), '--cell', str(cell)]), TYPES)


def mistakes(*words: str | Path, cell: Path = REFERENCE_CELL) -> list[str]:
    with pytest.raises(Refused) as refused:
        checked(*words, cell=cell)
    return [str(finding) for finding in refused.value.findings]


@pytest.fixture
def bad(tmp_path: Path) -> Path:
    path = tmp_path / 'bad.yaml'
    path.write_text(STUCK.read_text().replace('TASK_A', 'TASKA'))
    return path


def test_a_script_that_fits_is_summed_up(capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(TREES / 'reference_process.yaml', TREES / 'inspect_and_assemble.yaml') == 0
    assert capsys.readouterr().out.splitlines() == [
        f'reference_process: 9 tasks in 5 sections and 3 of initialization, {FITS}',
        '  pace: 6.5 s per item, limited by 4.1 + 4.2 + 4.3 + 4.4 + index move',
        '  Without 4.3 the pace would be 5.0 s per item, limited by 2.1 + index move.',
        f'inspect_and_assemble: 8 tasks in 5 sections and 1 of initialization, {FITS}',
        f'  pace: 7.5 s per item or longer ({WAITS}), limited by {CIRCLE}',
        '  Without inspect the pace would be 4.5 s per item, limited by assemble + index move.',
        (
            '  With capacity 2 of flag camera_read the pace would be 5.0 s per item, '
            'limited by inspect + index move.'
        ),
    ]


def test_recipes_are_checked_against_cell_capabilities(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert checked(GEAR_MOTOR, cell=GEAR_MOTOR_CELL) == 0
    assert capsys.readouterr().out == (
        'GM-37, version 3: 31 operations, cell gear_motor_line can do each, '
        '9 of them in more than one way\n'
    )
    assert checked(GEAR_MOTOR, '--json', cell=GEAR_MOTOR_CELL) == 0
    (recipe,) = json.loads(capsys.readouterr().out)['recipes']
    assert recipe == {'recipe': 'GM-37', 'version': 3, 'operations': 31, 'with_choice': 9}


def test_recipe_and_script_mistakes_are_reported_together(bad: Path) -> None:
    lines = mistakes(GEAR_MOTOR, bad)
    assert any('gear_motor.yaml:13:28: no component has the capability' in line for line in lines)
    assert any('bad.yaml' in line and 'no task `TASKA`' in line for line in lines)


def test_deck_recipe_fits_cell_with_capabilities(
    capsys: pytest.CaptureFixture[str],
) -> None:
    cell = ROOT / 'config' / 'cell_with_capabilities.yaml'
    assert checked(ROOT / 'recipes' / 'wm_100.yaml', cell=cell) == 0
    assert capsys.readouterr().out == (
        'WM-100, version 1: 9 operations, cell reference_cell can do each\n'
    )


def test_the_pace_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(TREES / 'inspect_and_assemble.yaml', '--json') == 0
    (pace,) = json.loads(capsys.readouterr().out)['paces']
    assert pace == {
        'script': 'inspect_and_assemble',
        'per_item_s': 7.5,
        'least_s': 7.5,
        'exact': False,
        'not_counted': ['waits for zone shared_table'],
        'limit': {
            'words': CIRCLE,
            'tasks': ['assemble', 'inspect'],
            'belt_moves': True,
            'items': 1,
            'flags': ['camera_read'],
            'only_one': '',
        },
        'quicker': {
            'task': 'inspect',
            'by_s': 3.0,
            'per_item_s': 4.5,
            'limit': {
                'words': 'assemble + index move',
                'tasks': ['assemble'],
                'belt_moves': True,
                'items': 1,
                'flags': [],
                'only_one': '',
            },
        },
        'roomier': {
            'flag': 'camera_read',
            'capacity': 2,
            'per_item_s': 5.0,
            'limit': {
                'words': 'inspect + index move',
                'tasks': ['inspect'],
                'belt_moves': True,
                'items': 1,
                'flags': [],
                'only_one': '',
            },
        },
        'expected': None,
    }


def test_what_is_likely_gives_an_expected_pace(capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(TREES / 'rework_by_weight.yaml') == 0
    *_, first, second = capsys.readouterr().out.splitlines()
    assert first == '  expected: 5.76 s per item (± 0.06 s)'
    assert second == '    over 1000 items in virtual time: weigh fails 10 % of its attempts'
    assert checked(TREES / 'rework_by_weight.yaml', '--json') == 0
    (pace,) = json.loads(capsys.readouterr().out)['paces']
    expected = pace['expected']
    assert expected['per_item_s'] == pytest.approx(5.76, abs=0.005)
    assert expected['rates'] == [{'task': 'weigh', 'what': 'fails', 'share': 0.1, 'of': None}]
    assert (expected['items'], expected['always'], expected['holds']) == (1000, [], 0)


def test_script_names_resolve_in_given_folders(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert checked('reference_process', '--trees', STUCK.parent, '--trees', TREES) == 0
    assert capsys.readouterr().out.startswith('reference_process: ')


def test_stuck_script_is_refused_at_flag_declaration() -> None:
    (error,) = mistakes(STUCK)
    assert error.startswith(f'{STUCK}:14:5: the line gets stuck with stuck, at item 4 in beat 3: ')
    assert 'section 2 is waiting for assemble to take flag read_before_assemble' in error
    assert 'section 4 is waiting for an item' in error
    assert 'belt is waiting for section 2 to finish with item 2' in error
    assert error.endswith('; capacity 2 of flag read_before_assemble frees it')


def test_the_mistakes_of_all_scripts_are_told(bad: Path, tmp_path: Path) -> None:
    missing = tmp_path / 'missing.yaml'
    findings = mistakes(bad, STUCK, missing)

    assert len(findings) == 4
    assert all(line.startswith(f'{bad}:') and 'TASKA' in line for line in findings[:2])
    assert findings[2].startswith(f'{STUCK}:14:5: the line gets stuck')
    assert findings[3].startswith(f'{missing}:1:1: there is no script file')


def test_the_mistakes_of_the_cell_are_told_too(tmp_path: Path) -> None:
    cell = tmp_path / 'cell.yaml'
    cell.write_text(REFERENCE_CELL.read_text().replace('section: 2', 'section: 6'))
    nowhere = tmp_path / 'nowhere.yaml'
    findings = mistakes(STUCK, nowhere, cell=cell)

    assert [line.split(':')[0] for line in findings] == [str(cell), str(nowhere)]
    assert 'section 6 is not on the belt' in findings[0]


def test_findings_as_json(bad: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(bad, '--json') == 1
    answer = json.loads(capsys.readouterr().out)

    assert answer['ok'] is False
    assert answer['findings'][0]['file'] == str(bad)
    assert answer['findings'][0]['line'] == 8
    assert set(answer['findings'][0]) == {'file', 'line', 'column', 'what', 'hint'}


def test_no_findings_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(TREES / 'reference_process.yaml', '--json') == 0
    report = json.loads(capsys.readouterr().out)
    assert len(report.pop('paces')) == 1
    assert report == {'findings': [], 'warnings': [], 'ok': True, 'recipes': [], 'orders': []}


# --- warnings ---------------------------------------------------------------------------------

DRIVE = '  3: [{id: bring, task: BRING, action: /cart/drive}]\n'


class Files:
    """A cell and a script, and what `check` warns of."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder = folder
        self.script = folder / 'line.yaml'
        self._capsys = capsys

    def check(self, script: str, durations: str = '', *options: str) -> list[str]:
        cell = self.folder / 'cell.yaml'
        cart = 'cart: {action: /cart/drive'
        cell.write_text(CELL.replace(cart, f'{cart}, durations: {{{durations}}}'))
        self.script.write_text(script)
        self.status = checked(self.script, '--trees', self.folder / 'trees', *options, cell=cell)
        self.out, err = self._capsys.readouterr()
        return [line.removeprefix(f'{self.folder}/') for line in err.splitlines()]


@pytest.fixture
def files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Files:
    return Files(tmp_path, capsys)


def of_cell(lines: list[str]) -> list[str]:
    return [line for line in lines if line.startswith('cell.yaml')]


def test_misspelt_duration_label_is_warning(files: Files) -> None:
    (warning,) = of_cell(files.check(LINE + DRIVE, 'BRNG: 2.0'))
    assert warning == (
        'cell.yaml:15:43: warning: no script has a task `BRNG` of `cart`: its nominal time has no '
        'effect; did you mean `BRING`?'
    )
    assert files.status == 0
    assert files.out.startswith('test: 3 tasks')


@pytest.mark.parametrize('durations', ['BRING: 2.0', ''])
def test_a_label_that_is_used_is_no_warning(files: Files, durations: str) -> None:
    assert of_cell(files.check(LINE + DRIVE, durations)) == []


def test_a_label_of_a_capability_is_no_warning(files: Files) -> None:
    able = 'BRING: 2.0, FETCH: 3.0}, workspaces: [left], capabilities: {fetch: {task: FETCH}'
    assert of_cell(files.check(LINE + DRIVE, able)) == []


def test_label_of_other_script_causes_no_warning(files: Files) -> None:
    trees = files.folder / 'trees'
    trees.mkdir()
    (trees / 'other.yaml').write_text(LINE + DRIVE.replace('BRING', 'FETCH'))
    (trees / 'broken.yaml').write_text('script: [')
    assert of_cell(files.check(LINE + DRIVE, 'BRING: 2.0, FETCH: 3.0')) == []


def test_unused_component_causes_no_warning(files: Files) -> None:
    assert of_cell(files.check(LINE, 'BRING: 2.0')) == []


def test_task_without_nominal_time_warns_once(files: Files) -> None:
    twice = DRIVE.replace(
        '}]', '}, {task: FETCH, action: /cart/drive}, {task: FETCH, action: /cart/drive}]'
    )
    warnings = [line for line in files.check(LINE + twice, 'BRING: 2.0') if '`cart`' in line]
    assert warnings == [
        (
            'line.yaml:5:54: warning: `FETCH` of `cart` has no nominal time: predictions take '
            '1 s; add `FETCH: SECONDS` to the `durations` of `cart`'
        )
    ]


@pytest.fixture
def without_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cell whose second robot can glue, nobody knows how fast, and an order of its product."""
    monkeypatch.chdir(tmp_path)
    cell = Path('cell.yaml')
    cell.write_text(GLUE_CELL.replace('{TASK_A: 4.0, TASK_B: 2.0}', '{TASK_B: 2.0}'))
    Path('recipes').mkdir()
    Path('recipes/box.yaml').write_text(RECIPE)
    Path('order.yaml').write_text('{order: W, recipe: BOX-7, quantity: 2, bind: {glue: robot_b}}')
    return cell


@pytest.mark.parametrize('file', ['order.yaml', 'recipes/box.yaml'])
def test_recipe_tasks_need_nominal_times(
    file: str, without_time: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert checked(file, cell=without_time) == 0
    assert capsys.readouterr().err == (
        'cell.yaml:25:5: warning: `TASK_A` of `robot_b` has no nominal time: predictions take '
        '1 s; add `TASK_A: SECONDS` to the `durations` of `robot_b`; did you mean `TASK_B`?\n'
    )
    assert checked(file, '--strict', cell=without_time) == 1


def test_without_any_nominal_time_no_task_lacks_one(files: Files) -> None:
    assert files.check(LINE + DRIVE) == []


HOMING = 'initialization: [{id: a, task: HOME, action: /belt/index%s}]\n'


def test_a_homing_for_every_job_is_a_warning(files: Files) -> None:
    assert files.check(LINE + HOMING % '') == [
        (
            'line.yaml:5:18: warning: `a` is done again for every job, with the same arguments; '
            'write `once: true`, and it is skipped while it has succeeded before'
        )
    ]


@pytest.mark.parametrize(
    'text',
    [
        HOMING % ', once: true',
        'initialization: [{id: b, task: PREPARE, action: /loader/task}]\n',
        'initialization: [{id: home, action: /cart/drive, args: {place: "${order.id}"}}]\n',
    ],
    ids=['once', 'no homing', 'other arguments for each job'],
)
def test_other_initialization_is_no_warning(files: Files, text: str) -> None:
    assert files.check(LINE + text) == []


REJECTING = """\
script: test
sections:
  1: [{id: place, task: PLACE_AT_CONVEYOR, action: /loader/task, qty_change: 1}]
  2:
    - {id: first, task: TASK_A, action: /table/task}
    - parallel:
      - {id: look, task: TASK_A, action: /table/task, on_failure: reject}
      - {id: beside, task: RUN, action: /lamp/task}
  3:
    - {id: behind, task: TASK_B, action: /press/task%s}
    - {id: mark, task: TASK_A, action: /press/task, runs_for: %s,
       args: {special_argument_2: "${results.%s.measurement}"}}
  4: [{id: pack, task: PICK_AND_PACK, action: /packer/task, qty_change: -1, runs_for: all}]
"""


@pytest.mark.parametrize('giver', ['look', 'behind'])
def test_result_missing_for_rejected_items_is_warning(files: Files, giver: str) -> None:
    assert files.check(REJECTING % ('', 'rejected', giver)) == [
        (
            f'line.yaml:11:7: warning: `${{results.{giver}.measurement}}` has no value here: a '
            f'rejected item never ran `{giver}` well; items are rejected by `look`; refer to a '
            'task before'
        )
    ]


@pytest.mark.parametrize(
    ('options', 'runs_for', 'giver'),
    [
        ('', 'rejected', 'first'),
        ('', 'all', 'behind'),
        ('', 'good', 'behind'),
        (', runs_for: rejected', 'rejected', 'behind'),
        (', runs_for: all', 'rejected', 'behind'),
        (', on_failure: reject', 'rejected', 'first'),
    ],
)
def test_result_of_some_item_causes_no_warning(
    files: Files, options: str, runs_for: str, giver: str
) -> None:
    assert files.check(REJECTING % (options, runs_for, giver)) == []


DISCARD = (
    '{id: discard, task: PICK_AND_PACK, action: /packer/task, qty_change: -1, runs_for: rejected}'
)
BEHIND = GOOD_ONLY.replace('qty_change: -1}', f'qty_change: -1}}, {DISCARD}')
BEFORE = GOOD_ONLY.replace('[{id: pack', f'[{DISCARD}, {{id: pack')


@pytest.mark.parametrize(('text', 'behind'), [(GOOD_ONLY, ''), (BEFORE, ' behind `discard`')])
def test_rejected_item_left_on_belt_is_warning(files: Files, text: str, behind: str) -> None:
    (line,) = files.check(text)
    assert line.startswith('line.yaml:4:')
    assert line.partition(': warning: ')[2] == (
        f'an item that an operator or `abort_job` rejects{behind} is never taken out: `pack` runs '
        'for good items only; set `runs_for: all`, or each such item stops the belt until '
        'somebody takes it off'
    )


@pytest.mark.parametrize('text', [LINE, BEHIND])
def test_removed_rejected_item_causes_no_warning(files: Files, text: str) -> None:
    assert files.check(text) == []


def test_strict_takes_warnings_for_mistakes(files: Files) -> None:
    assert len(files.check(LINE + HOMING % '', '', '--strict')) == 1
    assert (files.status, files.out) == (1, '')
    assert files.check(LINE + HOMING % ', once: true', '', '--strict') == []
    assert files.status == 0


def test_warnings_as_json(files: Files) -> None:
    assert files.check(LINE + HOMING % '', '', '--json') == []
    answer = json.loads(files.out)
    (warning,) = answer['warnings']
    assert (warning['line'], warning['file'], answer['ok']) == (5, str(files.script), True)
    files.check(LINE + HOMING % '', '', '--json', '--strict')
    assert json.loads(files.out)['ok'] is False


def test_warning_locates_task_in_group(files: Files) -> None:
    group = '  3:\n    tasks:\n      - parallel: [{task: TASK_A, action: /press/task},\n'
    group += '        [{task: X, action: /cart/drive}, {task: Y, action: /cart/drive}]]\n'
    warnings = [line for line in files.check(LINE + group, 'X: 1.0') if '`cart`' in line]
    assert warnings[0].startswith('line.yaml:8:42: warning: `Y` of `cart`')


def test_the_shipped_scripts_have_no_warnings(capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(*sorted(TREES.glob('*.yaml')), '--strict') == 0
    assert capsys.readouterr().err == ''


def test_changes_implied_by_setups_cause_no_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change = 'changes: {gripper: {task: TASK_C, argument: special_argument_1}}'
    keys = f'setups: {{gripper: [small, large]}}, {change}'
    (tmp_path / 'cell.yaml').write_text(Line(keys={'a2': keys}, seconds={'a2': 3.0}).text)
    text = expanded(with_section(2, '- {id: work, @a2, setup: {gripper: small}}'))
    (tmp_path / 'small.yaml').write_text(f'script: small\n{text}')
    assert checked(tmp_path / 'small.yaml', cell=tmp_path / 'cell.yaml') == 0
    assert 'fits cell test_line' in capsys.readouterr().out
