"""report, history and events, of each cell of a plant."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from fakes.long_journal import LongRun
from postgres_server import PostgresServer

from bt_orchestrator.cli.main import main

Verb = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope='module')
def plant(server: PostgresServer, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give the address of a plant with two cells; a third one has no events yet."""
    database = server.database()
    for cell, job in (('line 1', 'J1'), ('line_2', 'J2')):
        path = tmp_path_factory.mktemp('cell') / 'journal.sqlite3'
        run = LongRun(path)
        run.job(job, 1)
        run.close()
        to = server.place(database, cell.replace(' ', '%20'))
        assert main(['feed', '--journal', str(path), '--to', to]) == 0
    return server.address(database)


@pytest.fixture
def verb(plant: str, capsys: pytest.CaptureFixture[str]) -> Verb:
    def carry_out(name: str, *words: str, cell: str = '') -> tuple[int, str, str]:
        capsys.readouterr()
        address = plant.replace('?', f'/{cell}?') if cell else plant
        try:
            status = main([name, '--journal', address, *words])
        except SystemExit as end:
            status = int(str(end.code))
        return (status, *capsys.readouterr())

    return carry_out


def test_history_has_each_cell_under_its_name(verb: Verb) -> None:
    status, output, _ = verb('history')
    assert status == 0
    first, two = output.split('== line_2\n')
    assert first.startswith('== line 1\n')
    assert ('J1' in first, 'J2' in first, 'J1' in two, 'J2' in two) == (True, False, False, True)


def test_job_is_found_in_its_cell(verb: Verb) -> None:
    status, text, missing = verb('history', '--job', 'J2', '--json')
    assert status == 0
    assert [(job['plant_cell'], job['job']) for job in map(json.loads, text.splitlines())] == [
        ('line_2', 'J2')
    ]
    assert 'knows no job J2' in missing
    assert verb('history', '--job', 'J3')[0] == 1


def test_events_of_several_cells_name_their_cell(verb: Verb) -> None:
    status, output, _ = verb('events', '--event', 'job.completed')
    assert status == 0
    events = [json.loads(line) for line in output.splitlines()]
    jobs = [(event['plant_cell'], event['job']) for event in events]
    assert jobs == [('line 1', 'J1'), ('line_2', 'J2')]
    (alone,) = verb('events', '--event', 'job.completed', cell='line_2')[1].splitlines()
    assert json.loads(alone) == {key: events[1][key] for key in events[1] if key != 'plant_cell'}


def test_report_is_of_each_cell(verb: Verb) -> None:
    status, output, _ = verb('report', '--json')
    assert status == 0
    assert [json.loads(line)['plant_cell'] for line in output.splitlines()] == ['line 1', 'line_2']
    assert verb('report')[1].count('== line') == 2


@pytest.mark.parametrize(
    ('words', 'option'),
    [
        (('history', '--gantt'), 'gantt'),
        (('report', '--html'), 'html'),
        (('events', '--format', 'csv'), 'format'),
        (('events', '--follow'), 'follow'),
    ],
)
def test_documents_are_of_one_cell(verb: Verb, words: tuple[str, ...], option: str) -> None:
    status, _, text = verb(*words)
    assert (status, f'--{option} is of one cell: name it behind the database' in text) == (2, True)


def test_unreadable_cell_does_not_affect_others(verb: Verb, plant: str, tmp_path: Path) -> None:
    from bt_orchestrator.extensions.postgres.connecting import connected, place_of
    from bt_orchestrator.extensions.postgres.schema import FEED, begin_stretch, enter

    with connected(place_of(plant), 'test') as connection:
        cell = enter(connection, 'a_third', FEED, 'me')
        connection.execute(
            begin_stretch(connection, cell, 'h').sql('DROP TABLE {stretch}.jobs CASCADE')
        )
    try:
        status, output, missing = verb('history')
        assert status == 1
        assert missing.startswith('a_third: ')
        assert ('J1' in output, 'J2' in output) == (True, True)
    finally:
        with connected(place_of(plant), 'test') as connection:
            connection.execute(b"DELETE FROM plant.stretches WHERE history = 'h'")
            connection.execute(b"DELETE FROM plant.cells WHERE cell = 'a_third'")
