"""A job order of ISA-95 Job Control (OPC 10031-4) and a work order of ours, both ways."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import datetime, timezone

from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.order import RecipeChoice, Terms, WorkOrder, order_id_fault
from bt_orchestrator.model.status import ListedJob
from bt_orchestrator.view.report.isa95.codes import Finding, ReturnStatus, Unfit
from bt_orchestrator.view.report.isa95.machinery import (
    KINDS,
    REASON,
    RUNS_PLANNED,
    named_parameters,
    named_to_plain,
    wrong_value,
)
from bt_orchestrator.view.report.isa95.parts import (
    Parameter,
    Resource,
    Text,
    WorkMaster,
    text_to_plain,
    texts_from_plain,
)

DESCRIPTION = 'Description'
PERSONNEL, EQUIPMENT = 'PersonnelRequirements', 'EquipmentRequirements'
ASSETS, MATERIAL = 'PhysicalAssetRequirements', 'MaterialRequirements'

RESOURCES = {
    PERSONNEL: 'personnel',
    EQUIPMENT: 'equipment',
    ASSETS: 'physical_assets',
    MATERIAL: 'material',
}
"""Names in the standard, and fields of a `JobOrder`."""

RECIPE_VERSION = 'RecipeVersion'
"""A parameter of an order by recipe: the version; without it the newest is made."""

USE = 'EquipmentUse'
"""Of an equipment in an order by recipe: the operation that it is to do."""

OTHER = 'Details'
"""A parameter with what else the details of an order have, as JSON."""

_ONCE = (RUNS_PLANNED, RECIPE_VERSION, OTHER)
"""Parameters outside of the script, besides the names of OPC 40001-3."""

_MALFORMED = ReturnStatus.MALFORMED


@dataclass(frozen=True)
class JobOrder:
    """ISA95JobOrderDataType; what is empty was not given."""

    id: str
    description: tuple[Text, ...] = ()
    work_masters: tuple[WorkMaster, ...] = ()
    start: float | None = None
    """StartTime, seconds since the epoch."""
    end: float | None = None
    """EndTime: when it should have ended."""
    priority: int | None = None
    parameters: tuple[Parameter, ...] = ()
    personnel: tuple[Resource, ...] = ()
    equipment: tuple[Resource, ...] = ()
    physical_assets: tuple[Resource, ...] = ()
    material: tuple[Resource, ...] = ()


# --- from a job order ---------------------------------------------------------------------------


def work_order(
    order: JobOrder, components: Collection[str] = (), recipes: Collection[str] = ()
) -> WorkOrder:
    """Return the work order that a job order asks for.

    :param components: of the cell, that EquipmentRequirements may name; empty: not known
    :param recipes: names that WorkMasterID can have of recipes; every other is that of a script
    :raises Unfit: with every finding
    """
    read = _read(order, components, recipes)
    (master,) = order.work_masters
    recipe = RecipeChoice((master.id,), read.version, read.bind) if read.of_recipe else None
    return WorkOrder(
        '' if recipe else master.id,
        order.id,
        read.quantity,
        read.params,
        Terms(order.priority or 0, order.start, order.end, read.details),
        recipe,
    )


def changes(
    order: JobOrder,
    now: ListedJob | None,
    components: Collection[str] = (),
    recipes: Collection[str] = (),
) -> dict[str, object]:
    """Return the arguments of the request job.update; what the order does not name stays.

    :param now: the job as it is; None: it is not listed, and the cell will say so
    :param recipes: as of a new order
    :raises Unfit: with every finding
    """
    was = now.choice if now is not None else None
    read = _read(order, components, recipes, is_whole=False, was=was, is_known=now is not None)
    asked: dict[str, object] = {'job': order.id}
    if now is not None:
        asked |= _other_source(order, now, read)
    if read.quantity is not None:
        asked['quantity'] = read.quantity
    if read.params:
        asked['params'] = read.params
    if order.priority is not None:
        asked['priority'] = order.priority
    for key, moment in (('start', order.start), ('due', order.end)):
        if moment is not None:
            asked[key] = datetime.fromtimestamp(moment, timezone.utc).isoformat()
    if read.details:
        asked['details'] = {**(now.details if now is not None else {}), **read.details}
    return asked


def _other_source(order: JobOrder, now: ListedJob, read: _Reading) -> dict[str, object]:
    """Return what names the script or recipe of a job, if it is to be another one."""
    name, was = next((master.id for master in order.work_masters), ''), now.choice
    if not read.of_recipe:
        is_same = not name or (was is None and name == now.status.script)
        return {} if is_same else {'script': name}
    is_same = was is not None and (not name or name in was.recipes)
    wanted = RecipeChoice(() if is_same else (name,), read.version, read.bind)
    if wanted.over(was) == was:
        return {}
    named = {'recipe': list(wanted.recipes), 'version': wanted.version, 'bind': wanted.bind}
    return {key: value for key, value in named.items() if value}


def reason_in(order: JobOrder) -> str:
    """Return the reason that an order carries as a parameter; empty: none."""
    values = (parameter.value for parameter in order.parameters if parameter.id == REASON)
    return next((value.text if isinstance(value, Text) else str(value) for value in values), '')


def _read(
    order: JobOrder,
    components: Collection[str],
    recipes: Collection[str],
    *,
    is_whole: bool = True,
    was: RecipeChoice | None = None,
    is_known: bool = False,
) -> _Reading:
    """Read an order.

    :param was: what the job that it changes was made from
    :raises Unfit: with every finding
    """
    name = next((master.id for master in order.work_masters), '')
    of_recipe = name in recipes
    if was is not None:
        of_recipe = of_recipe or not name or name in was.recipes
    read = _Reading(order, components, is_whole, of_recipe, is_known)
    findings = tuple(read.findings())
    if findings:
        raise Unfit(findings)
    return read


@dataclass
class _Reading:
    order: JobOrder
    components: Collection[str]
    is_whole: bool
    """False: it changes a job, and may leave everything out."""
    of_recipe: bool
    is_known: bool = False
    """Its id is that of a job, perhaps of an older journal."""
    version: int | None = None
    """Of the recipe; None: the newest, or as it was."""
    bind: dict[str, str] = field(default_factory=dict)
    """Component that does an operation, by the operation's id."""
    quantity: int | None = None
    params: dict[str, str | int | float | bool] = field(default_factory=dict)
    details: dict[str, object] = field(default_factory=dict)

    def findings(self) -> Iterator[Finding]:
        """Read the order; yield everything that is wrong with it."""
        order = self.order
        fault = None if self.is_known else order_id_fault(order.id)
        if fault is not None:
            yield Finding('JobOrderID', f'{order.id!r} cannot be one: {fault}', _MALFORMED)
        if order.description:
            self.details[DESCRIPTION] = [text_to_plain(text) for text in order.description]
        yield from self._read_masters()
        yield from self._read_parameters()
        yield from self._read_resources()

    def _read_masters(self) -> Iterator[Finding]:
        masters = self.order.work_masters
        if len(masters) != 1 and (masters or self.is_whole):
            named = ', '.join(master.id for master in masters) or 'none'
            yield Finding('WorkMasterID', f'expected exactly one, found {named}')
        for master in masters[:1]:
            if not master.id:
                what = 'its ID is empty; name a script, or a recipe'
                yield Finding('WorkMasterID', what, _MALFORMED)
            yield from self._read_params('WorkMasterID.Parameters', master.parameters)

    def _read_parameters(self) -> Iterator[Finding]:
        where = 'JobOrderParameters'
        for parameter, is_first in _with_first(self.order.parameters):
            if not is_first and (parameter.id in _ONCE or parameter.id in KINDS):
                yield Finding(f'{where}.{parameter.id}', 'is given twice; give it once')
            elif parameter.id == RUNS_PLANNED:
                yield from self._read_quantity(f'{where}.{parameter.id}', parameter.value)
            elif parameter.id == RECIPE_VERSION and self.of_recipe:
                yield from self._read_version(f'{where}.{parameter.id}', parameter.value)
            elif parameter.id in KINDS:
                yield from self._read_named(f'{where}.{parameter.id}', parameter)
            elif parameter.id == OTHER:
                yield from self._read_others(f'{where}.{parameter.id}', parameter.value)
            elif parameter.id != REASON:
                yield from self._read_params(where, (parameter,))

    def _read_quantity(self, where: str, value: object) -> Iterator[Finding]:
        if not isinstance(value, int) or isinstance(value, bool):
            yield Finding(where, f'expected a whole number, found {value!r}', _MALFORMED)
        elif value < 1:
            yield Finding(where, f'expected the number of items, at least 1; found {value}')
        else:
            self.quantity = value

    def _read_version(self, where: str, value: object) -> Iterator[Finding]:
        if not isinstance(value, int) or isinstance(value, bool):
            yield Finding(where, f'expected a whole number, found {value!r}', _MALFORMED)
        elif value < 1:
            yield Finding(where, f'versions count from 1; found {value}')
        else:
            self.version = value

    def _read_named(self, where: str, parameter: Parameter) -> Iterator[Finding]:
        wrong = wrong_value(parameter)
        if wrong is not None:
            yield Finding(where, wrong, _MALFORMED)
        else:
            self.details[parameter.id] = named_to_plain(parameter)

    def _read_others(self, where: str, value: object) -> Iterator[Finding]:
        try:
            others = json.loads(value) if isinstance(value, str) else None
        except (RecursionError, ValueError):
            others = None
        if not isinstance(others, dict):
            yield Finding(where, f'expected a JSON object as a text, found {value!r}', _MALFORMED)
        else:
            self.details = {**others, **self.details}

    def _read_params(self, where: str, parameters: Iterable[Parameter]) -> Iterator[Finding]:
        """Read parameters of the script; the cell knows which those are."""
        for parameter in parameters:
            value = _scalar(parameter.value)
            place = f'{where}.{parameter.id}'
            if not parameter.id:
                yield Finding(where, 'a parameter has no ID', _MALFORMED)
            elif parameter.parts:
                yield Finding(place, 'a parameter of a script has no sub-parameters')
            elif value is None:
                expected = 'expected a boolean, a number or a text'
                yield Finding(place, f'{expected}, found {parameter.value!r}', _MALFORMED)
            elif parameter.id in self.params and self.params[parameter.id] != value:
                yield Finding(place, f'is given twice: {self.params[parameter.id]!r}, {value!r}')
            else:
                self.params[parameter.id] = value

    def _read_resources(self) -> Iterator[Finding]:
        for name, attribute in RESOURCES.items():
            resources = getattr(self.order, attribute)
            if resources:
                self.details[name] = [dict(resource) for resource in resources]
        for device in self.order.equipment:
            id_ = device.get('ID')
            if self.components and id_ not in self.components:
                there = ', '.join(sorted(self.components))
                yield Finding(EQUIPMENT, f'there is no {id_!r} in this cell; it has {there}')
            elif self.of_recipe:
                yield from self._read_use(str(id_ or ''), str(device.get(USE) or ''))

    def _read_use(self, component: str, operation: str) -> Iterator[Finding]:
        """Bind an operation; what only has to be there says no use."""
        if operation and self.bind.setdefault(operation, component) != component:
            components = f'{self.bind[operation]}, {component}'
            yield Finding(
                EQUIPMENT,
                f'`{operation}` is to be done by two: {components}; leave it at one of them',
            )


