"""Orders on a line that hostile peers attack, one after the other, while a clock measures."""

from __future__ import annotations

import json
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from attack.attacks.attack import Attack, Bounds
from attack.attacks.servers import ALONE
from attack.attacks.signatures import USERS
from attack.foreign_clock import PID
from attack.line import ITEMS, SCRIPT, UNTRUSTED, cell
from attack.measured import Measured
from attack.outcome import Outcome, Phase
from attack.peer import Target
from attack.steppable_node import AHEAD
from attack.tricky_controllers import NASTY
from attack.verdict import Claims, judge_end
from cell_processes import CellProcesses
from chaos.line import SPEED
from chaos.operator import Operator
from chaos.plan import SHARES
from program_process import ProgramProcess

STUCK_S = 90.0
"""A line that has done nothing for so long after an attack does not go on."""

SILENT_S = 10.0
"""A node that answers nothing for so long stands still, on the slowest machine."""

_LATE_S = 180.0
"""An attacker that needs so much longer than its time was not answered, or hangs."""

_QUIET_S = 0.5
"""What an attack leaves behind shows within that time."""

_HERE = Path(__file__).parent


class Siege:
    """States: running (in `run`), over. The folder keeps journal, logs and what programs said."""

    def __init__(
        self, folder: Path, attacks: Sequence[Attack], seconds: float, seed: int, most_ms: float
    ) -> None:
        """Start everything.

        :param seconds: how long each attack may take
        :param most_ms: how much slower than a plain node the node may answer
        """
        self._folder = folder
        self._attacks = attacks
        self._seconds = seconds
        self._seed = seed
        self._most_ms = most_ms
        self._journal = folder / 'journal.sqlite3'
        (folder / AHEAD).write_text('0')
        self._node_program = [str(_HERE / 'steppable_node.py'), str(folder / AHEAD)]
        self._cell = CellProcesses(
            folder,
            cell(random.Random(seed)),
            shares=SHARES,
            speed=SPEED,
            # The judge needs every event, however many jobs have ended.
            run_options=[
                *('--journal', str(self._journal), '--journal-keep-jobs', '-1'),
                *('--users', str(folder / USERS)),
            ],
            node_program=self._node_program,
        )
        tricky = [str(_HERE / 'tricky_controllers.py'), str(folder / NASTY)]
        self._cell.sims.append(self._cell.start_sim(','.join(UNTRUSTED), tricky))
        self._script = self._cell.script(SCRIPT, 'attacked').stem
        self._operator = Operator(
            self._cell.watch, self._script, ITEMS, self._journal, self._cell.log, spared=ALONE
        )
        self._measured = Measured(folder)
        self._beside: list[ProgramProcess] = []
        self._claims = Claims()
        self._errors_read = self._log_read = self._succeeded = 0

    def run(self, say: Callable[[Phase], None]) -> Outcome:
        """Attack the line, see that it goes on, and judge.

        :param say: is told of each phase that has ended
        """
        outcome, begun = Outcome(), time.monotonic()
        try:
            self._begin()
            for attack in (None, *self._attacks):
                phase = self._phase(attack)
                outcome.phases.append(phase)
                say(phase)
                if not self._cell.node.is_running:
                    outcome.faults.append(f'the node died: {self._cell.node.errors[-500:]}')
                    return outcome
            self._end(outcome)
        finally:
            for process in self._beside:
                process.kill()
            self._cell.close()
            outcome.seconds = time.monotonic() - begun
        return outcome

    def _begin(self) -> None:
        self._cell.connect()
        self._note_pid()
        for name, words in (('plain_node', []), ('foreign_clock', [self._folder, self._journal])):
            program = [str(_HERE / f'{name}.py'), *map(str, words)]
            self._beside.append(ProgramProcess([], self._folder, name, program))
            self._beside[-1].wait_ready()
        begun = time.monotonic()
        if not self._live(STUCK_S, lambda: self._measured.answers_since(begun) > 0):
            raise AssertionError('the foreign clock heard nothing of the node')

    # --- a phase ----------------------------------------------------------------------------

    def _phase(self, attack: Attack | None) -> Phase:
        """Let one attack happen, or none, and see what it did."""
        phase = Phase(attack.name if attack else 'nothing')
        bounds = attack.bounds if attack else Bounds()
        begin, before = time.monotonic(), self._tasks()
        if attack is None:
            self._live(self._seconds)
        else:
            self._attack(attack, phase)
        self._live(_QUIET_S)
        attacked = time.monotonic()
        if bounds.breaks_journal:
            self._restart()
        self._await_work(phase)
        end = time.monotonic()
        phase.seconds, phase.tasks = end - begin, self._tasks() - before
        # A node that is started again is another process, and has just been found.
        measured = attacked if bounds.breaks_journal else end
        phase.figures = self._measured.between(begin, measured, plain_too=bounds.plain_too)
        self._judge(phase, bounds)
        return phase

    def _attack(self, attack: Attack, phase: Phase) -> None:
        known = Target(
            self._cell.watch.name,
            self._cell.node.pid,
            self._beside[0].pid,
            str(self._journal),
            str(self._folder),
            str(self._cell.cell),
            self._script,
        )
        file = self._folder / 'target.json'
        file.write_text(json.dumps(asdict(known)))
        words = [attack.name, str(file), str(self._seed), str(self._seconds)]
        name = f'attack_{attack.name}'
        peer = ProgramProcess(words, self._folder, name, [str(_HERE / 'peer.py')])
        try:
            if not self._live(self._seconds + _LATE_S, lambda: not peer.is_running):
                phase.faults.append(f'the attacker has not ended: {peer.errors[-300:]}')
        finally:
            peer.kill()
        report = next(reversed(_reports(peer.output)), None)
        if report is None or peer.wait():
            phase.faults.append(f'the attack failed: {peer.errors[-500:]}')
        if report is not None:
            phase.counts = report['counts']
            phase.faults += report['complaints']
            self._claims.foreign_goals |= set(report['goals'])

    def _restart(self) -> None:
        """Start the node again, which has no journal any more."""
        self._note_pid('')
        self._cell.node.stop()
        self._cell.start_node(self._node_program)
        self._cell.node.wait_ready()
        self._operator.forget()
        self._errors_read = 0
        self._note_pid()

    def _await_work(self, phase: Phase) -> None:
        """See that the node answers and the line goes on, as soon as the attack is over."""
        now, before = time.monotonic(), self._tasks()
        for process in self._beside:
            assert process.is_running, f'nobody measures any more: {process.errors}'

        def works() -> bool:
            return self._tasks() > before and self._measured.answers_since(now) > 0

        if not self._live(STUCK_S, works):
            phase.faults.append(
                f'the line has not gone on within {STUCK_S:g} s: {self._state_in_words()}'
            )

    def _judge(self, phase: Phase, bounds: Bounds) -> None:
        figures = phase.figures
        most_ms = self._most_ms + 1e3 * bounds.stalls_s
        journal_mb = bounds.journal_mb + phase.tasks * bounds.journal_mb_a_task
        limits = (
            (figures.peak_mb, bounds.peak_mb, 'MB more memory at a time'),
            (figures.grown_mb, bounds.grown_mb, 'MB more memory for good'),
            (figures.journal_mb, journal_mb, 'MB of journal'),
            (figures.silent_s, SILENT_S + bounds.stalls_s, 's without an answer'),
            (figures.excess_ms, most_ms, 'ms for a ping beyond a plain node'),
        )
        for value, most, what in limits:
            if value > most:
                phase.faults.append(f'{value:.1f} {what}, of {most:.1f}')
        errors = self._cell.node.errors
        news, self._errors_read = errors[self._errors_read :], len(errors)
        for word in ('Traceback', 'internal error', '[FATAL]'):
            if word in news and not bounds.breaks_journal:
                where = news.index(word)
                phase.faults.append(f'the node says: {news[max(0, where - 100) : where + 400]!r}')
                break

    # --- the end ----------------------------------------------------------------------------

    def _end(self, outcome: Outcome) -> None:
        """Let the orders end, judge, and see that the journal replays to what was shown."""
        self._operator.gives_more = False
        if not self._live(STUCK_S, self._operator.is_done):
            outcome.faults.append(f'the orders have not ended: {self._state_in_words()}')
        watch = self._cell.watch
        self._live(_QUIET_S)
        shown = watch.status
        self._cell.node.kill()
        watch.statuses.clear()
        self._cell.start_node(self._node_program)
        self._cell.node.wait_ready()
        watch.ros.spin_until(lambda: watch.statuses, 'the status of the node that took over')
        self._claims.orders = [f'WO-{n}' for n in range(1, self._operator.orders + 1)]
        outcome.orders, outcome.items = self._operator.orders, self._operator.orders * ITEMS
        outcome.faults += judge_end(
            self._journal, self._cell.log, watch.events, self._claims, shown, watch.status
        )
        if self._cell.node.stop():
            outcome.faults.append(f'the node ended badly: {self._cell.node.errors[-300:]}')

    # --- living -----------------------------------------------------------------------------

    def _live(self, seconds: float, unless: Callable[[], bool] = lambda: False) -> bool:
        """Let the line run, and the operator do their work; return whether it is enough."""

        def look() -> bool:
            self._operator.look()
            return unless()

        return self._cell.watch.ros.spin_for(seconds, look)

    def _tasks(self) -> int:
        """Count what the controllers have done well, by their own log."""
        with self._cell.log.open('rb') as log:
            log.seek(self._log_read)
            self._succeeded += (news := log.read()).count(b'"succeeded"')
        self._log_read += len(news)
        return self._succeeded

    def _note_pid(self, pid: object = None) -> None:
        """Tell the foreign clock which process the node is; an empty text: none for now."""
        (self._folder / PID).write_text(str(self._cell.node.pid if pid is None else pid))

    def _state_in_words(self) -> str:
        status = self._cell.watch.status
        holds = [f'{hold.id} {hold.reason} {hold.message[:100]}' for hold in status.holds]
        waits = [wait.reason for section in status.sections for wait in section.waits]
        jobs = [f'{job.id} {job.state}' for job in status.jobs]
        failure = f', journal: {status.journal_failure}' if status.journal_failure else ''
        return f'{status.state}{failure}, holds {holds}, waits {waits}, jobs {jobs}'


def _reports(output: str) -> list[dict[str, Any]]:
    lines = [line for line in output.splitlines() if line.startswith('{"complaints"')]
    return [json.loads(line) for line in lines]
