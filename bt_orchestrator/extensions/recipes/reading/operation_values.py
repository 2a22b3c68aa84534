"""The values of one operation: parameters, data of others, policies and conditions."""

from __future__ import annotations

from typing import Any

from bt_orchestrator.extensions.recipes.reading.shelf import (
    Candidate,
    OperationDraft,
    RecipeDraft,
)
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.script.checks.arguments import MessageReader
from bt_orchestrator.script.checks.references import ReferenceReader
from bt_orchestrator.script.conditions.reader import ConditionReader
from bt_orchestrator.script.field_types import in_words, is_assignable
from bt_orchestrator.script.report import Report, did_you_mean, listing
from bt_orchestrator.script.task_reader import written_options
from bt_orchestrator.script.task_values import check_references, read_serial
from bt_orchestrator.script.yaml_nodes import Entry, Scalar, found, quoted


class OperationValues:
    """Reads the values of one operation, and holds them against all that can do it."""

    def __init__(self, draft: RecipeDraft, operation: OperationDraft, report: Report) -> None:
        self._draft = draft
        self._operation = operation
        self._report = report
        self._references = ReferenceReader(draft, operation, report)

    def options(self) -> dict[str, Any]:
        """Return the fields of Task that the operation sets."""
        options = written_options(self._operation.fields)
        condition = ConditionReader(self._operation, self._references, self._report).read()
        afterwards = ReferenceReader(self._draft, self._operation, self._report, of_verdict=True)
        verdict = ConditionReader(self._operation, afterwards, self._report).verdict()
        serial = read_serial(self._operation, afterwards, self._report)
        more = {'condition': condition, 'fails_unless': verdict, 'identifies': serial or None}
        return options | {name: value for name, value in more.items() if value is not None}

    # --- parameters -------------------------------------------------------------------------

    def parameters(self) -> dict[str, Any]:
        """Return the values of parameters; each fits whoever has the parameter."""
        values = {entry.key.text: self._parameter(entry) for entry in self._entries('parameters')}
        if self._operation.fields.is_sure('parameters'):
            for candidate in self._operation.candidates:
                self._check_missing_parameters(candidate, values)
        return values

    def _parameter(self, entry: Entry) -> Any:
        name, candidates = entry.key.text, self._operation.candidates
        having = [candidate for candidate in candidates if name in candidate.capability.parameters]
        if not having:
            check_references(entry.value, self._references)
            if candidates:
                self._unknown(entry, 'parameters', 'has no parameter', 'it has')
            return None
        fields = (
            candidate.goal_field(candidate.capability.parameters[name]) for candidate in having
        )
        types = {type_.ros_name: type_ for type_ in fields}
        reader = MessageReader(self._report, self._references)
        read = [reader.value(entry.value, type_, name) for type_ in types.values()]
        return read[0]

    def _check_missing_parameters(self, candidate: Candidate, values: dict[str, Any]) -> None:
        capability = candidate.capability
        for name, field in capability.parameters.items():
            if name not in values and field not in capability.args:
                place = self._operation.place('parameters')
                hint = f'{candidate} needs it: write `parameters: {{{name}: ...}}`'
                self._report.add(place, f'parameter `{name}` is missing', hint)

    # --- data of earlier operations ---------------------------------------------------------

    def needs(self) -> dict[str, str]:
        """Return the operation that gives each thing that is needed."""
        needs: dict[str, str] = {}
        for entry in self._entries('needs'):
            giver = self._giver(entry)
            if giver is not None:
                needs[entry.key.text] = giver.id
                self._check_given(entry, giver)
        if self._operation.fields.is_sure('needs'):
            given = {entry.key.text for entry in self._entries('needs')}
            for candidate in self._operation.candidates:
                for name in candidate.capability.needs.keys() - given:
                    self._report_missing_need(candidate, name)
        return needs

    def _giver(self, entry: Entry) -> OperationDraft | None:
        """Return the operation that is named, if there is one and it comes before."""
        if not isinstance(entry.value, Scalar) or not entry.value.text:
            what = f'`needs` names an operation for each thing, not {found(entry.value)}'
            self._report.add(entry.value.place, what, 'write for instance `{pose: locate}`')
            return None
        giver = self._draft.by_id.get(entry.value.text)
        if not isinstance(giver, OperationDraft):
            if not self._draft.may_have(entry.value.text):
                ids = list(self._draft.by_id)
                hint = did_you_mean(entry.value.text, ids, f'the operations are {listing(ids)}')
                what = f'`needs` names no operation: {quoted(entry.value.text)}'
                self._report.add(entry.value.place, what, hint)
            return None
        if not giver.precedes(self._operation):
            what = f'`{giver.id}` has not ended when `{self._operation.id}` starts'
            hint = f'put it before, or add `after: [{giver.id}]`'
            self._report.add(entry.value.place, what, hint)
            return None
        return giver

    def _check_given(self, entry: Entry, giver: OperationDraft) -> None:
        name = entry.key.text
        takers = [
            candidate
            for candidate in self._operation.candidates
            if name in candidate.capability.needs
        ]
        if self._operation.candidates and not takers:
            self._unknown(entry, 'needs', 'does not need', 'it needs')
        for candidate in giver.candidates:
            if name in candidate.given or name in candidate.capability.holds:
                for taker in takers:
                    self._check_pair(entry, candidate, taker)
            else:
                things = [*candidate.given, *candidate.capability.holds]
                otherwise = f'it gives {listing(things)}' if things else 'it gives nothing'
                what = f'{candidate}, which does `{giver.id}`, does not give `{name}`'
                self._report.add(entry.value.place, what, did_you_mean(name, things, otherwise))
        if giver.task.on_failure is OnFailure.CONTINUE and giver.fields.is_sure('on_failure'):
            what = (
                f'`{self._operation.id}` needs `{name}` of `{giver.id}`, which may continue '
                'without a result: every such failure holds the line'
            )
            self._report.add(entry.value.place, what, f'let `{giver.id}` hold or reject')

    def _check_pair(self, entry: Entry, giver: Candidate, taker: Candidate) -> None:
        name = entry.key.text
        field, given = taker.capability.needs[name], giver.given.get(name)
        if given is None:
            if field:
                what = f'`{giver.component}` holds `{name}` itself, and {taker} waits for a result'
                hint = f'write `needs: {{{name}: none}}` there, in the cell file'
                self._report.add(entry.value.place, what, hint)
        elif not field:
            what = f'{giver} gives `{name}` as a result, and no field of {taker} takes it'
            hint = f'write `needs: {{{name}: FIELD}}` there, in the cell file'
            self._report.add(entry.value.place, what, hint)
        elif not is_assignable(given, taker.goal_field(field)):
            needed = in_words(taker.goal_field(field))
            what = f'`{name}` of {giver} is {in_words(given)}, but `{field}` takes {needed}'
            self._report.add(entry.value.place, what, 'let both be of one type')

    def _report_missing_need(self, candidate: Candidate, name: str) -> None:
        before = [
            operation
            for operation in self._draft.operations
            if operation.precedes(self._operation)
        ]
        giving = [
            operation.id
            for operation in before
            if any(name in c.given or name in c.capability.holds for c in operation.candidates)
        ]
        what = f'{candidate} needs `{name}`'
        what += '' if giving else ', and no operation before gives it'
        hint = f'add `needs: {{{name}: {giving[-1] if giving else "OPERATION"}}}`'
        self._report.add(self._operation.place('needs'), what, hint)

    def _entries(self, key: str) -> tuple[Entry, ...]:
        node = self._operation.fields.mapping(key)
        return node.entries if node else ()

    def _unknown(self, entry: Entry, key: str, lacks: str, has: str) -> None:
        """Report a name that no capability of the operation knows."""
        each = (getattr(candidate.capability, key) for candidate in self._operation.candidates)
        known = list(dict.fromkeys(name for names in each for name in names))
        does = ' or '.join(f'`{capability}`' for capability in self._operation.does)
        otherwise = f'{has} {listing(known)}' if known else 'remove it'
        hint = did_you_mean(entry.key.text, known, otherwise)
        self._report.add(entry.key.place, f'{does} {lacks} {quoted(entry.key.text)}', hint)