def _with_first(parameters: Iterable[Parameter]) -> Iterator[tuple[Parameter, bool]]:
    """Yield parameters, and whether they are the first of their name."""
    before: set[str] = set()
    for parameter in parameters:
        yield parameter, parameter.id not in before
        before.add(parameter.id)


def _scalar(value: object) -> str | int | float | bool | None:
    if isinstance(value, Text):
        return value.text
    return value if isinstance(value, (str, int, float, bool)) else None


# --- back to a job order ------------------------------------------------------------------------


def job_order(job: ListedJob) -> JobOrder:
    """Return the job order that a listed job was made from, whichever door it came in by.

    Parameters of the script are with its work master; the others are named by OPC 40001-3.
    """
    status, details = job.status, job.details
    params = tuple(Parameter(name, value) for name, value in job.params.items())
    named = tuple(named_parameters(details))
    ids = {*_STANDARD, *(parameter.id for parameter in named)}
    choice = job.choice
    version = choice.version if choice is not None else None
    others = {key: value for key, value in details.items() if key not in ids}
    return JobOrder(
        status.id,
        texts_from_plain(details.get(DESCRIPTION)),
        tuple(
            WorkMaster(name, parameters=params)
            for name in (choice.recipes if choice is not None else (status.script,))
        ),
        status.start,
        status.due,
        status.priority,
        (
            Parameter(RUNS_PLANNED, status.quantity),
            *([] if version is None else [Parameter(RECIPE_VERSION, version)]),
            *named,
            *([Parameter(OTHER, json_of(others))] if others else []),
        ),
        **{field_: _resources(details.get(name)) for name, field_ in RESOURCES.items()},
    )


_STANDARD = {DESCRIPTION, *RESOURCES}


def _resources(plain: object) -> tuple[Resource, ...]:
    several = plain if isinstance(plain, (list, tuple)) else []
    return tuple(resource for resource in several if isinstance(resource, Mapping))
