"""One job on a real cell whose orchestrator and controllers are killed again and again."""

from __future__ import annotations

import json
import random
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cell_processes import CellProcesses
from chaos.crashing_node import POINTS
from chaos.line import SCRIPT, SPEED, cell
from chaos.truth import Controllers, Verdict, journal, judge

from bt_orchestrator.model import events as e

SHARES = ('feeder,conveyor', 'camera,worker,packer')
"""What each process of controllers simulates."""

BOTH = 'both'
"""The orchestrator, and controllers with it."""

STUCK_S = 90.0
"""A job that needs longer than that after the last kill is stuck."""

ANSWERED_S = 2.0
"""An operator who hears nothing for that long answers again."""

_MOST_ANSWERS = 5
"""An operator who was not heard so often opens another terminal."""

_QUIET_S = 15.0
"""So does one who hears no status for that long: there is one a second."""

_MOST_PASSES = 12
"""A crash point is passed at most so often before it kills: a few items' worth of settles."""


@dataclass
class Tally:
    """What a campaign did and what came of it."""

    kills: Counter[str] = field(default_factory=Counter)
    """By what was killed: a crash point, `orchestrator`, a share of the controllers, `both`."""
    with_goals: int = 0
    """Kills of an orchestrator while a goal ran."""
    items: int = 0
    adopted: int = 0
    resent: int = 0
    in_doubt: int = 0
    server_lost: int = 0
    answers: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    verdict: Verdict = field(default_factory=Verdict)

    @property
    def orchestrator_kills(self) -> int:
        """Count the kills of orchestrators, however."""
        return sum(n for name, n in self.kills.items() if name not in SHARES)

    def add(self, other: Tally) -> None:
        """Take in the figures of another job."""
        self.kills += other.kills
        self.answers += other.answers
        for name in ('with_goals', 'items', 'adopted', 'resent', 'in_doubt', 'server_lost'):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        self.seconds += other.seconds
        for name, found in vars(other.verdict).items():
            getattr(self.verdict, name).extend(found)


class _Answered:
    def done(self) -> bool:
        return True


