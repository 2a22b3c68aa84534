"""Orders on a cell whose leaders are killed and stopped; a standby goes on each time (9.4).

Each node is on a machine of its own, as far as it knows: its boot has another id than the boots of
the nodes before and after it.
"""

from __future__ import annotations

import os
import random
import signal
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from cell_processes import CellProcesses
from chaos.crashing_node import BOOT, CRASHES, KILL, POINTS, STOP, armed
from chaos.database import Database
from chaos.line import LONG_REMEMBERED_S, SCRIPT, SPEED, cell
from chaos.operator import Operator
from chaos.plan import SHARES
from chaos.truth import Controllers, Verdict, journal, judge
from program_process import ProgramProcess

from bt_orchestrator.model import events as e

STUCK_S = 90.0

ON_ITS_WAY_S = 0.05
"""A goal that is accepted so soon after the death of a leader was sent by that leader."""

_MOST_PASSES = 12

_NODE = Path(__file__).with_name('crashing_node.py')

_WRITERS = """
CREATE TABLE IF NOT EXISTS public.writers (seq bigint, session text);
CREATE OR REPLACE FUNCTION public.note_writer() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN INSERT INTO public.writers VALUES (NEW.seq, (
  SELECT concat(pid, backend_start) FROM pg_stat_get_activity(pg_backend_pid())));
RETURN NEW; END $$;
CREATE TRIGGER note_writer BEFORE INSERT ON cell_1.events
    FOR EACH ROW EXECUTE FUNCTION public.note_writer()
"""
"""Notes which session has written each event; the number of a process may come again."""


@dataclass
class Counts:
    """The figures of a campaign."""

    kills: int = 0
    stops: int = 0
    items: int = 0
    resent: int = 0
    in_doubt: int = 0
    without_a_person: int = 0
    """Take-overs after which no operator was asked before the next one."""
    after_s: dict[str, list[float]] = field(default_factory=dict)
    """Times from the death of a leader, by what they end with."""
    verdict: Verdict = field(default_factory=Verdict)

    def lines(self) -> Iterator[str]:
        """Yield the figures, and every fault."""
        both = self.kills + self.stops
        yield f'{self.items} items; leaders killed: {self.kills}, stopped: {self.stops}'
        yield (
            f'{self.without_a_person} of {both} take-overs without a person; {self.resent} goals '
            f'sent again with their UUID, {self.in_doubt} in doubt'
        )
        for what, times in sorted(self.after_s.items()):
            median, most = statistics.median(times), max(times)
            yield f'{what}: median {median:.2f} s, at most {most:.2f} s ({len(times)})'
        summary = ', '.join(
            f'{name.replace("_", " ")} {len(faults)}'
            for name, faults in vars(self.verdict).items()
        )
        yield summary
        yield from self.verdict.faults


