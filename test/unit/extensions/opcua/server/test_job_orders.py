"""Job orders of ISA-95 are stored, changed, or refused."""

from __future__ import annotations

from asyncua import ua
from opcua_mes import (
    ABORTED,
    COMMENT,
    DONE,
    MALFORMED,
    NOT_ACCEPTED,
    UNKNOWN,
    Mes,
    data,
    order,
    parameter,
    with_mes,
)
from web.stand_cell import StandCell

from bt_orchestrator.model.jobs.order import WorkOrder


def test_an_order_is_stored_started_made_and_cleared(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        await mes.listen(mes.client.nodes.server)
        assert await mes.method('Store', order('WO-7', script, 2)) == DONE
        await mes.wait_for('WO-7', 'NotAllowedToStart')
        assert await mes.method('Start', 'WO-7') == DONE
        ended = await mes.wait_for('WO-7', 'Ended')
        assert script == ended.JobOrder.WorkMasterID[0].ID
        response = await mes.response('WO-7')
        result = data(response)
        assert (result['GoodQuantity'], result['RunsCompleted'], result['JobResult']) == (2, 2, 1)
        assert response.EndTime > response.StartTime
        (last,) = await mes.heard_of(lambda entry: entry.Message.Text.startswith('WO-7 is Ended'))
        assert data(last.JobResponse) == result
        assert last.JobState[0].StateNumber == 5
        assert last.JobOrder.JobOrderID == 'WO-7'
        states = [entry.JobState[0].StateText.Text for entry in mes.heard]
        assert states == ['NotAllowedToStart', 'AllowedToStart', 'Running', 'Ended']
        shown = await mes.value('JobOrderResults/JobOrderResponseList')
        assert [data(entry) for entry in shown if entry.JobOrderID == 'WO-7'] == [result]
        assert await mes.method('Clear', 'WO-7') == DONE
        assert await mes.method('Clear', 'WO-7') == UNKNOWN
        assert await mes.method('Store', order('WO-7', script)) == NOT_ACCEPTED, 'used once'

    with_mes(url, look)


def test_what_was_done_can_be_read_at_once(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        for number in range(5):
            name = f'AT-{number}'
            assert await mes.method('Store', order(name, script)) == DONE
            assert name in await mes.listed()
            assert await mes.method('Cancel', name) == DONE
            assert name not in await mes.listed()

    with_mes(url, look)


def test_an_order_given_twice_is_made_once(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        assert await mes.method('Store', order('TW-1', script, 2)) == DONE
        assert await mes.method('StoreAndStart', order('TW-1', script, 2)) == NOT_ACCEPTED
        await mes.wait_for('TW-1', 'NotAllowedToStart')
        assert await mes.method('Cancel', 'TW-1') == DONE

    with_mes(url, look)


def test_wrong_order_returns_status_and_event(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        await mes.listen(mes.node('JobOrderControl'))
        unknown = parameter('nonsense', 1, ua.VariantType.Int64)
        twice = parameter('RunsPlanned', 1, ua.VariantType.UInt32)
        for wrong, status, words in (
            (order('', script), MALFORMED, 'JobOrderID'),
            (order('a/b', script), MALFORMED, 'slash'),
            (order('X-1', 'no_such_script'), NOT_ACCEPTED, 'no_such_script'),
            (order('X-1', script, parameters=[unknown]), NOT_ACCEPTED, 'nonsense'),
            (order('X-1', 'WM-100'), NOT_ACCEPTED, 'recipe'),
            (order('X-1', script, 0), NOT_ACCEPTED, 'RunsPlanned'),
            (ua.ISA95JobOrderDataType(JobOrderID='X-1'), NOT_ACCEPTED, 'exactly one'),
            (order('X<1>', script), MALFORMED, '`<` or `>`'),
            (order('X-1', script, parameters=[twice]), NOT_ACCEPTED, 'given twice'),
        ):
            assert await mes.method('StoreAndStart', wrong) == status
            await mes.heard_of(lambda event: words in f'{event.Message.Text} {event.Findings}')  # noqa: B023
        assert 'X-1' not in await mes.listed()
        for name in (
            'Start',
            'RevokeStart',
            'Pause',
            'Resume',
            'Stop',
            'Abort',
            'Cancel',
            'Clear',
        ):
            assert await mes.method(name, 'NO-1') == UNKNOWN
            assert await mes.method(name, '') == MALFORMED
        assert await mes.method('Update', order('NO-1', script)) == UNKNOWN
        refused = await mes.heard_of(lambda event: event.Method == 'Update')
        assert (refused[0].JobOrderID, refused[0].ReturnStatus) == ('NO-1', UNKNOWN)

    with_mes(url, look)


def test_wrong_argument_types_are_named_individually(script: str, url: str) -> None:
    good, mismatch = ua.StatusCodes.Good, ua.StatusCodes.BadTypeMismatch
    id_, comment = ua.Variant('NO-1'), ua.Variant(COMMENT, is_array=True)
    whole = ua.Variant(order('X-2', script), ua.VariantType.ExtensionObject)
    unit = ua.Variant(ua.EUInformation(), ua.VariantType.ExtensionObject)

    async def look(mes: Mes) -> None:
        for path, given, results in (
            ('JobOrderControl/Start', (ua.Variant(1), comment), [mismatch, good]),
            ('JobOrderControl/Start', (id_, ua.Variant('why')), [good, mismatch]),
            ('JobOrderControl/Store', (id_, ua.Variant(1)), [mismatch, mismatch]),
            ('JobOrderControl/Store', (unit, comment), [mismatch, good]),
            ('JobOrderControl/Store', (whole, COMMENT[0]), [good, mismatch]),
            ('JobOrderResults/RequestJobResponseByJobOrderID', (ua.Variant(7),), [mismatch]),
            ('JobOrderResults/RequestJobResponseByJobOrderState', (id_,), [mismatch]),
            ('PackML/SetUnitMode', (id_,), [mismatch]),
        ):
            sent = [item if isinstance(item, ua.Variant) else ua.Variant(item) for item in given]
            result = await mes.result(path, *sent)
            assert result.StatusCode.value == ua.StatusCodes.BadInvalidArgument, path
            assert [item.value for item in result.InputArgumentResults] == results, path
        hold = 'PackML/BaseStateMachine/MachineState/ExecuteState/Hold'
        too_many = await mes.result(hold, id_)
        assert too_many.StatusCode.value == ua.StatusCodes.BadTooManyArguments
        assert 'X-2' not in await mes.listed()

    with_mes(url, look)


def test_client_may_call_method_of_type(url: str) -> None:
    async def look(mes: Mes) -> None:
        uris = await mes.client.get_namespace_array()
        declared = ua.NodeId(7011, uris.index('http://opcfoundation.org/UA/ISA95-JOBCONTROL_V2/'))
        request = ua.CallMethodRequest()
        request.ObjectId, request.MethodId = mes.node('JobOrderControl').nodeid, declared
        request.InputArguments = [ua.Variant('NO-1', ua.VariantType.String), ua.Variant()]
        (result,) = await mes.client.uaclient.call([request])
        assert [output.Value for output in result.OutputArguments] == [UNKNOWN]

    with_mes(url, look)


def test_changed_order_is_reported_as_given(script: str, url: str) -> None:
    names = [
        parameter('Customers', ['ACME'], ua.VariantType.String),
        parameter('JobName', [ua.LocalizedText('Batch', 'en')], ua.VariantType.LocalizedText),
    ]
    material = ua.ISA95MaterialDataType(MaterialDefinitionID='M-1', Quantity='40')

    async def look(mes: Mes) -> None:
        given = order(
            'UP-1',
            script,
            4,
            Priority=3,
            Description=[ua.LocalizedText('For ACME', 'en')],
            MaterialRequirements=[material],
            parameters=names,
        )
        assert await mes.method('Store', given) == DONE
        stored = (await mes.wait_for('UP-1', 'NotAllowedToStart')).JobOrder
        assert stored.Description == given.Description
        assert stored.Priority == 3
        assert stored.MaterialRequirements == [material]
        assert {entry.ID: entry.Value for entry in stored.JobOrderParameters} == {
            entry.ID: entry.Value for entry in given.JobOrderParameters
        }
        stored.JobOrderParameters[0].Value = ua.Variant(6, ua.VariantType.UInt32)
        stored.Priority = 9
        await mes.listen(mes.node('JobOrderResults'))
        assert await mes.method('Update', stored) == DONE
        (changed,) = await mes.heard_of(lambda entry: entry.Message.Text == 'UP-1 was changed')
        assert changed.JobOrder == stored
        assert changed.JobState[0].StateText.Text == 'NotAllowedToStart'
        assert (await mes.listed())['UP-1'].JobOrder == stored
        assert await mes.method('Cancel', 'UP-1') == DONE

    with_mes(url, look)


def test_ended_orders_stay_listed_until_cleared(script: str, url: str) -> None:
    names = [f'END-{number:02}' for number in range(35)]

    async def look(mes: Mes) -> None:
        for name in names:
            assert await mes.method('Store', order(name, script)) == DONE
            assert await mes.method('Abort', name) == DONE
        assert [job_id for job_id in await mes.listed() if job_id in names] == names
        assert [job_id for job_id in await mes.found_in(ABORTED) if job_id in names] == names
        for name in (names[0], names[-1]):
            assert await mes.method('Clear', name) == DONE
            assert name not in await mes.listed()
            assert name not in await mes.found_in(ABORTED)
        for name in names[1:-1]:
            assert await mes.method('Clear', name) == DONE

    with_mes(url, look)


def test_orders_of_other_doors_are_told_too(url: str, line: tuple[StandCell, str]) -> None:
    async def look(mes: Mes) -> None:
        made = line[0].queue(WorkOrder(line[0].script, 'YAML-1', 1))
        assert made.accepted
        listed = await mes.wait_for('YAML-1', 'Ended')
        assert listed.JobOrder.JobOrderParameters[0].Value.Value == 1

    with_mes(url, look)
