"""A request: its arguments, who may make it, and when it needs a reason."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from bt_orchestrator.model.by import Role
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.job_control import Method
from bt_orchestrator.model.packml import VERBS, Cause

_CAUSES: Mapping[str, Cause] = {word: cause for cause, word in VERBS.items()}
_METHODS: Mapping[str, Method] = {
    method.verb: method
    for method in (*job_control.METHODS, job_control.REQUEUE, job_control.ANOTHER)
}


class About(Enum):
    """The subject of a request; all but the cell have an id, the first argument."""

    CELL = 'cell'
    QUEUE = 'queue'
    JOB = 'job'
    ITEM = 'item'
    HOLD = 'hold'
    COMPONENT = 'component'
    SCRIPT = 'script'
    STOP = 'stop'
    """A stop of the line, as the account tells it."""


class Kind(Enum):
    """The type of a parameter's value."""

    TEXT = 'text'
    WHOLE = 'whole number'
    YES_NO = 'yes or no'
    TEXTS = 'texts'
    VALUES = 'values by name'
    ORDERS = 'work orders'


class Why(Enum):
    """When a reason is required."""

    FIRST = 'first'
    """The request is refused without a reason."""
    AFTERWARDS = 'afterwards'
    """For emergencies: it is carried out, and a surface asks for the reason afterwards."""
    NEVER = 'never'
    """A reason is kept if one is given."""


@dataclass(frozen=True)
class Parameter:
    """One argument of a request."""

    name: str
    kind: Kind
    meaning: str
    is_required: bool = False
    choices: tuple[str, ...] = ()
    """The only values of a text; empty: any."""
    roles: frozenset[Role] | None = None
    """Roles that may give it; None: the same as for the request."""
    span: tuple[int, int] = (0, 2**32 - 1)
    """Smallest and largest whole number."""


@dataclass(frozen=True)
class Request:
    """One kind of request."""

    word: str
    """The word in commands and in records, for instance abort_job."""
    about: About
    effect: str
    """Its effect, for the user who is about to send it."""
    roles: frozenset[Role]
    moves: bool
    """It can make something move, now or later: in local it is for panels alone (7.8)."""
    parameters: tuple[Parameter, ...] = ()
    why: Why = Why.FIRST
    is_confirmed: bool = False
    """It changes items, queue or belt in a way that cannot be taken back: a surface asks twice."""
    is_limited: bool = False
    """It can be repeated without end, so its rate is limited. A stop, a pause or an answer is
    refused until something undoes it, so it is never delayed."""
    needs_safety: bool = False
    """It is refused while the safety input is not ready (semantics 7.9)."""
    needs_local: bool = False
    """It is asked at a panel of a line in local, and refused in remote (semantics 7.11)."""
    is_manual: bool = False
    """It is for manual mode alone (semantics 7.11), where the line makes nothing."""
    is_sign: bool = False
    """It says that somebody is there, and is not on record."""
    is_of_list: bool = False
    """It changes the list of jobs, and nothing on the line."""
    is_remark: bool = False
    """It says something about a hold, which stays."""
    also: tuple[str, ...] = ()
    """Other words for it that commands take; recorded is `word`."""

    @property
    def name(self) -> str:
        """Unique name, for instance job.pause."""
        return f'{self.about.value}.{self.word}'

    @property
    def subject(self) -> Parameter | None:
        """The id of its subject; None: the cell, which needs no id."""
        return self.parameters[0] if self.about in NAMED else None

    @property
    def cause(self) -> Cause | None:
        """The command of PackML that it gives to the cell; None: PackML has none."""
        return _CAUSES.get(self.word) if self.about is About.CELL else None

    @property
    def method(self) -> Method | None:
        """Its row of the table of job control; None: it is about no job, or moves one."""
        return _METHODS.get(self.word) if self.about is About.JOB else None

    @property
    def is_foreseen(self) -> bool:
        """Whether its effect on the ends of jobs can be worked out before it is made."""
        about = (About.QUEUE, About.JOB, About.COMPONENT, About.SCRIPT)
        return self.about in about and not self.is_of_list and not self.is_manual

    @property
    def takes_code(self) -> bool:
        """Whether a reason of the plant may come with it (semantics 7.10)."""
        return any(parameter.name == 'code' for parameter in self.parameters)

    @property
    def takes_orders(self) -> bool:
        """Whether work orders are among its arguments."""
        return any(parameter.kind is Kind.ORDERS for parameter in self.parameters)


NAMED = {
    About.JOB: Parameter('job', Kind.TEXT, 'id of the job', is_required=True),
    About.ITEM: Parameter('item', Kind.TEXT, 'for example WO-1001/3', is_required=True),
    About.HOLD: Parameter('hold', Kind.TEXT, 'id of the hold', is_required=True),
    About.COMPONENT: Parameter(
        'component', Kind.TEXT, 'name of the component in the cell file', is_required=True
    ),
    About.SCRIPT: Parameter(
        'script',
        Kind.TEXT,
        'digest of the script; or its name, if it is waited for by a job in the queue',
        is_required=True,
    ),
    About.STOP: Parameter(
        'stop',
        Kind.TEXT,
        'name of the stop, as `report --json` and the page tell it: HISTORY:SEQ',
        is_required=True,
    ),
}
"""The first argument, for subjects with an id."""
