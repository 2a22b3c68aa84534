"""The verb `user`: passwords come from the terminal, or from one line of the standard input."""

from __future__ import annotations

import io
import json
import termios
from collections.abc import Iterator
from pathlib import Path

import pytest
from pseudo_terminal import PseudoTerminal

from bt_orchestrator.cli.main import main
from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.file import UsersFile

PASSWORD = 'correct horse'


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'users.yaml'


def user(path: Path, *words: str, typed: str = '') -> int:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr('sys.stdin', io.StringIO(typed))
        return main(['user', *words, '--users', str(path)])


def test_add_list_role_remove(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert user(path, 'list') == 0
    assert user(path, 'add', 'ann', '--role', 'operate', typed=f'{PASSWORD}\n') == 0
    assert user(path, 'add', 'mes', '--role', 'mes', typed='another one') == 0
    assert user(path, 'role', 'ann', 'engineer') == 0
    assert UsersFile(path).verify('ann', PASSWORD) is Role.ENGINEER
    assert UsersFile(path).verify('mes', 'another one') is Role.MES
    assert user(path, 'list') == 0
    assert capsys.readouterr().out.splitlines() == [
        'there are no users',
        'ann has the role operate',
        'mes has the role mes',
        'ann has the role engineer',
        'ann  engineer',
        'mes  mes',
    ]
    assert user(path, 'remove', 'mes') == 0
    capsys.readouterr()
    assert user(path, 'list', '--json') == 0
    listing = json.loads(capsys.readouterr().out)
    users = [{'name': 'ann', 'role': 'engineer'}]
    assert listing == {'users': users, 'panels': [], 'keys': []}


def test_a_key_is_made_listed_and_removed(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert user(path, 'key', 'ann', '--role', 'operate') == 0
    private = path.parent / 'keys' / 'ann.pem'
    assert private.stat().st_mode & 0o777 == 0o600
    public = UsersFile(path).content().keys['ann'].public
    assert capsys.readouterr().out.splitlines() == [
        f'the key ann has the role operate; whoever has {private} is ann to the node',
        f'its public key is {public}',
    ]
    other = path.parent / 'elsewhere' / 'page.pem'
    given = ('--role', 'engineer', '--door', 'page', '--file', str(other))
    assert user(path, 'key', 'the page', *given) == 0
    assert other.exists()
    assert user(path, 'panel', 'key', 'ann') == 0
    capsys.readouterr()
    assert user(path, 'list') == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[:3] == ['there are no users', 'panels: key ann', f'key ann: operate, {public}']
    assert lines[3].startswith('key the page: engineer, of a page, ')
    assert user(path, 'list', '--json') == 0
    listing = json.loads(capsys.readouterr().out)['keys']
    assert listing[0] == {'name': 'ann', 'role': 'operate', 'door': '', 'public': public}
    assert listing[1]['door'] == 'page'
    assert user(path, 'no-key', 'ann') == 0
    assert list(UsersFile(path).content().keys) == ['the page']
    assert not UsersFile(path).content().panels


def test_a_public_key_of_another_computer_is_added(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    public = 'A' * 43 + '='
    assert user(path, 'key', 'ann', '--role', 'operate', '--public', public) == 0
    assert UsersFile(path).content().keys['ann'].public == public
    assert not (path.parent / 'keys').exists()
    assert user(path, 'key', 'bob', '--role', 'operate', '--public', 'AAAA') == 2
    assert 'a public key has 32 bytes, as base64' in capsys.readouterr().err


def test_a_key_that_is_refused_leaves_no_file(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert user(path, 'key', 'ann') == 2
    assert user(path, 'key', '../ann', '--role', 'view') == 2
    assert 'name one with --file' in capsys.readouterr().err
    assert user(path, 'key', 'ann', '--role', 'view') == 0
    other = path.parent / 'other.pem'
    assert user(path, 'key', 'ann', '--role', 'view', '--file', str(other)) == 1
    assert 'a key of ann is there already' in capsys.readouterr().err
    assert not other.exists()


def test_panels_are_named_listed_and_taken_back(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert user(path, 'add', 'ann', '--role', 'operate', typed=f'{PASSWORD}\n') == 0
    assert user(path, 'panel', 'user', 'ann') == 0
    assert user(path, 'panel', 'address', '192.168.3.20') == 0
    assert user(path, 'list') == 0
    assert user(path, 'no-panel', 'user', 'ann') == 0
    assert user(path, 'no-panel', 'user', 'ann') == 1
    captured = capsys.readouterr()
    assert captured.out.splitlines()[1:] == [
        'the user ann is a panel',
        'the address 192.168.3.20 is a panel',
        'ann  operate',
        'panels: user ann, address 192.168.3.20',
        'the user ann is no panel any more',
    ]
    assert 'the user ann is no panel; there are: address 192.168.3.20' in captured.err
    assert user(path, 'panel', 'ann') == 2
    assert user(path, 'panel', 'room', 'ann') == 2


@pytest.mark.parametrize(
    ('words', 'typed', 'status', 'message'),
    [
        (('add', 'bob', '--role', 'view'), '', 2, 'no password came'),
        (('add', 'bob', '--role', 'view'), 'short\n', 2, '8 to 200 characters; found 5'),
        (('add', 'bob'), PASSWORD, 2, '--role is one of view, mes, operate, engineer'),
        (('add', '--role', 'view'), PASSWORD, 2, 'expected one name, found nothing'),
        (('add', 'ann', '--role', 'view'), PASSWORD, 1, 'ann is there already'),
        (('role', 'ann', 'root'), '', 2, "one of view, mes, operate, engineer; found 'root'"),
        (('role', 'ann'), '', 2, 'expected a name and a role, found ann'),
        (('remove', 'bob'), '', 1, 'there is no user bob; there are: ann'),
    ],
)
def test_what_is_refused_changes_nothing(
    path: Path,
    capsys: pytest.CaptureFixture[str],
    words: tuple[str, ...],
    typed: str,
    status: int,
    message: str,
) -> None:
    assert user(path, 'add', 'ann', '--role', 'operate', typed=PASSWORD) == 0
    before = path.read_bytes()
    assert user(path, *words, typed=typed) == status
    assert message in capsys.readouterr().err
    assert path.read_bytes() == before


def test_a_file_that_others_may_read_is_told(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert user(path, 'add', 'ann', '--role', 'operate', typed=PASSWORD) == 0
    path.chmod(0o644)
    assert user(path, 'list') == 1
    assert 'chmod 600' in capsys.readouterr().err


@pytest.fixture
def terminal(path: Path) -> Iterator[PseudoTerminal]:
    words = ['user', 'add', 'ann', '--role', 'operate', '--users', str(path)]
    terminal = PseudoTerminal(words)
    yield terminal
    terminal.close()


def test_terminal_asks_password_twice_without_echo(path: Path, terminal: PseudoTerminal) -> None:
    terminal.until_shows('password of ann:')
    terminal.press(f'{PASSWORD}\n')
    terminal.until_shows('the same again:')
    terminal.press(f'{PASSWORD}\n')
    assert terminal.wait() == 0
    assert b'correct' not in terminal.raw
    assert termios.tcgetattr(terminal._slave) == terminal.modes
    assert UsersFile(path).verify('ann', PASSWORD) is Role.OPERATE


def test_two_that_differ_are_refused(path: Path, terminal: PseudoTerminal) -> None:
    terminal.until_shows('password of ann:')
    terminal.press(f'{PASSWORD}\n')
    terminal.until_shows('the same again:')
    terminal.press('another one\n')
    assert terminal.wait() == 2
    assert b'the two passwords differ; nothing was changed' in terminal.raw
    assert not path.exists()


def test_end_of_input_restores_terminal(path: Path, terminal: PseudoTerminal) -> None:
    terminal.until_shows('password of ann:')
    terminal.press('\x04')  # Ctrl-D, on an empty line
    assert terminal.wait() == 2
    assert termios.tcgetattr(terminal._slave) == terminal.modes
    assert not path.exists()
