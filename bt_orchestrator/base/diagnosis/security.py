"""Security of DDS (SROS 2), as the environment asks for it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from bt_orchestrator.base.diagnosis.check import Check, fail, ok, warn

_ENABLE, _KEYSTORE = 'ROS_SECURITY_ENABLE', 'ROS_SECURITY_KEYSTORE'


def security(environment: Mapping[str, str]) -> Check:
    """Look whether security is asked for, and whether there are keys for it.

    rcl itself says nothing where the variable of the keystore is missing.
    """
    if environment.get(_ENABLE, '') != 'true':
        return ok('security', f'off, {_ENABLE} is not true: any participant may command the cell')
    keystore = environment.get(_KEYSTORE, '')
    where = f'{_KEYSTORE}={keystore}' if keystore else f'{_KEYSTORE} is not set'
    if keystore and (Path(keystore) / 'enclaves').is_dir():
        return ok('security', f'{_ENABLE}=true, {where}')
    found = f'{_ENABLE}=true, and {where}: there are no keys'
    remedy = f'make a keystore with `ros2 security`, or unset {_ENABLE}'
    if environment.get('ROS_SECURITY_STRATEGY', '') == 'Enforce':
        return fail('security', found, remedy)
    return warn('security', f'{found}, and so there is no security', remedy)


def secured(environment: Mapping[str, str]) -> str:
    """Say that a middleware without its security libraries may be at fault; empty: it is not."""
    if environment.get(_ENABLE, '') != 'true':
        return ''
    return (
        f'; {_ENABLE} is true: this middleware may be built without security, or its keys do not '
        f'fit; unset {_ENABLE} to go on without'
    )
