"""Whatever an order says, at whichever door it came in: its structures can be sent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from asyncua import ua
from asyncua.common.utils import Buffer
from asyncua.ua.ua_binary import extensionobject_from_binary, extensionobject_to_binary
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.extensions.opcua.server.job_control.structures import Structures
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.status import JobStatus, ListedJob
from bt_orchestrator.view.report.isa95.job_order import DESCRIPTION, RESOURCES, job_order
from bt_orchestrator.view.report.isa95.job_response import response_of
from bt_orchestrator.view.report.isa95.machinery import KINDS

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(st.characters()),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                [
                    'Value',
                    'Description',
                    'Subparameters',
                    'EngineeringUnits',
                    'Text',
                    'Properties',
                    'ID',
                ]
            )
            | st.text(max_size=3),
            inner,
            max_size=3,
        )
    ),
    max_leaves=6,
)
NAMES = st.sampled_from([*KINDS, *RESOURCES, DESCRIPTION, 'Details', 'mine'])


def sent(structure: Any) -> Any:
    return extensionobject_from_binary(Buffer(extensionobject_to_binary(structure)))


@given(st.dictionaries(NAMES, JSON, max_size=4), st.dictionaries(st.text(max_size=3), JSON))
def test_any_details_and_parameters_can_be_sent(
    structures: Structures, details: Mapping[str, object], params: Mapping[str, object]
) -> None:
    job = ListedJob(JobStatus('WO-1', 's', JobWord.RUNNING, quantity=2), params, details, 'why')
    order = sent(structures.order(job_order(job)))
    assert order.JobOrderID == 'WO-1'
    assert sent(structures.response(response_of(job))).JobOrderID == 'WO-1'


def test_counts_and_enumerations_have_standard_types(structures: Structures) -> None:
    status = JobStatus('WO-1', 's', JobWord.ENDED, quantity=2**40, started=3)
    job = ListedJob(status, details={'JobExecutionMode': 2, 'PlannedSetupTime': 5})
    order = {item.ID: item.Value for item in structures.order(job_order(job)).JobOrderParameters}
    assert order['JobExecutionMode'].VariantType is ua.VariantType.Int32
    assert order['PlannedSetupTime'].VariantType is ua.VariantType.Double
    assert order['RunsPlanned'].VariantType is ua.VariantType.Int64, 'it does not fit into 32 bits'
    data = {item.ID: item.Value for item in structures.response(response_of(job)).JobResponseData}
    assert data['RunsStarted'].VariantType is ua.VariantType.UInt32
    assert data['JobResult'].VariantType is ua.VariantType.Int32
