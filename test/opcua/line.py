"""A line of real processes: simulated controllers, tree node, OPC UA server, and its clients."""

from __future__ import annotations

import hashlib
import ssl
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from cell_processes import CellProcesses, StartCell
from fakes.shipped import REASONS
from opcua.driver import Driver, Refused
from opcua_process import OpcUaProcess
from served_process import PASSWORD

from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.file import UsersFile
from bt_orchestrator.script.users.keys import Key, SigningKey

NAMESPACE = 'urn:bt_orchestrator:cell:small_cell'
RECEIVER, RESULTS = 'JobOrderControl', 'JobOrderResults'
ORDERS, RESPONSES = f'{RECEIVER}/JobOrderList', f'{RESULTS}/JobOrderResponseList'
EVENT = ('Time', 'EventId', 'isa95:JobOrder', 'isa95:JobState', 'isa95:JobResponse')
"""Fields of a job order's event."""


def job_order(
    order: str, script: str = 'small', runs: int | None = 1, **more: Any
) -> dict[str, Any]:
    """Return ISA95JobOrderDataType for `Driver.call`.

    :param runs: RunsPlanned; None: without it
    :param more: other fields, as the client names them
    """
    parameters = [parameter('RunsPlanned', 'UInt32', runs)] if runs is not None else []
    parameters += more.pop('parameters', [])
    return {
        'jobOrderID': order,
        'workMasterID': [{'ID': script}],
        'jobOrderParameters': parameters,
        **more,
    }


def parameter(name: str, type_name: str, value: Any) -> dict[str, Any]:
    """Return ISA95ParameterDataType for `Driver.call`."""
    array = {'arrayType': 'Array'} if isinstance(value, list) else {}
    return {'ID': name, 'value': {'dataType': type_name, 'value': value, **array}}


def state_of(states: Sequence[Any]) -> str:
    """Return a job's state as `Interrupted/Held`."""
    return '/'.join(state['stateText'] for state in states)


def states_in(orders: Sequence[Any] | None) -> dict[str, str]:
    """Return the states of JobOrderList by job order."""
    return {job['jobOrder']['jobOrderID']: state_of(job['state']) for job in orders or ()}


class Client(Driver):
    """node-opcua at the server of a line."""

    @property
    def states(self) -> dict[str, str]:
        """The state of every job order of now."""
        return states_in(self.read(ORDERS)[0])

    def status(self, method: str, *args: Any, comment: str = 'a test') -> int:
        """Call a method of job control and return its ReturnStatus."""
        done = self.call(RECEIVER, method, *args, [comment])
        [status] = done['outputs']
        is_done = status == 1
        assert (done['status'] == 'Good') == is_done, done
        assert is_done or done['status'].startswith('Uncertain'), done
        return int(status)

    def wait_state(self, order: str, *states: str) -> str:
        """Wait until a subscription to JobOrderList has told one of these states."""

        def reached() -> str:
            now = self.told_state(order)
            return now if now in states else ''

        return str(self.wait_until(reached, f'{order} in {states}'))

    def told_state(self, order: str) -> str:
        """Return the state that a subscription to JobOrderList has told last; `gone`: none."""
        lists = self.values(ORDERS)
        return states_in(lists[-1]).get(order, 'gone') if lists else ''

    def told(self, order: str, of: str = RESULTS) -> list[str]:
        """Return the states that events have told of a job order, in their order."""
        events = [row for row in self.events(of) if row['JobOrder']]
        return [
            state_of(row['JobState']) for row in events if row['JobOrder']['jobOrderID'] == order
        ]

    def wait_told(self, order: str, states: Sequence[str], of: str) -> None:
        """Wait for the last of some states of an order: events have told them and no others."""
        self.wait_until(lambda: states[-1] in self.told(order, of), f'{order}: {states[-1]}')
        assert self.told(order, of) == list(states)

    @property
    def thumbprint(self) -> str:
        """SHA-1 of its certificate, which it makes before its first connection."""
        [path] = self.pki.glob('own/certs/*.pem')
        return hashlib.sha1(ssl.PEM_cert_to_DER_cert(path.read_text())).hexdigest()


class Line:
    """Everything of one line, on one ROS domain. Ends in `close`."""

    def __init__(
        self, folder: Path, start_cell: StartCell, *, signs: bool = False, **cell: Any
    ) -> None:
        """Start it; options are those of `CellProcesses`.

        :param signs: the node requires signatures, and the server has a key
        """
        self._folder = folder
        self._stack = ExitStack()
        self.journal = folder / 'journal.sqlite3'
        reasons = ['--reasons', str(REASONS)]
        users, key = folder / 'users.yaml', folder / 'opcua_1.pem'
        required = ['--users', str(users), '--signed-commands', 'required']
        trust = required if signs else ['--trust-local-doors']
        options = ['--journal', str(self.journal), *trust, *reasons]
        self.cell: CellProcesses = start_cell(run_options=options, **cell)
        self.cell.connect()
        trees = ['--trees', str(self.cell.folder)]
        signing = ['--sign-with', str(key)] if signs else []
        public = SigningKey.made(key).public if signs else ''
        self.server = OpcUaProcess(folder, '/bt_orchestrator', [*trees, *reasons, *signing])
        if signs:
            UsersFile(users).add_key('opcua_1', Key(Role.MES, public, 'opcua'))
        self._stack.callback(self.server.close)

    def client(self, role: str = 'mes', name: str = '', endpoint: str = '') -> Client:
        """Connect a client with an encrypted connection, whose certificate is trusted.

        :param role: also the name of the user
        :param name: of the client; each has a certificate of its own
        """
        client = self.stranger(name or role, endpoint)
        try:
            client.do('connect', user=role, password=PASSWORD)
        except Refused:
            self.server.trust(client.thumbprint)
            client.do('connect', user=role, password=PASSWORD)
        return client

    def stranger(self, name: str, endpoint: str = '') -> Client:
        """Start a client that nobody trusts yet."""
        client = Client(self._folder, endpoint or self.server.endpoint, NAMESPACE, name)
        self._stack.callback(client.close)
        return client

    def close(self) -> None:
        """Leave nothing behind, but for the cell."""
        self._stack.close()
