"""A connection is cut, or the server killed, in a job: subscribers of two makes hear on."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from itertools import cycle
from pathlib import Path

import pytest
from cell_processes import small_script
from opcua.asyncua_subscriber import AsyncuaSubscriber
from opcua.conftest import StartLine, Tell
from opcua.line import EVENT, ORDERS, RESULTS, Line, job_order, states_in
from page.proxy import Proxy
from patience import PATIENCE_S

TOGETHER_S = 1.0
"""A subscriber that is there hears of a change within this time."""

MOST_REPUBLISHED = 20
"""Requests for lost messages; a client that gets a wrong answer sends a thousand a second."""

Lay = Callable[[int], Proxy]


@pytest.fixture
def lay() -> Iterator[Lay]:
    """Give a function that lays a wire to a port."""
    laid: list[Proxy] = []

    def lay(port: int) -> Proxy:
        laid.append(Proxy(port))
        return laid[-1]

    yield lay
    for wire in laid:
        wire.close()


class Watched:
    """A job at work, and two subscribers of different make."""

    def __init__(self, line: Line, folder: Path, lay: Lay) -> None:
        self.line = line
        self.wire = lay(line.server.port)
        endpoint = f'opc.tcp://127.0.0.1:{self.wire.port}'
        line.cell.script(small_script('slow', task='TASK_C'), 'slow')
        self.mes = line.client('mes', endpoint=endpoint)
        self.mes.do('subscribe', values=[ORDERS], events={RESULTS: EVENT})
        self.other = AsyncuaSubscriber(folder, endpoint)
        self.other.connect('mes', line.server.trust)
        assert self.mes.status('StoreAndStart', job_order('WO-1', 'slow', 500)) == 1
        self.mes.wait_state('WO-1', 'Running')
        self.until_both_hear()
        self._begins = len(self.mes.values(ORDERS)), len(self.other.lists)

    def until_both_hear(self) -> tuple[float, float]:
        """Pause and resume the line until each has heard of it; return the seconds it took."""
        began = time.monotonic()
        before = self._heard
        took: list[float | None] = [None, None]

        def look() -> bool:
            for at, (was, now) in enumerate(zip(before, self._heard, strict=True)):
                if took[at] is None and now > was:
                    took[at] = time.monotonic() - began
            return None not in took

        for command in cycle(('pause', 'resume')):
            self.line.cell.watch.command(command)
            if self.line.cell.watch.ros.spin_for(TOGETHER_S, look):
                break
            assert time.monotonic() < began + PATIENCE_S, f'who has heard, and when: {took}'
        first, second = took
        assert first is not None
        assert second is not None
        return first, second

    def assert_sound(self) -> None:
        """Fail if anything came twice, or a list without the job, or requests without end."""
        theirs = [event['EventId'] for event in self.mes.events(RESULTS)]
        assert len(set(theirs)) == len(theirs)
        others = [event for event, _, _ in self.other.told]
        assert len(set(others)) == len(others)
        lists = [*map(states_in, self.mes.values(ORDERS)[self._begins[0] :])]
        lists += [dict.fromkeys(orders, '') for orders in self.other.lists[self._begins[1] :]]
        assert lists
        assert [orders for orders in lists if 'WO-1' not in orders] == []
        assert self.mes.do('counted').get('RepublishRequest', 0) <= MOST_REPUBLISHED

    @property
    def _heard(self) -> tuple[int, int]:
        return len(self.mes.events(RESULTS)), len(self.other.told)

    def close(self) -> None:
        self.other.close()


@pytest.fixture
def watched(start_line: StartLine, tmp_path: Path, lay: Lay) -> Iterator[Watched]:
    rig = Watched(start_line(), tmp_path, lay)
    yield rig
    rig.close()


@pytest.mark.long
def test_cut_connection_resumes_without_republish_storm(watched: Watched, tell: Tell) -> None:
    watched.wire.cut()
    watched.mes.wait(lambda line: line.get('news') == 'lost', 'the loss')
    for command in ('pause', 'resume'):  # while nobody hears
        watched.line.cell.watch.command(command)
    watched.wire.mend()
    first, second = watched.until_both_hear()
    tell(f'after the cut: node-opcua {first:.1f} s, asyncua {second:.1f} s')
    watched.assert_sound()


@pytest.mark.long
def test_subscriptions_survive_server_kill_during_job(watched: Watched, tell: Tell) -> None:
    watched.line.server.kill_and_restart()
    first, second = watched.until_both_hear()
    tell(f'after the return: node-opcua {first:.1f} s, asyncua {second:.1f} s')
    watched.assert_sound()
