"""Rows of the OPC UA server: what an order of an MES costs, with and without many stored."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import closing
from typing import Any

from asyncua import Client, ua
from opcua_process import OpcUaProcess
from process_use import family_cpu_s
from program_process import ProgramProcess
from served_process import PASSWORD

from bench.rows import Row, percentile
from bench.stand import Stand, stand

STORED = 100
"""As many as the server holds (MaxDownloadableJobOrders), but for the one that runs."""

WARM_UP = 2
"""Orders before the first measurement."""

PATIENCE_S = 60.0
JOB_CONTROL = 'http://opcfoundation.org/UA/ISA95-JOBCONTROL_V2/'

Use = dict[str, float]


def opcua(rounds: int, orders: int) -> Iterator[Row]:
    """Give the same orders beside an empty queue and beside many stored ones."""
    with stand() as here:
        uses = [_round(here, orders) for _ in range(rounds)]
    median = {name: percentile([use[name] for use in uses], 0.5) for name in uses[0]}
    for key, who in (('opcua_order', 'server'), ('opcua_node', 'node')):
        ratios = [use[f'{who}, ms, many'] / use[f'{who}, ms, none'] for use in uses]
        yield Row(key, ratios, {name: ms for name, ms in median.items() if name.startswith(who)})


def _round(here: Stand, orders: int) -> Use:
    journal = here.folder / f'{here.name("opcua")}.sqlite3'
    options = ['--journal', str(journal), '--trust-local-doors']
    trees = ['--insecure', '--trees', str(here.folder)]
    with (
        here.node(options) as node,
        closing(OpcUaProcess(here.folder, '/bt_orchestrator', trees)) as server,
    ):
        server.wait_ready()
        processes = {'node': node, 'server': server.process}
        return asyncio.run(_measured(here, orders, processes, server.endpoint))


async def _measured(
    here: Stand, orders: int, processes: dict[str, ProgramProcess], endpoint: str
) -> Use:
    async with logged_in(endpoint) as client:
        mes = Mes(client, here.script.stem)
        await mes.subscribe()
        await mes.run('warm', WARM_UP)
        use: Use = {}
        for name in ('none', 'many'):
            if name == 'many':
                for number in range(STORED - 1):
                    await mes.call('Store', mes.order(f'stored-{number}'))
            before = {who: family_cpu_s(process.pid) for who, process in processes.items()}
            await mes.run(name, orders)
            for who, process in processes.items():
                used_s = family_cpu_s(process.pid) - before[who]
                use[f'{who}, ms, {name}'] = used_s / orders * 1e3
        return use


def logged_in(endpoint: str) -> Client:
    """Return a client that logs in as an MES does, when it connects."""
    client = Client(endpoint)
    client.set_user('mes')
    client.set_password(PASSWORD)
    return client


class Mes:
    """Subscribes to the list of orders and to their events, as an MES does."""

    def __init__(self, client: Client, script: str) -> None:
        self._client = client
        self._script = script
        self._ended: dict[str, asyncio.Event] = {}

    async def subscribe(self) -> None:
        """Begin to hear."""
        await self._client.load_data_type_definitions()
        names = await self._client.get_namespace_array()
        self._cell = next(
            at for at, name in enumerate(names) if name.startswith('urn:bt_orchestrator:cell:')
        )
        subscription = await self._client.create_subscription(100, self)
        kind = ua.NodeId.from_string(f'ns={names.index(JOB_CONTROL)};i=1006')
        await subscription.subscribe_events(self._node('JobOrderResults'), kind, queuesize=1000)
        await subscription.subscribe_data_change(self._node('JobOrderControl/JobOrderList'))

    async def run(self, name: str, orders: int) -> None:
        """Give orders one after the other, each when the one before has ended."""
        for number in range(orders):
            order = f'{name}-{number}'
            ended = self._ended[order] = asyncio.Event()
            await self.call('StoreAndStart', self.order(order))
            await asyncio.wait_for(ended.wait(), PATIENCE_S)
            await self.call('Clear', order)

    async def call(self, method: str, what: Any) -> None:
        """Call a method of job control, which must do what it is asked for."""
        receiver = 'JobOrderControl'
        node = self._node(receiver)
        comment = ua.Variant([ua.LocalizedText('a measurement')])
        status = await node.call_method(self._id(f'{receiver}/{method}'), what, comment)
        assert status == 1, f'{method}: {status}'

    def order(self, order: str) -> Any:
        """Return a job order for one item."""
        kinds: Any = ua  # has the structures once their definitions are loaded
        planned = kinds.ISA95ParameterDataType(
            ID='RunsPlanned', Value=ua.Variant(1, ua.VariantType.UInt32)
        )
        return kinds.ISA95JobOrderDataType(
            JobOrderID=order,
            WorkMasterID=[kinds.ISA95WorkMasterDataType(ID=self._script)],
            JobOrderParameters=[planned],
        )

    def event_notification(self, event: Any) -> None:
        """Take note of the end of an order."""
        order = event.JobOrder.JobOrderID
        if event.JobState[0].StateText.Text == 'Ended' and order in self._ended:
            self._ended[order].set()

    def datachange_notification(self, node: Any, value: Any, data: Any) -> None:
        """Hear the list of orders; decoding it costs this process alone."""

    def _node(self, path: str) -> Any:
        return self._client.get_node(self._id(path))

    def _id(self, path: str) -> ua.NodeId:
        return ua.NodeId.from_string(f'ns={self._cell};s={path}')
