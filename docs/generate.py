"""Write what is made from the code: parts of the pages (keys, events, verbs), and schemas/.

    python docs/generate.py          write them
    python docs/generate.py --check  say which files are not up to date, exit 1

A generated part stands between `<!-- generated: NAME -->` and `<!-- end -->`; what is between them
is replaced, everything else is the author's.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

from tables import (
    decisions,
    event_stream,
    job_control,
    keys,
    losses,
    opcua,
    page_api,
    programs,
    requests,
    rules,
    states,
    status,
)

from bt_orchestrator.script.cell_keys import CELL
from bt_orchestrator.script.json_schema import SCHEMA_FILES, json_schema
from bt_orchestrator.script.orders.recipe_keys import OVERRIDES, RECIPE
from bt_orchestrator.script.script_keys import ORDER, SCRIPT
from bt_orchestrator.script.shifts.shifts_keys import REASONS, SHIFTS

ROOT = Path(__file__).resolve().parents[1]
PAGES = (
    'README.md',
    'docs/semantics.md',
    'docs/account.md',
    'docs/cell_file.md',
    'docs/recipe_file.md',
    'docs/order_file.md',
    'docs/verbs.md',
    'docs/ros_names.md',
    'docs/status.md',
    'docs/events.md',
    'docs/script_reference.md',
    'docs/opcua_reference.md',
    'docs/mes.md',
    'docs/operating.md',
    'docs/requests.md',
    'docs/page_api.md',
    'docs/queue.md',
    'docs/security.md',
    'docs/decisions/README.md',
)

PARTS: Mapping[str, Callable[[], Iterator[str]]] = {
    'keys of a cell file': partial(keys.keys_of, CELL),
    'keys of a recipe': partial(keys.keys_of, RECIPE),
    'keys of overrides': partial(keys.keys_of, OVERRIDES),
    **{f'keys of {table.name}': partial(keys.keys_in, table) for table in SCRIPT.tree()},
    'keys of a work order': partial(keys.keys_of, ORDER),
    'keys of a file of shifts': partial(keys.keys_of, SHIFTS),
    'keys of a file of reasons': partial(keys.keys_of, REASONS),
    'losses': losses.losses,
    'kinds of faults': states.kinds_of_faults,
    'methods of a job': states.methods_of_a_job,
    'states of a job': states.states_of_a_job,
    'events': event_stream.events_in_groups,
    'decisions': decisions.decisions,
    'tests of the rules': rules.tests_of_the_rules,
    'verbs': programs.verbs,
    'options of the verbs': programs.options_of_the_verbs,
    'parameters of the node': programs.parameters_of_the_node,
    'states of the cell': states.states_of_the_cell,
    'status': status.status,
    'kinds of waits': status.kinds_of_waits,
    'causes of a standstill': status.causes_of_a_standstill,
    'stop reasons': states.stop_reasons,
    'commands and states': states.commands_in_states,
    'everything that can be asked': requests.everything_that_can_be_asked,
    'roles': requests.roles,
    'API of the page': page_api.api_of_the_page,
    'simple values of OPC UA': opcua.simple_values,
    'states in numbers': opcua.states_in_numbers,
    'values of PackML': opcua.values_of_packml,
    'commands of PackML': opcua.commands_of_packml,
    'numbers of stop reasons': opcua.stop_numbers,
    'methods and states of ISA-95': job_control.methods_and_states_of_isa_95,
    'what differs from ISA-95': job_control.what_differs_from_isa_95,
    'numbers of ReturnStatus': job_control.numbers_of_return_status,
    'parameters of a job order': job_control.parameters_of_a_job_order,
    'own parameters of a response': job_control.own_parameters_of_a_response,
}

_PART = re.compile(r'(<!-- generated: (?P<name>[\w -]+) -->\n).*?(?=<!-- end -->)', re.DOTALL)


def generated(text: str) -> str:
    """Return a page with its generated parts made anew."""
    return _PART.sub(lambda part: part[1] + '\n' + '\n'.join(PARTS[part['name']]()) + '\n', text)


def stale_files(root: Path = ROOT) -> dict[str, str]:
    """Return what the files have to say that do not say what the code says."""
    wanted = {page: generated((root / page).read_text(encoding='utf-8')) for page in PAGES}
    for name, table in SCHEMA_FILES.items():
        wanted[f'schemas/{name}'] = json.dumps(json_schema(table), indent=2) + '\n'
    return {name: text for name, text in wanted.items() if _text(root / name) != text}


def _text(path: Path) -> str:
    return path.read_text(encoding='utf-8') if path.exists() else ''


def main(words: Sequence[str]) -> int:
    """Write the files, or check them."""
    stale = stale_files()
    if '--check' in words:
        for name in stale:
            sys.stderr.write(f'{name} is not up to date: run python docs/generate.py\n')
        return 1 if stale else 0
    for name, text in stale.items():
        (ROOT / name).write_text(text, encoding='utf-8')
        sys.stdout.write(f'{name} written\n')
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
