"""A planner's day: the queue is changed by keys, with what would come of it; an order is given."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cell_processes import STATELESS_CELL, CellProcesses, StartCell, small_script
from page.axe import barriers
from page.browsing import Tab
from page.conftest import Sit, StartPage

ROUNDED_S = 0.11
"""Times are told to a tenth of a second."""


ABLE_CELL = STATELESS_CELL
for name, does in (
    ('feeder', '{task: TASK_A, qty_change: 1}'),
    ('worker', '{task: TASK_A}'),
    ('packer', '{task: TASK_A, qty_change: -1}, worker: {task: TASK_A}'),
):
    of = f'action: {name}/task'
    between = '\n    ' if name == 'worker' else ', '
    able = f'{of}{between}capabilities: {{{name}: {does}}}'
    ABLE_CELL = ABLE_CELL.replace(of, able)

RECIPE = """\
recipe: P-1
version: 4
script: made
params: {lot: {type: int}}
operations: [{id: a, do: feeder}, {id: b, do: worker}, {id: c, do: packer}]
"""

ORDER = """\
{order: made, recipe: P-1, version: 3, bind: {b: worker}, quantity: 2, params: {lot: 8}}
"""


@pytest.fixture
def planned(start_cell: StartCell, tmp_path: Path) -> CellProcesses:
    """Give a line with a long job on it, two behind that, and a recipe."""
    # 500 items at this speed take minutes: the job is there to the end.
    cell = start_cell(ABLE_CELL, speed=4, run_options=['--recipes', str(tmp_path / 'cell')])
    cell.connect()
    (cell.folder / 'recipe.yaml').write_text(RECIPE)
    (cell.folder / 'before.yaml').write_text(RECIPE.replace('version: 4', 'version: 3'))
    text = small_script().replace('\nsections:', '\nparams: {lot: {type: int}}\nsections:')
    (cell.folder / 'lots.yaml').write_text(text.replace('small', 'lots'))
    cell.run_small(quantity=500, order='long')
    cell.watch.until('item.removed')
    for name in ('a', 'b'):
        cell.watch.submit(Path('small'), quantity=20, order=name)
    return cell


def in_queue(tab: Tab) -> list[str]:
    """Return the jobs that wait, as the page shows them."""
    rows = tab.page.locator('[data-list="queue"] > [data-job]')
    return [str(row.get_attribute('data-job')) for row in rows.all()]


def in_order(ends: dict[str, float]) -> list[str]:
    """Return jobs in the order in which they end."""
    return sorted(ends, key=lambda job: ends[job])


def computed(tab: Tab) -> dict[str, tuple[str, float | None]]:
    """Return what the dialog says of each job: what changes, and by how many seconds."""
    tab.page.locator('dialog [data-what-if="known"]').wait_for()
    effects = {}
    for row in tab.page.locator('dialog tr[data-job]').all():
        by = row.get_attribute('data-by')
        change = str(row.get_attribute('data-change'))
        effects[str(row.get_attribute('data-job'))] = (change, None if by is None else float(by))
    return effects


def test_keys_move_job_once_consequence_is_known(
    planned: CellProcesses, start_page: StartPage, sit: Sit
) -> None:
    page = start_page('--trees', str(planned.folder))
    tab = sit(page.port).open('queue')
    tab.log_in('operate')
    tab.until(lambda: in_queue(tab) == ['a', 'b'], 'the queue')

    status, output, errors = planned.verb('what-if', 'job move b 1', '--json')
    assert status == 0, errors
    forecast = {entry['job']: entry['ends_s'] for entry in json.loads(output)['after']}
    assert in_order(forecast) == ['long', 'b', 'a']

    tab.page.locator('[data-job="b"] [data-do="place"]').focus()
    tab.page.keyboard.press('ArrowUp')
    assert tab.page.locator('[data-job="a"]').get_attribute('data-drop') == 'before'
    assert in_queue(tab) == ['a', 'b'], 'nothing has moved'
    with tab.page.expect_response('**/api/what-if') as answered:
        tab.page.keyboard.press('Enter')
    before, after = (
        {entry['job']: entry['ends'] for entry in answered.value.json()[key]}
        for key in ('before', 'after')
    )
    assert in_order(after) == ['long', 'b', 'a']
    shown = computed(tab)
    assert {job: change for job, (change, _) in shown.items()} == {
        'long': 'same',
        'a': 'later',
        'b': 'earlier',
    }
    for job, (_, by_s) in shown.items():
        assert by_s == pytest.approx(after[job] - before[job], abs=ROUNDED_S)

    tab.page.keyboard.type('the customer waits')
    tab.page.keyboard.press('Tab')
    tab.page.keyboard.press('Tab')
    tab.page.keyboard.press('Enter')
    tab.until(lambda: in_queue(tab) == ['b', 'a'], 'the new order')
    decided = planned.watch.until('operator.decided', job='b', who='operate')
    assert decided['reason'] == 'the customer waits'
    focused = 'document.activeElement.closest("[data-job]")?.dataset.job'
    # The news may come before the answer, which closes the dialog.
    tab.until(lambda: tab.page.evaluate(focused) == 'b', 'the focus with what was moved')


def test_proposed_order_is_applied_once_effects_are_known(
    planned: CellProcesses, start_page: StartPage, sit: Sit
) -> None:
    page = start_page()
    tab = sit(page.port).open('queue')
    tab.log_in('operate')
    tab.until(lambda: in_queue(tab) == ['a', 'b'], 'the queue')
    propose = tab.page.locator('[data-do="propose"]')
    propose.click()
    tab.page.locator('[data-proposal="same"]').wait_for()
    assert tab.count('dialog') == 0, 'no job has a due time'

    due = ('--due', '2020-01-01T00:00:00Z', '--quantity', '5', '--reason', 'promised')
    assert planned.verb('job', 'update', 'b', *due)[0] == 0
    status, output, errors = planned.verb('queue', 'propose', '--json')
    assert status == 0, errors
    assert json.loads(output)['order'] == ['b', 'a']

    propose.click()
    shown = computed(tab)
    assert {job: change for job, (change, _) in shown.items()} == {
        'long': 'same',
        'a': 'later',
        'b': 'earlier',
    }
    explanation = tab.page.locator('dialog .said-before').inner_text()
    assert 'the best of all 2 orders' in explanation
    assert barriers(tab) == []
    tab.confirm('queue.arrange', 'promised')
    tab.until(lambda: in_queue(tab) == ['b', 'a'], 'the new order')
    assert planned.watch.until('queue.arranged')['jobs'] == ['b', 'a']


def test_corrected_order_is_queued_in_its_place(
    planned: CellProcesses, start_page: StartPage, sit: Sit
) -> None:
    page = start_page('--trees', str(planned.folder))
    tab = sit(page.port).open('order')
    tab.log_in('mes')
    tab.page.locator('[name="script"]').select_option('lots')
    tab.page.locator('[name="quantity"]').fill('20')
    tab.page.locator('[name="params.lot"]').fill('seven')
    tab.page.locator('[name="position"]').fill('1')
    name = tab.page.locator('[name="order"]').input_value()
    tab.page.locator('[data-do="order"]').click()
    wrong = tab.page.locator('[name="params.lot"][aria-invalid="true"]')
    wrong.wait_for()
    tab.until(
        lambda: tab.page.evaluate('document.activeElement.name') == 'params.lot', 'the focus'
    )
    warning = tab.page.locator('.field:has([name="params.lot"]) .field-warning').inner_text()
    assert 'must be a whole number' in warning
    assert tab.count('dialog') == 0, 'nothing is sent'

    wrong.fill('7')
    tab.page.locator('[data-check="fine"]').wait_for()
    tab.page.keyboard.press('Enter')
    shown = computed(tab)
    assert list(shown) == ['long', name, 'a', 'b']
    assert shown[name][0] == 'new'
    assert shown['a'][0] == 'later'
    tab.page.locator('dialog [data-do="send"]').click()
    tab.page.locator('.order-done').wait_for()
    queued = planned.watch.until('job.queued', job=name)
    assert (queued['params'], queued['quantity']) == ({'lot': 7}, 20)
    assert tab.page.locator('[name="order"]').input_value() != name, 'the next order is another'
    tab.page.locator('.order-done a').click()
    tab.until_screen('queue')
    tab.until(lambda: in_queue(tab) == [name, 'a', 'b'], 'the order in its place')


def test_order_by_recipe_takes_newest_or_chosen_version(
    planned: CellProcesses, start_page: StartPage, sit: Sit
) -> None:
    page = start_page('--recipes', str(planned.folder))
    tab = sit(page.port).open('order')
    tab.log_in('mes')
    name = tab.page.locator('[name="order"]').input_value()
    tab.page.locator('[name="quantity"]').fill('2')
    tab.page.locator('[name="script"]').select_option('recipe/P-1')
    version = tab.page.locator('[name="version"]')
    assert version.locator('option').all_inner_texts() == ['the newest (4)', '4', '3']
    tab.page.locator('[data-do="order"]').click()
    tab.page.locator('[name="params.lot"][aria-invalid="true"]').fill('8')
    tab.page.locator('[data-check="fine"]').wait_for()
    tab.page.locator('[data-do="order"]').click()
    tab.page.locator('dialog [data-do="send"]').click()
    queued = planned.watch.until('job.queued', job=name)
    assert (queued['recipe'], queued['recipe_version']) == ('P-1', 4)
    assert (queued['params'], queued['choice']) == ({'lot': 8}, {'recipes': ['P-1']})

    tab.page.locator('.order-done').wait_for()
    name = tab.page.locator('[name="order"]').input_value()
    version.focus()
    tab.page.keyboard.press('3')
    tab.page.keyboard.press('Tab')
    tab.page.keyboard.press('Enter')  # who does what
    tab.page.keyboard.press('Tab')
    tab.page.keyboard.press('w')
    assert tab.page.locator('[name="params.lot"]').input_value() == '8', 'it is kept'
    tab.page.locator('[data-check="fine"]').wait_for()
    assert barriers(tab) == []
    tab.page.locator('[data-do="order"]').click()
    tab.page.locator('dialog [data-do="send"]').click()
    queued = planned.watch.until('job.queued', job=name)
    bound = {'recipes': ['P-1'], 'version': 3, 'bind': {'b': 'worker'}}
    assert (queued['recipe_version'], queued['choice']) == (3, bound)


def test_job_by_recipe_changes_to_another_version(
    planned: CellProcesses, start_page: StartPage, sit: Sit
) -> None:
    (planned.folder / 'order.yaml').write_text(ORDER)
    status, _, errors = planned.verb('submit', str(planned.folder / 'order.yaml'))
    assert status == 0, errors
    page = start_page('--recipes', str(planned.folder))
    engineer = sit(page.port).open('job/made')
    engineer.log_in('engineer')
    engineer.page.locator('[data-offer="job.update"]').click()
    dialog = engineer.page.locator('dialog[data-dialog="job.update"]')
    assert dialog.locator('[name="version"]').input_value() == '3'
    assert dialog.locator('[name="bind.b"]').input_value() == 'worker'
    dialog.locator('[name="version"]').select_option('')
    dialog.locator('[name="bind.b"]').select_option('packer')
    assert barriers(engineer) == []
    engineer.confirm('job.update', 'the new version')
    updated = planned.watch.until('job.updated', job='made')
    bound = {'recipes': ['P-1'], 'bind': {'b': 'packer'}}
    assert (updated['recipe_version'], updated['choice']) == (4, bound)
