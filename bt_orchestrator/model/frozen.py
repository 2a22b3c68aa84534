"""Frozen facts: made, copied and worked out in less time than dataclasses and functools take."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from typing import Any, Generic, TypeVar

_T = TypeVar('_T')
_Fact = TypeVar('_Fact')
_set = object.__setattr__
"""Also of a frozen class."""


def changed(fact: _T, **changes: Any) -> _T:
    """Return a copy of a frozen dataclass with other values in some fields.

    As `dataclasses.replace`, for classes without `__post_init__`: that one calls the constructor
    again, which sets field by field; it took 5 us, and this 1 us, five times a task.
    """
    copy = object.__new__(type(fact))
    _set(copy, '__dict__', {**vars(fact), **changes})
    return copy


def shared(fact: object, kind: type[Any]) -> dict[str, Any]:
    """Return the fields of a fact that a dataclass has by the same names."""
    return {name: value for name, value in vars(fact).items() if name in kind.__dataclass_fields__}


def made_at_once(kind: type[_T]) -> type[_T]:
    """Give a frozen dataclass a constructor that sets all fields by one call.

    The constructor of `dataclasses` calls `object.__setattr__` for each field. For classes without
    `__post_init__` and without slots.
    """
    before: Any = kind.__init__
    code = before.__code__
    names = code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount]
    positional = ', '.join(('self', *names[: code.co_argcount - 1]))
    by_name = (
        ', '.join(('', '*', *names[code.co_argcount - 1 :])) if code.co_kwonlyargcount else ''
    )
    factories = {
        field.name: field.default_factory
        for field in dataclasses.fields(kind)  # type: ignore[arg-type]  # it is a dataclass
        if field.default_factory is not dataclasses.MISSING
    }
    lines = [
        f'def __init__({positional}{by_name}):',
        *(f'    if {name} is unset: {name} = factories[{name!r}]()' for name in factories),
        f'    set_(self, "__dict__", {{{", ".join(f"{name!r}: {name}" for name in names)}}})',
    ]
    parameters = inspect.signature(before).parameters
    unset = next((parameters[name].default for name in factories), None)
    made: dict[str, Any] = {}
    known = {'set_': _set, 'factories': factories, 'unset': unset}
    exec('\n'.join(lines), known, made)
    after = made['__init__']
    after.__defaults__, after.__kwdefaults__ = before.__defaults__, before.__kwdefaults__
    after.__annotations__, after.__qualname__ = before.__annotations__, before.__qualname__
    kind.__init__ = after  # type: ignore[method-assign]
    return kind


class worked_out(Generic[_Fact, _T]):  # noqa: N801 - as cached_property
    """A property that is worked out once, as `functools.cached_property`, without its lock."""

    def __init__(self, work: Callable[[_Fact], _T]) -> None:
        self._work, self._name = work, work.__name__
        self.__doc__ = work.__doc__

    def __get__(self, fact: _Fact, _: type | None = None) -> _T:
        value = vars(fact)[self._name] = self._work(fact)
        return value
