"""The container file and the compose file: read by hadolint and against the schema of Compose."""

from __future__ import annotations

from collections.abc import Iterator

from outcome import Outcome, Place, end_of, run


def look(place: Place) -> Iterator[Outcome]:
    folder = place.root / 'config' / 'container'
    lint = (place.tools / 'hadolint', '--no-color', '--failure-threshold', 'info')
    schema = (place.tools / 'check-jsonschema', '--builtin-schema', 'vendor.compose-spec')
    for what, checker in (('Containerfile', lint), ('compose.yaml', schema)):
        done = run(*checker, what, cwd=folder)
        failed = done.returncode != 0
        yield Outcome(what, end_of(done) if failed else 'no complaint', failed)
