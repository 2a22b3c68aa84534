"""All requests, row by row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from bt_orchestrator.model import failures
from bt_orchestrator.model.by import Control, Role
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.job_control import Method
from bt_orchestrator.model.packml import VERBS, Cause, UnitMode
from bt_orchestrator.model.requests.request import NAMED, About, Kind, Parameter, Request, Why
from bt_orchestrator.model.stop_reason import AFTER, NEVER, STOP_AFTER

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
    moves: bool,
    **more: Any,
) -> Request:
    subject = (NAMED[about],) if about in NAMED else ()
    return Request(word, about, effect, roles, moves, (*subject, *parameters), **more)


CODE = Parameter('code', Kind.TEXT, "code of the plant's reason for the stop of the line")
"""Of the requests that stop the line, or end a stop (semantics 7.10)."""

# --- the cell (semantics 7.2, 7.3) --------------------------------------------------------------

_HOLD = Parameter(
    'hold', Kind.TEXT, 'release this pause or hold of the cell, also one of another person'
)
_EVERYONES = Parameter('everyones', Kind.YES_NO, 'release the pauses of all persons')
_BELT = Parameter('belt', Kind.TEXTS, 'every slot, as in 1=WO-1/3 and 2=empty')
_AS_SHOWN = Parameter(
    'as_shown',
    Kind.WHOLE,
    'the belt is as the status with this seq shows it',
    span=(0, 2**64 - 1),
)

CELL: Mapping[Cause, Request] = {
    Cause.RESET: _request(
        About.CELL,
        VERBS[Cause.RESET],
        'gets the cell ready to start',
        _OPERATORS,
        is_limited=True,
        moves=True,
        needs_safety=True,
    ),
    Cause.START: _request(
        About.CELL,
        VERBS[Cause.START],
        'lets the cell begin to work',
        _OPERATORS,
        moves=True,
        needs_safety=True,
        is_limited=True,
    ),
    Cause.HOLD: _request(
        About.CELL,
        VERBS[Cause.HOLD],
        'starts nothing more; what runs goes on to its end',
        _OPERATORS,
        CODE,
        why=Why.AFTERWARDS,
        moves=False,
    ),
    Cause.UNHOLD: _request(
        About.CELL,
        VERBS[Cause.UNHOLD],
        'lets the cell go on after a pause, or after a restart',
        _OPERATORS,
        _HOLD,
        _EVERYONES,
        CODE,
        is_limited=True,
        moves=True,
        needs_safety=True,
    ),
    Cause.STOP: _request(
        About.CELL,
        VERBS[Cause.STOP],
        'finishes the cycles in hand, then stops; orders wait for a start',
        _OPERATORS,
        CODE,
        why=Why.AFTERWARDS,
        moves=False,
    ),
    Cause.ABORT: _request(
        About.CELL,
        VERBS[Cause.ABORT],
        'cancels every goal now; items and queue are kept',
        _OPERATORS,
        CODE,
        why=Why.AFTERWARDS,
        moves=False,
    ),
    Cause.CLEAR: _request(
        About.CELL,
        VERBS[Cause.CLEAR],
        'says what stands on the belt of a cell that was aborted; it is Stopped then',
        _ENGINEERS,
        _BELT,
        _AS_SHOWN,
        is_confirmed=True,
        is_limited=True,
        moves=True,
        needs_safety=True,
    ),
}

STOP_AFTERS: Mapping[str, Request] = {
    after: _request(
        About.CELL,
        STOP_AFTER + after,
        effect,
        _OPERATORS,
        moves=after == NEVER,
        is_limited=True,
    )
    for after, effect in (
        *(
            (after, f'begins no more {after}s, lets the line run empty, then stops')
            for after in AFTER
        ),
        (NEVER, 'withdraws the request to run the line empty'),
    )
}
"""By the word for after what."""

CONTROLS: Mapping[Control, Request] = {
    Control.LOCAL: _request(
        About.CELL,
        Control.LOCAL.value,
        'lets only the panels of the line move it; what runs goes on',
        _OPERATORS,
        moves=False,
        is_limited=True,
    ),
    Control.REMOTE: _request(
        About.CELL,
        Control.REMOTE.value,
        'lets everybody move the line again who may; asked at a panel',
        _OPERATORS,
        moves=True,
        is_limited=True,
    ),
}
"""From where the line may be moved (semantics 7.8)."""

UNIT_MODES: Mapping[UnitMode, Request] = {
    UnitMode.MANUAL: _request(
        About.CELL,
        UnitMode.MANUAL.value,
        'lets the cell stand, and an engineer at a panel run single goals',
        _ENGINEERS,
        moves=True,
        needs_local=True,
        needs_safety=True,
        is_limited=True,
    ),
    UnitMode.PRODUCTION: _request(
        About.CELL,
        UnitMode.PRODUCTION.value,
        'ends manual mode, and says what stands on the belt; orders wait for a start',
        _ENGINEERS,
        _BELT,
        _AS_SHOWN,
        moves=True,
        is_confirmed=True,
        is_limited=True,
        is_manual=True,
    ),
}
"""How the cell is used (semantics 7.11)."""

AT_PANEL = _request(
    About.CELL, 'at_panel', 'says that somebody still is at the panel that a goal of manual mode '
    'was sent from; not on record', _ENGINEERS,
    moves=True, needs_local=True, why=Why.NEVER, is_limited=True, is_manual=True, is_sign=True,
)  # fmt: skip

# --- the queue and its jobs (semantics 6.6) -----------------------------------------------------

ADD = _request(
    About.QUEUE, 'add', 'queues work orders in this order, all or none', _BOTH,
    Parameter('orders', Kind.ORDERS, 'work orders', is_required=True),
    Parameter('position', Kind.WHOLE, 'place of the first, from 1; else by priority and start'),
    Parameter('held', Kind.YES_NO, 'keep them from starting'),
    moves=False, why=Why.NEVER, is_limited=True,
)  # fmt: skip

ARRANGE = _request(
    About.QUEUE, 'arrange', 'puts the queue into the order that was proposed, if it is as it was',
    _OPERATORS,
    Parameter(
        'queue_digest', Kind.TEXT, 'of the queue that it was proposed for', is_required=True
    ),
    Parameter('jobs', Kind.TEXTS, 'ids in the new order, as proposed', is_required=True),
    moves=True, is_limited=True,
)  # fmt: skip

MOVE = _request(
    About.JOB, 'move', 'puts a queued job at another place', _OPERATORS,
    Parameter('position', Kind.WHOLE, 'place in the queue, from 1', is_required=True),
    moves=True, is_limited=True,
)  # fmt: skip
NEXT = _request(
    About.JOB, 'next', 'puts a queued job in front of all others, and releases it', _OPERATORS,
    moves=True, is_limited=True,
)  # fmt: skip


def _of_method(
    method: Method, roles: frozenset[Role], *parameters: Parameter, **more: Any
) -> Request:
    word, also = method.verb, method.also
    return _request(About.JOB, word, method.meaning, roles, *parameters, also=also, **more)


UPDATE = _of_method(
    job_control.UPDATE,
    _PLANNERS,
    Parameter('quantity', Kind.WHOLE, 'items to make'),
    Parameter('params', Kind.VALUES, 'parameters of the script'),
    Parameter('script', Kind.TEXT, 'name of a script; the node reads it anew', roles=_ENGINEERS),
    Parameter(
        'recipe',
        Kind.TEXTS,
        'in place of a script: names of recipes, the first that can be made',
        roles=_ENGINEERS,
    ),
    Parameter('version', Kind.WHOLE, 'version of the recipe', roles=_ENGINEERS),
    Parameter(
        'bind', Kind.VALUES, 'component that does an operation, by its id', roles=_ENGINEERS
    ),
    Parameter('priority', Kind.WHOLE, 'the higher the more urgent', span=(-(2**15), 2**15 - 1)),
    Parameter('start', Kind.TEXT, 'when it should begin, with time zone; none: take it away'),
    Parameter('due', Kind.TEXT, 'when it should have ended, with time zone; none: take it away'),
    Parameter('details', Kind.VALUES, 'JSON of the customer; empty: take it away'),
    moves=True,
    is_limited=True,
)

REQUEUE = _of_method(
    job_control.REQUEUE,
    _BOTH,
    Parameter('order', Kind.TEXT, 'id of the new order; else that of the job, with -rest'),
    moves=True,
    is_limited=True,
)

_CONTROLS = (
    _of_method(job_control.START, _BOTH, moves=True, is_limited=True),
    _of_method(job_control.REVOKE_START, _BOTH, moves=False),
    UPDATE,
    _of_method(job_control.PAUSE, _BOTH, CODE, moves=False),
    _of_method(job_control.RESUME, _BOTH, moves=True, is_limited=True),
    _of_method(job_control.ANOTHER, _OPERATORS, moves=True, is_limited=True),
    _of_method(job_control.STOP, _BOTH, moves=False),
    REQUEUE,
    _of_method(job_control.ABORT, _ENGINEERS, moves=True, is_confirmed=True),
    _of_method(job_control.CANCEL, _PLANNERS, moves=True, is_confirmed=True),
    # It changes only the list; the MES that ordered a job must be able to clear it.
    _of_method(job_control.CLEAR, _BOTH, moves=False, is_of_list=True),
)

# --- items and holds (semantics 7.1) ------------------------------------------------------------

REMOVE_ITEM = _request(
    About.ITEM, 'remove_item', 'records that an item was taken off the belt by hand; it leaves an '
    'empty position', _ENGINEERS, moves=True, is_confirmed=True,
)  # fmt: skip

_RESULTS = Parameter(
    'results', Kind.VALUES, 'result fields of the task, for later tasks that refer to them'
)

ANSWERS: Mapping[str, Request] = {
    request.word: request
    for request in (
        _request(
            About.HOLD, failures.RETRY, 'tries the task once more', _OPERATORS, CODE, moves=True,
        ),
        _request(
            About.HOLD, failures.AGAIN, 'does the repeat that the task is in once more, from its '
            'first task', _OPERATORS, CODE, moves=True,
        ),
        _request(
            About.HOLD, failures.CHANGE, 'changes the setup that the task lacks, and then does '
            'the task', _OPERATORS, CODE, moves=True,
        ),
        _request(
            About.HOLD, failures.MARK_DONE, 'the task was done: its item goes on as after success',
            _OPERATORS, _RESULTS, CODE, moves=True,
        ),
        _request(
            About.HOLD, failures.SKIP, 'the item goes on without the task; its flags count as '
            'performed', _OPERATORS, CODE, moves=True,
        ),
        _request(
            About.HOLD, failures.REJECT, 'the item is rejected: later tasks are skipped, and it '
            'leaves the line as scrap', _OPERATORS, CODE, moves=True, is_confirmed=True,
        ),
        _request(
            About.HOLD, failures.ABORT_JOB, 'ends the job of the item: its goals are cancelled, '
            'its items on the line are rejected and drain', _ENGINEERS, CODE,
            moves=True, is_confirmed=True,
        ),
    )
}  # fmt: skip

ACKNOWLEDGE = _request(
    About.HOLD, 'acknowledge', 'records that somebody has seen it; it stays', _OPERATORS,
    moves=False, why=Why.NEVER, is_limited=True, is_remark=True,
)  # fmt: skip
COMMENT = _request(
    About.HOLD, 'comment', 'records what somebody says about it; it stays', _OPERATORS,
    moves=False, is_limited=True, is_remark=True,
)  # fmt: skip
# --- components (semantics 7.5) -----------------------------------------------------------------

OUT_OF_SERVICE = _request(
    About.COMPONENT, 'out_of_service', 'sends a component no goal, and lets the queue pass jobs '
    'that need it; what runs goes on; this is no lockout', _OPERATORS, CODE,
    moves=False,
)  # fmt: skip
IN_SERVICE = _request(
    About.COMPONENT, 'in_service', 'lets a component get goals again, and lets jobs that need it '
    'start', _OPERATORS, moves=True, needs_safety=True, is_limited=True,
)  # fmt: skip

RUN_TASK = _request(
    About.COMPONENT, 'run_task', 'sends it one goal in manual mode, for as long as its panel is '
    'heard', _ENGINEERS,
    Parameter('task', Kind.TEXT, 'task constant of its action type', is_required=True),
    Parameter('args', Kind.VALUES, 'fields of the goal'),
    Parameter('hold', Kind.TEXT, 'the hold that keeps the component; it stays'),
    moves=True, needs_local=True, needs_safety=True, is_limited=True, is_manual=True,
)  # fmt: skip
CANCEL_TASK = _request(
    About.COMPONENT, 'cancel_task', 'cancels its goal of manual mode', _OPERATORS,
    moves=False, why=Why.AFTERWARDS, is_manual=True,
)  # fmt: skip

# --- scripts (semantics 6.10) -------------------------------------------------------------------

RELEASE_SCRIPT = _request(
    About.SCRIPT, 'release_script', 'lets jobs of a generated script start on this cell',
    _ENGINEERS,
    Parameter('cell_digest', Kind.TEXT, 'refuse it unless this is the digest of the cell'),
    moves=True,
    is_limited=True,
)  # fmt: skip

# --- stops of the line (semantics 7.10) ----------------------------------------------------------

CLASSIFY = _request(
    About.STOP, 'classify', "says the plant's reason for a stop of the line; the last one counts",
    _OPERATORS, replace(CODE, is_required=True), moves=False, why=Why.NEVER, is_limited=True,
)  # fmt: skip

TABLE: tuple[Request, ...] = (
    *CELL.values(),
    *STOP_AFTERS.values(),
    *CONTROLS.values(),
    *UNIT_MODES.values(),
    AT_PANEL,
    ADD,
    ARRANGE,
    MOVE,
    NEXT,
    *_CONTROLS,
    REMOVE_ITEM,
    *ANSWERS.values(),
    ACKNOWLEDGE,
    COMMENT,
    OUT_OF_SERVICE,
    IN_SERVICE,
    RUN_TASK,
    CANCEL_TASK,
    RELEASE_SCRIPT,
    CLASSIFY,
)
"""All requests, in the order of the documentation."""

REQUESTS: Mapping[str, Request] = {request.name: request for request in TABLE}
"""By name."""

_ALSO = {f'{request.about.value}.{word}': request for request in TABLE for word in request.also}


def of_name(name: str) -> Request | None:
    """Return the request of a name, also with another of its words; None: there is none."""
    return REQUESTS.get(name) or _ALSO.get(name)


def of_word(about: About, word: str) -> Request | None:
    """Return the request that a word stands for; None: there is none."""
    return of_name(f'{about.value}.{word}')


def requests_about(*about: About) -> tuple[Request, ...]:
    """Return the requests about some kinds of subjects, in the order of the table."""
    return tuple(request for request in TABLE if request.about in about)


def words_about(about: About) -> tuple[str, ...]:
    """Return every word that stands for a request."""
    return tuple(
        word for request in requests_about(about) for word in (request.word, *request.also)
    )


def is_remark(word: str) -> bool:
    """Tell whether a word about a hold leaves it unchanged."""
    request = of_word(About.HOLD, word)
    return request is not None and request.is_remark
