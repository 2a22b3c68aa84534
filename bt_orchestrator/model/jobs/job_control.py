"""The commands to a job in each of its states: one table, after ISA-95 Job Control (7.2).

Code, documentation and tests are made from it, and every interface asks it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from bt_orchestrator.model.by import Role
from bt_orchestrator.model.cell import Approval
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.words import joined, sentence

Change = Mapping[JobWord | None, JobWord | None]
"""State before and after; None: there is no such job."""


@dataclass(frozen=True, eq=False)
class Method:
    """One thing that can be asked of a job; there is one of each."""

    name: str
    """Method name in ISA-95 Job Control."""
    verb: str
    """The word for it in commands, for instance `job hold JOB`."""
    meaning: str
    changes: Change
    also: tuple[str, ...] = ()
    """Other words for it that commands take."""

    @property
    def title(self) -> str:
        """Both names, as in Start (release)."""
        return self.name if self.name.lower() == self.verb else f'{self.name} ({self.verb})'


NOT_ALLOWED, ALLOWED = JobWord.NOT_ALLOWED_TO_START, JobWord.ALLOWED_TO_START
RUNNING, HELD, SUSPENDED = JobWord.RUNNING, JobWord.HELD, JobWord.SUSPENDED
ENDED, ABORTED = JobWord.ENDED, JobWord.ABORTED

STORE = Method('Store', 'add --held', 'queue an order that may not start yet', {None: NOT_ALLOWED})
STORE_AND_START = Method(
    'StoreAndStart', 'add', 'queue an order; it starts when its turn comes', {None: ALLOWED}
)
START = Method('Start', 'release', 'let a job start when its turn comes', {NOT_ALLOWED: ALLOWED})
REVOKE_START = Method(
    'RevokeStart', 'hold', 'keep a job in its place; others pass it', {ALLOWED: NOT_ALLOWED}
)
UPDATE = Method(
    'Update',
    'update',
    'change quantity, parameters, script or recipe of a job that has not started',
    {NOT_ALLOWED: NOT_ALLOWED, ALLOWED: ALLOWED},
)
PAUSE = Method(
    'Pause', 'pause', 'begin no more items of a job; those on the line go on', {RUNNING: SUSPENDED}
)
RESUME = Method('Resume', 'resume', 'go on with the items of a job', {SUSPENDED: RUNNING})
STOP = Method(
    'Stop',
    'stop',
    'end a job early: its items on the line are finished, and it begins no others',
    dict.fromkeys((RUNNING, HELD, SUSPENDED), ENDED),
)
ABORT = Method(
    'Abort',
    'abort',
    'end a job now: its goals are cancelled, its items are rejected and drain',
    dict.fromkeys((NOT_ALLOWED, ALLOWED, RUNNING, HELD, SUSPENDED), ABORTED),
)
CANCEL = Method(
    'Cancel',
    'cancel',
    'take a job that has not started out of the queue',
    {NOT_ALLOWED: None, ALLOWED: None},
    also=('remove',),
)
CLEAR = Method(
    'Clear',
    'clear',
    'remove an ended job from the list; the journal keeps it',
    {ENDED: None, ABORTED: None},
)

REQUEUE = Method(
    'Requeue',
    'requeue',
    'end a job by recipe early, and queue what it has not begun anew, without what is out of '
    'service',
    STOP.changes,
)
"""Ours: ISA-95 has nothing like it."""

ANOTHER = Method(
    'Another',
    'another',
    'refuse the first piece of a job, whose next item is its first piece then',
    RESUME.changes,
)
"""Ours, too."""

METHODS = (
    STORE,
    STORE_AND_START,
    START,
    REVOKE_START,
    UPDATE,
    PAUSE,
    RESUME,
    STOP,
    ABORT,
    CANCEL,
    CLEAR,
)
"""Those of ISA-95."""

LEFT_WHILE_ENDING: Mapping[str, tuple[Method, ...]] = {'stopping': (ABORT,), 'aborting': ()}
"""The requests about a job that ends when its last item has left."""


MORE_WHILE_PASSED: tuple[Method, ...] = (REVOKE_START,)
"""Further requests about a job that is not held and is passed, because its script is not released
or it lacks a component out of service; `release` changes nothing for it, unless it waits for its
start as well."""

MORE_WHILE_AWAITING: tuple[Method, ...] = (START,)
"""Further requests about a job that is AllowedToStart and waits for its start."""


@dataclass(frozen=True)
class JobFacts:
    """The facts that decide which methods are possible for a job now."""

    word: JobWord
    """Its ISA-95 state."""
    ending: str = ''
    """`stopping` or `aborting`, if it already ends."""
    awaits_start: bool = False
    """It waits for the start of its order (semantics 6.7)."""
    unreleased: str = ''
    """Digest of its script, if that is not released (semantics 6.10)."""
    unavailable: Sequence[str] = ()
    """Components out of service that it needs (semantics 7.5)."""
    is_held: bool = True
    """A person holds it. False: its state NotAllowedToStart has other reasons."""
    is_by_recipe: bool = True
    """Its order named a recipe."""
    left: int = 1
    """How many of its items have not begun."""
    piece: str = ''
    """The first piece whose approval it waits for (semantics 6.12)."""
    piece_left: str = ''
    """How that has left the line; empty: it has not."""

    @property
    def is_passed(self) -> bool:
        """Whether the queue passes it although it is not held."""
        lacks = bool(self.unreleased or self.unavailable)
        return self.word is NOT_ALLOWED and lacks and not self.is_held


def refusal(method: Method, job: str, facts: JobFacts) -> str | None:
    """Say why something cannot be asked of a job now; None: it can."""
    word, ending = facts.word, facts.ending
    if facts.is_passed:
        if method in MORE_WHILE_PASSED:
            return None
        if method is START and not facts.awaits_start:
            return joined(*_passed_words(job, facts.unreleased, facts.unavailable))
    if word is ALLOWED and facts.awaits_start and method in MORE_WHILE_AWAITING:
        return None
    if word not in method.changes:
        fitting = ' or '.join(before.value for before in method.changes if before is not None)
        states = {'job_state': word.value, 'job_states': fitting}
        return sentence('not_for_job', job=job, method=method.title, **states)
    if ending and method not in LEFT_WHILE_ENDING[ending]:
        left_to_ask = ', '.join(other.title for other in LEFT_WHILE_ENDING[ending])
        kind = 'job_ends_but' if left_to_ask else 'job_ends'
        return sentence(kind, job=job, job_state=ending, method=left_to_ask)
    if method is ANOTHER and not facts.piece:
        return sentence('no_first_piece', job=job)
    if method is RESUME and facts.piece and facts.piece_left != 'packed':
        return _no_approval(job, facts)
    return _no_rest(job, facts) if method is REQUEUE else None


def not_approving(job: str, piece: str, role: Role, who: Approval) -> str | None:
    """Say why a role may not approve a first piece (semantics 6.12); None: it may."""
    may = {Role.ENGINEER, *([Role.OPERATE] if who is Approval.OPERATE else [])}
    if not piece or role in may:
        return None
    names = ' or '.join(sorted(approver.value for approver in may))
    return sentence('not_approver', job=job, item=piece, roles=names, role=role.value)


def _no_approval(job: str, facts: JobFacts) -> str:
    """Say why a first piece cannot be approved."""
    if not facts.piece_left:
        return sentence('first_piece_here', item=facts.piece, job=job)
    return sentence('first_piece_lost', item=facts.piece, job=job, left=facts.piece_left)


def _no_rest(job: str, facts: JobFacts) -> str | None:
    """Say why nothing of a job on the line can be made anew; None: something can."""
    if not facts.is_by_recipe:
        return sentence('no_recipe', job=job)
    if not facts.left:
        return sentence('no_rest', job=job)
    return None


def _passed_words(job: str, unreleased: str, unavailable: Sequence[str]) -> Iterator[str]:
    if unreleased:
        yield sentence('not_released', job=job, words=unreleased_words(unreleased))
    if unavailable:
        yield sentence('unavailable', job=job, words=unavailable_words(unavailable))


def lacks_words(unreleased: str, unavailable: Sequence[str]) -> Iterator[str]:
    """Say why a job is passed that is not held, and what lets it start."""
    if unreleased:
        yield unreleased_words(unreleased)
    if unavailable:
        yield unavailable_words(unavailable)


def unreleased_words(digest: str) -> str:
    """Say that a script is not released, and who can do that."""
    return sentence('unreleased', digest=digest)


def unavailable_words(unavailable: Sequence[str]) -> str:
    """Say which components a job lacks, and what lets it start."""
    kind = 'lacks_component' if len(unavailable) == 1 else 'lacks_components'
    return sentence(kind, components=' and '.join(unavailable))
