"""The figures of a campaign."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from chaos.copying import BACKUP
from chaos.crashing_node import POINTS
from chaos.plan import SHARES, STRIKES, Shot
from chaos.truth import Verdict
from chaos.witnesses import Record


@dataclass
class Tally:
    """What was done and what came of it."""

    planned: Counter[str] = field(default_factory=Counter)
    """Shots, by what they were to kill."""
    kills: Counter[str] = field(default_factory=Counter)
    """By what was killed: a crash point, `orchestrator`, a share of the controllers, `both`."""
    figures: Counter[str] = field(default_factory=Counter)
    """What else was counted, by its name in the report."""
    answers: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    verdict: Verdict = field(default_factory=Verdict)

    @property
    def orchestrator_kills(self) -> int:
        """Count the kills of orchestrators, however."""
        return sum(n for name, n in self.kills.items() if name not in SHARES)

    @property
    def points_without_kill(self) -> list[str]:
        """Name the crash points that were planned and at which nobody died."""
        return [point for point in POINTS if self.planned[point] and not self.kills[point]]

    @property
    def faults(self) -> list[str]:
        """Everything that must not be, one sentence each."""
        unshot = [f'nobody was killed at {point}' for point in self.points_without_kill]
        return [*self.verdict.faults, *unshot]

    def plan(self, shots: Iterable[Shot]) -> None:
        """Note what is to be killed."""
        self.planned.update(shot.target for shot in shots if shot.kills or shot.target in SHARES)

    def count_copies(self, copies: Iterable[Record]) -> None:
        """Note what readings of the journal while it was written have brought."""
        for copy in copies:
            kind = 'copies' if copy['kind'] == BACKUP else 'readings'
            self.figures['refused ' + kind if 'refused' in copy else kind] += 1
            self.figures['copies after a crash'] += copy['after_crash'] and kind == 'copies'

    def add(self, other: Tally) -> None:
        """Take in the figures of another job."""
        for name in ('planned', 'kills', 'figures', 'answers'):
            getattr(self, name).update(getattr(other, name))
        self.seconds += other.seconds
        self.verdict.add(other.verdict)


def lines(total: Tally) -> Iterator[str]:
    """Yield the figures, and every fault."""
    figures, verdict, kills = total.figures, total.verdict, total.orchestrator_kills
    yield f'{figures["items"]} items, {total.seconds:.0f} s; kills: {_listed(total.kills)}'
    points = ', '.join(f'{point} {total.kills[point]}' for point in POINTS)
    yield f'by crash point: {points}'
    if struck := {name: figures[name] for name in ('stops', *STRIKES) if figures[name]}:
        yield f'besides: {_listed(struck)}; ended by itself {figures["ended by itself"]}'
    share = figures['with goals'] / kills if kills else 0.0
    yield (
        f'{kills} kills of the orchestrator, {share:.0%} of them while a goal ran; '
        f'{figures["clock steps"]} starts after the clock was set, '
        f'{figures["waits"]} that waited for an operator'
    )
    yield (
        f'{figures["adopted"]} goals adopted, {figures["resent"]} sent again with their UUID, '
        f'{figures["in doubt"]} in doubt, {figures["lost"]} lost with their server; answers: '
        f'{_listed(total.answers) or "none"}'
    )
    yield (
        f'{figures["copies"]} copies of the journal while it was written, '
        f'{figures["copies after a crash"]} of them after a crash, and {figures["readings"]} '
        f'readings; {figures["refused copies"] + figures["refused readings"]} were refused; '
        f'{figures["looks"]} verbs beside'
    )
    summary = ', '.join(
        f'{name.replace("_", " ")} {len(faults)}' for name, faults in vars(verdict).items()
    )
    yield f'{summary}, points without a kill {len(total.points_without_kill)}'
    yield from total.faults


def _listed(counter: Mapping[str, int]) -> str:
    return ', '.join(f'{name} {count}' for name, count in sorted(counter.items()))
