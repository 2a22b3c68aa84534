"""Numbers and names that a user types, each in the first verb that takes it."""

from __future__ import annotations

import pytest

from bt_orchestrator.cli.main import main


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        ('events --journal j --count -5', 'argument --count: expected'),
        ('events --journal j --count=-5', 'expected a whole number from 0'),
        (f'events --journal j --since-seq {"9" * 23}', 'expected a whole number from 0'),
        (f'events --journal j --count {2**63}', 'expected a whole number from 0'),
        ('events --journal j --count ²', 'expected a whole number from 0'),
        ('status --timeout nan', 'expected seconds, 0 or more'),
        ('status --timeout inf', 'expected seconds, 0 or more'),
        ('status --timeout=-1', 'expected seconds, 0 or more'),
        ('doctor --timeout soon', 'expected seconds, 0 or more'),
        ('demo --speed 0', 'expected a number greater than 0'),
        ('demo --speed nan', 'expected a number greater than 0'),
        ('status --node a/b/', 'expected a name such as /line_1/bt_orchestrator'),
        ('status --node 1', 'expected a name such as /line_1/bt_orchestrator'),
        (f'queue add o.yaml --at {2**32}', 'expected a whole number from 0 to 4294967295'),
        ('queue update WO-1 --quantity=-1', 'expected a whole number from 0'),
    ],
)
def test_what_cannot_be_is_told(
    words: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    assert message in capsys.readouterr().err


def test_a_node_name_with_a_space(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(['status', '--node', 'a b'])
    assert "found 'a b'" in capsys.readouterr().err
