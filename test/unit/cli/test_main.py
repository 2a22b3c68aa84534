"""The program: finding the verb, and telling how it ended."""

from __future__ import annotations

import argparse
import importlib.util
import io
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from bt_orchestrator.base.errors import Finding, OrchestratorError, Refused
from bt_orchestrator.cli import main as program
from bt_orchestrator.cli import verbs as verbs_of_program
from bt_orchestrator.cli.main import main, parsed, without_ros_arguments
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.verbs import VERBS, actions_of, help_line, module_name

Use = Callable[[Callable[[argparse.Namespace], int]], None]


class FakeVerb(ModuleType):
    """A module of a verb with one option."""

    def __init__(self, run: Callable[[argparse.Namespace], int]) -> None:
        super().__init__('bt_orchestrator.cli.fake')
        self.run = run

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        parser.add_argument('--speed', type=float, default=1.0)


@pytest.fixture
def use(monkeypatch: pytest.MonkeyPatch) -> Use:
    """Give a function that makes `check` and `run` verbs that do what it is told."""

    def use(run: Callable[[argparse.Namespace], int]) -> None:
        verbs = {'check': ('fake', 'fake'), 'run': ('fake', 'fake')}
        for module in (program, verbs_of_program):
            monkeypatch.setattr(module, 'VERBS', verbs)
        monkeypatch.setattr(program, 'GROUPS', {'test': verbs})
        monkeypatch.setitem(sys.modules, 'bt_orchestrator.cli.fake', FakeVerb(run))

    return use


def raising(error: BaseException) -> Callable[[argparse.Namespace], int]:
    def run(args: argparse.Namespace) -> int:
        raise error

    return run


@pytest.mark.parametrize('verb', VERBS)
def test_every_verb_has_its_file(verb: str) -> None:
    assert importlib.util.find_spec(module_name(verb)) is not None


def test_verb_gets_options_and_returns_exit_status(use: Use) -> None:
    seen = []

    def run(args: argparse.Namespace) -> int:
        seen.append(args.speed)
        return 7

    use(run)

    assert main(['check', '--speed', '2']) == 7
    assert seen == [2.0]


