"""scripts/environment: what it installs with, builds again, and shows meanwhile."""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import projects
import pytest
import report
import yaml
from commands import run_logged
from fakes.programs import program
from installer import Installer
from projects import Project, interface_project
from sources import digest, find_sources
from steps import merged

import bt_orchestrator.cli.main

ROOT = Path(__file__).parents[3]
PACKAGE_XML = '<package><name>drill_interfaces</name></package>'


@pytest.fixture
def environment(tmp_path: Path) -> Path:
    """Give a folder like .venv/<distro>, whose Python says what it was asked, in ``asked``."""
    (tmp_path / 'logs').mkdir()
    asked = tmp_path / 'asked'
    program(tmp_path / 'bin' / 'python', f'echo "python $@" >>{asked}')
    return tmp_path


def asked(environment: Path) -> list[str]:
    return (environment / 'asked').read_text().splitlines()


def make_installer(environment: Path) -> Installer:
    return Installer(environment / 'bin' / 'python', environment / 'logs')


def test_silent_step_shows_latest_program_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(report, 'SILENCE_S', 0.01)
    log = tmp_path / 'pip.log'
    shown = ''
    with report.step('1 of 2, packages', lambda: [log]):
        run_logged(log, 'echo', 'Collecting numpy==2.4.6 (from -r kilted.txt (line 4))')
        deadline = time.monotonic() + 20
        while 'Collecting numpy' not in shown and time.monotonic() < deadline:
            shown += capsys.readouterr().err
    assert re.search(r'1 of 2, packages: \d+ s  Collecting numpy==2\.4\.6\n', shown)
    assert capsys.readouterr().err.endswith(' s\n')


def test_nothing_may_be_silent_for_five_seconds() -> None:
    assert report.SILENCE_S < 5


def test_a_failure_shows_the_end_of_its_log(tmp_path: Path) -> None:
    with pytest.raises(report.Failure, match='no such option') as failure:
        run_logged(tmp_path / 'a.log', 'sh', '-c', 'echo no such option; exit 2')
    assert str(tmp_path / 'a.log') in str(failure.value)


def test_uv_installs_where_there_is_one(environment: Path) -> None:
    program(environment / 'bin' / 'uv', f'echo "uv $@ into $VIRTUAL_ENV" >>{environment}/asked')
    make_installer(environment).install_wheels('build', Path('a.whl'))
    [line] = asked(environment)
    assert line.startswith('uv pip install')
    assert '--force-reinstall a.whl --no-deps --no-build-isolation' in line
    assert line.endswith(f'into {environment}')


