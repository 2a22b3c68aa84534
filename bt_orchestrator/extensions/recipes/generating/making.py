"""From inputs to the text of a script that was read again, proven and run before it is shown."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from bt_orchestrator.base.errors import OrchestratorError, Refused, counted
from bt_orchestrator.extensions.recipes.generating.inputs import Inputs
from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.extensions.recipes.planning.outcome import (
    Generated,
    Judge,
    NotFound,
    NotMade,
    Price,
    Why,
)
from bt_orchestrator.extensions.recipes.planning.outcome import Made as Fact
from bt_orchestrator.extensions.recipes.planning.planner import Problem, prices
from bt_orchestrator.model.codec import digest, digest_of
from bt_orchestrator.model.jobs.order import compared_words
from bt_orchestrator.model.script import MadeFrom, Script
from bt_orchestrator.script.orders.admission import admitted
from bt_orchestrator.script.writing.script_text import Comments, write_script
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.store.memory import MemoryStore

_ORIGIN = re.compile(r'(?m)^made_from:.*\n(?:[ \t].*\n)*')


class NotVouchedFor(OrchestratorError):
    """A generated script did not pass what every script has to pass."""


@dataclass(frozen=True)
class Made:
    """A script that was generated, and its file."""

    generated: Generated
    made_from: MadeFrom
    text: str


def make(
    inputs: Inputs, without: frozenset[str] = frozenset(), keep: Script | None = None
) -> Made:
    """Generate the script, write it, and try what was written.

    :param without: components that are out of service
    :param keep: a script of before, of which as much as possible is kept
    :raises NotMade: there is none, or none was found
    :raises NotVouchedFor: it does not pass
    """
    judge = judge_of(inputs)
    generated = plan(inputs, without, keep, judge)
    if keep is not None:
        generated = _freely(generated, inputs, without, judge)
    comments = comments_of(generated, inputs, without)
    bare = write_script(replace(generated.script, made_from=None), inputs.cell, comments)
    lacking = tuple(sorted(without & inputs.able))
    made_from = replace(inputs.made_from, text_digest=text_digest(bare), without=lacking)
    script = replace(generated.script, made_from=made_from)
    made = Made(
        replace(generated, script=script), made_from, write_script(script, inputs.cell, comments)
    )
    _try(made, inputs, judge)
    return made


def plan(inputs: Inputs, without: frozenset[str], keep: Script | None, judge: Judge) -> Generated:
    """Find the script, without writing it.

    :raises NotMade: there is none, or none was found
    """
    return generate(
        inputs.cell, inputs.recipe, inputs.overrides, without=without, keep=keep, judge=judge
    )


def _freely(
    generated: Generated, inputs: Inputs, without: frozenset[str], judge: Judge
) -> Generated:
    """Return the same script as made without one to keep; return other ones unchanged.

    A script that is generated anew on itself is then the same file, reasons and all.
    """
    with suppress(NotMade):
        freely = plan(inputs, without, None, judge)
        if freely.script == generated.script:
            return freely
    return generated


def prices_of(
    made: Made, inputs: Inputs, without: frozenset[str]
) -> Mapping[str, tuple[Price, ...]]:
    """Return what each other component of each operation would cost."""
    problem = Problem(inputs.cell, inputs.recipe, inputs.overrides, without)
    return prices(problem, made.generated, judge_of(inputs))


def judge_of(inputs: Inputs) -> PaceJudge:
    """Return what runs scripts of a cell in virtual time."""
    return PaceJudge(inputs.cell, inputs.types, MemoryStore)


def text_digest(text: str) -> str:
    """Return a digest of a file without the key `made_from`, however its lines end."""
    return digest_of(_ORIGIN.sub('', '\n'.join(text.splitlines()) + '\n'))


def _try(made: Made, inputs: Inputs, judge: Judge) -> None:
    """Read what was written, prove that it cannot get stuck, and run it.

    :raises NotVouchedFor: it does not pass
    """
    name = f'{made.generated.script.name}.yaml'
    try:
        again = admitted(made.text, name, inputs.cell, inputs.types)
    except Refused as refused:
        why = _two_setups(made.generated.script) or _defect(
            f'would be refused: {refused.in_short}'
        )
        raise NotVouchedFor(why) from refused
    meant = replace(made.generated.script, made_from=made.made_from)
    apart = (again.made_from, again.likely) == (meant.made_from, meant.likely)
    if digest(again) != digest(meant) or not apart:
        raise NotVouchedFor(_defect('is read as another one'))
    if judge.pace_s(again) is None:
        raise NotVouchedFor(_defect('does not finish in the simulation'))


def _two_setups(script: Script) -> str:
    """Name operations that need different values of a setup of their component (semantics 5.3)."""
    first: dict[tuple[str, str], tuple[str, str]] = {}
    for task in script.tasks.values():
        for setup, value in task.setup.items():
            other, there = first.setdefault((task.component, setup), (task.id, value))
            if there != value:
                return (
                    f'`{other}` needs {setup} {there} of `{task.component}`, and `{task.id}` '
                    f'{value}: put an operation between them that changes it, and one behind them '
                    'that changes it back, or bind one of them to another component'
                )
    return ''


def _defect(what: str) -> str:
    return (
        f'the generated script {what}, so nothing is written; this is a defect of the program: '
        'report it with the recipe, its overrides and the cell file'
    )


# Remarks of a generated script about its lines: facts that stay, no figures.


def comments_of(generated: Generated, inputs: Inputs, without: Collection[str]) -> Comments:
    """Return the comments of a generated script."""
    recipe = inputs.recipe
    origin_of_all = (
        f'Generated from version {recipe.version} of the recipe {recipe.name} for the cell '
        f'{inputs.cell.name}. Do not edit it: change the recipe, the cell or the overrides, '
        'and generate it again.'
    )
    lacking = f'Without {", ".join(sorted(without))}.'
    head = [origin_of_all, lacking] if without else [origin_of_all]
    return Comments(
        head, tasks={task: origin_remark(made) for task, made in generated.made.items()}
    )


def origin_remark(made: Fact) -> str:
    """Say where a task came from, and why this component does it."""
    if not made.capability:
        return f'prepares {made.component}'
    what = made.operation
    if made.capability != made.operation:
        what += f' ({made.capability})'
    return f'{what} by {made.component}: {reason_remark(made)}'


def reason_remark(made: Fact) -> str:
    """Say why a component does an operation."""
    others = [alternative for alternative in made.alternatives if alternative != made.component]
    if made.why is Why.ONLY or not others:
        return made.why.value
    return f'{made.why.value}; {", ".join(others)} could too'


# The output and pace of the line while one component is out of service: for planners.


@dataclass(frozen=True)
class Outage:
    """The line without one component."""

    component: str
    per_item_s: float | None = None
    """None: the product cannot be made, or it is not known how."""
    slower: float = 0.0
    """As a part of the time with all components."""
    elsewhere: tuple[str, ...] = ()
    """Operations that are done elsewhere."""
    only_there: tuple[str, ...] = ()
    """Operations that no other component can do."""
    reasons: tuple[str, ...] = ()
    """Why not."""
    is_proven: bool = True
    """The script cannot be made."""

    @property
    def words(self) -> str:
        """The consequences."""
        if self.per_item_s is None:
            verdict = 'not to be made' if self.is_proven else 'not known'
            why = f'{", ".join(self.only_there)} only there' if self.only_there else ''
            return f'{verdict}: {why or "; ".join(self.reasons)}'
        return compared_words(self.per_item_s, self.slower)


def outages(
    inputs: Inputs, whole: Generated, without: frozenset[str], keep: Script | None
) -> Iterator[Outage]:
    """Yield what comes of each component's outage, in the order of the cell file.

    :param whole: the script with all that are in service
    :param without: components that are out of service in any case
    """
    judge = judge_of(inputs)
    for name, component in inputs.cell.components.items():
        if not component.capabilities or name in without:
            continue
        try:
            generated = plan(inputs, without | {name}, keep, judge)
        except NotMade as fault:
            is_proven = not isinstance(fault, NotFound)
            lost = _only_at(name, whole)
            yield Outage(name, only_there=lost, reasons=fault.reasons, is_proven=is_proven)
        else:
            seconds, before = generated.claim.per_item_s, whole.claim.per_item_s
            slower = seconds / before - 1 if before else 0.0
            yield Outage(name, seconds, slower, moved(whole.script, generated))


def _only_at(component: str, whole: Generated) -> tuple[str, ...]:
    facts = (fact for fact in whole.made.values() if fact.capability and not fact.alternatives)
    return tuple(fact.operation for fact in facts if fact.component == component)


def moved(old: Script, now: Generated) -> tuple[str, ...]:
    """Return the operations that are done elsewhere than in a script."""
    return tuple(
        task
        for task, fact in now.made.items()
        if fact.capability
        and (
            task not in old.tasks
            or old.tasks[task].component != fact.component
            or old.section_of(task) != fact.section
        )
    )


def outage_lines(whole: Generated, all_outages: Sequence[Outage]) -> Iterator[str]:
    """Yield a table."""
    rows = [('all in service', f'{whole.claim.per_item_s:.1f} s per item', '')]
    for outage in all_outages:
        moved = (
            f'{counted(len(outage.elsewhere), "operation")} elsewhere' if outage.elsewhere else ''
        )
        rows.append((outage.component, outage.words, moved))
    width = max(len(out) for out, _, _ in rows)
    for out, words, moved in rows:
        yield f'{out.ljust(width)}  {words}{", " if moved else ""}{moved}'


def plain_outages(whole: Generated, all_outages: Sequence[Outage]) -> Mapping[str, Any]:
    """Return them as data that JSON can carry."""
    each = [{**vars(outage), 'words': outage.words} for outage in all_outages]
    return {'ok': True, 'per_item_s': whole.claim.per_item_s, 'without': each}
