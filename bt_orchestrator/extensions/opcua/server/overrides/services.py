"""The services that there are, by the ids of their requests.

Not among them are those that change the address space or register other servers. asyncua has them,
the latter for clients without a login.
"""

from __future__ import annotations

from collections.abc import Iterable

from asyncua import ua


def _ids(names: Iterable[str]) -> frozenset[ua.NodeId]:
    return frozenset(map(_id, names))


def _id(name: str) -> ua.NodeId:
    return ua.NodeId(getattr(ua.ObjectIds, f'{name}Request_Encoding_DefaultBinary'))


CREATE_SESSION = _id('CreateSession')
ACTIVATE_SESSION = _id('ActivateSession')
CLOSE_SESSION = _id('CloseSession')
TRANSFER = _id('TransferSubscriptions')

DISCOVERY = _ids(('FindServers', 'GetEndpoints', 'CloseSecureChannel'))
"""Without a login, and without encryption: clients learn here how to connect."""

KNOWN = frozenset(
    (
        CREATE_SESSION,
        ACTIVATE_SESSION,
        CLOSE_SESSION,
        TRANSFER,
        *_ids(
            (
                'Read',
                'Write',
                'HistoryRead',
                'Browse',
                'TranslateBrowsePathsToNodeIds',
                'RegisterNodes',
                'UnregisterNodes',
                'Call',
                'CreateSubscription',
                'ModifySubscription',
                'DeleteSubscriptions',
                'SetPublishingMode',
                'Publish',
                'Republish',
                'CreateMonitoredItems',
                'ModifyMonitoredItems',
                'DeleteMonitoredItems',
                'SetMonitoringMode',
            )
        ),
    )
)
"""With a login, each."""

READING = (KNOWN | DISCOVERY) - {TRANSFER, *_ids(('Write', 'HistoryRead', 'Call'))}
"""Of these the ones that change nothing but a client's own subscriptions, in the plain way."""
