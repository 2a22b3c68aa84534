"""Finding a script by its name."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.script.lookup import find_below, find_script, is_path
from bt_orchestrator.script.report import Place


@pytest.fixture
def folders(tmp_path: Path) -> list[Path]:
    folders = [tmp_path / 'own', tmp_path / 'installed']
    for folder in folders:
        folder.mkdir()
        (folder / 'process.yaml').touch()
    (folders[1] / 'inspect.yaml').touch()
    return folders


def refusal(name: str, folders: list[Path]) -> str:
    with pytest.raises(Refused) as caught:
        find_script(name, folders)
    return str(caught.value)


def test_name_is_looked_up_in_folder_order(folders: list[Path]) -> None:
    assert find_script('process', folders) == folders[0] / 'process.yaml'
    assert find_script('process', folders[::-1]) == folders[1] / 'process.yaml'
    assert find_script('inspect', folders) == folders[1] / 'inspect.yaml'


def test_a_path_is_taken_as_it_is(folders: list[Path]) -> None:
    path = str(folders[1] / 'inspect.yaml')
    assert find_script(path, []) == Path(path)


def test_path_below_folders_works_like_a_name(folders: list[Path]) -> None:
    path = folders[1] / 'inspect.yaml'
    for asked in ('inspect', str(path), f'{folders[0]}/../installed/inspect.yaml'):
        script_path = find_below(asked, folders, '--any')
        assert script_path.resolve() == path.resolve()


@pytest.mark.parametrize('path', ['/etc/shadow', '/etc/nothing.yaml', '../x.yaml', 'a/\0b', '/'])
def test_of_a_file_elsewhere_nothing_is_told(folders: list[Path], path: str) -> None:
    with pytest.raises(Refused) as caught:
        find_below(path, folders, '--any')
    (finding,) = caught.value.findings
    assert finding.what.startswith('the path `')
    assert finding.what.endswith(f'` is not in a folder of this node ({folders[0]}, {folders[1]})')
    assert finding.hint == 'put the script there, or start the node with --any'


def test_who_may_give_no_path_is_offered_none(folders: list[Path]) -> None:
    with pytest.raises(Refused, match=r'; check the name$'):
        find_below('x', folders, '--any')


def test_a_link_that_leads_elsewhere_is_elsewhere(folders: list[Path], tmp_path: Path) -> None:
    (tmp_path / 'secret.yaml').touch()
    (folders[0] / 'link.yaml').symlink_to(tmp_path / 'secret.yaml')
    with pytest.raises(Refused):
        find_below(str(folders[0] / 'link.yaml'), folders, '--any')


@pytest.mark.parametrize(
    ('text', 'expected'),
    [('process', False), ('v1.2', False), ('a/b', True), ('a.yaml', True), ('a.yml', True)],
)
def test_what_is_a_path(text: str, expected: bool) -> None:
    assert is_path(text) is expected


def test_an_unknown_name_is_told_with_the_nearest(folders: list[Path]) -> None:
    assert refusal('inspct', folders) == (
        f'inspct:1:1: there is no script `inspct`: looked in {folders[0]}, {folders[1]}; '
        'did you mean `inspect`?'
    )
    assert refusal('x', []) == (
        'x:1:1: there is no script `x`: looked in no folder; check the name, or give a path'
    )


def test_missing_lookup_folder_is_no_mistake(folders: list[Path]) -> None:
    nowhere = folders[0] / 'nowhere'
    assert find_script('inspect', [nowhere, *folders]).name == 'inspect.yaml'
    assert str(nowhere) in refusal('x', [nowhere])


def test_an_unknown_path_is_told_with_its_neighbour(folders: list[Path]) -> None:
    path = folders[1] / 'inspekt.yaml'
    assert refusal(str(path), folders).endswith('; did you mean `inspect.yaml`?')
    assert refusal('no/such.yaml', folders) == (
        'no/such.yaml:1:1: there is no script file `no/such.yaml`; check the path'
    )


@pytest.mark.parametrize('name', ['a\x00b', 'x' * 5000, '', '.', 'a\x00/b.yaml'])
def test_names_that_no_file_can_have(name: str, folders: list[Path]) -> None:
    assert 'there is no script' in refusal(name, folders)


def test_the_finding_may_point_into_an_order(folders: list[Path]) -> None:
    with pytest.raises(Refused, match=r'^order\.yaml:2:9: there is no script `x`'):
        find_script('x', folders, 'order.yaml', Place(2, 9))
