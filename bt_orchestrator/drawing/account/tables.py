"""The tables of the page: the waterfall and the Paretos with their bars, and what stands below."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from bt_orchestrator.drawing.account.bars import bar
from bt_orchestrator.drawing.account.html import Column, Row, table, text
from bt_orchestrator.report.account.account import Account
from bt_orchestrator.report.account.figures import Bar, Figures
from bt_orchestrator.report.account.losses import WORDS, Step
from bt_orchestrator.report.account.stops import Held, Stop
from bt_orchestrator.report.account.troubles import FailingTask
from bt_orchestrator.report.account.words import UNKNOWN, duration, percent

_TIME, _NUMBER = Column('time', 'n'), Column('times', 'n')


def waterfall(shown: Figures) -> Iterator[str]:
    """Yield from the planned time over every loss to what is left at the end."""
    columns = (Column(''), Column('', 'bar'), _TIME, Column('of planned', 'n'))
    yield from table(columns, _steps(shown))


def _steps(shown: Figures) -> Iterator[Row]:
    whole = shown.times.planned.total_us
    left = Fraction(0)
    for one in shown.steps_seen():
        begin, left = (left, left - one.us) if one.loss else (Fraction(0), one.us)
        drawn = bar(begin / whole, left / whole)
        told = (drawn, _signed(one), percent(one.us / whole))
        yield Row((text(one.title), *told), _kind(one))


def _kind(one: Bar) -> str:
    return f'loss {_step(WORDS[one.loss].step)}' if one.loss else 'left'


def _step(step: Step) -> str:
    return step.value.replace(' ', '-')


def _signed(one: Bar) -> str:
    return (
        f'\N{MINUS SIGN}{duration(one.us)}' if one.loss and one.us >= 0 else duration(abs(one.us))
    )


def stops(shown: Figures) -> Iterator[str]:
    """Yield the Pareto of the stops: how long, how often, and the share of them and all above."""
    found = [one for one in shown.times.stops if one.is_shown]
    if not found:
        return
    columns = (Column(''), Column('', 'bar'), _TIME, _NUMBER, Column('so far', 'n'))
    yield from table(columns, _pareto(found))


def _pareto(found: list[Stop]) -> Iterator[Row]:
    whole, longest, so_far = sum(one.us for one in found), found[0].us, 0
    for one in found:
        so_far += one.us
        name = f'{text(WORDS[one.loss].title)}<small>{text(one.about)}</small>'
        drawn = bar(0, Fraction(one.us, longest))
        told = (drawn, duration(one.us), str(one.times), percent(Fraction(so_far, whole)))
        yield Row((name, *told), _step(Step.AVAILABILITY))


def holds(account: Account) -> Iterator[str]:
    """Yield the holds in their order, with what was answered."""
    times = account.figures.times
    if times.holds:
        columns = (
            Column('from', 't'),
            Column('to', 't'),
            Column('lost', 'n'),
            Column('what'),
            Column('answer'),
        )
        yield from table(columns, (_hold(account, held) for held in times.holds))
    if times.holds_left_out:
        us = sum(times.left_out_us.values())
        yield f'<p>and {times.holds_left_out} others, {duration(us)} together</p>'


def _hold(account: Account, held: Held) -> Row:
    end = 'stands' if held.released_us is None else account.period.clock(held.released_us)
    loss = f'<small>{text(WORDS[held.loss].title)}</small>' if held.loss else ''
    answer = f'{held.answer} by {held.who}' if held.answer else UNKNOWN
    why = f'<small>{text(held.reason)}</small>' if held.reason else ''
    return Row(
        (
            account.period.clock(held.raised_us),
            end,
            duration(held.lost_us) if held.lost_us else UNKNOWN,
            f'{text(held.words)}{loss}',
            f'{text(answer)}{why}',
        )
    )


def made(shown: Figures) -> Iterator[str]:
    """Yield the jobs of which anything left the line."""
    if not shown.times.made:
        return
    titles = ('pace', 'good', 'nonconforming', 'rejected', 'by hand', 'outside')
    columns = (Column('job'), Column('script'), *(Column(title, 'n') for title in titles))
    yield from table(columns, _made(shown))


def _made(shown: Figures) -> Iterator[Row]:
    for one in shown.times.made:
        pace = shown.paces.get(one.digest)
        recipe = f'<small>recipe {text(one.recipe)}</small>' if one.recipe else ''
        counts = (one.good, one.nonconforming, one.rejected, one.by_hand, one.outside)
        per_item = UNKNOWN if pace is None else f'{pace.per_item_s:.1f} s'
        yield Row((text(one.job), text(one.script) + recipe, per_item, *map(str, counts)))


def failing(shown: Figures) -> Iterator[str]:
    """Yield the Pareto of the attempts that failed."""
    found = shown.times.failing
    if not found:
        return
    columns = (Column(''), Column('', 'bar'), _NUMBER, Column('took', 'n'))
    yield from table(columns, (_failed(one, found[0].times) for one in found))


def _failed(one: FailingTask, most: int) -> Row:
    about = text(f'{one.task}: {one.reason}')
    name = f'{text(one.component or "nothing sent")}<small>{about}</small>'
    drawn = bar(0, Fraction(one.times, most))
    return Row((name, drawn, str(one.times), duration(one.us)), 'count')


def repairs(shown: Figures) -> Iterator[str]:
    """Yield the components that failed, with the means of their times."""
    if not shown.times.repairs:
        return
    titles = ('failures', 'down', 'MTBF', 'MTTR')
    columns = (Column('component'), *(Column(title, 'n') for title in titles))
    rows = (
        Row(
            (
                text(one.component),
                str(one.failures),
                duration(one.down_us),
                duration(shown.mtbf_us(one)),
                duration(shown.mttr_us(one)),
            )
        )
        for one in shown.times.repairs
    )
    yield from table(columns, rows)
