"""Whether jobs of several scripts can share the flags of a line (semantics 4.1)."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.job_commands import Sharing
from bt_orchestrator.model.proof.deadlock import get_stuck_together
from bt_orchestrator.model.script import Dependency, Script
from bt_orchestrator.model.words import sentence


def examine(new: Mapping[str, Script], live: Mapping[str, Script]) -> Sharing:
    """Check new scripts against those of live jobs, and against the new ones before them.

    Scripts are given by their digests.
    """
    known = dict(live)
    why_not: dict[str, str] = {}
    for name, script in new.items():
        reason = contradiction(script, known)
        if reason is not None:
            why_not[name] = reason
        known[name] = script
    return Sharing(frozenset(known), why_not)


def contradiction(
    new: Script, known: Mapping[str, Script], sharing: Sharing | None = None
) -> str | None:
    """Say why a script cannot share its flags with those of other jobs.

    :param known: by digest
    :param sharing: an earlier result of `examine`; used if it covers all of them
    """
    if not new.dependencies:
        return None
    name = digest(new)
    others = {other: script for other, script in known.items() if script.dependencies}
    if sharing is not None and {name, *others} <= sharing.among:
        return sharing.why_not.get(name)
    others.pop(name, None)
    return _disagreement(new, others) or _circle(new, others)


def _circle(new: Script, others: Mapping[str, Script]) -> str | None:
    """Say with which scripts a line could get stuck, although none does alone."""
    flags = {dependency.flag for dependency in new.dependencies}
    sharing = [s for s in others.values() if not flags.isdisjoint(d.flag for d in s.dependencies)]
    if not sharing or not get_stuck_together([new, *others.values()]):
        return None
    names = ', '.join(dict.fromkeys(script.name for script in sharing))
    return sentence('stuck_together', script=new.name, others=names)


def _disagreement(new: Script, others: Mapping[str, Script]) -> str | None:
    """Say which script shares a flag and disagrees about it."""
    for script in others.values():
        there = {dependency.flag: dependency for dependency in script.dependencies}
        for dependency in new.dependencies:
            other = there.get(dependency.flag)
            if other is not None and _traits(new, dependency) != _traits(script, other):
                names = {'script': new.name, 'other': script.name}
                return sentence('flag_differs', **names, flag=dependency.flag)
    return None


def _traits(script: Script, dependency: Dependency) -> tuple[int, int, int, int]:
    upstream = script.section_of(dependency.upstream)
    downstream = script.section_of(dependency.downstream)
    return dependency.capacity, dependency.initial, upstream, downstream
