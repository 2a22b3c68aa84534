"""One job order from an MES, with asyncua: store and start it, hear of it, what became of it.

pip install 'asyncua>=2.1,<2.2'
OPCUA_PASSWORD=… python mes_order.py opc.tcp://HOST:4840 USER ORDER SCRIPT QUANTITY
"""

from __future__ import annotations

import asyncio
import os
import socket
import sys
from pathlib import Path
from typing import Any

from asyncua import Client, ua
from asyncua.common.methods import to_variant
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from cryptography.x509.oid import ExtendedKeyUsageOID

JOB_CONTROL = 'http://opcfoundation.org/UA/ISA95-JOBCONTROL_V2/'
APPLICATION = f'urn:{socket.gethostname()}:mes-example'


async def main(endpoint: str, user: str, order: str, script: str, quantity: str) -> None:
    client = Client(endpoint)
    client.set_user(user)
    client.set_password(os.environ['OPCUA_PASSWORD'])
    await encrypt(client, Path(os.environ.get('OPCUA_PKI', 'pki')))
    async with client:
        await client.load_data_type_definitions()  # the structures of ISA-95
        await run(client, order, script, int(quantity))


async def encrypt(client: Client, folder: Path) -> None:
    """Use the certificate in a folder, which is made at the first start and stays the same."""
    folder.mkdir(exist_ok=True)
    key, certificate = folder / 'key.pem', folder / 'certificate.der'
    client.application_uri = APPLICATION
    await setup_self_signed_certificate(
        key, certificate, APPLICATION, socket.gethostname(), [ExtendedKeyUsageOID.CLIENT_AUTH], {}
    )
    key.chmod(0o600)
    await client.set_security(SecurityPolicyBasic256Sha256, certificate, key)


async def run(client: Client, order: str, script: str, quantity: int) -> None:
    names = await client.get_namespace_array()
    [cell] = [at for at, name in enumerate(names) if name.startswith('urn:bt_orchestrator:cell:')]

    def node(path: str) -> Any:
        return client.get_node(ua.NodeId(path, cell))

    async def call(on: str, method: str, *arguments: Any) -> Any:
        """Call a method; its last output is ReturnStatus: 1 is done, others say why not.

        Not with `call_method`, which keeps the outputs to itself unless all is well.
        """
        request = ua.CallMethodRequest(
            ObjectId=ua.NodeId(on, cell),
            MethodId=ua.NodeId(f'{on}/{method}', cell),
            InputArguments=to_variant(*arguments),
        )
        [result] = await client.uaclient.call([request])
        if not result.OutputArguments:
            result.StatusCode.check()
        *results, status = [output.Value for output in result.OutputArguments]
        print(f'{method}: {status}')
        if status != 1:
            raise SystemExit(f'{method} was refused; see docs/mes.md for the number')
        return results

    # Hear of the order before it is stored: no event is missed.
    ended = asyncio.Event()

    class Listener:
        def event_notification(self, event: Any) -> None:
            if event.JobOrder is not None and event.JobOrder.JobOrderID == order:
                state = '/'.join(state.StateText.Text for state in event.JobState)
                print(f'{order}: {state}')
                if state in ('Ended', 'Aborted'):
                    ended.set()

    standard = names.index(JOB_CONTROL)
    subscription = await client.create_subscription(100, Listener())
    await subscription.subscribe_events(node('JobOrderResults'), ua.NodeId(1006, standard))

    planned = ua.ISA95ParameterDataType(
        ID='RunsPlanned', Value=ua.Variant(quantity, ua.VariantType.UInt32)
    )
    job_order = ua.ISA95JobOrderDataType(
        JobOrderID=order,
        WorkMasterID=[ua.ISA95WorkMasterDataType(ID=script)],
        JobOrderParameters=[planned],
    )
    comment = [ua.LocalizedText('an example')]
    await call('JobOrderControl', 'StoreAndStart', job_order, comment)
    await ended.wait()

    [response] = await call('JobOrderResults', 'RequestJobResponseByJobOrderID', order)
    for figure in response.JobResponseData:
        if figure.ID in ('GoodQuantity', 'ScrapQuantity'):
            print(f'{figure.ID}: {figure.Value.Value:g}')
    await call('JobOrderControl', 'Clear', order, comment)


if __name__ == '__main__':
    asyncio.run(main(*sys.argv[1:]))
