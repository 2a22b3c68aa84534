"""Rows of the operator page: what it costs, beside `watch` on a terminal, on a line at work."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

from page_process import PageProcess
from process_use import family_cpu_s
from program_process import ProgramProcess
from pseudo_terminal import PseudoTerminal
from stream_readers import StreamReader, StuckReader

from bench.rows import Row, percentile
from bench.stand import ENDLESS, Stand, stand
from bench.tail import until

READERS = 20
STUCK = 30
WARM_UP = 20
"""Tasks before the first measurement: connections, caches, the admission of the order."""

SETTLED_S = 3.0
"""After its start a process loads ROS, and discovers others for a while."""

Use = dict[str, float]


def page(rounds: int, seconds: float) -> Iterator[Row]:
    """Let `watch` and the page look at the same line, one after the other."""
    with stand() as here:
        uses = [_round(here, seconds, number) for number in range(rounds)]
    median = {f'{name}': percentile([use[name] for use in uses], 0.5) for name in uses[0]}
    yield Row('page_cpu', _ratios(uses, 'page read, % CPU', 'watch, % CPU'), median)
    yield Row('page_node', _ratios(uses, 'node under page, % CPU', 'node under watch, % CPU'))
    yield Row('page_reader', _ratios(uses, 'page read, % CPU', 'page not read, % CPU'))
    yield Row('page_readers', _ratios(uses, 'many, p95 in ms', 'one, p95 in ms'))


def _ratios(rounds: list[Use], above: str, below: str) -> list[float]:
    return [use[above] / use[below] for use in rounds]


def _round(here: Stand, seconds: float, number: int) -> Use:
    """Measure each; every other round begins with the page."""
    with here.node(['--journal', str(here.folder / f'page_{number}.sqlite3')]) as node:
        tail = here.tail()
        here.submit('WO-1', ENDLESS)
        tail.until_ended(WARM_UP)
        looks: list[Callable[[], Use]] = [
            lambda: _watched(node, seconds),
            lambda: _paged(here.folder, node, seconds),
        ]
        use: Use = {}
        for look in looks if number % 2 else reversed(looks):
            use |= look()
        return use


def _watched(node: ProgramProcess, seconds: float) -> Use:
    """Measure `watch` and the node."""
    with closing(PseudoTerminal(['watch'], columns=120, lines=40)) as watch:
        watch.until_shows('WO-1')
        watch.read_for(SETTLED_S)
        used = _loads([watch.pid, node.pid], lambda: watch.read_for(seconds))
    return {'watch, % CPU': used[0], 'node under watch, % CPU': used[1]}


def _paged(folder: Path, node: ProgramProcess, seconds: float) -> Use:
    """Measure the page and the node: nobody reads, one does, many do beside stuck ones."""
    with closing(PageProcess(folder, '/bt_orchestrator')) as page, ExitStack() as stack:
        page.wait_ready()
        pids = [page.process.pid, node.pid]
        with _reading(page):
            time.sleep(SETTLED_S)
        alone = _loads(pids, lambda: time.sleep(seconds))
        with _reading(page) as single:
            read = _loads(pids, lambda: time.sleep(seconds))
        many = [stack.enter_context(_reading(page)) for _ in range(READERS)]
        for _ in range(STUCK):
            stack.callback(StuckReader(page.port).close)
        time.sleep(seconds)
        until(lambda: page.readers == READERS, 'all that are stuck to be sent away')
        delays_s = [delay for reader in many for delay in reader.delays_s]
    return {
        'page not read, % CPU': alone[0],
        'page read, % CPU': read[0],
        'node under page, % CPU': read[1],
        'one, p95 in ms': percentile(single.delays_s, 0.95) * 1e3,
        'one, p50 in ms': percentile(single.delays_s, 0.5) * 1e3,
        'many, p95 in ms': percentile(delays_s, 0.95) * 1e3,
        'many, p50 in ms': percentile(delays_s, 0.5) * 1e3,
    }


@contextmanager
def _reading(page: PageProcess) -> Iterator[StreamReader]:
    with closing(StreamReader(page.port)) as reader:
        reader.wait_begun()
        yield reader


def _loads(pids: list[int], meanwhile: Callable[[], object]) -> list[float]:
    """Return the shares of a core that processes use meanwhile, with their children, percent."""
    before, began = [family_cpu_s(pid) for pid in pids], time.monotonic()
    meanwhile()
    took_s = time.monotonic() - began
    return [
        (family_cpu_s(pid) - was) / took_s * 100 for pid, was in zip(pids, before, strict=True)
    ]
