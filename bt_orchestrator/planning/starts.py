"""Plans that the search begins with."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.planning.plans import Plan, Plans

BISECTIONS = 12

_LAST = 10**9
"""Behind every section."""


def starts(plans: Plans) -> Iterator[Plan]:
    """Yield what was declared first, what is where it was, everything early, late, and by weight.

    The last one is the heuristic of ranked positional weight, with the shortest time of a section
    that it finds room in (Helgeson and Birnie 1961).
    """
    early = plans.first()
    yield _with_choices(plans, early, [0] * len(early))
    yield early
    yield plans.last()
    yield _with_choices(
        plans, early, [min(range(len(ways)), key=ways.__getitem__) for ways in plans.moved]
    )
    weighed = _by_weight(plans)
    if weighed is not None:
        yield weighed


def _with_choices(plans: Plans, plan: Plan, numbers: list[int]) -> Plan:
    for piece, number in enumerate(numbers):
        plan = plans.with_choice(plan, piece, number)
    return plan


def _by_weight(plans: Plans) -> Plan | None:
    least = [min(one.us for one in ways) for ways in plans.choices]
    weights = [
        own + sum(least[other] for other in range(len(least)) if behind >> other & 1)
        for own, behind in zip(least, plans.pieces.all_behind, strict=True)
    ]
    ranked = sorted(range(len(weights)), key=lambda piece: (-weights[piece], piece))
    low, high = 0, plans.move_us + sum(max(one.us for one in ways) for ways in plans.choices)
    found = _filled(plans, ranked, high)
    for _ in range(BISECTIONS):
        middle = (low + high) // 2
        filled = _filled(plans, ranked, middle)
        if filled is None:
            low = middle
        else:
            found, high = filled, middle
    return found


def _filled(plans: Plans, ranked: list[int], most_us: int) -> Plan | None:
    """Put each piece into the first section with room for it; None: there is none."""
    plan = list(plans.first())
    took: dict[int, int] = {}
    placed: dict[int, int] = {}
    left = list(ranked)
    while left:
        piece = next(one for one in left if placed.keys() >= {*plans.pieces.before[one]})
        left.remove(piece)
        earliest = max((placed.get(one, 0) for one in plans.before[piece]), default=0)
        latest = min((placed.get(one, _LAST) for one in plans.behind[piece]), default=_LAST)
        ways = plans.choices[piece]
        fit = [
            (one.section, one.us, number)
            for number, one in enumerate(ways)
            if earliest <= one.section <= latest
            and took.get(one.section, 0) + one.us + plans.move_us * one.needs_belt <= most_us
        ]
        if not fit:
            return None
        section, us, plan[piece] = min(fit)
        placed[piece] = section
        took[section] = took.get(section, 0) + us
    return tuple(plan)
