"""An MES at the OPC UA server: asyncua's own client, which calls the methods of ISA-95."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from typing import Any

import asyncua
from asyncua import ua
from opcua_reader import Reader, client_of, to_the_end
from patience import PATIENCE_S

DONE, UNKNOWN, WRONG, NOT_ACCEPTED, MALFORMED = 1, 2, 8, 16, 1 << 32
ENDED, ABORTED = 5, 6
COMMENT = [ua.LocalizedText('a test', 'en')]


class Mes(Reader):
    """An MES."""

    def __init__(self, client: asyncua.Client, idx: int) -> None:
        super().__init__(client, idx)
        self.heard: list[Any] = []

    async def send(
        self, path: str, *given: ua.Variant, on: ua.NodeId | None = None
    ) -> tuple[ua.StatusCode, list[Any]]:
        """Call a method; returns status and outputs, which asyncua keeps back unless Good."""
        result = await self.result(path, *given, on=on)
        return result.StatusCode, [output.Value for output in result.OutputArguments or ()]

    async def result(
        self, path: str, *given: ua.Variant, on: ua.NodeId | None = None
    ) -> ua.CallMethodResult:
        """Call a method; returns all that is answered."""
        request = ua.CallMethodRequest()
        request.ObjectId = on or self.node(path.rpartition('/')[0]).nodeid
        request.MethodId = self.node(path).nodeid
        request.InputArguments = list(given)
        (result,) = await self.client.uaclient.call([request])
        return result

    async def method(self, name: str, what: object, comment: Any = COMMENT) -> int:
        """Call a method of the receiver; a failure has to carry Uncertain."""
        is_id = isinstance(what, str)
        type_ = ua.VariantType.String if is_id else ua.VariantType.ExtensionObject
        text = ua.Variant(comment, ua.VariantType.LocalizedText, is_array=True)
        code, outputs = await self.send(f'JobOrderControl/{name}', ua.Variant(what, type_), text)
        (status,) = outputs
        assert code.is_good() if status == DONE else code.is_uncertain(), (code, status)
        return int(status)

    async def listed(self) -> dict[str, Any]:
        """Return the listed jobs by their ids."""
        return {
            job.JobOrder.JobOrderID: job
            for job in await self.value('JobOrderControl/JobOrderList')
        }

    async def wait_for(self, job: str, *states: str) -> Any:
        """Wait until a job is listed in a state."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            entry = (await self.listed()).get(job)
            is_now = [] if entry is None else [state.StateText.Text for state in entry.State]
            if is_now == list(states):
                return entry
            assert time.monotonic() < deadline, f'{job} is {is_now}'
            await asyncio.sleep(0.05)

    async def response(self, job: str) -> Any:
        """Return the response of a job that is listed."""
        code, (response, status) = await self.send(
            'JobOrderResults/RequestJobResponseByJobOrderID',
            ua.Variant(job, ua.VariantType.String),
        )
        assert (code.is_good(), status) == (True, DONE)
        return response

    async def found_in(self, state: int) -> list[str]:
        """Return the ids of the jobs with a response that are in a state, by its number."""
        wanted = [ua.ISA95StateDataType(StateNumber=state)]
        _, (responses, status) = await self.send(
            'JobOrderResults/RequestJobResponseByJobOrderState',
            ua.Variant(wanted, ua.VariantType.ExtensionObject, is_array=True),
        )
        assert status == DONE
        return [response.JobOrderID for response in responses]

    async def listen(self, node: asyncua.Node) -> None:
        """Hear the events of a node."""
        subscription = await self.client.create_subscription(50, self)
        types = [
            ua.NodeId('JobOrderChangedEventType', self.idx),
            ua.NodeId('RequestRefusedEventType', self.idx),
        ]
        await subscription.subscribe_events(node, types)

    def event_notification(self, event: Any) -> None:
        """Take in an event; asyncua calls it."""
        self.heard.append(event)

    async def heard_of(self, is_it: Callable[[Any], bool], number: int = 1) -> list[Any]:
        """Wait until so many events of a kind were heard; return all of them."""
        deadline = time.monotonic() + PATIENCE_S
        while len(events := [event for event in self.heard if is_it(event)]) < number:
            assert time.monotonic() < deadline, [event.Message.Text for event in self.heard]
            await asyncio.sleep(0.05)
        return events


def parameter(name: str, value: object, type_: ua.VariantType) -> Any:
    """Return a parameter of a job order."""
    is_array = isinstance(value, list)
    return ua.ISA95ParameterDataType(ID=name, Value=ua.Variant(value, type_, is_array=is_array))


def order(id_: str, script: str, runs: int = 1, **fields: Any) -> Any:
    """Return a job order; `parameters` are those besides the quantity."""
    runs_planned = parameter('RunsPlanned', runs, ua.VariantType.UInt32)
    more = fields.pop('parameters', [])
    return ua.ISA95JobOrderDataType(
        JobOrderID=id_,
        WorkMasterID=[ua.ISA95WorkMasterDataType(ID=script)],
        JobOrderParameters=[runs_planned, *more],
        **fields,
    )


def data(response: Any) -> dict[str, Any]:
    """Return the data of a job response by their names."""
    return {entry.ID: entry.Value.Value for entry in response.JobResponseData}


def with_mes(url: str, what: Callable[[Mes], Awaitable[None]]) -> None:
    """Do something as an MES, without encryption and login."""

    async def connected() -> None:
        async with client_of(url) as client:
            await client.load_data_type_definitions()
            mes = await Mes.of(client)
            assert isinstance(mes, Mes)
            await what(mes)

    to_the_end(connected())
