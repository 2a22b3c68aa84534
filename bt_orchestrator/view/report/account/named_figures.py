"""The figures of an account by name: those of the line, of a product, of a job, of a component."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from enum import Enum
from fractions import Fraction
from typing import NamedTuple

from bt_orchestrator.view.report.account.causes.flaws import Effect
from bt_orchestrator.view.report.account.causes.made import Made
from bt_orchestrator.view.report.account.figures import Figures
from bt_orchestrator.view.report.account.losses import PARTS, WORDS, Loss, Part, Step
from bt_orchestrator.view.report.account.stops import Repairs, Stop
from bt_orchestrator.view.report.account.words import duration, percent


class By(Enum):
    """The owners of the rows of a report."""

    PRODUCT = 'product'
    """A recipe, or a script that was written by hand."""
    JOB = 'job'
    COMPONENT = 'component'


class Unit(Enum):
    """The unit of a figure."""

    RATIO = 'ratio'
    COUNT = 'count'
    SECONDS = 'seconds'
    """Kept as microseconds."""

    def words(self, value: Fraction | None, *, signed: bool = False) -> str:
        """Write a figure, or with a sign the change of one."""
        if value is None:
            return ''
        if not value and self is not Unit.RATIO:
            return '0'
        sign = '+' if signed and value > 0 else ''
        if self is Unit.COUNT:
            number = f'{float(value):.1f}' if signed else str(value)
        elif self is Unit.SECONDS:
            number = duration(value)
        else:
            number = f'{float(value) * 100:.1f} points' if signed else percent(value)
        return f'{sign}{number}'


class Figure(NamedTuple):
    """One figure of an account."""

    name: str
    title: str
    unit: Unit
    tell: Callable[[Figures], Fraction | int | None]


OF_LINE = (
    Figure('oee', 'OEE', Unit.RATIO, lambda shown: shown.oee),
    Figure('availability', 'availability', Unit.RATIO, lambda shown: shown.availability),
    Figure('performance', 'performance', Unit.RATIO, lambda shown: shown.performance),
    Figure('quality', 'quality', Unit.RATIO, lambda shown: shown.quality),
    Figure('produced', 'produced', Unit.COUNT, lambda shown: shown.produced),
    Figure('good', 'good', Unit.COUNT, lambda shown: shown.good),
    Figure(
        'first_pass_yield', 'first-pass yield', Unit.RATIO, lambda shown: shown.first_pass_yield
    ),
    Figure('per_item', 'time of an item', Unit.SECONDS, lambda shown: shown.per_item_us),
    Figure('pace', 'pace', Unit.SECONDS, lambda shown: shown.pace_us),
    Figure('planned', 'planned time', Unit.SECONDS, lambda shown: shown.times.planned.total_us),
)


def of_loss(loss: Loss) -> Figure:
    """Return a loss of time; performance and quality are known with a pace alone."""
    needs_pace = WORDS[loss].step in {Step.PERFORMANCE, Step.QUALITY}

    def tell(shown: Figures) -> Fraction | None:
        return None if needs_pace and not shown.has_paces else shown.loss_us(loss)

    return Figure(loss.value, f'- {WORDS[loss].title}', Unit.SECONDS, tell)


def _of_part(part: Part, title: str) -> Figure:
    return Figure(part.value, f'    {title}', Unit.SECONDS, lambda shown: shown.part_us(part))


def of_parts(loss: Loss) -> Iterator[Figure]:
    """Yield the parts of a loss, and of an own fault its classes."""
    for part, words in PARTS.items():
        if words.loss is loss:
            yield _of_part(part, words.title)
    if loss is Loss.OWN_FAULT:
        yield Figure(
            'micro_stops', '    micro-stops', Unit.COUNT, lambda shown: shown.micro_stops().times
        )
        yield Figure(
            'breakdowns', '    breakdowns', Unit.COUNT, lambda shown: shown.breakdowns().times
        )


def _of_made(name: str, by: By) -> tuple[Figure, ...]:
    def made(shown: Figures) -> list[Made]:
        return [
            job for job in shown.times.made if name == (job.job if by is By.JOB else job.product)
        ]

    def good_of_produced(shown: Figures) -> Fraction | None:
        produced = sum(job.produced for job in made(shown))
        return Fraction(sum(job.good for job in made(shown)), produced) if produced else None

    def first_pass_yield(shown: Figures) -> Fraction | None:
        passed = shown.of_causes(sum(job.first_pass for job in made(shown)))
        produced = sum(job.produced for job in made(shown))
        return Fraction(passed, produced) if produced and passed is not None else None

    def at_pace(shown: Figures) -> Fraction | None:
        left = [job for job in made(shown) if job.produced]
        if any(job.digest not in shown.paces for job in left):
            return None
        return sum(
            (shown.paces[job.digest].limit.per_item_us * job.produced for job in left), Fraction(0)
        )

    def count(field: str, title: str) -> Figure:
        return Figure(
            field, title, Unit.COUNT, lambda shown: sum(getattr(job, field) for job in made(shown))
        )

    def again(field: str, title: str) -> Figure:
        def told(shown: Figures) -> int | None:
            return shown.of_causes(sum(getattr(job, field) for job in made(shown)))

        return Figure(field, title, Unit.COUNT, told)

    return (
        count('produced', 'produced'),
        count('good', 'good'),
        count('nonconforming', 'nonconforming'),
        count('rejected', 'rejected'),
        count('by_hand', 'by hand'),
        Figure('good_of_produced', 'good of produced', Unit.RATIO, good_of_produced),
        again('first_pass', 'first pass'),
        Figure('first_pass_yield', 'first-pass yield', Unit.RATIO, first_pass_yield),
        again('attempts', 'further attempts'),
        again('rounds', 'rework rounds'),
        Figure('at_pace', 'time at the pace', Unit.SECONDS, at_pace),
    )


def _of_component(name: str) -> tuple[Figure, ...]:
    def stops(shown: Figures) -> list[Stop]:
        return [stop for stop in shown.times.stops if stop.component == name and stop.is_shown]

    def repairs(shown: Figures) -> Repairs | None:
        return next((repair for repair in shown.times.repairs if repair.component == name), None)

    def mtbf(shown: Figures) -> Fraction | None:
        failed = repairs(shown)
        return None if failed is None else shown.mtbf_us(failed)

    def mttr(shown: Figures) -> Fraction | None:
        failed = repairs(shown)
        return None if failed is None else shown.mttr_us(failed)

    def failures(shown: Figures) -> int:
        failed = repairs(shown)
        return 0 if failed is None else failed.failures

    def attempts(shown: Figures) -> int:
        return sum(failure.times for failure in shown.times.failing if failure.component == name)

    def operated(shown: Figures) -> int | None:
        return shown.of_causes(shown.times.operated_us.get(name, 0))

    def caused(field: str, title: str, *effects: Effect) -> Figure:
        def told(shown: Figures) -> int | None:
            return shown.of_causes(
                sum(
                    flaw.times
                    for flaw in shown.times.flaws
                    if flaw.of.component == name and flaw.of.effect in effects
                )
            )

        return Figure(field, title, Unit.COUNT, told)

    return (
        Figure('lost', 'lost', Unit.SECONDS, lambda shown: sum(stop.us for stop in stops(shown))),
        Figure(
            'stops', 'stops', Unit.COUNT, lambda shown: sum(stop.times for stop in stops(shown))
        ),
        Figure(
            'micro_stops',
            'micro-stops',
            Unit.COUNT,
            lambda shown: shown.micro_stops(name).times,
        ),
        Figure('breakdowns', 'breakdowns', Unit.COUNT, lambda shown: shown.breakdowns(name).times),
        Figure('operated', 'operating time', Unit.SECONDS, operated),
        Figure('failures', 'failures', Unit.COUNT, failures),
        Figure('mtbf', 'MTBF', Unit.SECONDS, mtbf),
        Figure('mttr', 'MTTR', Unit.SECONDS, mttr),
        Figure('failed_attempts', 'failed attempts', Unit.COUNT, attempts),
        caused('scrap', 'not good by it', Effect.REJECTED, Effect.NONCONFORMING),
        caused('again', 'done again by it', Effect.ATTEMPT, Effect.ROUND),
    )


def of_named(name: str, by: By) -> tuple[Figure, ...]:
    """Return the figures of a product, a job or a component."""
    return _of_component(name) if by is By.COMPONENT else _of_made(name, by)


def names_of(shown: Figures, by: By) -> Iterable[str]:
    """Return all names: components by what they cost, all else in the order in which it came."""
    times = shown.times
    if by is By.COMPONENT:
        lists = (times.stops, times.repairs, times.failing)
        named = (record.component for records in lists for record in records)
        return dict.fromkeys(filter(None, (*named, *times.operated_us)))
    return dict.fromkeys(job.job if by is By.JOB else job.product for job in times.made)
