"""scripts/test: budgets of the gates, what is run again, and what .ci/bare takes off PATH."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from fakes.programs import program
from patience import PATIENCE_S, until

ROOT = Path(__file__).parents[3]


def run(command: list[str], cwd: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    own = {name: text for name, text in os.environ.items() if name != 'CI'}
    return subprocess.run(
        command, cwd=cwd, env={**own, **variables}, capture_output=True, text=True, check=False
    )


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """Give a clone whose tools do nothing, and whose lint may take no time."""
    text = (ROOT / 'scripts' / 'test').read_text()
    for there, here in (('[lint]=20', '[lint]=0'), ('shm=/dev/shm', f'shm={tmp_path}/memory')):
        assert there in text
        text = text.replace(there, here)
    (tmp_path / 'memory').mkdir()
    (tmp_path / 'scripts').mkdir()
    (tmp_path / 'scripts' / 'test').write_text(text)
    program(tmp_path / 'scripts' / 'bootstrap')
    for tool in ('pytest', 'lint-imports'):
        program(tmp_path / '.venv' / 'jazzy' / 'bin' / tool)
    program(tmp_path / '.venv' / 'jazzy' / 'bin' / 'ruff', 'sleep 1.1')
    (tmp_path / '.venv' / 'jazzy' / 'bin' / 'python').symlink_to(sys.executable)
    return tmp_path


def gates(clone: Path, *words: str, **variables: str) -> subprocess.CompletedProcess[str]:
    return run(['bash', 'scripts/test', *words], clone, **variables)


def test_slow_gate_is_named_but_does_not_fail(clone: Path) -> None:
    done = gates(clone, '--only', 'format,lint', CI='true')
    assert done.returncode == 0
    assert 'lint         passed, over twice its budget ' in done.stdout
    assert 'format       passed  ' in done.stdout


def test_types_are_left_out_without_the_annotated_rclpy(clone: Path) -> None:
    done = gates(clone, '--only', 'types')
    assert (done.returncode, 'types        left out' in done.stdout) == (0, True)
    assert gates(clone, '--only', 'types', CI='true').returncode == 1


@pytest.mark.parametrize('status', [0, 1])
def test_types_are_checked_alongside_following_gates(clone: Path, status: int) -> None:
    mypy = clone / '.venv' / 'kilted' / 'bin' / 'mypy'
    waits = 'for _ in $(seq 1500); do [ -e imported ] && break; sleep 0.02; done'
    program(mypy, waits, '[ -e imported ] || exit 3', f'echo looked; exit {status}')
    program(clone / '.venv' / 'jazzy' / 'bin' / 'lint-imports', 'echo contracts; touch imported')
    done = gates(clone, '--only', 'types,imports')
    assert done.returncode == status, done.stdout + done.stderr
    assert done.stdout.index('contracts') < done.stdout.index('looked')
    assert f'types        {"FAILED" if status else "passed"} ' in done.stdout


def test_a_stop_ends_the_types_too(clone: Path) -> None:
    """As Ctrl-C does, which a terminal sends to the whole foreground."""
    mypy = clone / '.venv' / 'kilted' / 'bin' / 'mypy'
    program(mypy, 'echo $$ >pid', 'while true; do sleep 0.02; done')
    program(clone / '.venv' / 'jazzy' / 'bin' / 'lint-imports', 'while true; do sleep 0.02; done')
    running = subprocess.Popen(
        ['bash', 'scripts/test', '--only', 'types,imports'],
        cwd=clone,
        stdout=subprocess.DEVNULL,
        start_new_session=True,
    )
    until(
        lambda: (clone / 'pid').exists() and (clone / 'pid').read_text().endswith('\n'), 'its pid'
    )
    os.killpg(running.pid, signal.SIGTERM)
    running.wait(PATIENCE_S)
    mypy_of = Path('/proc', (clone / 'pid').read_text().strip())
    until(lambda: not mypy_of.exists() or ') Z ' in (mypy_of / 'stat').read_text(), 'its end')


@pytest.mark.parametrize(('number', 'status'), [(2, 0), (3, 1)])
def test_repeats_are_named_and_limited_to_two(clone: Path, number: int, status: int) -> None:
    names = ', '.join(f'"test_a.py::test_{index}": true' for index in range(number))
    program(
        clone / '.venv' / 'jazzy' / 'bin' / 'pytest',
        'for word; do case $word in cache_dir=*) cache=${word#*=}/v/cache;; esac; done',
        'case "$*" in *--last-failed*) exit 0;; esac',
        f"mkdir -p $cache; echo '{{{names}}}' >$cache/lastfailed; exit 1",
    )
    done = gates(clone, '--only', 'system')
    assert done.returncode == status
    assert 'passed on repeat:\ntest_a.py::test_0\ntest_a.py::test_1\n' in done.stdout


@pytest.mark.parametrize('status', [0, 1])
@pytest.mark.parametrize('written', ['', 'touch "$TMPDIR/kept"'])
def test_only_failed_run_keeps_its_files_in_memory(clone: Path, status: int, written: str) -> None:
    program(clone / 'bin' / 'df', 'echo Avail; echo 4000001')
    pytest_ = clone / '.venv' / 'jazzy' / 'bin' / 'pytest'
    program(pytest_, 'echo "$TMPDIR" >where', written or 'true', f'exit {status}')
    words = ['env', '-u', 'TMPDIR', 'bash', 'scripts/test', '--only', 'unit']
    done = run(words, clone, PATH=f'{clone / "bin"}:{os.environ["PATH"]}')
    where = Path((clone / 'where').read_text().strip())
    assert where.parent == clone / 'memory'
    assert (done.returncode, where.exists()) == (status, bool(status and written))
    assert (f'rm -r {where}' in done.stdout) == where.exists()


def test_what_fails_twice_has_failed(clone: Path) -> None:
    program(
        clone / '.venv' / 'jazzy' / 'bin' / 'pytest',
        'for word; do case $word in cache_dir=*) cache=${word#*=}/v/cache;; esac; done',
        'mkdir -p $cache; echo \'{"test_a.py::test_0": true}\' >$cache/lastfailed; exit 1',
    )
    done = gates(clone, '--only', 'system')
    assert (done.returncode, 'programs     FAILED' in done.stdout) == (1, True)


@pytest.mark.parametrize(
    ('gate', 'option'), [('unit', '--parquet'), ('page', '--browser'), ('opcua', '--node')]
)
def test_a_gate_has_brought_what_it_alone_needs(clone: Path, gate: str, option: str) -> None:
    bootstrap = clone / 'scripts' / 'bootstrap'
    program(bootstrap, f'case "$*" in *{option}*) echo none came; exit 1;; esac')
    done = gates(clone, '--only', f'system,{gate}')
    assert done.returncode == 1
    assert 'programs     passed' in done.stdout
    assert 'none came' in done.stdout
    assert f'{gate:12} FAILED' in done.stdout


def test_the_gates_of_programs_run_together(clone: Path) -> None:
    pytest_ = clone / '.venv' / 'jazzy' / 'bin' / 'pytest'
    program(pytest_, 'echo "$TEST_PROCESSES_AT_ONCE: $*" >>asked')
    done = gates(clone, '--only', 'integration,unit,opcua')
    assert done.returncode == 0, done.stdout + done.stderr
    lines = (clone / 'asked').read_text().splitlines()
    unit, programs, extensions = sorted(lines, key=lambda line: line.split()[-1])
    assert re.fullmatch(r': .* test/unit/extensions', extensions)
    assert re.fullmatch(r': .* test/unit --ignore=test/unit/extensions', unit)
    assert re.fullmatch(r'\d+: .* test/integration test/opcua', programs)


def test_unit_tests_alone_are_all_of_them(clone: Path) -> None:
    program(clone / '.venv' / 'jazzy' / 'bin' / 'pytest', 'echo "$*" >>asked')
    assert gates(clone, '--only', 'unit').returncode == 0
    assert re.fullmatch(r'.* test/unit\n', (clone / 'asked').read_text())


@pytest.mark.parametrize('status', [0, 1])
def test_unit_tests_run_beside_the_programs(clone: Path, status: int) -> None:
    waits = 'for _ in $(seq 1500); do [ -e begun ] && break; sleep 0.02; done; [ -e begun ]'
    unit = f'*ignore*) {waits} && chrt --pid $$ && exit {status};;'
    program(
        clone / '.venv' / 'jazzy' / 'bin' / 'pytest',
        f'case "$*" in {unit} *system) touch begun; echo programs ran; esac',
    )
    done = gates(clone, '--only', 'unit,system')
    assert done.returncode == status, done.stdout + done.stderr
    assert done.stdout.index('programs ran') < done.stdout.index('SCHED_IDLE')
    assert f'unit         {"FAILED" if status else "passed"} ' in done.stdout


def test_ci_path_hides_manually_installed_programs(tmp_path: Path) -> None:
    for name in ('node', 'chromium', 'psql', 'redis-server', 'c++'):
        program(tmp_path / 'bin' / name, f'echo {name}')
    path = f'{tmp_path / "bin"}:{os.environ["PATH"]}'
    for name in ('node', 'chromium', 'psql', 'redis-server'):
        looked = run(['bash', str(ROOT / '.ci' / 'bare'), 'which', name], tmp_path, PATH=path)
        assert looked.stdout == ''
    assert run(['bash', str(ROOT / '.ci' / 'bare'), 'c++'], tmp_path, PATH=path).stdout == 'c++\n'


def test_ci_programs_are_available_to_every_user(tmp_path: Path) -> None:
    """`apt-get` runs its checks as a user of its own."""
    mode = ['bash', '-c', 'stat -c %A "$PATH"']
    result = run(['bash', str(ROOT / '.ci' / 'bare'), *mode], tmp_path, PATH=os.environ['PATH'])
    assert result.stdout == 'drwxr-xr-x\n'


def test_bootstrap_tools_are_on_the_short_path(tmp_path: Path) -> None:
    for name in ('bash', 'mktemp', 'chmod', 'ln', 'rm', 'ls'):
        (tmp_path / name).symlink_to(str(shutil.which(name)))
    names = ['bash', '-c', 'ls "$PATH"']
    result = run(['bash', str(ROOT / '.ci' / 'bare'), *names], tmp_path, PATH=str(tmp_path))
    assert {'dot', 'python3', 'c++'} <= set(result.stdout.split())


@pytest.mark.parametrize(
    ('reason', 'ci', 'status'),
    [('no clock here', 'true', 1), ('no clock here', '', 0), ('needs root, for x', 'true', 0)],
)
def test_unlisted_skip_in_ci_is_a_failure(
    tmp_path: Path, reason: str, ci: str, status: int
) -> None:
    (tmp_path / 'test_a.py').write_text(
        f'import pytest\n@pytest.mark.skip(reason={reason!r})\ndef test_a(): pass\n'
        'def test_b(): pass\n'
    )
    command = [sys.executable, '-m', 'pytest', '-q', '-p', 'skips', '--rootdir', '.', 'test_a.py']
    done = run(command, tmp_path, CI=ci, PYTHONPATH=str(ROOT / 'test'))
    assert done.returncode == status, done.stdout + done.stderr
    assert ('test_a.py::test_a: ' in done.stdout) == bool(status)


@pytest.mark.parametrize(('begun_s', 'rounds'), [(115, ['3']), (121, [])])
def test_shard_stops_drawing_lines_at_its_time_limit(
    tmp_path: Path, begun_s: int, rounds: list[str]
) -> None:
    program(tmp_path / 'bin' / 'git', 'echo 000003')
    asked = f'echo "$*" | sed "s/.*seed=\\([0-9]*\\).*/\\1/" >>{tmp_path}/asked'
    program(tmp_path / '.venv' / 'jazzy' / 'bin' / 'pytest', asked, 'sleep 5.1')
    path = f'{tmp_path / "bin"}:{os.environ["PATH"]}'
    shard = ['bash', str(ROOT / '.ci' / 'shard'), '120']
    done = run(shard, tmp_path, PATH=path, SECONDS=str(begun_s))
    assert done.returncode == 0, done.stdout + done.stderr
    there = tmp_path / 'asked'
    assert (there.read_text().split() if there.exists() else []) == rounds


def test_shard_failure_fails_ci(tmp_path: Path) -> None:
    program(tmp_path / 'bin' / 'git', 'echo 000000')
    program(tmp_path / '.venv' / 'jazzy' / 'bin' / 'pytest', 'exit 1')
    path = f'{tmp_path / "bin"}:{os.environ["PATH"]}'
    assert run(['bash', str(ROOT / '.ci' / 'shard'), '120'], tmp_path, PATH=path).returncode == 1
