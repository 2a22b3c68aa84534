from __future__ import annotations

import argparse
from dataclasses import fields

import pytest

from bt_orchestrator.cli import run
from bt_orchestrator.ros.node_parameters import BadParameter, NodeParameters, described


def parsed(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    run.add_arguments(parser)
    return parser.parse_args(words)


def test_without_options_a_node_has_the_defaults() -> None:
    args = vars(parsed())
    options = {name: args[name] for name, _ in described() if name not in ('trees', 'recipes')}
    assert NodeParameters(**options) == NodeParameters()


def test_every_parameter_is_an_option() -> None:
    args = parsed(
        *(
            '--cell',
            'c.yaml',
            '--tick-rate-hz',
            '20',
            '--executor',
            'events',
            '--client',
            'plain',
            '--no-auto-start',
        ),
        *('--auto-resume', '--journal', 'j.sqlite3', '--journal-synchronous', 'NORMAL'),
        *(
            '--journal-keep-jobs',
            '7',
            '--journal-timeout',
            '3',
            '--server-timeout',
            '1',
            '--no-expected-end',
        ),
        *('--unauthenticated-role', 'mes', '--trust-local-doors'),
        *('--inspection', 'py_trees_ros', '--trees', 'folder', '--script-paths'),
        *(
            '--control',
            'remote',
            '--users',
            'users.yaml',
            '--reasons',
            'reasons.yaml',
            '--standby',
            '--signed-commands',
            'required',
        ),
    )
    parameters = NodeParameters(**{name: getattr(args, name) for name, _ in described()})
    for field in fields(NodeParameters):
        assert getattr(parameters, field.name) != field.default, field.name


def test_what_is_no_choice_is_refused_in_words() -> None:
    with pytest.raises(BadParameter, match="executor: expected single or events, found 'turbo'"):
        NodeParameters(executor='turbo')
