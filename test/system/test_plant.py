"""Three cells and one database: feeds that are killed, a database that is away, a failing cell."""

from __future__ import annotations

import os
import random
import signal
import sqlite3
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest
from cell_processes import SMALL_CELL, CellProcesses, StartCell, remembering
from patience import PATIENCE_S, until
from postgres_server import PostgresServer, postgres_server
from program_process import ProgramProcess

KILLS = 8


@pytest.fixture
def server() -> Iterator[PostgresServer]:
    with postgres_server() as database:
        yield database


class Plant:
    """The database, as somebody sees it from outside."""

    def __init__(self, server: PostgresServer) -> None:
        self._server = server
        self.name = server.database()

    def rows(self, query: str) -> list[tuple[object, ...]]:
        import psycopg

        with psycopg.connect(self._server.address(self.name)) as connection:
            records: list[tuple[object, ...]] = connection.execute(query.encode()).fetchall()
            return records

    def to(self, cell: str) -> str:
        return self._server.place(self.name, cell)

    def events(self, cell: str) -> list[tuple[object, ...]]:
        import psycopg

        where = f"WHERE cell = '{cell}' ORDER BY seq"
        try:
            return self.rows(f'SELECT seq, record FROM plant.events {where}')
        except psycopg.errors.UndefinedTable:
            return []  # no feed has come so far yet


def journal(cell: CellProcesses) -> Path:
    return cell.folder / 'journal.sqlite3'


def in_file(cell: CellProcesses) -> list[tuple[object, ...]]:
    with closing(sqlite3.connect(f'file:{journal(cell)}?mode=ro', uri=True)) as database:
        return database.execute('SELECT seq, record FROM events ORDER BY seq').fetchall()


class Feeding:
    """A feed of a cell, which may be killed and started again."""

    def __init__(self, plant: Plant, cell: CellProcesses, name: str, *options: str) -> None:
        self._words = ['feed', '--follow', '--to', plant.to(name), *options]
        self._folder, self._name, self._number = cell.folder, name, 0
        self.start()

    def start(self) -> None:
        self._number += 1
        name = f'feed_{self._name}_{self._number}'
        self.process = ProgramProcess(self._words, self._folder, name)

    def close(self) -> None:
        self.process.kill()


def test_feed_and_database_failures_lose_and_repeat_nothing(
    start_cell: StartCell, tmp_path: Path, server: PostgresServer
) -> None:
    """The line goes on all the time, and its node knows of none of it."""
    options = ['--journal', str(tmp_path / 'cell' / 'journal.sqlite3')]
    cell = start_cell(remembering(SMALL_CELL), run_options=options)
    cell.connect()
    plant, rolled = Plant(server), random.Random(7)
    over_file = Feeding(plant, cell, 'by_file', '--journal', str(journal(cell)))
    over_door = Feeding(plant, cell, 'by_door')
    with closing(over_file), closing(over_door):
        cell.run_small(quantity=12)
        for number in range(KILLS):
            time.sleep(rolled.uniform(0.2, 0.9))  # where the kill falls is a matter of chance
            feed = over_file if number % 2 else over_door
            feed.process.kill()
            if number == KILLS // 2:
                server.stop(signal.SIGQUIT)  # as a crash
                cell.watch.until_ended('WO-1', within_s=PATIENCE_S)
                server.start()
            feed.start()
        cell.run_small(quantity=2, order='WO-2')
        cell.watch.until_ended('WO-2', within_s=PATIENCE_S)
        cell.watch.until_state('Complete')
        until(lambda: plant.events('by_door') == in_file(cell), 'all events over the door')
        assert over_door.process.stop() == 0, over_door.process.errors
        cell.stop()
        expected = in_file(cell)
        until(lambda: plant.events('by_file') == expected, 'all events of the file')
        assert over_file.process.stop() == 0, over_file.process.errors
    ran = [record['goal'] for record in cell.goals(event='started')]
    assert len(ran) == len(set(ran))
    assert plant.rows('SELECT * FROM plant.gaps') == []


@pytest.mark.long
def test_three_cells_with_one_database_stay_independent(
    start_cell: StartCell, tmp_path: Path, server: PostgresServer
) -> None:
    """A node is killed, a feed is stopped, the database goes away: the others go on.

    The first cell has its journal in the database, so it ends, and goes on when that is back.
    """
    plant = Plant(server)
    cells: dict[str, CellProcesses] = {}
    feeds: dict[str, Feeding] = {}
    with ExitStack() as stack:
        for name in ('one', 'two', 'three'):
            place = plant.to(name) if name == 'one' else str(tmp_path / name / 'journal.sqlite3')
            options = ['--journal', place, '--auto-resume']
            cell = start_cell(
                remembering(SMALL_CELL), folder=name, namespace=f'/{name}', run_options=options
            )
            cells[name] = cell
            if name == 'one':
                continue
            words = ('--journal', str(journal(cell)), '--page', f'http://{name}:8080/')
            feeds[name] = stack.enter_context(closing(Feeding(plant, cell, name, *words)))
        for cell in cells.values():
            cell.connect()
            cell.run_small(quantity=6, task='TASK_C')
        cells['one'].kill_and_restart_node()
        feeds['two'].process.stop()
        until(lambda: len(plant.events('three')) > 20, 'events of the third cell')
        assert cells['one'].node.is_running, cells['one'].node.errors
        server.stop(signal.SIGQUIT)
        assert cells['one'].node.wait() == os.EX_TEMPFAIL, cells['one'].node.errors
        for name in feeds:
            cells[name].watch.until_ended('WO-1', within_s=PATIENCE_S)
        server.start()
        feeds['two'].start()
        cells['one'].start_node()
        cells['one'].node.wait_ready()
        cells['one'].watch.until_ended('WO-1', within_s=PATIENCE_S)
        for name, cell in cells.items():
            cell.watch.until_state('Complete')
            ran = [record['goal'] for record in cell.goals(event='started')]
            assert len(ran) == len(set(ran))
            if name in feeds:
                until(lambda: plant.events(name) == in_file(cell), f'all events of {name}')  # noqa: B023
        query = "SELECT cell, page FROM plant.overview WHERE state = 'Complete' ORDER BY cell"
        assert plant.rows(query) == [
            ('one', ''),
            ('three', 'http://three:8080/'),
            ('two', 'http://two:8080/'),
        ]
        for cell in cells.values():
            cell.stop()
