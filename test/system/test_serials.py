"""The serials of items, with real servers, a journal, and a node that is killed (6.8)."""

from __future__ import annotations

from pathlib import Path

from cell_processes import ROOT, StartCell, run_verb

from bt_orchestrator.model import events as e
from bt_orchestrator.store.sqlite.store import SqliteStore

ITEMS = 4


def test_6_8_serial_is_known_to_every_later_node(start_cell: StartCell, tmp_path: Path) -> None:
    journal = tmp_path / 'journal.sqlite3'
    cell = start_cell(
        (ROOT / 'config' / 'serial_cell.yaml').read_text(),
        fail=['scanner#3=reads:2'],
        run_options=['--journal', str(journal), '--auto-resume'],
    )
    cell.connect()
    script = (ROOT / 'trees' / 'serial_cell' / 'one_serial_an_item.yaml').read_text()
    cell.watch.submit(cell.script(script, 'one_serial_an_item'), quantity=ITEMS)
    cell.watch.until('item.identified', item='WO-1/1')
    cell.kill_and_restart_node()
    hold = cell.watch.until_held()
    assert (hold.reason, hold.item) == ('duplicate_serial', 'WO-1/3')
    assert hold.controller_said == 'serial: SN-2'
    assert 'READ' in hold.last_feedback
    cell.kill_and_restart_node()
    assert cell.watch.until_held().reason == 'duplicate_serial'
    words = ('answer', hold.id, 'mark_done', '--result', 'serial=SN-3', '--reason', 'it says so')
    status, _, errors = cell.verb(*words, '--who', 'Ann')
    assert status == 0, errors
    cell.watch.until_ended('WO-1')
    cell.stop()

    store = SqliteStore(journal)
    read = [(x.item, x.serial) for x in store.read() if isinstance(x, e.ItemIdentified)]
    store.close()
    assert read == [(f'WO-1/{n}', f'SN-{n}') for n in range(1, ITEMS + 1)]
    status, output, _ = run_verb(
        tmp_path, 'history', '--journal', str(journal), '--serial', 'SN-3'
    )
    assert status == 0
    assert 'WO-1/3  packed' in output
