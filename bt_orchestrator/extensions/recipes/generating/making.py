"""From inputs to the text of a script that was read again, proven and run before it is shown."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

from bt_orchestrator.base.errors import OrchestratorError, Refused
from bt_orchestrator.extensions.recipes.generating.comments import comments_of
from bt_orchestrator.extensions.recipes.generating.inputs import Inputs
from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.extensions.recipes.planning.outcome import Generated, Judge, NotMade, Price
from bt_orchestrator.extensions.recipes.planning.prices import prices
from bt_orchestrator.extensions.recipes.planning.problem import Problem
from bt_orchestrator.model.codec import digest, digest_of
from bt_orchestrator.model.script import MadeFrom, Script
from bt_orchestrator.script.orders.admission import admitted
from bt_orchestrator.script.writing.script_text import write_script
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
    found = plan(inputs, without, keep, judge)
    if keep is not None:
        found = _freely(found, inputs, without, judge)
    comments = comments_of(found, inputs, without)
    bare = write_script(replace(found.script, made_from=None), inputs.cell, comments)
    lacking = tuple(sorted(without & inputs.able))
    made_from = replace(inputs.made_from, text_digest=text_digest(bare), without=lacking)
    script = replace(found.script, made_from=made_from)
    made = Made(
        replace(found, script=script), made_from, write_script(script, inputs.cell, comments)
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


def _freely(found: Generated, inputs: Inputs, without: frozenset[str], judge: Judge) -> Generated:
    """Return the same script as made without one to keep; return other ones unchanged.

    A script that is generated anew on itself is then the same file, reasons and all.
    """
    with suppress(NotMade):
        freely = plan(inputs, without, None, judge)
        if freely.script == found.script:
            return freely
    return found


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
        raise NotVouchedFor(_defect(f'would be refused: {refused.in_short}')) from refused
    meant = replace(made.generated.script, made_from=made.made_from)
    apart = (again.made_from, again.likely) == (meant.made_from, meant.likely)
    if digest(again) != digest(meant) or not apart:
        raise NotVouchedFor(_defect('is read as another one'))
    if judge.pace_s(again) is None:
        raise NotVouchedFor(_defect('does not finish in the simulation'))


def _defect(what: str) -> str:
    return (
        f'the generated script {what}, so nothing is written; this is a defect of the program: '
        'report it with the recipe, its overrides and the cell file'
    )
