"""The request of a command, and whether its sender has permission for it (semantics 7.1)."""

from __future__ import annotations

from bt_orchestrator.model.cell_commands import CellCommand
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.commands import (
    AnswerHold,
    Command,
    ReleaseScript,
    RemoveItem,
    SetService,
)
from bt_orchestrator.model.jobs.job_commands import (
    AddJobs,
    ControlJob,
    MoveJob,
    RequeueJob,
    RunNext,
    StopAfter,
    UpdateJob,
)
from bt_orchestrator.model.requests import (
    ADD,
    CELL,
    IN_SERVICE,
    MOVE,
    NEXT,
    OUT_OF_SERVICE,
    RELEASE_SCRIPT,
    REMOVE_ITEM,
    REQUEUE,
    STOP_AFTERS,
    UPDATE,
    About,
    Request,
    of_word,
    refusal,
)
from bt_orchestrator.model.state import CellState


def request_of(command: Command) -> Request | None:
    """Return the request that a command is.

    None: it is not in the table, as the engine's own commands and unknown words.
    """
    match command:
        case AnswerHold(_, answer):
            return of_word(About.HOLD, answer)
        case RemoveItem():
            return REMOVE_ITEM
        case SetService(_, in_service):
            return IN_SERVICE if in_service else OUT_OF_SERVICE
        case ReleaseScript():
            return RELEASE_SCRIPT
        case CellCommand():
            return CELL[command.cause]
        case AddJobs():
            return ADD
        case MoveJob():
            return MOVE
        case RunNext():
            return NEXT
        case UpdateJob():
            return UPDATE
        case RequeueJob():
            return REQUEUE
        case ControlJob(verb):
            return of_word(About.JOB, verb)
        case StopAfter(after):
            return STOP_AFTERS.get(after)
    return None


def not_allowed(command: Command, state: CellState) -> str | None:
    """Say why the sender has no permission for a command; None: it has.

    A command without a sender comes from the plan of a virtual run.
    """
    request, by = request_of(command), getattr(command, 'by', None)
    if request is None or by is None:
        return None
    return refusal(request, by, _restricted(command, state))


def _restricted(command: Command, state: CellState) -> tuple[str, ...]:
    """Return the used parameters that need a higher role than the request itself."""
    if not isinstance(command, UpdateJob):
        return ()
    now = state.jobs.get(command.job.id)
    changes = now is not None and now.digest != digest(command.job.script)
    return ('script',) if changes else ()
