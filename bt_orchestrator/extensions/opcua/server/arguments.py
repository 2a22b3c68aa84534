"""The arguments of methods: as they are declared, and whether a call fits them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import asyncua
from asyncua import ua
from asyncua.common.ua_utils import data_type_to_variant_type

_KIND = ua.VariantType
_MAY_BE_NULL = (_KIND.String, _KIND.LocalizedText)


@dataclass(frozen=True)
class Argument:
    """An argument of a method, or an output."""

    name: str
    type: ua.VariantType
    """`Variant`: it may have a value of every type."""
    meaning: str
    is_list: bool = False
    is_optional: bool = False
    """Of a method that had fewer arguments before; clients that know it so leave it out."""
    structure: type | None = None
    """The class of a structure."""

    def accepts(self, given: ua.Variant) -> bool:
        """Tell whether a value is of its type; null is an empty text, or no list."""
        if given.VariantType is _KIND.Null:
            return self.is_list or self.type in _MAY_BE_NULL
        if self.is_list and given.Value is None:
            return True
        if self.type is _KIND.Variant:
            return True
        if given.VariantType is not self.type or given.is_array is not self.is_list:
            return False
        several = given.Value if self.is_list else [given.Value]
        return self.structure is None or all(isinstance(one, self.structure) for one in several)

    def value_of(self, given: ua.Variant) -> Any:
        """Return the value for the method; a text is never null."""
        if self.is_list:
            return [one or '' for one in given.Value or ()] if self._is_text else given.Value or []
        return given.Value or '' if self._is_text else given.Value

    @property
    def _is_text(self) -> bool:
        return self.type is _KIND.String

    @property
    def declared(self) -> ua.Argument:
        """As clients read it."""
        declared = ua.Argument()
        declared.Name = self.name
        declared.DataType = ua.NodeId(self.type.value)
        declared.ValueRank = 1 if self.is_list else -1
        declared.ArrayDimensions = [0] if self.is_list else []
        declared.Description = ua.LocalizedText(self.meaning)
        return declared


async def declared_at(server: asyncua.Server, method: asyncua.Node) -> list[Argument]:
    """Return the arguments that a nodeset declares for a method."""
    names = {one.BrowseName.Name: one for one in await method.get_children_descriptions()}
    if 'InputArguments' not in names:
        return []
    return [
        Argument(
            one.Name or '',
            await data_type_to_variant_type(server.get_node(one.DataType)),
            '',
            is_list=one.ValueRank >= 1,
            structure=ua.extension_objects_by_datatype.get(one.DataType),
        )
        for one in await server.get_node(names['InputArguments'].NodeId).read_value()
    ]


def wrong(inputs: Sequence[Argument], given: Sequence[ua.Variant]) -> ua.CallMethodResult | None:
    """Return what is wrong with arguments, argument by argument; None: nothing."""
    if len(given) < sum(not one.is_optional for one in inputs):
        return with_status(ua.StatusCodes.BadArgumentsMissing)
    if len(given) > len(inputs):
        return with_status(ua.StatusCodes.BadTooManyArguments)
    codes = [
        ua.StatusCodes.Good if one.accepts(value) else ua.StatusCodes.BadTypeMismatch
        for one, value in zip(inputs, given, strict=False)
    ]
    if not any(codes):
        return None
    result = with_status(ua.StatusCodes.BadInvalidArgument)
    result.InputArgumentResults = [ua.StatusCode(code) for code in codes]
    return result


def with_status(code: int) -> ua.CallMethodResult:
    """Return the result of a call that has no outputs."""
    result = ua.CallMethodResult()
    result.StatusCode = ua.StatusCode(code)
    return result
