"""The eleven methods of ISA-95 Job Control: the requests behind them, and what they answer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_control import METHODS, Method
from bt_orchestrator.model.requests import About, Request, requests_about
from bt_orchestrator.view.report.isa95.codes import ReturnStatus

STORING = (job_control.STORE, job_control.STORE_AND_START)
"""The methods that bring an order; Update brings one of a job that is there."""

REQUESTS: Mapping[Method, Request] = {
    **{
        method: request
        for request in requests_about(About.QUEUE)
        if request.takes_orders
        for method in STORING
    },
    **{
        request.method: request
        for request in requests_about(About.JOB)
        if request.method in METHODS
    },
}
"""The requirements of every method on the cell. Methods that ISA-95 does not have are left out."""

STATES: tuple[JobWord | None, ...] = (None, *JobWord)
"""The states that a method can meet; None: there was never an order with this id."""


class Answered(NamedTuple):
    """The answer of a method, and the state that follows."""

    status: ReturnStatus
    after: JobWord | None
    """None: the job is not listed."""
    is_later: bool = False
    """The state follows when the last item has left the line; until then the job is ending."""


_DRAINS = (
    'answers 1 at once; the state follows when its last item has left the line, and until then '
    '`Ending` tells it'
)

DIFFERENT: Mapping[tuple[Method, JobWord], str] = {
    **{
        (method, word): _DRAINS
        for method in (job_control.STOP, job_control.ABORT)
        for word in (JobWord.RUNNING, JobWord.HELD, JobWord.SUSPENDED)
    },
    (job_control.RESUME, JobWord.HELD): 'a hold needs an answer, at the line or by AnswerHold',
}
"""Where a method does not do all that OPC 10031-4 says, and why."""


def refused(method: Method, word: JobWord | None, ending: str = '') -> ReturnStatus:
    """Return the status of a request that the cell has refused.

    :param word: state of the job; None: it is not listed
    :param ending: `stopping` or `aborting` if the job already ends
    """
    if method in STORING:
        return ReturnStatus.NOT_ACCEPTED
    if word is None:
        return ReturnStatus.UNKNOWN_ID
    if job_control.refusal(method, '', job_control.JobFacts(word, ending)) is not None:
        return ReturnStatus.WRONG_STATE
    return ReturnStatus.NOT_ACCEPTED


def answered(method: Method, word: JobWord | None) -> Answered:
    """Return what a method answers to a request without mistakes, in each state of a job."""
    if word not in method.changes:
        return Answered(refused(method, word), word)
    is_later = (method, word) in DIFFERENT
    return Answered(ReturnStatus.DONE, method.changes[word], is_later)


TABLE: Mapping[Method, tuple[Answered, ...]] = {
    method: tuple(answered(method, word) for word in STATES) for method in METHODS
}
"""All 88 cells: by method, in the order of `STATES`."""