def test_pip_does_what_uv_cannot(environment: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program(environment / 'bin' / 'uv', 'echo no route to host; exit 1')
    make_installer(environment).install_lists('runtime', Path('runtime.txt'))
    [line] = asked(environment)
    assert line.startswith('python -m pip install')
    assert '-r runtime.txt' in line
    assert 'once more with pip' in capsys.readouterr().err


@pytest.mark.parametrize('setting', ['global.index-url', ':env:.proxy', 'install.no-index'])
def test_configured_pip_installs_instead_of_uv(
    environment: Path, setting: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr('installer.find_spec', lambda name: None)
    says = f'case "$*" in *config*) echo "{setting}=\'x\'";; esac'
    program(environment / 'bin' / 'python', f'echo "python $@" >>{environment}/asked', says)
    pins = environment / 'installers.txt'
    pins.write_text('pip==26.3\nuv==0.13.9\n')
    make_installer(environment).prepare(pins)
    assert asked(environment) == ['python -m ensurepip', 'python -m pip config list']


def test_the_environment_holds_compiled_modules() -> None:
    for module in (bt_orchestrator.cli.main, yaml):
        assert module.__spec__ is not None
        assert Path(str(module.__spec__.cached)).exists()


def test_uv_is_installed_only_as_wheel(environment: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('installer.find_spec', lambda name: None)
    pins = environment / 'installers.txt'
    make_installer(environment).prepare(pins)
    wanted = f'-m pip install --only-binary :all: --require-hashes -r {pins}'
    assert wanted in asked(environment)[-1]


LISTS = sorted((ROOT / 'scripts' / 'requirements').glob('*.txt'))


@pytest.mark.parametrize('path', LISTS, ids=lambda path: path.stem)
def test_every_list_pins_each_package_by_its_hash(path: Path) -> None:
    packages = re.split(r'(?m)^(?=\w)', path.read_text())[1:]
    assert packages
    bare = [text for text in packages if '==' not in text or '--hash=sha256:' not in text]
    assert bare == []


def test_lists_for_another_computer_name_a_package_once() -> None:
    shared = 'numpy==2.5.5 \\\n    --hash=sha256:11\n'
    lists = [f'# made by uv\n{shared}rich==15.0.0 \\\n    --hash=sha256:22\n', f'#\n{shared}']
    assert merged(lists) == [shared, 'rich==15.0.0 \\\n    --hash=sha256:22\n']


WHEEL = """from zipfile import ZipFile
with ZipFile('lost-1.0-py3-none-any.whl', 'w') as wheel:
    wheel.writestr('lost.py', '')
    for name, text in (
        ('METADATA', 'Metadata-Version: 2.1\\nName: lost\\nVersion: 1.0\\n'),
        ('WHEEL', 'Wheel-Version: 1.0\\nTag: py3-none-any\\n'),
        ('RECORD', ''),
    ):
        wheel.writestr(f'lost-1.0.dist-info/{name}', text)
"""


@pytest.mark.parametrize('has_uv', [True, False])
def test_a_file_of_another_hash_is_not_installed(tmp_path: Path, has_uv: bool) -> None:
    subprocess.run([sys.executable, '-c', WHEEL], cwd=tmp_path, check=True)
    (wheel,) = tmp_path.glob('*.whl')
    hashes = {'other': '0' * 64, 'own': hashlib.sha256(wheel.read_bytes()).hexdigest()}
    for name, digits in hashes.items():
        (tmp_path / f'{name}.txt').write_text(f'lost @ {wheel.as_uri()} --hash=sha256:{digits}\n')
    folder = tmp_path / 'environment'
    subprocess.run([sys.executable, '-m', 'venv', '--without-pip', str(folder)], check=True)
    python = folder / 'bin' / 'python'
    if has_uv:
        shutil.copy(Path(sys.prefix, 'bin', 'uv'), python.with_name('uv'))
    (installer := Installer(python, tmp_path))._pip = [
        sys.executable,
        '-m',
        'pip',
        '--python',
        python,
    ]
    with pytest.raises(report.Failure, match=r'(?i)hash'):
        installer.install_lists('packages', tmp_path / 'other.txt')
    installer.install_lists('packages', tmp_path / 'own.txt')
    assert list(folder.glob('lib/python*/site-packages/lost.py'))


def interfaces(folder: Path, environment: Path) -> Project:
    """Describe a package in `folder`, whose build says so in ``asked`` and makes ``d.whl``."""
    builder = environment / 'rosidl_pip'
    builder.mkdir(exist_ok=True)
    (folder / 'action').mkdir(parents=True, exist_ok=True)
    (folder / 'package.xml').write_text(PACKAGE_XML)
    python = program(
        environment / 'bin' / 'python', f'echo built >>{environment}/asked', 'echo $$ >"$4/d.whl"'
    )
    return interface_project(folder, builder, python, 'foundation')


def build(project: Project, environment: Path) -> str:
    wheels = environment / 'wheels'
    shutil.rmtree(wheels, ignore_errors=True)
    wheels.mkdir()
    project.build(environment / 'logs' / 'scratch', wheels)
    return (wheels / 'd.whl').read_text()


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    return tmp_path / 'cache'


def test_interfaces_are_built_once_for_all_clones(environment: Path, cache: Path) -> None:
    first = build(interfaces(environment / 'clone' / 'drill', environment), environment)
    second = build(interfaces(environment / 'other' / 'drill', environment), environment)
    assert first == second
    assert asked(environment) == ['built']


@pytest.mark.parametrize('changed', ['drill/action/Drill.action', 'rosidl_pip/compile.py'])
def test_changed_interfaces_are_built_again(environment: Path, cache: Path, changed: str) -> None:
    build(interfaces(environment / 'drill', environment), environment)
    (environment / changed).write_text('new')
    build(interfaces(environment / 'drill', environment), environment)
    assert asked(environment) == ['built', 'built']


def test_unwritable_home_costs_only_time(environment: Path, cache: Path) -> None:
    cache.write_text('a file where a folder should be')
    assert build(interfaces(environment / 'drill', environment), environment)


def test_the_cache_does_not_grow_for_ever(
    environment: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(projects, 'KEPT_WHEELS', 2)
    project = interfaces(environment / 'drill', environment)
    for number in range(4):
        (environment / 'drill' / 'action' / 'Drill.action').write_text(str(number))
        project = interfaces(environment / 'drill', environment)
        build(project, environment)
    kept = list((cache / 'bt_orchestrator' / 'interfaces').iterdir())
    assert len(kept) == 2
    assert project.stamp in [path.name for path in kept]


def test_own_package_is_remembered_until_folder_is_gone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    known = tmp_path / 'venv' / 'interfaces.txt'
    folder = tmp_path / 'drill'
    folder.mkdir()
    (folder / 'package.xml').write_text(PACKAGE_XML)
    for _ in range(2):
        projects.remember(str(folder), known)
    assert projects.read_list(known) == [folder]
    shutil.rmtree(folder)
    assert projects.read_list(known) == []
    assert 'is no folder any more' in capsys.readouterr().err


def test_a_folder_that_is_no_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(report.Failure, match=r'expected an interface package with package\.xml'):
        projects.remember(str(tmp_path), tmp_path / 'interfaces.txt')
    assert not (tmp_path / 'interfaces.txt').exists()


def test_fingerprint_depends_on_names_and_contents_not_places(tmp_path: Path) -> None:
    prints = []
    for folder, name, text in (('a', 'x', '1'), ('b', 'x', '1'), ('c', 'y', '1'), ('d', 'x', '2')):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / name).write_text(text)
        prints.append(digest(find_sources(tmp_path / folder), tmp_path / folder))
    assert prints[0] == prints[1]
    assert len(set(prints)) == 3
