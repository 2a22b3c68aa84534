"""The job response provider: what became of a job, by its id or by its state."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from asyncua import ua

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.extensions.opcua.server.job_control.answers import answer, one
from bt_orchestrator.extensions.opcua.server.job_control.jobs import Jobs
from bt_orchestrator.extensions.opcua.server.job_control.structures import (
    RESPONSE,
    Structures,
    listed,
    none_of,
    states_from,
)
from bt_orchestrator.extensions.opcua.server.space import Call
from bt_orchestrator.model.status import ListedJob
from bt_orchestrator.view.report.isa95.job_response import response_of
from bt_orchestrator.view.report.isa95.job_states import are_known, has_all
from bt_orchestrator.view.report.isa95.return_status import ReturnStatus


class Results:
    """The two methods of ISA95JobResponseProviderObjectType."""

    def __init__(
        self, jobs: Jobs, structures: Structures, shown: Callable[[], Iterable[ListedJob]]
    ) -> None:
        """Prepare.

        :param shown: returns the jobs that the newest status lists
        """
        self._jobs = jobs
        self._structures = structures
        self._shown = shown

    def calls(self) -> Mapping[str, Call]:
        """Return what carries out each method, by its name."""
        return {
            'RequestJobResponseByJobOrderID': self._by_id,
            'RequestJobResponseByJobOrderState': self._by_state,
        }

    async def _by_id(self, name: str) -> ua.CallMethodResult:
        nothing = one(none_of(RESPONSE))
        if not name:
            return answer(ReturnStatus.MALFORMED, nothing)
        try:
            job = await self._jobs.ask(name)
        except NodeUnreachable as error:
            raise ua.UaStatusCodeError(ua.StatusCodes.BadNoCommunication) from error
        if job is None:
            return answer(ReturnStatus.UNKNOWN_ID, nothing)
        return answer(ReturnStatus.DONE, one(self._response(job)))

    async def _by_state(self, wanted: Sequence[object]) -> ua.CallMethodResult:
        if not wanted:
            return answer(ReturnStatus.MALFORMED, listed([]))
        states = states_from(wanted)
        if not are_known(states):
            return answer(ReturnStatus.WRONG_STATE, listed([]))
        responses = (response_of(job, self._jobs.book.interrupted) for job in self._shown())
        found = [one for one in responses if has_all(one.states, states)]
        return answer(ReturnStatus.DONE, listed(list(map(self._structures.response, found))))

    def _response(self, job: ListedJob) -> object:
        return self._structures.response(response_of(job, self._jobs.book.interrupted))
