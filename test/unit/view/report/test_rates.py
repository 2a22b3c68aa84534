"""How often tasks ran and failed, by the events of a journal (semantics 8.4)."""

from __future__ import annotations

from fakes.line import Line, with_section

from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.script import Script
from bt_orchestrator.view.report.rates import LEAST, Rate, RatesSeen, rates_of

SECTION = """
  - {id: look, @a2}
  - {id: more, @b2, when: {value: "${results.look.measurement}", at_least: 1}, likely: 0.9}
  - id: weigh
    @b2.TASK_B
    fails_unless: {value: "${results.weigh.measurement}", at_most: 1}
    retries: 5
    likely: 0.9
""".replace('@b2.TASK_B', 'task: TASK_B\n    action: /b2/do')
HOLDS = ' '.join(f'TASK_A#{n}=reads:2' for n in (3, 4, 9))
REFUSED = ' '.join(f'TASK_B#{n}=reads:2' for n in (1, 2, 7, 8, 9))


def seen(quantity: int, *, name: str = 'test') -> tuple[Script, list[Rate]]:
    """Return what a run tells of a script, which may have another name."""
    line = Line(faults={'a2': HOLDS, 'b2': REFUSED})
    run = line.run(with_section(2, SECTION), quantity)
    assert run.ended
    rates = RatesSeen()
    for record in run.records:
        rates.follow(from_record(record))
    script = line.script(with_section(2, SECTION), name)
    return script, list(rates_of(script, rates))


def test_observed_rates_override_those_of_file() -> None:
    _, rates = seen(30)
    assert rates == [Rate('more', 'runs', 3 / 30, 30), Rate('weigh', 'fails', 5 / 35, 35)]
    assert list(map(str, rates)) == [
        'more runs for 10 % of 30 items',
        'weigh fails 14.3 % of 35 attempts',
    ]


def test_too_few_observations_keep_rates_of_file() -> None:
    _, rates = seen(LEAST - 1)
    assert rates == [Rate('more', 'runs', 0.9), Rate('weigh', 'fails', 5 / 24, 24)]
    assert str(rates[0]) == 'more runs for 90 % of items'


def test_another_script_is_not_asked_for_its_rates() -> None:
    _, rates = seen(30, name='other')
    assert rates == [Rate('more', 'runs', 0.9), Rate('weigh', 'fails', 0.9)]


def test_a_rejected_item_says_nothing_of_a_condition() -> None:
    line = Line(faults={'a2': 'TASK_B#*=abort'})
    section = """
      - {id: look, @a2}
      - {id: drop, @a2.TASK_B, on_failure: reject}
      - {id: more, @b2, when: "${results.look.item_present}"}
    """
    text = with_section(2, section).replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    rates = RatesSeen()
    for record in line.run(text, LEAST).records:
        rates.follow(from_record(record))
    assert list(rates_of(line.script(text), rates)) == [Rate('drop', 'fails', 1.0, LEAST)]
