"""The view in plain lines, one for each change that matters: for logs, pipes, dumb terminals."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from bt_orchestrator.model import events as e
from bt_orchestrator.model.branch import Branch, Outcome
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.folds.cell_folds import hold_of
from bt_orchestrator.model.hold_words import hold_words, why_words
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.task_spans import TaskSpan, TaskSpans
from bt_orchestrator.model.texts import one_line
from bt_orchestrator.view.screen import words
from bt_orchestrator.view.screen.advice import Shell, hold_advice, next_choices, next_lines
from bt_orchestrator.view.screen.fit import stay
from bt_orchestrator.view.screen.machine import Hearing

WEIGHTS = {Outcome.RUNNING: 1, Outcome.FAILURE: 1, Outcome.SUCCESS: 2, Outcome.INVALID: 3}


def weight_of(branch: Branch) -> int:
    """Return how much a behaviour matters; what works or waits itself comes first."""
    works = any(child.status is Outcome.RUNNING for child in branch.children)
    return 0 if branch.status is Outcome.RUNNING and not works else WEIGHTS[branch.status]


@dataclass(frozen=True)
class Twig:
    """One line of the picture of a tree."""

    depth: int
    branch: Branch


def printable(branch: Branch) -> Branch:
    """Return a tree whose texts steer no terminal."""
    return replace(
        branch,
        name=one_line(branch.name),
        words=one_line(branch.words),
        children=tuple(map(printable, branch.children)),
    )


def paths(branch: Branch, above: str = '') -> Iterator[tuple[str, Branch]]:
    """Yield every behaviour with its path, the root first."""
    path = f'{above}/{branch.name}'
    yield path, branch
    for child in branch.children:
        yield from paths(child, path)


def twigs(root: Branch, room: int) -> tuple[list[Twig], int]:
    """Return the lines of a tree that find room, and how many behaviours are not shown.

    What does not run is folded first, then what only wraps something that speaks for itself, and
    then what matters least goes.
    """
    lines = list(_all(root, 0))
    total = len(lines)
    for shown in (_live, _essential):
        if len(lines) > room:
            lines = list(shown(root, 0))
    places = stay([weight_of(twig.branch) for twig in lines], room)
    return [lines[place] for place in places], total - len(places)


def _all(branch: Branch, depth: int) -> Iterator[Twig]:
    yield Twig(depth, branch)
    for child in branch.children:
        yield from _all(child, depth + 1)


def _live(branch: Branch, depth: int) -> Iterator[Twig]:
    """Yield what runs with its children, and of all else only the top."""
    yield Twig(depth, branch)
    if branch.status is Outcome.RUNNING:
        for child in branch.children:
            yield from _live(child, depth + 1)


def _essential(branch: Branch, depth: int) -> Iterator[Twig]:
    """Yield what runs or failed, without decorators whose child says it."""
    ticked = [child for child in branch.children if child.status is not Outcome.INVALID]
    if branch.is_decorator and ticked:
        yield from _essential(ticked[0], depth)
        return
    yield Twig(depth, branch)
    if branch.status is Outcome.RUNNING:
        for child in ticked:
            if child.status is not Outcome.SUCCESS:
                yield from _essential(child, depth + 1)


class EventLines:
    """Says what happens, what an operator can do about it, and nothing else."""

    def __init__(self, shell: Shell, say: Callable[[str], object]) -> None:
        self._shell = shell
        self._say = say
        self._progress = Progress()
        self._is_first = True
        self._role: Role | None = None
        self._next: list[str] = []
        self._notes: tuple[str, ...] = ()

    def on_status(self, status: CellStatus) -> None:
        """Say what can be typed where the cell has come to stand."""
        self._role = status.unauthenticated_role
        if self._is_first:
            self._say_all(self._held(status))
        self._is_first = False
        effects = [choice.effect for choice in next_choices(status)]
        if effects != self._next:
            self._next = effects
            self._say_all(f'next: {text}' for text in next_lines(status, self._shell))

    def _held(self, status: CellStatus) -> Iterator[str]:
        """Yield the holds that were raised before the first status."""
        for hold in status.holds:
            yield words.hold_text(hold)
            yield from (f'  {text}' for text in hold_advice(hold, self._shell, self._role))

    def on_event(self, event: e.Event) -> None:
        """Say what happened."""
        self._say_all(self._progress.follow(event))
        if isinstance(event, e.HoldRaised):
            advice = hold_advice(hold_of(event), self._shell, self._role)
            self._say_all(f'  {text}' for text in advice)

    def on_notes(self, notes: Sequence[str]) -> None:
        """Say notes that are new."""
        self._say_all(note for note in notes if note not in self._notes)
        self._notes = tuple(notes)

    def on_tree(self, tree: Branch) -> None:
        """Say nothing."""

    def on_blackboard(self, values: Mapping[str, str]) -> None:
        """Say nothing."""

    def refresh(self) -> None:
        """Say nothing."""

    def _say_all(self, texts: Iterable[str]) -> None:
        for text in texts:
            self._say(text)


class PlainView(EventLines):
    """Says how the cell stands at first, and then what changes."""

    def __init__(self, shell: Shell, say: Callable[[str], object]) -> None:
        super().__init__(shell, say)
        self._hearing = Hearing(time.monotonic())
        self._is_away = True
        self._troubles: list[str] = []
        self._stopped = ''
        self._behaviours: dict[str, str] = {}
        self._variables: dict[str, str] = {}

    def on_status(self, status: CellStatus) -> None:
        """Print the status at first and when the node is back; later only what is no event."""
        self._hearing.heard(time.monotonic())
        troubles = [text for text in (words.failure(status), *words.troubles(status)) if text]
        if self._is_away:
            self._is_away = False
            self._is_first = False
            self._next = [choice.effect for choice in next_choices(status)]
            self._say_all(words.status_lines(status, self._shell))
        else:
            super().on_status(status)
            self._say_all(text for text in troubles if text not in self._troubles)
            gone = [text for text in self._troubles if text not in troubles]
            self._say_all(f'over: {text}' for text in gone)
            if words.stopped(status) != self._stopped:
                self._say_all(text for text in [words.stopped(status)] if text)
        self._stopped = words.stopped(status)
        self._troubles = troubles

    def on_tree(self, tree: Branch) -> None:
        """Say which behaviours came to something else."""
        behaviours = {
            path: f'{branch.status.word}  {branch.words}'.rstrip() for path, branch in paths(tree)
        }
        self._say_changes('tree', self._behaviours, behaviours)
        self._behaviours = behaviours

    def on_blackboard(self, values: Mapping[str, str]) -> None:
        """Say which variables changed."""
        variables = dict(values)
        self._say_changes('blackboard', self._variables, variables)
        self._variables = variables

    def refresh(self) -> None:
        """Say when the node went away."""
        silent_s = self._hearing.silent_s(time.monotonic())
        if silent_s is not None and not self._is_away:
            self._is_away = True
            self._say(f'no news from {self._shell.node} for {words.duration(silent_s)}')

    def _say_changes(self, what: str, before: Mapping[str, str], now: Mapping[str, str]) -> None:
        self._say_all(f'{what} {k}  {v}' for k, v in now.items() if before.get(k) != v)
        self._say_all(f'{what} {key}  is gone' for key in before if key not in now)


# Progress of a line in plain lines, one a step that a person would want to see.


class Progress:
    """Turns the event stream into lines for a terminal or a log."""

    def __init__(self) -> None:
        self.held = False
        """An operator must answer, and nothing goes on."""
        self._start: float | None = None
        self._spans = TaskSpans()

    def follow(self, event: e.Event) -> Iterator[str]:
        """Yield the lines that an event deserves, usually none or one."""
        if self._start is None:
            self._start = event.time
        elif isinstance(event, e.ClockStepped):
            self._start += event.seconds
        for line in self._lines(event):
            yield f'{event.time - self._start:7.2f} s  {line}'

    def _lines(self, event: e.Event) -> Iterator[str]:
        span = self._spans.follow(event)
        if isinstance(event, e.CellStateChanged):
            self.held = event.state == 'Held'
        if span is not None and isinstance(event, e.TaskSucceeded):
            yield _succeeded(span)
        elif type(event) in _LINES:
            yield _LINES[type(event)](event)


def _succeeded(span: TaskSpan) -> str:
    started = span.started
    return f'{_place(started)}{started.name} at {started.action}, {span.seconds:.2f} s'


def _place(event: e.TaskEvent) -> str:
    if event.section is not None:
        return f'section {event.section:<3} {event.item}  '
    if event.key == e.MANUAL_KEY:
        return 'manual      '
    return f'initialization {event.job}  ' if event.job else 'belt        '


def _section(event: e.RoundBegun | e.ItemRemoved, what: str) -> str:
    return f'section {event.section:<3} {event.item}{what}'


def _cell_state(event: e.CellStateChanged) -> str:
    reason = f' ({event.reason})' if event.reason else ''
    return f'cell {event.state}{reason}'


def _round(event: e.RoundBegun) -> str:
    return _section(event, f'  {", ".join(event.tasks)} once more (round {event.n + 1})')


def _job(event: e.JobQueued | e.JobCompleted | e.JobAborted) -> str:
    return f'{event.job} {event.event.split(".")[1]}'


def _failed(event: e.TaskFailed) -> str:
    why = why_words(event.reason, event.message, event.controller_said, event.topic_says)
    return f'{_place(event)}{event.task} failed: {why}'


_LINES: Mapping[type[e.Event], Callable[..., str]] = {
    e.TaskFailed: _failed,
    e.TaskSkipped: lambda event: f'{_place(event)}{event.task} skipped: {event.reason}',
    e.TaskMarkedDone: lambda event: f'{_place(event)}{event.task} marked done',
    e.RoundBegun: _round,
    e.ItemRejected: lambda event: f'item        {event.item} rejected: {event.reason}',
    e.ItemNonconforming: lambda event: f'item        {event.item} nonconforming: {event.reason}',
    e.ItemIdentified: lambda event: f'item        {event.item} is {event.serial}',
    e.ItemRemoved: lambda event: _section(event, f' {event.how.replace("_", " ")}'),
    e.HoldRaised: lambda event: f'HOLD {event.hold}: {hold_words(event)}',
    e.ComponentOutOfService: lambda event: f'{event.component} is out of service ({event.reason})',
    e.ComponentInService: lambda event: f'{event.component} is in service',
    e.ScriptReleased: lambda event: f'script {event.digest} is released ({event.reason})',
    e.CellStateChanged: _cell_state,
    e.SafetyChanged: lambda event: (
        'safety input ready' if event.ready else f'safety input not ready: {event.reason}'
    ),
    e.UnitModeChanged: lambda event: f'cell in {event.mode} ({event.reason})',
    e.ControlChanged: lambda event: f'line in {event.control} ({event.reason})',
    **dict.fromkeys((e.JobQueued, e.JobCompleted, e.JobAborted), _job),
}
"""The sentence of an event that needs none before it."""
