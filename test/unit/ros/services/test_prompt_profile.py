"""The profile that has Fast DDS drop answers at once is added to whatever the user has."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from bt_orchestrator.ros.fast_dds import OLD_PROFILE, OLD_PROFILES, PROFILE, PROFILES
from bt_orchestrator.ros.services.prompt_profile import SERVICE, prompt_answers

MINE = """<?xml version="1.0"?>
<dds><profiles>
  <participant profile_name="mine"/>
</profiles></dds>
"""


def seen_within(environ: dict[str, str], name: str) -> str:
    """Return the profiles that are named while a participant is made."""
    before = dict(environ)
    with prompt_answers(environ):
        file = Path(environ[name])
        text = file.read_text()
    assert environ == before
    assert not file.exists() or str(file) == before.get(name)
    return text


@pytest.mark.parametrize(
    ('distro', 'name', 'profile', 'period'),
    [
        ('jazzy', OLD_PROFILES, OLD_PROFILE, '<heartbeatPeriod>'),
        ('kilted', PROFILES, PROFILE, '<heartbeat_period>'),
    ],
)
def test_it_stands_beside_what_this_package_says(
    distro: str, name: str, profile: str, period: str
) -> None:
    text = seen_within({'ROS_DISTRO': distro, name: profile}, name)
    assert text.count(SERVICE) == 1
    values = re.findall(rf'{period}\s*<sec>0</sec>\s*<nanosec>(\d+)</nanosec>', text)
    assert len(values) == 2, 'that of other writers, and that of services'
    assert len(set(values)) == 1
    kept = Path(profile).read_text()
    assert text.startswith(kept[: kept.index('</profiles>')])


@pytest.mark.parametrize('name', [PROFILES, OLD_PROFILES])
def test_it_stands_beside_what_the_user_says(name: str, tmp_path: Path) -> None:
    file = tmp_path / 'mine.xml'
    file.write_text(MINE)
    text = seen_within({'ROS_DISTRO': 'kilted', name: str(file)}, name)
    assert 'profile_name="mine"' in text
    assert SERVICE in text


def test_it_stands_alone_where_nothing_is_said() -> None:
    assert SERVICE in seen_within({'ROS_DISTRO': 'jazzy'}, OLD_PROFILES)


@pytest.mark.parametrize('text', [MINE.replace('mine', 'service'), '<dds/>', '', b'\xff\xfe\x00'])
def test_suitable_or_unreadable_profile_file_stays(text: str | bytes, tmp_path: Path) -> None:
    file = tmp_path / 'mine.xml'
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    environ = {'ROS_DISTRO': 'kilted', PROFILES: str(file)}
    with prompt_answers(environ):
        assert environ[PROFILES] == str(file)


def test_a_file_that_is_not_there_stays() -> None:
    environ = {'ROS_DISTRO': 'kilted', PROFILES: os.devnull + '/none'}
    with prompt_answers(environ):
        assert environ[PROFILES] == os.devnull + '/none'