class Succession:
    """States: running (in `run`), over. The folder keeps logs and what programs said."""

    def __init__(self, folder: Path, seed: int, items: int, kills: int, stops: int) -> None:
        """Plan it; crash points take turns."""
        self._folder = folder
        self._drawn = random.Random(seed)
        shots = [KILL] * kills + [STOP] * stops
        self._drawn.shuffle(shots)
        points = list(POINTS)
        self._shots = [(points[n % len(points)], how) for n, how in enumerate(shots)]
        self._counts = Counts()
        self._items = items
        self._database = Database()
        options = ['--journal', self._database.address, '--standby', '--auto-resume']
        self._cell = CellProcesses(
            folder,
            cell(self._drawn, items, LONG_REMEMBERED_S),
            shares=SHARES,
            speed=SPEED,
            run_options=options,
            node_program=self._program(0),
        )
        self._leader = self._cell.node
        self._old: list[ProgramProcess] = []
        script = self._cell.script(SCRIPT).stem
        rows = self._database.rows
        self._operator = Operator(self._cell.watch, script, items, rows, self._cell.log)

    def run(self) -> Counts:
        """Run the orders to their end, and judge."""
        try:
            self._leader.wait_ready('tree node ready: ')
            self._cell.connect()
            for statement in _WRITERS.replace('CREATE TRIGGER', '\0CREATE TRIGGER').split('\0'):
                self._database.execute(statement)
            for number, (_, how) in enumerate(self._shots):
                self._take_over(number, how)
            self._operator.gives_more = False
            if not self._live(STUCK_S, self._operator.is_done):
                self._counts.verdict.stuck.append(f'the orders did not end within {STUCK_S:g} s')
            self._leader.stop()
            self._judge()
        finally:
            for node in (self._leader, *self._old):
                node.kill()
            self._cell.close()
            self._database.close()
        return self._counts

    def _program(self, number: int) -> Sequence[str]:
        """Return what Python runs as the node of a number, on a machine of its own."""
        folder = self._folder / f'machine_{number}'
        folder.mkdir(parents=True)
        (folder / BOOT).write_text(f'boot-{number}')
        shot = self._shots[number] if number < len(self._shots) else None
        nth = str(self._drawn.randint(1, _MOST_PASSES))
        return [str(_NODE), str(folder), '0.0', *((shot[0], nth, shot[1]) if shot else ())]

    def _take_over(self, number: int, how: str) -> None:
        folder, old = self._folder / f'machine_{number}', self._leader
        name = f'node_{number + 1}'
        standby = self._cell.start_beside(name, program=self._program(number + 1))
        self._old.append(standby)
        standby.wait_ready('standby ready: ')
        # The others have just been started, and do not see the servers yet.
        can_take_over = number % 2 == 0
        if can_take_over:
            self._live(STUCK_S, lambda: self._can_take_over(standby))
        (folder / armed(0)).touch()
        crash = folder / CRASHES
        if not self._live(STUCK_S, crash.exists):
            self._counts.verdict.stuck.append(f'{self._shots[number]} was not passed')
            old.send(signal.SIGKILL)
            crash.touch()
        if not self._live(STUCK_S, lambda: 'tree node ready: ' in standby.output):
            self._counts.verdict.stuck.append(f'no take-over after {self._shots[number]}')
        led = time.time()
        died = crash.stat().st_mtime
        self._operator.forget()
        self._live(STUCK_S, lambda: self._goal_after(died) is not None)
        goal = self._goal_after(died)
        self._note(
            f'{how}, standby {"can take over" if can_take_over else "is new"}: ', died, led, goal
        )
        if how == KILL:
            self._counts.kills += 1
            old.kill()
        else:
            self._counts.stops += 1
            old.send(signal.SIGCONT)
            status = old.wait(20.0)
            if status != os.EX_TEMPFAIL:
                self._counts.verdict.stuck.append(f'a leader that went on ended with {status}')
        self._old.remove(standby)
        self._leader = self._cell.node = standby

    def _can_take_over(self, standby: ProgramProcess) -> bool:
        """Tell whether the leader has heard from a standby that it could."""
        known = self._cell.watch.status.leadership.standbys
        return any(entry.process == standby.pid and not entry.trouble for entry in known)

    def _note(self, when: str, died: float, led: float, goal: float | None) -> None:
        for what, moment in (('next leader', led), ('next goal', goal)):
            if moment is not None:
                self._counts.after_s.setdefault(when + what, []).append(moment - died)

    def _goal_after(self, died: float) -> float | None:
        """Return when a controller accepted the first goal after the death of a leader."""
        times = (record['time'] for record in self._cell.goals(event='accepted'))
        return next((moment for moment in times if moment > died + ON_ITS_WAY_S), None)

    def _live(self, seconds: float, unless: Callable[[], bool]) -> bool:
        """Let the line run, and the operator do theirs; return whether it is enough."""
        until = time.monotonic() + seconds

        def look() -> bool:
            self._operator.look()
            return unless() or self._operator.is_cut_off(node_lives=True)

        while True:
            self._cell.watch.ros.spin_for(until - time.monotonic(), look)
            if unless() or time.monotonic() >= until:
                return unless()
            self._cell.watch.connect_anew()
            self._operator.forget()

    def _judge(self) -> None:
        counts, events = self._counts, journal(self._database.rows)
        counts.verdict.add(judge(events, Controllers(self._cell.log), {}))
        seqs = [event.seq for event in events]
        if seqs != list(range(1, len(events) + 1)):
            counts.verdict.untrue.append('the numbers of the events have gaps')
        counts.verdict.untrue += self._late_writers()
        counts.items = self._operator.orders * self._items
        counts.resent = sum(isinstance(x, e.TaskResent) for x in events)
        counts.in_doubt = sum(
            isinstance(x, e.TaskFailed) and x.reason == 'in_doubt' for x in events
        )
        asked = [False]
        for event in events:
            if isinstance(event, e.OrchestratorStarted):
                asked.append(False)
            asked[-1] |= isinstance(event, e.OperatorDecided) and event.hold is not None
        counts.without_a_person = asked[2:].count(False)

    def _late_writers(self) -> Iterator[str]:
        """Yield each event that a session wrote after a later session had begun to write."""
        seen: list[str] = []
        rows = self._database.ask_all('SELECT seq, session FROM public.writers ORDER BY seq')
        for seq, session in rows:
            if session in seen[:-1]:
                yield f'event {seq} was written by a leader after the next one had begun'
            elif session not in seen:
                seen.append(session)
