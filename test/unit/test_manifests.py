"""package.xml: one version everywhere, and keys that the index of rosdep has."""

from __future__ import annotations

import configparser
import re
from importlib.metadata import version
from xml.etree import ElementTree

import pytest
import yaml
from fakes.shipped import ROOT

MANIFESTS = ('package.xml', 'interfaces/bt_orchestrator_interfaces/package.xml')
OWN = {'bt_orchestrator_interfaces'}
KNOWN = yaml.safe_load((ROOT / 'test' / 'data' / 'rosdep_keys.yaml').read_text(encoding='utf-8'))


def manifest(name: str) -> ElementTree.Element:
    return ElementTree.parse(ROOT / name).getroot()


def test_manifest_versions_match_package_without_candidate_suffix() -> None:
    setup = re.findall(r"version='(\d+\.\d+\.\d+)',", (ROOT / 'setup.py').read_text())
    config = configparser.ConfigParser()
    config.read(ROOT / 'setup.cfg')
    assert [manifest(name).findtext('version') for name in MANIFESTS] == [*setup, *setup]
    assert version('bt_orchestrator') == setup[0] + config['egg_info']['tag_build']


@pytest.mark.parametrize('name', MANIFESTS)
def test_the_index_of_rosdep_has_every_key(name: str) -> None:
    keys = {node.text for node in manifest(name) if node.tag.endswith('depend')} - OWN
    assert len(keys) > 4
    assert keys - {*KNOWN['of_ros'], *KNOWN['of_the_system']} == set(), (
        'not in the kept list: see whether the index has it, then add it to '
        f'test/data/rosdep_keys.yaml (last compared {KNOWN["compared"]})'
    )


def test_kept_list_has_no_unused_keys() -> None:
    named = {node.text for name in MANIFESTS for node in manifest(name)}
    assert {*KNOWN['of_ros'], *KNOWN['of_the_system']} - named == set()
