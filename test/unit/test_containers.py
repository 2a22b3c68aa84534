"""The compose file: its command lines are the program's, and its image is of this version."""

from __future__ import annotations

import re
from importlib.metadata import version

import yaml
from fakes.shipped import ROOT

from bt_orchestrator.cli.verbs import command_of

FOLDER = ROOT / 'config' / 'container'
COMPOSE = yaml.safe_load((FOLDER / 'compose.yaml').read_text(encoding='utf-8'))
OWN = {
    name: service
    for name, service in COMPOSE['services'].items()
    if service['image'].startswith('bt_orchestrator:')
}


def test_their_command_lines_are_read_by_the_program() -> None:
    assert set(OWN) == {'node', 'page', 'opcua', 'feed'}
    for service in OWN.values():
        command = command_of(service['command'])
        command.parser().parse_args(command.rest)


def test_the_image_has_the_version_of_the_package() -> None:
    text = (FOLDER / 'Containerfile').read_text(encoding='utf-8')
    named = [*re.findall(r'bt_orchestrator:(\S+)', text)]
    named += [service['image'].partition(':')[2] for service in OWN.values()]
    assert set(named) == {version('bt_orchestrator')}


def test_every_program_runs_without_rights_on_its_computer() -> None:
    for service in OWN.values():
        assert (service['cap_drop'], service['read_only']) == (['ALL'], True)
        assert service['security_opt'] == ['no-new-privileges:true']
    assert re.search(r'^USER [1-9]\d*:', (FOLDER / 'Containerfile').read_text(), re.MULTILINE)
