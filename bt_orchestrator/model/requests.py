"""Everything that can be asked of a cell, a job, an item or a hold: one table.

Verbs, services, help and documentation come from it, and so does who may ask what. In which state
something is possible is not restated here: `packml`, `job_control` and `failures` decide it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum

from bt_orchestrator.model import failures
from bt_orchestrator.model.by import By
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_control import Method
from bt_orchestrator.model.packml import VERBS, Cause, PackmlState, possible_in
from bt_orchestrator.model.roles import Role
from bt_orchestrator.model.wish import STOP_AFTER


class About(Enum):
    """What a request is about; all but a cell are named by an id, the first argument."""

    CELL = 'cell'
    QUEUE = 'queue'
    JOB = 'job'
    ITEM = 'item'
    HOLD = 'hold'


class Kind(Enum):
    """What the value of a parameter is."""

    TEXT = 'text'
    WHOLE = 'whole number'
    YES_NO = 'yes or no'
    TEXTS = 'texts'
    VALUES = 'values by name'
    ORDERS = 'work orders'


class Why(Enum):
    """When somebody has to say why."""

    FIRST = 'first'
    """The request is refused without a reason."""
    AFTERWARDS = 'afterwards'
    """Danger does not wait: it is carried out, and a surface asks for the reason then."""
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


@dataclass(frozen=True)
class Request:
    """One thing that can be asked."""

    word: str
    """As people type it and as it is recorded, for instance abort_job."""
    about: About
    effect: str
    """What it does, for somebody who is about to ask it."""
    roles: frozenset[Role]
    parameters: tuple[Parameter, ...] = ()
    why: Why = Why.FIRST
    is_confirmed: bool = False
    """It changes items, queue or belt in a way that cannot be taken back: a surface asks twice."""

    @property
    def name(self) -> str:
        """Name that no other request has, for instance job.pause."""
        return f'{self.about.value}.{self.word}'

    @property
    def subject(self) -> Parameter | None:
        """The id of what it is about; None: of the cell there is only one."""
        return self.parameters[0] if self.about in _NAMED else None


_NAMED = {
    About.JOB: Parameter('job', Kind.TEXT, 'id of the job', is_required=True),
    About.ITEM: Parameter('item', Kind.TEXT, 'for example WO-1001/3', is_required=True),
    About.HOLD: Parameter('hold', Kind.TEXT, 'id of the hold', is_required=True),
}

_ENGINEERS = frozenset({Role.ENGINEER})
_OPERATORS = frozenset({Role.OPERATE, Role.ENGINEER})
_PLANNERS = frozenset({Role.MES, Role.ENGINEER})
_BOTH = _OPERATORS | _PLANNERS


def _request(
    about: About,
    word: str,
    effect: str,
    roles: frozenset[Role],
    *parameters: Parameter,
    why: Why = Why.FIRST,
    is_confirmed: bool = False,
) -> Request:
    subject = (_NAMED[about],) if about in _NAMED else ()
    return Request(word, about, effect, roles, (*subject, *parameters), why, is_confirmed)


# --- the cell (semantics 7.2, 7.3) --------------------------------------------------------------

_HOLD = Parameter('hold', Kind.TEXT, 'release this pause or hold of the cell, whoever paused')
_EVERYONES = Parameter('everyones', Kind.YES_NO, 'release every pause of a person, whoever paused')
_BELT = Parameter('belt', Kind.TEXTS, 'every slot, as in 1=WO-1/3 and 2=empty')
_AS_SHOWN = Parameter('as_shown', Kind.WHOLE, 'the belt is as the status with this seq shows it')

_CELL: Mapping[Cause, Request] = {
    Cause.RESET: _request(
        About.CELL,
        VERBS[Cause.RESET],
        'gets a cell that is Stopped or Complete ready to start',
        _OPERATORS,
    ),
    Cause.START: _request(
        About.CELL, VERBS[Cause.START], 'lets a cell that is Idle begin to work', _OPERATORS
    ),
    Cause.HOLD: _request(
        About.CELL,
        VERBS[Cause.HOLD],
        'starts nothing more; what runs goes on to its end',
        _OPERATORS,
        why=Why.AFTERWARDS,
    ),
    Cause.UNHOLD: _request(
        About.CELL,
        VERBS[Cause.UNHOLD],
        'lets the cell go on after a pause, or after a restart',
        _OPERATORS,
        _HOLD,
        _EVERYONES,
    ),
    Cause.STOP: _request(
        About.CELL,
        VERBS[Cause.STOP],
        'finishes the cycles in hand, then stops; orders wait for a start',
        _OPERATORS,
        why=Why.AFTERWARDS,
    ),
    Cause.ABORT: _request(
        About.CELL,
        VERBS[Cause.ABORT],
        'cancels every goal now; items and queue are kept',
        _OPERATORS,
        why=Why.AFTERWARDS,
    ),
    Cause.CLEAR: _request(
        About.CELL,
        VERBS[Cause.CLEAR],
        'says what stands on the belt of a cell that was aborted; it is Stopped then',
        _ENGINEERS,
        _BELT,
        _AS_SHOWN,
        is_confirmed=True,
    ),
}

_STOP_AFTERS = tuple(
    _request(About.CELL, STOP_AFTER + after, effect, _OPERATORS)
    for after, effect in (
        ('item', 'begins no more items, lets the line run empty, then stops'),
        ('job', 'begins no more jobs, lets the line run empty, then stops'),
        ('never', 'takes back that the line runs empty and stops'),
    )
)

# --- the queue and its jobs (semantics 6.6) -----------------------------------------------------

_ADD = _request(
    About.QUEUE, 'add', 'queues work orders in this order, all or none', _BOTH,
    Parameter('orders', Kind.ORDERS, 'work orders', is_required=True),
    Parameter('position', Kind.WHOLE, 'place of the first, from 1; the end unless it is said'),
    Parameter('held', Kind.YES_NO, 'keep them from starting'),
    why=Why.NEVER,
)  # fmt: skip

_MOVE = _request(
    About.JOB, 'move', 'puts a queued job at another place', _OPERATORS,
    Parameter('position', Kind.WHOLE, 'place in the queue, from 1', is_required=True),
)  # fmt: skip
_NEXT = _request(
    About.JOB, 'next', 'puts a queued job in front of all others, and releases it', _OPERATORS
)


def _of_method(
    method: Method, roles: frozenset[Role], *parameters: Parameter, is_confirmed: bool = False
) -> Request:
    return _request(
        About.JOB, method.verb, method.meaning, roles, *parameters, is_confirmed=is_confirmed
    )


_UPDATE = _of_method(
    job_control.UPDATE,
    _PLANNERS,
    Parameter('quantity', Kind.WHOLE, 'items to make'),
    Parameter('params', Kind.VALUES, 'parameters of the script'),
    Parameter('script', Kind.TEXT, 'name of a script; the node reads it anew'),
    Parameter('priority', Kind.WHOLE, 'the higher the more urgent'),
    Parameter('start', Kind.TEXT, 'when it should begin, with time zone; none: take it away'),
    Parameter('due', Kind.TEXT, 'when it should have ended, with time zone; none: take it away'),
    Parameter('details', Kind.VALUES, 'JSON of the customer; empty: take it away'),
)

_JOB: tuple[tuple[Method, Request], ...] = (
    (job_control.START, _of_method(job_control.START, _BOTH)),
    (job_control.REVOKE_START, _of_method(job_control.REVOKE_START, _BOTH)),
    (job_control.UPDATE, _UPDATE),
    (job_control.PAUSE, _of_method(job_control.PAUSE, _BOTH)),
    (job_control.RESUME, _of_method(job_control.RESUME, _BOTH)),
    (job_control.STOP, _of_method(job_control.STOP, _BOTH)),
    (job_control.ABORT, _of_method(job_control.ABORT, _ENGINEERS, is_confirmed=True)),
    (job_control.CANCEL, _of_method(job_control.CANCEL, _PLANNERS, is_confirmed=True)),
    # It changes only what is listed, and whoever ordered a job has to be able to tick it off.
    (job_control.CLEAR, _of_method(job_control.CLEAR, _BOTH)),
)

# --- items and holds (semantics 7.1) ------------------------------------------------------------

_REMOVE_ITEM = _request(
    About.ITEM, 'remove_item', 'records that an item was taken off the belt by hand; it leaves an '
    'empty position', _ENGINEERS, is_confirmed=True,
)  # fmt: skip

_RESULTS = Parameter(
    'results', Kind.VALUES, 'result fields of the task, for later tasks that refer to them'
)

_ANSWERS: Mapping[str, Request] = {
    request.word: request
    for request in (
        _request(About.HOLD, failures.RETRY, 'tries the task once more', _OPERATORS),
        _request(
            About.HOLD, failures.MARK_DONE, 'the task was done: its item goes on as after success',
            _OPERATORS, _RESULTS,
        ),
        _request(
            About.HOLD, failures.SKIP, 'the item goes on without the task; its flags count as '
            'performed', _OPERATORS,
        ),
        _request(
            About.HOLD, failures.REJECT, 'the item is rejected: later tasks are skipped, and it '
            'leaves the line as scrap', _OPERATORS, is_confirmed=True,
        ),
        _request(
            About.HOLD, failures.ABORT_JOB, 'ends the job of the item: its goals are cancelled, '
            'its items on the line are rejected and drain', _ENGINEERS, is_confirmed=True,
        ),
    )
}  # fmt: skip

TABLE: tuple[Request, ...] = (
    *_CELL.values(),
    *_STOP_AFTERS,
    _ADD,
    _MOVE,
    _NEXT,
    *(request for _, request in _JOB),
    _REMOVE_ITEM,
    *_ANSWERS.values(),
)
"""All requests, in the order of the documentation."""

REQUESTS: Mapping[str, Request] = {request.name: request for request in TABLE}
"""By name."""


# --- what is possible now -----------------------------------------------------------------------


def of_cell(state: PackmlState) -> tuple[Request, ...]:
    """Return what may be asked of the cell in a state; of a broken one only `abort`."""
    return (*(_CELL[cause] for cause in possible_in(state)), *_STOP_AFTERS)


def of_job(word: JobWord, ending: str = '') -> tuple[Request, ...]:
    """Return what may be asked of a job in a state.

    :param ending: `stopping` or `aborting` if the job already ends
    """
    is_queued = word in (JobWord.NOT_ALLOWED_TO_START, JobWord.ALLOWED_TO_START)
    places = (_MOVE, _NEXT) if is_queued else ()
    fitting = (
        request
        for method, request in _JOB
        if job_control.refusal(method, '', word, ending) is None
    )
    return (*places, *fitting)


def of_hold(answers: Iterable[str]) -> tuple[Request, ...]:
    """Return the requests behind the answers that a hold offers, in its order."""
    others = {VERBS[Cause.UNHOLD]: _CELL[Cause.UNHOLD], _REMOVE_ITEM.word: _REMOVE_ITEM}
    known = {**_ANSWERS, **others}
    return tuple(known[answer] for answer in answers if answer in known)


# --- asking -------------------------------------------------------------------------------------


class BadArguments(ValueError):
    """Arguments that a request does not have, or that it lacks; says what was expected."""


@dataclass(frozen=True)
class Asked:
    """A request, what it is about, and who makes it."""

    request: Request
    by: By
    arguments: Mapping[str, object] = field(default_factory=dict)
    """By name; parameters that were not said are left out."""


def ask(name: str, by: By, **arguments: object) -> Asked:
    """Return a request with its arguments; those that are None are left out.

    :param name: in `REQUESTS`, for instance hold.retry
    :raises BadArguments: it has other parameters, one is missing, or a value is none of its kind
    """
    request = REQUESTS.get(name)
    if request is None:
        raise BadArguments(f'there is no request {name!r}; one of {", ".join(REQUESTS)}')
    known = {parameter.name: parameter for parameter in request.parameters}
    given = {key: value for key, value in arguments.items() if value is not None}
    for key in given:
        if key not in known:
            expected = ', '.join(known) or 'nothing'
            raise BadArguments(f'{name} takes {expected}; found {key}')
    for parameter in request.parameters:
        _check(name, parameter, given)
    return Asked(request, by, given)


_TYPES: Mapping[Kind, tuple[type, ...]] = {
    Kind.TEXT: (str,),
    Kind.WHOLE: (int,),
    Kind.YES_NO: (bool,),
    Kind.TEXTS: (list, tuple),
    Kind.VALUES: (Mapping,),
    Kind.ORDERS: (list, tuple),
}


def _check(name: str, parameter: Parameter, given: Mapping[str, object]) -> None:
    if parameter.name not in given:
        if parameter.is_required:
            raise BadArguments(f'{name} needs {parameter.name}: {parameter.meaning}')
        return
    value = given[parameter.name]
    is_bool_for_whole = parameter.kind is Kind.WHOLE and isinstance(value, bool)
    if not isinstance(value, _TYPES[parameter.kind]) or is_bool_for_whole:
        expected = f'{parameter.name} of {name} is {parameter.kind.value}'
        raise BadArguments(f'{expected} ({parameter.meaning}); found {value!r}')
    if parameter.choices and value not in parameter.choices:
        choices = ', '.join(parameter.choices)
        raise BadArguments(f'{parameter.name} of {name} is one of {choices}; found {value!r}')
