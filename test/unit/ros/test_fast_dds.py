"""ros/fast_dds.py: no shared memory, unless the user has said what Fast DDS is to use."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from bt_orchestrator.cli.main import main
from bt_orchestrator.ros.fast_dds import OLD_PROFILE, PROFILE, keep_off_shared_memory

OWN = ('FASTDDS_BUILTIN_TRANSPORTS', 'FASTDDS_DEFAULT_PROFILES_FILE')
OLD = 'FASTRTPS_DEFAULT_PROFILES_FILE'


@pytest.mark.parametrize(
    ('distro', 'name', 'profile'),
    [
        ('jazzy', OLD, OLD_PROFILE),
        ('humble', OLD, OLD_PROFILE),
        ('kilted', OWN[1], PROFILE),
        ('lyrical', OWN[1], PROFILE),
        ('', OWN[1], PROFILE),
    ],
)
def test_fast_dds_gets_the_profile_that_it_reads(distro: str, name: str, profile: str) -> None:
    environ = {'ROS_DISTRO': distro}
    keep_off_shared_memory(environ)
    assert environ == {'ROS_DISTRO': distro, 'FASTDDS_BUILTIN_TRANSPORTS': 'UDPv4', name: profile}
    assert Path(profile).is_file()


@pytest.mark.parametrize('name', [*OWN, OLD])
def test_what_the_user_has_set_stays_alone(name: str) -> None:
    environ = {name: 'mine'}
    keep_off_shared_memory(environ)
    assert environ == {name: 'mine'}


@pytest.mark.parametrize('name', ['DEFAULT_FASTDDS_PROFILES.xml', 'DEFAULT_FASTRTPS_PROFILES.xml'])
def test_a_profile_in_this_folder_is_the_users(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).touch()
    environ: dict[str, str] = {}
    keep_off_shared_memory(environ)
    assert environ == {}


def test_every_verb_keeps_off_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in (*OWN, OLD):
        monkeypatch.setenv(name, '')
    with pytest.raises(SystemExit):
        main(['--help'])
    assert os.environ[OWN[0]] == 'UDPv4'
