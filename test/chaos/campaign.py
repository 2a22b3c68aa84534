"""Orders on a real cell whose orchestrator and controllers are killed again and again."""

from __future__ import annotations

import json
import random
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from cell_processes import CellProcesses
from chaos.crashing_node import CLOCKS, CRASHES, POINTS
from chaos.line import SCRIPT, SPEED, cell
from chaos.operator import Operator
from chaos.plan import BOTH, SHARES, Restart, Shot
from chaos.readers import Readers
from chaos.tally import Tally
from chaos.truth import Clocks, Controllers, journal, judge, rows
from chaos.witnesses import bad_copies, vanished

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_record

STUCK_S = 90.0
"""Orders that need longer than that after the last kill are stuck."""

_MOST_PASSES = 12
"""A crash point is passed at most so often before it kills: a few items' worth of settles."""

_NODE = Path(__file__).with_name('crashing_node.py')

_AT_ONCE = Restart()


class Campaign:
    """States: running (in `run`), over. The folder keeps journal, logs and what programs said."""

    def __init__(self, folder: Path, seed: int, items: int, shots: Sequence[Shot]) -> None:
        """Plan it.

        :param items: of each order; another one is given whenever one has ended before the last
            shot
        """
        self._drawn = random.Random(seed)
        self._shots = list(shots)
        self._folder = folder
        self._journal = folder / 'journal.sqlite3'
        self._killed: dict[str, list[float]] = defaultdict(list)
        self._ahead_s = 0.0
        self._armed = ''
        """The crash point at which the present node dies."""
        self._crashes_before = 0
        self._events_checked = self._statuses_checked = 0
        self._tally = Tally()
        self._tally.plan(shots)
        options = ['--journal', str(self._journal)]
        self._cell = CellProcesses(
            folder, cell(self._drawn, items), shares=SHARES, speed=SPEED, run_options=options
        )
        self._readers = Readers(folder / 'readers', self._journal)
        script = self._cell.script(SCRIPT).stem
        self._operator = Operator(self._cell.watch, script, items, self._journal, self._cell.log)
        self._items = items

    def run(self) -> Tally:
        """Run the orders to their end, and judge."""
        begun = time.monotonic()
        try:
            self._cell.connect()
            self._readers.copy(self._cell.node.pid)
            self._shoot_until_the_end()
            self._cell.node.stop()
            self._readers.stop()
        finally:
            self._readers.kill()
            self._cell.close()
        self._judge()
        self._count_events()
        self._tally.seconds = time.monotonic() - begun
        return self._tally

    # --- shooting ---------------------------------------------------------------------------

    def _shoot_until_the_end(self) -> None:
        for shot, following in zip(self._shots, [*self._shots[1:], None], strict=True):
            if shot.target in POINTS:
                self._await_crash(shot.target)
            else:
                self._shoot(shot.target)
            if shot.target not in SHARES:
                self._start_node(shot.restart, following.target if following else '')
        self._operator.gives_more = False
        if not self._live(STUCK_S, self._operator.is_done):
            self._stuck(f'the orders did not end within {STUCK_S:g} s')

    def _shoot(self, target: str) -> None:
        self._live(self._drawn.uniform(0.0, 1.0))
        self._count(target, self._goals_run())
        if target not in SHARES:
            self._cell.node.kill()
        if target in SHARES or target == BOTH:
            self._kill_controllers(self._drawn.choice(SHARES) if target == BOTH else target)

    def _await_crash(self, point: str) -> None:
        """Wait until the node dies at a crash point, which is not always the one it has."""
        if self._armed != point:
            self._cell.node.kill()
            self._start_node(_AT_ONCE, point)
        self._live(STUCK_S, lambda: not self._cell.node.is_running)
        records = self._crash_records()[self._crashes_before :]
        if records:
            self._count(point, records[0]['running'])
        else:
            self._stuck(f'{point} was not passed within {STUCK_S:g} s')
        self._cell.node.kill()

    def _kill_controllers(self, share: str) -> None:
        place = SHARES.index(share)
        self._cell.sims[place].kill()
        for component in share.split(','):
            self._killed[component].append(time.time())
        self._cell.sims[place] = self._cell.start_sim(share)
        self._cell.sims[place].wait_ready()

    def _start_node(self, restart: Restart, upcoming: str) -> None:
        """Start a node in place of one that is dead.

        :param upcoming: what is shot at next; it has that crash point, if it is one
        """
        self._check_kept()
        self._cell.watch.ros.spin_for(restart.away_s, self._readers.look)
        self._operator.forget()
        self._ahead_s += restart.clock_step_s
        self._armed = upcoming if upcoming in POINTS else ''
        crash = [self._armed, str(self._drawn.randint(1, _MOST_PASSES))] if self._armed else []
        self._crashes_before = len(self._crash_records())
        program = [str(_NODE), str(self._folder), str(self._ahead_s), *crash]
        self._cell.start_node(program, ['--auto-resume'] if restart.auto_resume else [])
        self._readers.copy(self._cell.node.pid)
        self._tally.figures['clock steps'] += restart.clock_step_s != 0.0
        self._tally.figures['waits'] += not restart.auto_resume
        if self._armed:
            self._cell.node.wait_ready_or_end()
        else:
            self._cell.node.wait_ready()

    def _count(self, what: str, running: int) -> None:
        self._tally.kills[what] += 1
        self._tally.figures['with goals'] += what not in SHARES and running > 0

    def _stuck(self, what: str) -> None:
        self._tally.verdict.stuck.append(what)

    def _crash_records(self) -> list[dict[str, Any]]:
        file = self._folder / CRASHES
        lines = file.read_text().splitlines() if file.exists() else []
        return [json.loads(line) for line in lines]

    def _goals_run(self) -> int:
        records = self._cell.goals()
        ended = {r['goal'] for r in records if r['event'] in ('ended', 'died') and 'goal' in r}
        return sum(r['event'] == 'started' and r['goal'] not in ended for r in records)

    def _check_kept(self) -> None:
        """See that the journal of a dead node reaches as far as anybody has heard of it."""
        watch = self._cell.watch
        told = [event['seq'] for event in watch.events[self._events_checked :]]
        told += [status.seq for status in watch.statuses[self._statuses_checked :]]
        self._events_checked, self._statuses_checked = len(watch.events), len(watch.statuses)
        kept = len(rows(self._journal))
        if max(told, default=0) > kept:
            self._tally.verdict.vanished.append(
                f'event {max(told)} was on a topic; after a kill the journal ends at {kept}'
            )

    # --- living -----------------------------------------------------------------------------

    def _live(self, seconds: float, unless: Callable[[], bool] = lambda: False) -> bool:
        """Let the line run, and operator and readers do theirs; return whether it is enough."""
        until = time.monotonic() + seconds
        while True:
            self._cell.watch.ros.spin_for(
                until - time.monotonic(),
                lambda: self._look(unless) or self._is_cut_off(),
            )
            if not self._is_cut_off():
                return unless()
            self._cell.watch.connect_anew()
            self._operator.forget()

    def _look(self, unless: Callable[[], bool]) -> bool:
        self._operator.look()
        self._readers.look()
        return unless()

    def _is_cut_off(self) -> bool:
        return self._operator.is_cut_off(node_lives=self._cell.node.is_running)

    # --- judging ----------------------------------------------------------------------------

    def _judge(self) -> None:
        kept, heard = rows(self._journal), self._cell.watch.events
        records = [json.loads(record) for _, record in kept]
        verdict = self._tally.verdict
        verdict.add(
            judge(
                [from_record(record) for record in records],
                Controllers(self._cell.log),
                self._killed,
                heard=[from_record(record) for record in heard],
                clocks=Clocks(self._folder / CLOCKS),
            )
        )
        verdict.vanished += vanished(records, heard, 'the operator')
        verdict.vanished += [
            f'event {seq}, contained in a status, is not in the journal'
            for seq in {max(self._readers.seqs_of_status, default=0)}
            if seq > len(kept)
        ]
        verdict.misled += [*self._readers.misled(records), *self._readers.complaints]
        verdict.bad_copies += bad_copies(kept, self._readers.copies)
        failures = {status.journal_failure for status in self._cell.watch.statuses} - {''}
        verdict.stuck += [f'somebody kept the node from writing: {why}' for why in failures]

    def _count_events(self) -> None:
        tally, copies = self._tally, self._readers.copies
        events = journal(self._journal)
        failed = Counter(x.reason for x in events if isinstance(x, e.TaskFailed))
        tally.figures.update(
            {
                'items': self._operator.orders * self._items,
                'adopted': sum(isinstance(x, e.TaskAdopted) for x in events),
                'resent': sum(isinstance(x, e.TaskResent) for x in events),
                'in doubt': failed['in_doubt'],
                'lost': failed['server_lost'],
                'looks': self._readers.looks,
            }
        )
        tally.count_copies(copies)
        tally.answers.update(
            x.answer for x in events if isinstance(x, e.OperatorDecided) and x.hold is not None
        )
