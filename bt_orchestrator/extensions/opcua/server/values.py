"""The values of the nodes: written together, only those that changed, with time and quality."""

from __future__ import annotations

import asyncio
import logging
import time
from datetime import datetime, timezone
from typing import NamedTuple

import asyncua
from asyncua import ua

log = logging.getLogger(__name__)

TOGETHER_S = 0.1
"""Changes within this time are written once."""


_LAST_BUILT_IN = ua.VariantType.DiagnosticInfo.value
_ENUMERATION = ua.NodeId(ua.ObjectIds.Enumeration)
_HAS_SUBTYPE = ua.NodeId(ua.ObjectIds.HasSubtype)


NO_TIME = datetime(1601, 1, 1, tzinfo=timezone.utc)
"""Zero, which OPC UA takes for no time; asyncua cannot send None."""


class _Shown(NamedTuple):
    variant: ua.Variant
    at: float
    """When it became so, by the node's clock."""
    is_own: bool
    code: int = ua.StatusCodes.Good


class Values:
    """All calls come from the server's loop."""

    def __init__(self, server: asyncua.Server) -> None:
        self._space = server.iserver.aspace
        self._shown: dict[ua.NodeId, _Shown] = {}
        self._waiting: dict[ua.NodeId, _Shown] = {}
        self._types: dict[ua.NodeId, ua.VariantType] = {}
        self._later: asyncio.TimerHandle | None = None
        self._task: asyncio.Task[None] | None = None
        self._is_doubted = False
        self._telling: list[asyncua.Node] = []

    @property
    def is_doubted(self) -> bool:
        """Tell whether clients see that the values are old."""
        return self._is_doubted

    def put(
        self,
        node: asyncua.Node,
        value: object,
        stamp: float,
        *,
        is_own: bool = False,
        code: int = ua.StatusCodes.Good,
    ) -> None:
        """Show a value from now on.

        :param value: a `ua.Variant`, or what the type of the node can hold; None: no time
        :param stamp: since when it is so, by the node's clock
        :param is_own: the server knows it by itself: it is never doubted
        :param code: what a value that is known is good for
        """
        id_ = node.nodeid
        if not isinstance(value, ua.Variant):
            type_ = self._type(id_)
            is_no_time = value is None and type_ is ua.VariantType.DateTime
            value = ua.Variant(NO_TIME if is_no_time else value, type_)
        shown = self._waiting.get(id_) or self._shown.get(id_)
        if shown is not None and (shown.variant, shown.code) == (value, code):
            return
        self._waiting[id_] = _Shown(value, stamp, is_own, code)
        self._write_soon()

    def tell_trust(self, node: asyncua.Node) -> None:
        """Have a Boolean node say whether the values are those of now."""
        self._telling.append(node)
        self.put(node, not self._is_doubted, time.time(), is_own=True)

    def doubt(self) -> None:
        """Tell clients that all values are the last that were known."""
        self._set_doubt(True)

    def trust(self) -> None:
        """Tell clients that the values are those of now."""
        self._set_doubt(False)

    def _set_doubt(self, is_doubted: bool) -> None:
        if is_doubted != self._is_doubted:
            self._is_doubted = is_doubted
            self._waiting = self._shown | self._waiting
            for node in self._telling:
                self.put(node, not is_doubted, time.time(), is_own=True)
            self._write_soon()

    async def write(self) -> None:
        """Write what waits, now."""
        waiting, self._waiting = self._waiting, {}
        self._shown |= waiting
        for id_, shown in waiting.items():
            status = await self._space.write_attribute_value(
                id_, ua.AttributeIds.Value, self._data(shown)
            )
            if not status.is_good():
                log.error('%s was not written: %s', id_.to_string(), status.name)

    def close(self) -> None:
        """Stop writing."""
        if self._later is not None:
            self._later.cancel()

    def _data(self, shown: _Shown) -> ua.DataValue:
        code = shown.code
        if self._is_doubted and not shown.is_own and code == ua.StatusCodes.Good:
            code = ua.StatusCodes.UncertainLastUsableValue
        return ua.DataValue(
            shown.variant,
            ua.StatusCode(code),
            SourceTimestamp=moment(shown.at),
            ServerTimestamp=datetime.now(timezone.utc),
        )

    def _type(self, id_: ua.NodeId) -> ua.VariantType:
        if id_ not in self._types:
            read = self._space.read_attribute_value
            variant = read(id_, ua.AttributeIds.Value).Value
            if variant is None or variant.VariantType is ua.VariantType.Null:
                self._types[id_] = self._built_in(read(id_, ua.AttributeIds.DataType).Value.Value)
            else:
                self._types[id_] = variant.VariantType
        return self._types[id_]

    def _built_in(self, data_type: ua.NodeId) -> ua.VariantType:
        """Return the type in which values of a data type are sent, as Double of Duration."""
        while data_type.NamespaceIndex or data_type.Identifier > _LAST_BUILT_IN:
            if data_type == _ENUMERATION:
                return ua.VariantType.Int32
            data_type = next(
                reference.NodeId
                for reference in self._space[data_type].references
                if reference.ReferenceTypeId == _HAS_SUBTYPE and not reference.IsForward
            )
        return ua.VariantType(data_type.Identifier)

    def _write_soon(self) -> None:
        if self._later is None:
            self._later = asyncio.get_running_loop().call_later(TOGETHER_S, self._start)

    def _start(self) -> None:
        self._later = None
        self._task = asyncio.ensure_future(self.write())


def moment(stamp: float) -> datetime:
    """Return seconds since the epoch as OPC UA has a time."""
    return datetime.fromtimestamp(stamp, timezone.utc)
