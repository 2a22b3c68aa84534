"""What an interface package contains."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

KINDS = ('msg', 'srv', 'action')


@dataclass(frozen=True)
class InterfacePackage:
    """One package; `files` are relative to `root`, for example ``msg/Status.msg``."""

    root: Path
    name: str
    version: str
    description: str
    licence: str
    files: tuple[Path, ...]


def read_package(root: Path) -> InterfacePackage:
    """Read package.xml and find every definition, as ``CMakeLists.txt`` does with a glob."""
    xml = ElementTree.parse(root / 'package.xml').getroot()
    files = tuple(
        path.relative_to(root) for kind in KINDS for path in sorted(root.glob(f'{kind}/*.{kind}'))
    )
    if not files:
        raise SystemExit(f'{root}: expected definitions in msg/, srv/ or action/, found none')
    return InterfacePackage(
        root=root,
        name=_text(xml, 'name'),
        version=_text(xml, 'version'),
        description=_text(xml, 'description'),
        licence=_text(xml, 'license'),
        files=files,
    )


def _text(xml: ElementTree.Element, tag: str) -> str:
    text = xml.findtext(tag)
    if text is None or not text.strip():
        raise SystemExit(f'package.xml: expected <{tag}>, found none')
    return ' '.join(text.split())
