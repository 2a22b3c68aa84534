"""Why each component does what it does."""

from __future__ import annotations

from bt_orchestrator.model.recipe import Overrides
from bt_orchestrator.model.script import Script
from bt_orchestrator.planning.candidates import Candidate
from bt_orchestrator.planning.outcome import Made, Why
from bt_orchestrator.planning.plans import Plan, Plans
from bt_orchestrator.planning.scripts import chosen


def made(plan: Plan, plans: Plans, overrides: Overrides, script: Script) -> dict[str, Made]:
    """Return where each task came from, in the order of the script."""
    found = chosen(plan, plans)
    facts = {
        task.id: Made(task.id, '', task.component, 0, Why.ONLY) for task in script.initialization
    }
    for section in script.sections.values():
        for task in section.tasks:
            facts[task.id] = _made(found[task.id], plan, plans, overrides)
    return facts


def _made(one: Candidate, plan: Plan, plans: Plans, overrides: Overrides) -> Made:
    name = one.operation.id
    piece = plans.pieces.number_of[name]
    others = dict.fromkeys(
        member.component.name
        for choice in plans.choices[piece]
        for member in choice.members
        if member.operation.id == name and member.component is not one.component
    )
    why = Why.ONLY
    if name in overrides.bind:
        why = Why.OVERRIDE
    elif others:
        why = _why(piece, plan, plans)
    return Made(
        operation=name,
        capability=one.capability.name,
        component=one.component.name,
        section=one.section,
        why=why,
        alternatives=tuple(others),
    )


def _why(piece: int, plan: Plan, plans: Plans) -> Why:
    here = plans.cost(plan)
    others = [
        plans.cost(plans.with_choice(plan, piece, number))
        for number in range(len(plans.choices[piece]))
        if number != plan[piece]
    ]
    known = [one for one in others if one is not None]
    if here is None or not known or all(one.us > here.us for one in known):
        return Why.PACE
    if all(one.moved > here.moved for one in known):
        return Why.KEPT
    if all((one.us, one.spread) > (here.us, here.spread) for one in known):
        return Why.SPREAD
    return Why.DECLARED
