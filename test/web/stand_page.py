"""Puts the stand together: cell, jobs, page and server."""

from __future__ import annotations

import argparse
import time
from fractions import Fraction
from pathlib import Path

from fakes.quick_users import write_users
from fakes.shipped import RECIPES, TREES
from web.stand_cell import StandCell

from bt_orchestrator.cli.processes.planning_process import PlanningProcess
from bt_orchestrator.extensions.page.web.access import Access
from bt_orchestrator.extensions.page.web.page import WebPage
from bt_orchestrator.extensions.page.web.seams import Plant, Sources
from bt_orchestrator.extensions.page.web.server import PageServer
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.jobs.order import Terms, WorkOrder
from bt_orchestrator.model.plant.shifts import DAY_MIN, Hours, Shift, Shifts
from bt_orchestrator.ports.records import PlantCell
from bt_orchestrator.store.memory import MemoryStore

USERS = {'ann': Role.OPERATE, 'eve': Role.ENGINEER, 'mes': Role.MES, 'vic': Role.VIEW}
"""All with `quick_users.PASSWORD`."""


CELLS = (
    PlantCell('line_1', 'Held', 1.8e9, 'own_fault', 99, 1.8e9, 2.0, 1, 'http://line-1:8080/'),
    PlantCell('line_2', 'Execute', 1.8e9, '', 7, 1.8e9, None, 0, ''),
)
"""Of the plant."""


def stand_page(folder: Path, args: argparse.Namespace) -> tuple[StandCell, PageServer]:
    """Return a cell with a queue, and the server of its page, which is to be started."""
    faults = None if args.fail is None else [fault for fault in args.fail if fault != 'none']
    stand = StandCell(
        folder, MemoryStore(), sections=args.sections, faults=faults, speed=args.speed
    )
    orders = [_order(stand, number, args.quantity) for number in range(args.jobs)]
    answer = stand.queue(*orders) if orders else None
    assert answer is None or answer.accepted, answer
    access = Access(
        write_users(folder / 'users.yaml', USERS),
        args.host,
        args.port,
        local_user='' if args.login else 'stand',
    )
    trees = (TREES if args.sections == 5 else folder,)
    planning = PlanningProcess(trees, (RECIPES,))
    plant = Plant(_shifts(), stand.cell)
    sources = Sources(
        trees=trees, recipes=(RECIPES,), planning=planning, plant=plant, cells=lambda: CELLS
    )
    return stand, PageServer(WebPage(stand.node.name, stand.open_door, access, sources))


def _shifts() -> Shifts:
    """Return a shift that has begun in this minute."""
    begin_min = int(time.time() // 60) % DAY_MIN
    hours = Hours(begin_min, (begin_min + 480) % DAY_MIN)
    return Shifts({'early': Shift('early', hours)}, 'UTC', {'oee': Fraction(3, 4)})


def _order(stand: StandCell, number: int, quantity: int) -> WorkOrder:
    due = time.time() + 600.0 * (number + 1)
    # The first ones are the most urgent, so the jobs stay in their order.
    terms = Terms(priority=max(2 - number // 2, 0), due=due if number % 2 else None)
    return WorkOrder(stand.script, f'WO-{1001 + number}', quantity + number, {}, terms)
