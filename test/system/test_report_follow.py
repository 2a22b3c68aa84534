"""The account of the shift that runs, on a real pseudo-terminal; no node is needed."""

from __future__ import annotations

import signal
from pathlib import Path

from fakes.hand_made_shift import the_day
from pseudo_terminal import PseudoTerminal

from bt_orchestrator.store.sqlite.store import SqliteStore


def test_report_redraws_and_leaves_terminal_clean(tmp_path: Path) -> None:
    journal = tmp_path / 'cell.db'
    events = the_day().events
    store = SqliteStore(journal)
    store.append([event for event in events if event.time < events[-1].time])
    words = ['report', '--follow', '--journal', str(journal), '--from', '2026-05-18T06:00Z']
    terminal = PseudoTerminal([*words, '--every', '600'], lines=30)
    try:
        terminal.until_shows('made 538, 520 of them good')
        store.append([event for event in events if event.time >= events[-1].time])
        terminal.press(' ')
        terminal.until_shows('made 539, 521 of them good')
        terminal.send(signal.SIGINT)
        assert terminal.wait() == 0
        terminal.assert_left_clean()
    finally:
        terminal.close()
        store.close()
