"""An account as plain data, as JSON carries it, and as CSV."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from fractions import Fraction
from typing import IO, Any, NamedTuple

from bt_orchestrator.view.report.account.account import Account
from bt_orchestrator.view.report.account.causes.flaws import flaw_plain, measured_plain
from bt_orchestrator.view.report.account.figures import LACKS, Bar, Figures, Lack, StopClass
from bt_orchestrator.view.report.account.losses import PARTS, Loss
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.account.stops import FailingTask, Held, Repairs, Stop
from bt_orchestrator.view.report.account.words import clock_plain
from bt_orchestrator.view.report.csv_export import csv_cell
from bt_orchestrator.view.report.line_stops import LineStop, ReasonShare, ReasonSum, shares


def account_plain(account: Account) -> dict[str, Any]:
    """Return everything that a report says; times in seconds, null: not known."""
    shown = account.figures
    times = shown.times
    return {
        'cell': times.cell or None,
        'period': _period(account),
        'made_from': _source(account),
        'notes': list(account.notes()),
        **clock_plain(account.period, account.source.steps),
        'oee': _oee(shown),
        'targets': {name: _number(ratio) for name, ratio in account.period.targets.items()},
        'lack': None if shown.lack is None else shown.lack.value,
        'quantities': {
            'produced': shown.produced,
            'good': shown.good,
            'first_pass': shown.first_pass,
        },
        'first_pass_yield': _number(shown.first_pass_yield),
        'rate': {'per_item_s': seconds_of(shown.per_item_us), 'pace_s': seconds_of(shown.pace_us)},
        'waterfall': [_bar(bar) for bar in shown.waterfall()],
        'losses': {bar.loss.value: seconds_of(bar.us) for bar in shown.waterfall() if bar.loss},
        'jobs': [_job(shown, number) for number in range(len(times.made))],
        'loss_parts': {part.value: seconds_of(shown.part_us(part)) for part in PARTS},
        'own_fault_classes': {
            'shorter_than_s': seconds_of(shown.micro_stop_us),
            'micro_stops': _class(shown.micro_stops()),
            'breakdowns': _class(shown.breakdowns()),
        },
        'stops': [stop_plain(stop) for stop in times.stops],
        'reasons': [_reason(account, share) for share in shares(times.by_reason)],
        'stops_by_reason': [_summed_reason(reason) for reason in times.by_reason],
        'not_classified': _number(shown.not_classified),
        'line_stops': [line_stop_plain(account, stop) for stop in times.line_stops],
        'line_stops_all': {
            'count': times.line_stops_count,
            'seconds': seconds_of(times.line_stops_us),
            'shorter_s': seconds_of(times.short_stops_us),
        },
        'holds': [held_plain(held, account.period) for held in times.holds],
        'holds_left_out': {
            'count': times.holds_left_out,
            'seconds': {loss.value: seconds_of(us) for loss, us in times.left_out_us.items()},
        },
        'failed_attempts': [summed(failure) for failure in times.failing],
        'scrap_and_rework': [flaw_plain(flaw) for flaw in times.flaws],
        'measured': [measured_plain(measurement) for measurement in times.measured],
        'components': [_component(shown, repair) for repair in times.repairs],
        'operated_s': {name: seconds_of(us) for name, us in times.operated_us.items()},
    }


def _oee(shown: Figures) -> dict[str, Any]:
    return {
        'availability': _number(shown.availability),
        'performance': _number(shown.performance),
        'quality': _number(shown.quality),
        'oee': _number(shown.oee),
    }


def _bar(bar: Bar) -> dict[str, Any]:
    loss = bar.loss.value if bar.loss else None
    return {'title': bar.title, 'loss': loss, 'seconds': seconds_of(bar.us)}


def _class(stop_class: StopClass) -> dict[str, Any]:
    return {'times': stop_class.times, 'seconds': seconds_of(stop_class.us)}


def stop_plain(stop: Stop) -> dict[str, Any]:
    """Return equal stops of the line."""
    return {**summed(stop), 'loss': stop.loss.value, 'part': stop.part.value or None}


def _component(shown: Figures, repairs: Repairs) -> dict[str, Any]:
    return {
        'component': repairs.component,
        'failures': repairs.failures,
        'down_s': seconds_of(repairs.down_us),
        'repair_s': seconds_of(repairs.repair_us),
        'mtbf_s': seconds_of(shown.mtbf_us(repairs)),
        'mttr_s': seconds_of(shown.mttr_us(repairs)),
    }


def _period(account: Account) -> dict[str, Any]:
    period = account.period
    return {
        'name': period.name,
        'from': period.iso(period.begin_us),
        'to': period.iso(period.end_us),
        'planned_s': seconds_of(period.planned.total_us),
        'planned': [[period.iso(begin), period.iso(end)] for begin, end in period.planned.pieces],
    }


def _source(account: Account) -> dict[str, Any]:
    source, when = account.source, account.period.iso
    span = [when(us) for us in account.books.span]
    return {
        'history': source.extent.history,
        'first_seq': source.first_seq,
        'last_seq': source.last_seq,
        'removed_before_seq': source.extent.first_seq,
        'damaged': source.unreadable,
        'books': {'from': span[0], 'to': span[1]} if span else None,
        'rounded': [when(us) for us in account.books.rounded],
    }


def _job(shown: Figures, number: int) -> dict[str, Any]:
    job = shown.times.made[number]
    pace = shown.paces.get(job.digest)
    return {
        'job': job.job,
        'script': job.script,
        'recipe': job.recipe or None,
        'recipe_version': job.recipe_version,
        'pace_s': None if pace is None else pace.per_item_s,
        'produced': job.produced,
        'good': job.good,
        'nonconforming': job.nonconforming,
        'rejected': job.rejected,
        'by_hand': job.by_hand,
        'outside_planned_time': job.outside,
        'first_pass': shown.of_causes(job.first_pass),
        'further_attempts': shown.of_causes(job.attempts),
        'rework_rounds': shown.of_causes(job.rounds),
    }


def summed(record: Stop | FailingTask) -> dict[str, Any]:
    """Return equal stops, or failures."""
    plain = record._asdict()
    seconds = seconds_of(plain.pop('us'))
    return {**plain, 'seconds': seconds}


def _reason(account: Account, share: ReasonShare) -> dict[str, Any]:
    reason = account.period.reasons.get(share.code)
    return {
        'code': share.code or None,
        'words': dict(reason.words) if reason is not None else None,
        'group': (reason.group or None) if reason is not None else None,
        'times': share.times,
        'seconds': seconds_of(share.us),
        'share': _number(account.figures.of_stops(share.us)),
    }


def _summed_reason(reason: ReasonSum) -> dict[str, Any]:
    named = {**reason._asdict(), 'code': reason.code or None, 'loss': reason.loss.value}
    seconds = seconds_of(named.pop('us'))
    return {**named, 'seconds': seconds}


def line_stop_plain(account: Account, stop: LineStop) -> dict[str, Any]:
    """Return one stop of the line, with its reason."""
    span, reason, when = stop.span, stop.reason, account.period.iso
    is_later = reason is not None and reason.seq > 0
    return {
        'stop': account.stop_name(stop),
        'loss': span.loss.value,
        'detail': span.detail,
        'component': span.component,
        'hold': span.hold or None,
        'part': span.part.value or None,
        'class': _class_of(account, stop),
        'from': when(span.since_us),
        'to': when(span.until_us),
        'seconds': seconds_of(stop.us),
        'code': None if reason is None else reason.code,
        'by': reason.who if reason is not None and is_later else None,
        'why': reason.why if reason is not None and is_later else None,
        'given_seq': reason.seq if reason is not None and is_later else None,
    }


def _class_of(account: Account, stop: LineStop) -> str | None:
    if stop.span.loss is not Loss.OWN_FAULT:
        return None
    return 'micro_stop' if stop.us < account.figures.micro_stop_us else 'breakdown'


def held_plain(held: Held, period: Period) -> dict[str, Any]:
    """Return a hold."""
    when = period.iso
    return {
        'hold': held.hold,
        'loss': held.loss.value if held.loss else None,
        'words': held.words,
        'raised': when(held.raised_us),
        'released': None if held.released_us is None else when(held.released_us),
        'stood_s': seconds_of(held.stood_us),
        'lost_s': seconds_of(held.lost_us),
        'answer': held.answer or None,
        'who': held.who or None,
        'reason': held.reason or None,
    }


def seconds_of(us: Fraction | int | None) -> float | None:
    """Return a time in seconds."""
    return None if us is None else round(float(us) / US, 6)


def _number(ratio: Fraction | None) -> float | None:
    return None if ratio is None else round(float(ratio), 6)


# An account as CSV: one table of numbers, each with the part that it belongs to.


class Row(NamedTuple):
    """One number, or a few that belong together."""

    part: str
    name: str
    component: str = ''
    detail: str = ''
    number: int | None = None
    seconds: float | None = None
    ratio: float | None = None
    code: str = ''
    """Of the reason of a stop."""


def write_csv(account: Account, file: IO[str]) -> None:
    """Write all rows; what is not known is empty."""
    rows = csv.writer(file)
    rows.writerow(Row._fields)
    for row in _rows(account_plain(account)):
        rows.writerow(map(csv_cell, row))


def _rows(plain: dict[str, Any]) -> Iterator[Row]:
    period = plain['period']
    yield Row('period', period['name'], detail=period['from'], seconds=period['planned_s'])
    yield from (Row('oee', name, ratio=ratio) for name, ratio in plain['oee'].items())
    yield from (Row('quantity', name, number=n) for name, n in plain['quantities'].items())
    yield Row('quantity', 'first_pass_yield', ratio=plain['first_pass_yield'])
    yield from (Row('rate', name, seconds=seconds) for name, seconds in plain['rate'].items())
    if plain['lack'] is not None:
        yield Row('note', plain['lack'], detail=LACKS[Lack(plain['lack'])])
    for name in ('clock_set', 'changed_breaks'):
        for record in plain.get(name, ()):
            yield Row('note', name, detail=record['from'], seconds=record['seconds'])
    for bar in plain['waterfall']:
        part = 'loss' if bar['loss'] else 'time'
        name = bar['loss'] or bar['title']
        yield Row(part, name, detail=bar['title'], seconds=bar['seconds'])
    for name, seconds in plain['loss_parts'].items():
        yield Row('part of loss', name, seconds=seconds)
    for name in ('micro_stops', 'breakdowns'):
        stop_class = plain['own_fault_classes'][name]
        yield Row('class', name, number=stop_class['times'], seconds=stop_class['seconds'])
    for job in plain['jobs']:
        yield from (Row('job', job['job'], detail=kind, number=job[kind]) for kind in _COUNTS)
    for record in plain['stops']:
        yield Row(
            'stop',
            record['loss'],
            record['component'],
            record['detail'],
            record['times'],
            record['seconds'],
        )
    for record in plain['reasons']:
        detail = record['group'] or ''
        code, share = record['code'] or 'not_classified', record['share']
        yield Row('reason', code, '', detail, record['times'], record['seconds'], share)
    for record in plain['line_stops']:
        about = record['component'], record['detail']
        yield Row(
            'line stop',
            record['stop'],
            *about,
            seconds=record['seconds'],
            code=record['code'] or '',
        )
    for record in plain['holds']:
        yield Row('hold', record['hold'], detail=record['words'], seconds=record['lost_s'])
    for record in plain['failed_attempts']:
        named = record['task'], record['component'], record['reason']
        yield Row('failed attempt', *named, record['times'], record['seconds'])
    for record in plain['scrap_and_rework']:
        why = ' '.join(
            filter(None, (record['decision'], record['task'], record['reason'], record['bound']))
        )
        yield Row(record['effect'], record['product'], record['component'], why, record['times'])
    for record in plain['measured']:
        what = f'{record["task"]} {record["value"]}'
        for name in ('least', 'mean', 'greatest'):
            yield Row(
                'measured', what, record['component'], name, record['times'], None, record[name]
            )
    for record in plain['components']:
        for name in ('mtbf_s', 'mttr_s'):
            yield Row(
                'component', name[:-2], record['component'], '', record['failures'], record[name]
            )


_COUNTS = ('good', 'nonconforming', 'rejected', 'by_hand', 'outside_planned_time')
