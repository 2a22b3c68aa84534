"""ISA-95 Job Control: what each method answers, the numbers of answers, named parameters."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.extensions.opcua.mes.methods import DIFFERENT, STATES, TABLE, Answered
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.view.report.isa95.codes import ReturnStatus
from bt_orchestrator.view.report.isa95.job_response import EXTRAS
from bt_orchestrator.view.report.isa95.machinery import IN_RESPONSE, KINDS
from tables.docstrings import of_members
from tables.markdown import code, table
from tables.standard import GONE, NONE, Cell, read_table


def methods_and_states_of_isa_95() -> Iterator[str]:
    """Yield what each method answers in each state; bold where the standard says otherwise."""
    standard = read_table()
    titles = ('method', *(NONE if state is None else state.value for state in STATES))
    rows = (
        (
            code(method.name),
            *(
                _cell(answered, standard[method.name, _name(state)])
                for state, answered in zip(STATES, row, strict=True)
            ),
        )
        for method, row in TABLE.items()
    )
    yield from table(titles, rows)


def what_differs_from_isa_95() -> Iterator[str]:
    """Yield the cells that are otherwise than in the standard, and why."""
    reasons: dict[str, list[str]] = {}
    for (method, state), reason in DIFFERENT.items():
        reasons.setdefault(reason, []).append(f'{code(method.name)} of {state.value}')
    yield from table(
        ('cells', 'why'), ((', '.join(cells), reason) for reason, cells in reasons.items())
    )


def numbers_of_return_status() -> Iterator[str]:
    """Yield the bits."""
    rows = ((value, f'{meaning}.') for value, meaning in of_members(ReturnStatus).items())
    yield from table(('ReturnStatus', 'means'), rows)


def parameters_of_a_job_order() -> Iterator[str]:
    """Yield what OPC 40001-3 names, and where it is told again."""
    rows = (
        (code(name), kind.value, 'order and response' if name in IN_RESPONSE else 'order')
        for name, kind in KINDS.items()
    )
    yield from table(('parameter', 'value', 'told again in'), rows)


def own_parameters_of_a_response() -> Iterator[str]:
    """Yield the parameters that no standard names."""
    yield from table(('parameter', 'means'), ((code(name), what) for name, what in EXTRAS.items()))


def _name(state: JobWord | None) -> str:
    return NONE if state is None else state.value


def _cell(ours: Answered, standard: Cell) -> str:
    after = GONE if ours.after is None else ours.after.value
    if ours.status is not ReturnStatus.DONE:
        text = f'{ours.status.value}'
        return (
            text if ours.status == standard.status else f'**{text}** (standard: {_said(standard)})'
        )
    return f'**1, later {after}**' if ours.is_later else f'1, {after}'


def _said(standard: Cell) -> str:
    return f'{standard.status}, {standard.after}' if standard.after else f'{standard.status}'
