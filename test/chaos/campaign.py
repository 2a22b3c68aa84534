"""Orders on a real cell whose orchestrator and controllers are killed again and again."""

from __future__ import annotations

import json
import os
import random
import signal
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from cell_processes import CellProcesses
from chaos.crashing_node import CLOCKS, CRASHES, KILL, POINTS, STOP, armed
from chaos.database import Database
from chaos.line import LONG_REMEMBERED_S, REMEMBERED_S, SCRIPT, SPEED, cell
from chaos.operator import Operator
from chaos.plan import BOTH, SHARES, STRIKES, Restart, Shot
from chaos.readers import Readers
from chaos.tally import Tally
from chaos.truth import Clocks, Controllers, Place, journal, judge, rows
from chaos.witnesses import bad_copies, vanished

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_record

STUCK_S = 90.0
"""Orders that need longer than that after the last kill are stuck."""

_MOST_PASSES = 12
"""A crash point is passed at most so often before it kills: a few items' worth of settles."""

_NODE = Path(__file__).with_name('crashing_node.py')

_AT_ONCE = Restart()


def _points(shots: Iterable[Shot]) -> Iterator[Shot]:
    """Yield the shots at crash points, up to the first shot that kills."""
    for shot in shots:
        if shot.target in POINTS:
            yield shot
        if shot.kills:
            return


class Campaign:
    """States: running (in `run`), over. The folder keeps journal, logs and what programs said."""

    def __init__(
        self,
        folder: Path,
        seed: int,
        items: int,
        shots: Sequence[Shot],
        database: Database | None = None,
        run_options: Sequence[str] = (),
    ) -> None:
        """Plan it.

        :param items: of each order; another one is given whenever one has ended before the last
            shot
        :param database: keeps the journal, and is closed at the end; None: a file does
        :param run_options: further options of each node
        """
        self._drawn = random.Random(seed)
        self._shots = list(shots)
        self._folder = folder
        file = folder / 'journal.sqlite3'
        self._database = database
        self._journal: Place = file if database is None else database.rows
        self._killed: dict[str, list[float]] = defaultdict(list)
        self._ahead_s = 0.0
        self._armed: list[Shot] = []
        """The crash points at which the present node stops, and dies at the last one."""
        self._passed = 0
        """Crash points that the present node has passed, and lives."""
        self._crashes_before = 0
        self._events_checked = self._statuses_checked = 0
        self._tally = Tally()
        self._tally.plan(shots)
        options = ['--journal', str(file) if database is None else database.address]
        self._cell = CellProcesses(
            folder,
            cell(self._drawn, items, REMEMBERED_S if database is None else LONG_REMEMBERED_S),
            shares=SHARES,
            speed=SPEED,
            run_options=[*options, *run_options],
        )
        self._readers = Readers(folder / 'readers', file if database is None else None)
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
        try:
            self._judge()
            self._count_events()
        finally:
            if self._database is not None:
                self._database.close()
        self._tally.seconds = time.monotonic() - begun
        return self._tally

    # --- shooting ---------------------------------------------------------------------------

    def _shoot_until_the_end(self) -> None:
        for number, shot in enumerate(self._shots, 1):
            if shot.target in POINTS:
                self._await_crash(shot)
            elif shot.target in STRIKES:
                self._strike(shot.target)
            else:
                self._shoot(shot.target)
            if shot.kills:
                self._start_node(shot.restart, self._shots[number:])
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

    def _strike(self, how: str) -> None:
        """Do something to the database, while goals run."""
        assert self._database is not None
        self._live(self._drawn.uniform(0.0, 1.0))
        if self._live(STUCK_S, self._database.strike(how)):
            self._tally.figures[how] += 1
        else:
            self._stuck(f'{how} did not happen within {STUCK_S:g} s')

    def _await_crash(self, shot: Shot) -> None:
        """Wait until the node stops or dies at a crash point, which may not be its next one."""
        if self._armed[:1] != [shot]:
            self._cell.node.kill()
            self._start_node(_AT_ONCE, [shot])
        self._allow_next()
        self._live(STUCK_S, lambda: len(self._crash_records()) > self._crashes_before)
        records = self._crash_records()[self._crashes_before :]
        if not records:
            self._stuck(f'{shot.target} was not passed within {STUCK_S:g} s')
        elif shot.stopped_s:
            self._tally.figures['stops'] += 1
            self._cell.watch.ros.spin_for(shot.stopped_s, self._readers.look)
            self._cell.node.send(signal.SIGCONT)
        else:
            self._count(shot.target, records[0]['running'])
        self._crashes_before += len(records)
        del self._armed[:1]
        self._passed += 1
        if not shot.stopped_s:
            self._cell.node.kill()

    def _kill_controllers(self, share: str) -> None:
        place = SHARES.index(share)
        self._cell.sims[place].kill()
        for component in share.split(','):
            self._killed[component].append(time.time())
        self._cell.sims[place] = self._cell.start_sim(share)
        self._cell.sims[place].wait_ready()

    def _start_node(self, restart: Restart, upcoming: Sequence[Shot]) -> None:
        """Start a node in place of one that is dead.

        :param upcoming: the next shots; it has their crash points, up to the first that kills it
        """
        self._check_kept()
        self._cell.watch.ros.spin_for(restart.away_s, self._readers.look)
        self._operator.forget()
        self._ahead_s += restart.clock_step_s
        self._armed = list(_points(upcoming))
        points = [word for shot in self._armed for word in self._words(shot)]
        for left in self._folder.glob(armed(0).replace('0', '*')):
            left.unlink()
        self._passed = 0
        if upcoming and upcoming[0] in self._armed:
            self._allow_next()
        self._crashes_before = len(self._crash_records())
        program = [str(_NODE), str(self._folder), str(self._ahead_s), *points]
        self._cell.start_node(program, ['--auto-resume'] if restart.auto_resume else [])
        self._readers.copy(self._cell.node.pid)
        self._tally.figures['clock steps'] += restart.clock_step_s != 0.0
        self._tally.figures['waits'] += not restart.auto_resume
        if self._armed:
            self._cell.node.wait_ready_or_end()
        else:
            self._cell.node.wait_ready()

    def _allow_next(self) -> None:
        """Let the next crash point of the node do what it is for."""
        (self._folder / armed(self._passed)).touch()

    def _words(self, shot: Shot) -> tuple[str, str, str]:
        passes = self._drawn.randint(1, _MOST_PASSES)
        return shot.target, str(passes), STOP if shot.stopped_s else KILL

    def _revive(self) -> None:
        """Start a node again that has ended because it could not write, as a service is."""
        if self._cell.node.is_running or self._cell.node.wait() != os.EX_TEMPFAIL:
            return
        self._tally.figures['ended by itself'] += 1
        self._start_node(_AT_ONCE, self._armed)

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
        published = [event['seq'] for event in watch.events[self._events_checked :]]
        published += [status.seq for status in watch.statuses[self._statuses_checked :]]
        self._events_checked, self._statuses_checked = len(watch.events), len(watch.statuses)
        kept = len(rows(self._journal))
        if max(published, default=0) > kept:
            self._tally.verdict.vanished.append(
                f'event {max(published)} was on a topic; after a kill the journal ends at {kept}'
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
        self._revive()
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