@pytest.mark.parametrize(
    'words',
    [['chekc'], ['check', '--sped', '1'], ['check', '--spee', '1'], ['--cell', 'check']],
)
def test_wrong_use(use: Use, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    use(lambda args: 0)
    with pytest.raises(SystemExit) as ended:
        main(words)

    assert ended.value.code == 2
    assert capsys.readouterr().err.startswith('usage: bt-orchestrator')


def test_only_node_verbs_accept_ros_arguments(use: Use) -> None:
    seen = []

    def run(args: argparse.Namespace) -> int:
        seen.append(args.ros_args)
        return 0

    use(run)
    words = ['run', '--ros-args', '-p', 'x:=1', '--', '--speed', '2']

    assert main(words) == 0
    assert seen == [words]
    with pytest.raises(SystemExit):
        main(['check', '--ros-args', '-p', 'x:=1'])


@pytest.mark.parametrize(
    ('words', 'own'),
    [
        ('run --cell c', 'run --cell c'),
        ('run --ros-args -p x:=1', 'run'),
        ('run --ros-args -p x:=1 -- --cell c --ros-args -r a:=b', 'run --cell c'),
        ('run -- --cell', 'run -- --cell'),
    ],
)
def test_ros_arguments_end_at_two_dashes(words: str, own: str) -> None:
    assert without_ros_arguments(words.split()) == own.split()


def test_every_finding_is_a_line(use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    use(raising(Refused([Finding('a', 1, 2, 'x', 'y'), Finding('b', 3, 4, 'z')])))

    assert main(['check']) == 1
    assert capsys.readouterr().err == 'a:1:2: x; y\nb:3:4: z\n'


@pytest.mark.parametrize(
    ('error', 'status'),
    [
        (OrchestratorError('no node answers'), 1),
        (WrongUse('no node answers'), 2),
    ],
)
def test_other_errors_are_told_by_the_verb(
    use: Use, error: OrchestratorError, status: int, capsys: pytest.CaptureFixture[str]
) -> None:
    use(raising(error))

    assert main(['check']) == status
    assert capsys.readouterr().err == 'bt-orchestrator check: error: no node answers\n'


def test_closed_input_output_and_errors_are_no_fault() -> None:
    """As `history >&-` in a shell, or a service that a supervisor starts with nothing open."""
    program = (
        'import os, sys; sys.argv[1:] = ["completion", "bash"]; '
        'from bt_orchestrator.cli.main import main; status = main(); '
        'seen = [os.readlink(f"/proc/self/fd/{n}") for n in range(3)]; '
        'assert seen == ["/dev/null"] * 3, seen; import py_trees; os._exit(status)'
    )
    shell = f"exec {sys.executable} -c '{program}' <&- >&- 2>&-"
    assert subprocess.run(['/bin/sh', '-c', shell], check=False).returncode == 0


def test_an_argument_that_is_no_text_is_refused(
    use: Use, capsys: pytest.CaptureFixture[str]
) -> None:
    """Neither ROS 2 nor a journal can carry it: rclpy fails at the command line alone."""
    use(raising(AssertionError()))
    assert main(['check', '--speed', os.fsdecode(b'1\xff')]) == 2
    errors = capsys.readouterr().err
    assert errors.startswith(r"bt-orchestrator: error: the argument '1\udcff' is not UTF-8, ")
    assert errors.count('\n') == 1


def test_a_missing_package_is_named(use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    use(raising(ModuleNotFoundError("No module named 'rclpy'", name='rclpy')))

    assert main(['check']) == 1
    assert 'the Python package rclpy is not installed' in capsys.readouterr().err


def test_missing_own_module_is_a_defect(use: Use) -> None:
    use(raising(ModuleNotFoundError('gone', name='bt_orchestrator.cli.gone')))

    with pytest.raises(ModuleNotFoundError):
        main(['check'])


def test_an_interrupted_verb_ends_as_shells_expect(use: Use) -> None:
    use(raising(KeyboardInterrupt()))

    assert main(['check']) == 130


def test_the_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(['--version'])

    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith('bt-orchestrator ')


def test_the_help_names_every_verb(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(['--help'])
    words = {line.split()[0] for line in capsys.readouterr().out.splitlines() if line.split()}

    assert set(VERBS) <= words


@pytest.mark.parametrize(
    'words', [['add', '--held', 'a.yaml', 'b.yaml'], ['add', 'a.yaml', '--held', 'b.yaml']]
)
def test_options_may_stand_between_what_is_named(words: list[str]) -> None:
    args = parsed(['queue', *words])
    assert (args.verb, args.orders) == ('queue add', [Path('a.yaml'), Path('b.yaml')])
    assert args.held


@pytest.mark.parametrize(
    ('line', 'shown'),
    [
        ('bt-orchestrator re', f'render|{help_line("render")}'),
        ('bt-orchestrator job re', f'release|{actions_of("job")["release"].effect}'),
        ('bt-orchestrator cell clear --as', '--as-shown '),
        ('bt-orchestrator remove-item --rea', '--reason '),
    ],
)
def test_a_shell_shows_what_each_verb_does(line: str, shown: str, tmp_path: Path) -> None:
    asked = {
        '_ARGCOMPLETE': '1',
        '_ARGCOMPLETE_SHELL': 'fish',
        '_ARGCOMPLETE_DFS': '|',
        'COMP_LINE': line,
        'COMP_POINT': str(len(line)),
    }
    done = subprocess.run(
        ['bash', '-c', f'{sys.executable} -m bt_orchestrator 8>&1 9>/dev/null'],
        cwd=tmp_path,
        env={**os.environ, **asked},
        capture_output=True,
        text=True,
        check=True,
    )
    assert shown in done.stdout


def test_without_a_verb_all_of_them_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([])
    assert ended.value.code == 2
    listed = capsys.readouterr().out
    assert [verb for verb in VERBS if f'\n  {verb} ' not in listed] == []


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (['statsu'], "found 'statsu'; did you mean status?"),
        (['status', '--jsn'], 'unrecognized arguments: --jsn; did you mean --json?'),
        (['answer', '1', 'rety', '--reason', 'w'], "found 'rety'; did you mean retry?"),
        (['qqqqqq'], "found 'qqqqqq'\n"),
    ],
)
def test_what_was_probably_meant(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(words)
    assert message in capsys.readouterr().err


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_terminal_shows_fifty_mistakes(use: Use, monkeypatch: pytest.MonkeyPatch) -> None:
    many = [Finding('a.yaml', line, 1, 'wrong', 'mend it') for line in range(1, 124)]
    use(raising(Refused(many)))
    shown: dict[str, list[str]] = {}
    for name, stream in (('terminal', _Terminal()), ('pipe', io.StringIO())):
        monkeypatch.setattr(sys, 'stderr', stream)
        assert main(['check']) == 1
        shown[name] = stream.getvalue().splitlines()
    assert shown['pipe'] == [str(finding) for finding in many]
    *first, last = shown['terminal']
    assert first == shown['pipe'][:50]
    assert last == '... and 73 more mistakes; check --json has all of them'


def test_one_mistake_is_counted_as_one() -> None:
    finding = Finding('a.yaml', 1, 1, 'wrong', 'mend it')
    assert Refused([finding]).count == 'refused with 1 finding'
    assert Refused([finding, finding]).count == 'refused with 2 findings'


class RCLError(RuntimeError):
    """As rclpy has it."""


RCLError.__module__ = 'rclpy._rclpy_pybind11'


@pytest.mark.parametrize(
    ('domain', 'message'),
    [
        ('abc', "ROS_DOMAIN_ID: 'abc' is not a domain; set a whole number from 0 to 232; "),
        ('7', 'ROS 2 says: no memory; '),
    ],
)
def test_ros_that_cannot_be_used(
    use: Use,
    domain: str,
    message: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', domain)
    use(raising(RCLError('no memory, at /src/rcl/init.c:49\nmore')))
    assert main(['check']) == 1
    said_all = capsys.readouterr().err
    assert said_all.startswith(f'bt-orchestrator check: error: {message}')
    assert said_all.endswith('bt-orchestrator doctor looks at all of it\n')


def test_a_defect_is_not_hidden(use: Use) -> None:
    use(raising(RuntimeError('a defect')))
    with pytest.raises(RuntimeError, match='a defect'):
        main(['check'])
