"""An account as text for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bt_orchestrator.view.report.account.account import Account
from bt_orchestrator.view.report.account.causes.flaws import (
    EFFECTS,
    MEASURED_TITLES,
    flaw_words,
    measured_name,
    measured_texts,
)
from bt_orchestrator.view.report.account.figures import Figures
from bt_orchestrator.view.report.account.fold import Times
from bt_orchestrator.view.report.account.losses import PARTS, WORDS, Loss
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.stops import Held
from bt_orchestrator.view.report.account.words import UNKNOWN, duration, is_seen, percent, rate
from bt_orchestrator.view.report.line_stops import shares
from bt_orchestrator.view.report.tables import table

MOST_ROWS = 10
"""Lines of a Pareto; a page and JSON have all."""


def account_text(account: Account) -> Iterator[str]:
    """Yield the lines of an account; each part is left out where it has nothing to say."""
    period, shown = account.period, account.figures
    cell = f'cell {shown.times.cell}, ' if shown.times.cell else ''
    yield f'{cell}{period.name}, {period.when(period.begin_us)} to {period.when(period.end_us)}'
    yield from (f'  {note}' for note in account.notes())
    yield ''
    yield from _head(shown, period)
    yield from titled('where the time went', _waterfall(shown))
    yield from titled('own fault by length', class_lines(shown))
    yield from titled('made', _made(shown))
    yield from titled('stops, the longest first', stop_lines(shown.times))
    if account.tells_reasons:
        yield from titled(_reasons_title(shown), reason_lines(account))
        yield from titled('stops one by one', line_stop_lines(account))
    yield from titled('holds', hold_lines(shown.times, period))
    yield from titled('scrap and rework by cause', flaw_lines(shown.times))
    yield from titled('measured values beside their bounds', measured_lines(shown.times))
    yield from titled('failed attempts', failing_lines(shown.times))
    yield from titled('components that failed', _repairs(shown))


def titled(title: str, lines: Iterator[str]) -> Iterator[str]:
    """Yield lines under a title; nothing if there are none."""
    first = next(lines, None)
    if first is not None:
        yield ''
        yield f'{title}:'
        yield f'  {first}'
        yield from (f'  {line}' for line in lines)


def _head(shown: Figures, period: Period) -> Iterator[str]:
    parts = (
        f'availability {percent(shown.availability)}',
        f'performance {percent(shown.performance)}',
        f'quality {percent(shown.quality)}',
    )
    yield f'OEE  {percent(shown.oee)} = {" x ".join(parts)}'
    if period.targets:
        wanted = (f'{name} {percent(ratio)}' for name, ratio in period.targets.items())
        yield f'target: {", ".join(wanted)}'
    yield f'made {shown.produced}, {shown.good} of them good{first_pass_words(shown)}'
    if shown.produced:
        yield f'rate {rate(shown.per_item_us)} of production; the pace is {rate(shown.pace_us)}'


def _waterfall(shown: Figures) -> Iterator[str]:
    rows = []
    for bar in shown.steps_seen():
        name = f'- {bar.title}' if bar.loss else bar.title
        rows.append((name, duration(bar.us), percent(shown.of_planned(bar.us))))
        rows += [
            (f'    {title}', duration(us), percent(shown.of_planned(us)))
            for title, us in parts_of(shown, bar.loss)
        ]
    yield from table(('', 'time', 'of planned'), rows)


def parts_of(shown: Figures, loss: Loss | None) -> Iterator[tuple[str, int]]:
    """Yield the parts of a loss that can be seen, by name."""
    for part, words in PARTS.items():
        us = shown.part_us(part)
        if words.loss is loss and us is not None and is_seen(us):
            yield words.title, us


def class_lines(shown: Figures) -> Iterator[str]:
    """Yield the micro-stops and the breakdowns."""
    limit = duration(shown.micro_stop_us)
    rows = [
        (title, str(stop_class.times), duration(stop_class.us))
        for title, stop_class in (
            (f'micro-stops, shorter than {limit}', shown.micro_stops()),
            ('breakdowns', shown.breakdowns()),
        )
        if is_seen(stop_class.us)
    ]
    if rows:
        yield from table(('', 'times', 'time'), rows)


def _made(shown: Figures) -> Iterator[str]:
    rows = []
    for job in shown.times.made:
        pace = shown.paces.get(job.digest)
        per_item = UNKNOWN if pace is None else f'{pace.per_item_s:.1f} s'
        counts = (job.good, job.nonconforming, job.rejected, job.by_hand, job.outside)
        rows.append((job.job, job.script, per_item, *map(str, counts)))
    if rows:
        titles = ('good', 'nonconforming', 'rejected', 'by hand', 'outside planned time')
        yield from table(('job', 'script', 'pace', *titles), rows)


def stop_lines(times: Times) -> Iterator[str]:
    """Yield the stops that cost most."""
    rows = [
        (
            ', '.join(filter(None, (WORDS[stop.loss].title, stop.about))),
            str(stop.times),
            duration(stop.us),
        )
        for stop in times.stops
        if stop.is_shown
    ]
    yield from _pareto(('', 'times', 'time'), rows)


def _reasons_title(shown: Figures) -> str:
    return f'stops by reason, {percent(shown.not_classified)} of their time not classified'


def reason_lines(account: Account) -> Iterator[str]:
    """Yield the reasons of stops, the longest first."""
    shown, period = account.figures, account.period
    reasons = shares(shown.times.by_reason)
    rows = []
    for share in reasons:
        reason = period.reasons.get(share.code)
        code = share.code if reason is not None else ''
        group = reason.group if reason is not None else ''
        words = period.reason_words(share.code)
        numbers = (str(share.times), duration(share.us), percent(shown.of_stops(share.us)))
        rows.append((words, code, group, *numbers))
    yield from _pareto(('', 'code', 'group', 'times', 'time', 'of all'), rows)


def line_stop_lines(account: Account) -> Iterator[str]:
    """Yield the longest stops with their names and their reasons, the longest first."""
    period = account.period
    stops = sorted(account.figures.times.line_stops, key=lambda stop: (-stop.us, stop.span.seq))
    rows = [
        (
            period.clock(stop.span.since_us),
            duration(stop.us),
            stop.about,
            account.stop_name(stop),
            period.reason_words('' if stop.reason is None else stop.reason.code),
        )
        for stop in stops
    ]
    yield from _pareto(('from', 'time', '', 'name', 'reason'), rows)


def hold_lines(times: Times, period: Period) -> Iterator[str]:
    """Yield the holds that cost most, with their answers."""
    for held in times.holds:
        yield f'{_from_to(period, held)}  {held.words}'
        if held.answer:
            reason = f': {held.reason}' if held.reason else ''
            yield f'  {held.answer} by {held.who}{reason}'
    if times.holds_left_out:
        us = sum(times.left_out_us.values())
        yield f'and {times.holds_left_out} others, {duration(us)} together'


def _from_to(period: Period, held: Held) -> str:
    end = period.clock(held.released_us) if held.released_us is not None else 'now'
    begun = period.clock(held.raised_us)
    return f'{begun} to {end}, {duration(held.lost_us)} lost'


def first_pass_words(shown: Figures) -> str:
    """Say how many were good in the first pass; nothing if that is not known."""
    if not shown.produced or shown.first_pass is None:
        return ''
    share = percent(shown.first_pass_yield)
    return f', {shown.first_pass} in the first pass (first-pass yield {share})'


def flaw_lines(times: Times) -> Iterator[str]:
    """Yield the causes of scrap and rework, the most frequent first."""
    products = {flaw.of.product for flaw in times.flaws}
    rows = []
    for flaw in times.flaws:
        named = (EFFECTS[flaw.of.effect], flaw.of.product if len(products) > 1 else '')
        rows.append((': '.join(filter(None, named)), flaw_words(flaw.of), str(flaw.times)))
    yield from _pareto(('', 'cause', 'times'), rows)


def measured_lines(times: Times) -> Iterator[str]:
    """Yield the measured values of each task with a verdict."""
    rows = [
        (measured_name(measurement), *measured_texts(measurement))
        for measurement in times.measured
    ]
    yield from _pareto(('', *MEASURED_TITLES), rows)


def failing_lines(times: Times) -> Iterator[str]:
    """Yield the tasks that failed most often."""
    rows = [
        (
            f'{failure.component or "nothing sent"}: {failure.task}, {failure.reason}',
            str(failure.times),
            duration(failure.us),
        )
        for failure in times.failing
    ]
    yield from _pareto(('', 'times', 'took'), rows)


def _repairs(shown: Figures) -> Iterator[str]:
    rows = []
    for repairs in shown.times.repairs:
        between, repair = shown.mtbf_us(repairs), shown.mttr_us(repairs)
        rows.append(
            (
                repairs.component,
                str(repairs.failures),
                duration(repairs.down_us),
                UNKNOWN if between is None else duration(between),
                duration(repair),
            )
        )
    yield from _pareto(('', 'failures', 'down', 'MTBF', 'MTTR'), rows)


def _pareto(titles: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> Iterator[str]:
    if rows:
        yield from table(titles, rows[:MOST_ROWS])
    if len(rows) > MOST_ROWS:
        yield f'and {len(rows) - MOST_ROWS} more'
