"""References in arguments and conditions: targets, the time of their results, and types."""

from __future__ import annotations

from bt_orchestrator.model.action_type import FieldType
from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.model.script import RunsFor
from bt_orchestrator.script.drafts import ScriptDraft, TaskDraft
from bt_orchestrator.script.field_types import (
    PARAMETER_TYPES,
    in_words,
    is_assignable,
    is_printable,
    misfit,
)
from bt_orchestrator.script.references import (
    Path,
    ReferenceFault,
    fixed_reference,
    is_single,
    split,
)
from bt_orchestrator.script.report import Place, Report, did_you_mean, listing
from bt_orchestrator.script.yaml_nodes import Scalar, found_value, quoted

TEXT = FieldType('str', 'string')


class ReferenceReader:
    """Reads the strings of one task that contain references (`argument_checks.Templates`).

    A reference to a task's results is legal if that task has ended before this one starts, for
    the same item: an earlier step of the same section (or an earlier task of the same track of a
    group), or any task of an upstream section that is not a trailing one (semantics 3.8, 6.3).
    A task that runs for rejected items only cannot give a result to one that runs for good items,
    because no item becomes good again; the other way round is legal.
    """

    def __init__(
        self,
        script: ScriptDraft,
        task: TaskDraft | None,
        report: Report,
        *,
        of_verdict: bool = False,
    ) -> None:
        """Read the references of a task.

        :param task: None: they are of the script itself, which knows the order only
        :param of_verdict: its own results are there, too (semantics 2.8)
        """
        self._script = script
        self._task = task
        self._report = report
        self._of_verdict = of_verdict

    def read(self, node: Scalar, name: str, needed: FieldType) -> Template | None:
        """Return the template of a string, for a field of a type; None if it is wrong."""
        read = self.template(node)
        if read is None:
            return None
        template, given = read
        if given is not None and not is_assignable(given, needed):
            what = f'`{name}` must be {in_words(needed)}, but {quoted(str(template))} is'
            hint = 'refer to a value of that type'
            if needed.kind == 'str' and not needed.is_array and is_printable(given):
                hint = 'put text around the reference, and its value is formatted into it'
            self._report.add(node.place, f'{what} {in_words(given)}', hint)
        elif given is not None:
            self._check_default(node, name, template, needed)
        return template

    def _check_default(
        self, node: Scalar, name: str, template: Template, needed: FieldType
    ) -> None:
        """Report a parameter whose default is of the right type, and yet does not fit."""
        reference = template.parts[0]
        if not (isinstance(reference, Reference) and is_single(template)):
            return
        parameter = self._script.params.get(reference.name)
        if reference.source != 'params' or parameter is None or parameter.default is None:
            return
        problem = misfit(parameter.default, needed)
        if problem is not None:
            default = found_value(parameter.default)
            what = f'`{name}` must be {problem.needed}, but `{parameter.name}` is by default'
            self._report.add(node.place, f'{what} {default}', 'change the default')

    def template(self, node: Scalar) -> tuple[Template, FieldType | None] | None:
        """Return a template and its type, None where the type is not known; None if it is wrong.

        A string that is exactly one reference keeps the referenced type; any other is text.
        """
        parts = [self._typed(part, node) for part in split(node.text)]
        typed = [part for part in parts if part is not None]
        if len(typed) < len(parts):
            return None
        template = Template(tuple(part for part, _ in typed))
        if is_single(template):
            return template, typed[0][1]
        for part, type_ in typed:
            if type_ is not None and not is_printable(type_):
                what = f'{quoted(f"${{{part}}}")} is {in_words(type_)} and cannot be put into text'
                self._report.add(node.place, what, 'refer to one of its fields')
        return template, TEXT

    def _typed(
        self, part: str | Path | ReferenceFault, node: Scalar
    ) -> tuple[str | Reference, FieldType | None] | None:
        """Return a part of a string with its type; None if it is wrong."""
        if isinstance(part, str):
            return part, TEXT
        try:
            if isinstance(part, ReferenceFault):
                raise part
            return self._find(part)
        except ReferenceFault as fault:
            self._report.add(node.place, fault.what, fault.hint)
        except _UnknownReference:
            pass
        return None

    def _find(self, written: Path) -> tuple[Reference, FieldType | None]:
        if written.source == 'params':
            return self._param(written)
        if written.source in ('item', 'results') and not self._has_item:
            why = 'initialization has no items' if self._task else 'the order is all that is known'
            what = f'{quoted(str(written))} cannot be used here: {why}'
            raise ReferenceFault(what, 'use `params` or `order`')
        if written.source == 'results':
            return self._result(written)
        return fixed_reference(written)

    @property
    def _has_item(self) -> bool:
        return self._task is not None and self._task.position is not None

    def _param(self, written: Path) -> tuple[Reference, FieldType | None]:
        params = self._script.params
        if written.rest in params:
            type_ = PARAMETER_TYPES.get(params[written.rest].type)
            return Reference('params', written.rest), type_
        if written.rest in self._script.unread_params:
            raise _UnknownReference
        known = listing(params)
        otherwise = f'the parameters are {known}' if known else f'declare it: {_declared(written)}'
        hint = did_you_mean(written.rest, params, otherwise)
        what = f'the {self._script.kind} has no parameter {quoted(written.rest)}'
        raise ReferenceFault(what, hint)

    # --- results --------------------------------------------------------------------------

    def own_field(self, place: Place, field: str) -> tuple[Reference, FieldType | None] | None:
        """Return a result field of the task itself, and its type; None if there is none."""
        assert self._task is not None
        written = Path('results', f'{self._task.id}.{field}')
        try:
            return self._field(self._task, tuple(field.split('.')), written)
        except ReferenceFault as fault:
            self._report.add(place, fault.what, fault.hint)
        return None

    def _result(self, written: Path) -> tuple[Reference, FieldType | None]:
        """Ids may contain dots: the longest id that the reference begins with is meant."""
        words = written.rest.split('.')
        for length in range(len(words), 0, -1):
            giver = self._script.by_id.get('.'.join(words[:length]))
            if giver is not None:
                self._check_order(giver, written)
                return self._field(giver, tuple(words[length:]), written)
        if any(self._script.may_have('.'.join(words[:n])) for n in range(1, len(words) + 1)):
            raise _UnknownReference
        kind, step = self._script.kind, self._script.step
        hint = did_you_mean(
            '.'.join(words[:-1]) or words[0],
            self._script.by_id,
            f'name {self._script.a_step} of this {kind}',
        )
        raise ReferenceFault(f'{quoted(str(written))} names no {step} of the {kind}', hint)

    def _check_order(self, giver: TaskDraft, written: Path) -> None:
        fault = self._order_fault(giver)
        if fault is not None:
            what = f'{quoted(str(written))} has no value here: {fault}'
            assert self._task is not None
            hint = f'refer to {self._script.a_step} that has ended before this one starts'
            raise ReferenceFault(what, giver.hint_to_precede(self._task) or hint)

    def _order_fault(self, giver: TaskDraft) -> str | None:
        """Say why a task cannot have given a result before this one starts."""
        task = self._task
        assert task is not None
        if giver is task:
            return None if self._of_verdict else f'it is this {self._script.step} itself'
        if giver.section is None:
            return f'`{giver.id}` is an initialization task and has no item'
        if giver.is_beside(task):
            return f'`{giver.id}` runs in parallel'
        if not giver.may_precede(task):
            return f'`{giver.id}` runs later'
        if giver.section != task.section and self._script.trailing(giver):
            return f'`{giver.id}` runs after its section has released the conveyor'
        pair = (giver.task.runs_for, task.task.runs_for)
        if pair == (RunsFor.REJECTED, RunsFor.GOOD) and _is_sure(giver) and _is_sure(task):
            return f'`{giver.id}` runs for rejected items only, and this task for good ones'
        return None

    def _field(
        self, giver: TaskDraft, names: tuple[str, ...], written: Path
    ) -> tuple[Reference, FieldType | None]:
        reference = Reference('results', giver.id, names)
        if giver.type is None:
            return reference, None
        results = giver.results
        if not names:
            what = f'{quoted(str(written))} names no result field'
            raise ReferenceFault(what, _offer('', giver, list(results)))
        known, type_ = results, None
        for depth, name in enumerate(names):
            type_ = known.get(name)
            if type_ is None and name in giver.type.result.fields and not depth:
                what = f'`{name}` is not kept: a task that has succeeded has it true'
                raise ReferenceFault(what, _offer('', giver, list(known)))
            if type_ is None:
                what = f'{giver.type.name} has no result `{".".join(names[: depth + 1])}`'
                raise ReferenceFault(what, _offer(name, giver, list(known)))
            nested = type_.message if not type_.is_array else None
            known = nested.fields if nested else {}
        return reference, type_


class _UnknownReference(Exception):
    """A reference to something that could not be read (and was reported)."""


def _is_sure(task: TaskDraft) -> bool:
    return task.fields.is_sure('runs_for')


def _offer(name: str, giver: TaskDraft, known: list[str]) -> str:
    otherwise = f'there is {listing(known)}' if known else 'there is none to refer to'
    return did_you_mean(name, known, otherwise) if giver.type else otherwise


def _declared(written: Path) -> str:
    return f'`params: {{{written.rest}: {{type: str}}}}`'
