"""The page says which node leads the cell, and whether another one can take over."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path

from page.browsing import Tab
from page.conftest import Sit
from page.stands import Stand, stand

from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.model.status import Leadership, StandbyStatus
from bt_orchestrator.model.words import sentence

PANEL = '[data-part="nodes"]'
SILENT = sentence('standby_silent', time='14:20:00')


def led(line: Stand, *standbys: StandbyStatus) -> None:
    """Let the status of the cell tell of a leader and these standbys."""
    leadership = Leadership('line-1', 411, 7, standbys)
    with line.cell.lock:
        running = line.cell.node.running
        running.overview = Overview(running.engine, leadership=lambda: leadership)


def rows(tab: Tab) -> list[str]:
    texts: list[str] = tab.page.locator(f'{PANEL} li').all_inner_texts()
    return texts


def tells(tab: Tab, words: str) -> bool:
    return any(row.startswith(words) for row in rows(tab)[-1:])


def test_9_4_page_shows_whether_standby_can_take_over(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, jobs=1) as line:
        english = sit(line.port, viewport={'width': 390, 'height': 800}).open()
        german = sit(line.port, locale='de-DE').open()
        for tab in (english, german):
            tab.until_news()
            assert not tab.page.locator(PANEL).is_visible(), 'no other node can lead this cell'

        leads = 'line-1, process 411, leads (epoch 7)'
        for standbys, words, word in (
            ((), 'No standby was heard.', 'Kein Ersatzknoten wurde gehört.'),
            (
                (StandbyStatus('line-2', 90),),
                'line-2, process 90, stands by and can take over',
                'line-2, Prozess 90, ist Ersatz und kann übernehmen',
            ),
            (
                (StandbyStatus('line-2', 90, SILENT),),
                f'line-2, process 90, stands by and cannot take over: {SILENT}',
                'line-2, Prozess 90, ist Ersatz und kann nicht übernehmen: ',
            ),
        ):
            led(line, *standbys)
            english.until(partial(tells, english, words), words)
            german.until(partial(tells, german, word), word)
            assert rows(english) == [leads, words]
            assert rows(german)[0] == 'line-1, Prozess 411, führt (Epoche 7)'
        assert SILENT not in rows(german)[1], 'a reason in English on a German page'
        if folder := os.environ.get('STANDBY_PICTURES'):
            for tab, name in ((english, 'english'), (german, 'german')):
                tab.page.locator(PANEL).scroll_into_view_if_needed()
                tab.page.screenshot(path=Path(folder) / f'standby_{name}.png')