class Campaign:
    """States: running (in `run`), over. The folder keeps journal, logs and what programs said."""

    def __init__(self, folder: Path, seed: int, items: int, kills: Sequence[str]) -> None:
        """Plan a job.

        :param kills: what is killed, in order: as in `Tally.kills`
        """
        self._drawn = random.Random(seed)
        self._plan = iter(kills)
        self._folder = folder
        self._journal = folder / 'journal.sqlite3'
        self._crashes = folder / 'crashes.jsonl'
        self._items = items
        self._killed: dict[str, list[float]] = defaultdict(list)
        self._tally = Tally(items=items)
        options = ['--journal', str(self._journal), '--auto-resume']
        self._cell = CellProcesses(
            folder, cell(self._drawn, items), shares=SHARES, speed=SPEED, run_options=options
        )
        self._asked: Any = _Answered()
        self._patient_until = 0.0
        self._unheard = 0
        self._heard, self._heard_s = 0, time.monotonic()

    def run(self) -> Tally:
        """Run the job to its end, and judge."""
        begun = time.monotonic()
        try:
            self._cell.connect()
            path = self._cell.script(SCRIPT)
            self._cell.watch.submit(path, quantity=self._items, order='WO-1')
            self._shoot_until_the_end()
            self._cell.node.stop()
        finally:
            self._cell.close()
        self._judge()
        self._tally.seconds = time.monotonic() - begun
        return self._tally

    # --- shooting ---------------------------------------------------------------------------

    def _shoot_until_the_end(self) -> None:
        for target in self._plan:
            if self._is_over():
                return
            self._shoot(target)
        if not self._live(STUCK_S):
            self._tally.verdict.stuck.append(f'the job did not end within {STUCK_S:g} s')

    def _shoot(self, target: str) -> None:
        if target in POINTS:
            self._let_crash(target)
            return
        self._live(self._drawn.uniform(0.0, 1.0))
        self._count(target, self._goals_run())
        if target not in SHARES:
            self._cell.node.kill()
        if target in SHARES or target == BOTH:
            self._kill_controllers(self._drawn.choice(SHARES) if target == BOTH else target)
        if target not in SHARES:
            self._start_node()

    def _let_crash(self, point: str) -> None:
        """Replace the node by one that dies at a crash point, and that by an ordinary one."""
        self._cell.node.kill()
        before = len(self._crash_records())
        words = [point, str(self._drawn.randint(1, _MOST_PASSES)), str(self._crashes)]
        self._start_node(crashing=words)
        over = self._live(STUCK_S, unless=lambda: not self._cell.node.is_running)
        records = self._crash_records()[before:]
        if records:
            self._count(point, records[0]['running'])
        elif not over:
            self._tally.verdict.stuck.append(f'{point} was not passed within {STUCK_S:g} s')
        self._cell.node.kill()
        self._start_node()

    def _kill_controllers(self, share: str) -> None:
        place = SHARES.index(share)
        self._cell.sims[place].kill()
        for component in share.split(','):
            self._killed[component].append(time.time())
        self._cell.sims[place] = self._cell.start_sim(share)
        self._cell.sims[place].wait_ready()

    def _start_node(self, crashing: Sequence[str] = ()) -> None:
        self._asked, self._unheard = _Answered(), 0
        self._cell.start_node(crashing)
        if crashing:
            self._cell.node.wait_ready_or_end()
        else:
            self._cell.node.wait_ready()

    def _count(self, what: str, running: int) -> None:
        self._tally.kills[what] += 1
        self._tally.with_goals += what not in SHARES and running > 0

    def _crash_records(self) -> list[dict[str, Any]]:
        if not self._crashes.exists():
            return []
        return [json.loads(line) for line in self._crashes.read_text().splitlines()]

    def _goals_run(self) -> int:
        records = self._cell.goals()
        ended = {r['goal'] for r in records if r['event'] in ('ended', 'died') and 'goal' in r}
        return sum(r['event'] == 'started' and r['goal'] not in ended for r in records)

    # --- living -----------------------------------------------------------------------------

    def _live(self, seconds: float, unless: Callable[[], bool] = lambda: False) -> bool:
        """Let the line run and answer its holds; return whether the job is over."""
        until = time.monotonic() + seconds
        while True:
            self._cell.watch.ros.spin_for(
                until - time.monotonic(),
                lambda: self._look() or unless() or self._is_cut_off(),
            )
            if not self._is_cut_off():
                return self._is_over()
            self._cell.watch.connect_anew()
            self._asked, self._unheard = _Answered(), 0

    def _is_cut_off(self) -> bool:
        if len(self._cell.watch.statuses) != self._heard or not self._cell.node.is_running:
            self._heard, self._heard_s = len(self._cell.watch.statuses), time.monotonic()
        return self._unheard > _MOST_ANSWERS or time.monotonic() - self._heard_s > _QUIET_S

    def _look(self) -> bool:
        for hold in self._cell.watch.status.holds:
            if hold.task and hold.answers:
                self._answer(hold)
        return self._is_over()

    def _is_over(self) -> bool:
        jobs = self._cell.watch.status.jobs
        return any(job.id == 'WO-1' and job.state == 'Ended' for job in jobs)

    def _answer(self, hold: Any) -> None:
        """Do what an operator does who has looked at the machine: its own log is the truth."""
        if not self._asked.done() and time.monotonic() < self._patient_until:
            return
        # Of a node that is no more, perhaps, or that had not discovered the operator yet.
        self._patient_until = time.monotonic() + ANSWERED_S
        self._unheard = 0 if self._asked.done() else self._unheard + 1
        done = any(Controllers(self._cell.log).succeeded(goal) for goal in self._goals_of(hold))
        self._asked = self._cell.watch.send_answer(hold.id, 'mark_done' if done else 'retry')

    def _goals_of(self, hold: Any) -> Iterator[str]:
        for event in journal(self._journal):
            if not isinstance(event, e.TaskStarted):
                continue
            if (event.item or '', event.task) == (hold.item, hold.task):
                yield event.goal

    # --- judging ----------------------------------------------------------------------------

    def _judge(self) -> None:
        events = journal(self._journal)
        tally = self._tally
        found = judge(events, Controllers(self._cell.log), self._killed)
        found.stuck += tally.verdict.stuck
        tally.verdict = found
        tally.adopted = sum(isinstance(x, e.TaskAdopted) for x in events)
        tally.resent = sum(isinstance(x, e.TaskResent) for x in events)
        failed = Counter(x.reason for x in events if isinstance(x, e.TaskFailed))
        tally.in_doubt, tally.server_lost = failed['in_doubt'], failed['server_lost']
        tally.answers.update(
            x.answer for x in events if isinstance(x, e.OperatorDecided) and x.hold is not None
        )
