"""A forecast as text for a person."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.cli.tables import table
from bt_orchestrator.sim.forecast import Forecast, JobForecast, SectionLoad


def forecast_lines(forecast: Forecast) -> Iterator[str]:
    """Yield everything that a run says about the line."""
    yield from job_lines(forecast)
    yield ''
    yield f'total time     {forecast.total_s:.1f} s'
    if forecast.per_item_s is not None:
        yield f'time per item  {forecast.per_item_s:.1f} s in steady state'
    slowest = forecast.bottleneck
    if slowest is not None:
        work = f'{slowest.busy_per_cycle_s:.1f} s of work for an item'
        yield f'bottleneck     section {slowest.section}, {work}'
    yield ''
    yield from table(
        ('section', 'cycles', 'busy', 'per cycle'), [_section(load) for load in forecast.sections]
    )
    yield ''
    yield from table(
        ('component', 'tasks', 'busy', 'utilisation'),
        [
            (load.component, str(load.tasks), f'{load.busy_s:.1f} s', f'{load.utilisation:.1%}')
            for load in forecast.components
        ],
    )


def job_lines(forecast: Forecast) -> Iterator[str]:
    """Yield how each job goes."""
    headers = ('job', 'script', 'items', 'packed', 'rejected', 'missing', 'nonconforming')
    yield from table((*headers, 'per item', 'finished'), [_job(job) for job in forecast.jobs])


def _job(job: JobForecast) -> tuple[str, ...]:
    counts = (job.quantity, job.packed, job.rejected, job.missing, job.nonconforming)
    return (job.job, job.script, *map(str, counts), _seconds(job.per_item_s), _finish(job))


def _finish(job: JobForecast) -> str:
    end = _seconds(job.finished_s)
    return f'aborted {end}' if job.aborted else end


def _section(load: SectionLoad) -> tuple[str, ...]:
    busy = f'{load.busy_s:.1f} s'
    return (str(load.section), str(load.cycles), busy, f'{load.busy_per_cycle_s:.1f} s')


def _seconds(time_s: float | None) -> str:
    return '-' if time_s is None else f'{time_s:.1f} s'
