"""What a line adds to a process in which everything is loaded: CPU seconds and memory."""

from __future__ import annotations

import gc
import json
import os
import sys
import time

import rclpy
from process_use import memory_mb
from rclpy.node import Node

from bench.line_files import SECTIONS, cell_text, script_text
from bt_orchestrator.cli.bootstrap import installed_types
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.ros.actions.gateway import RosGateway
from bt_orchestrator.ros.clock import RosClock
from bt_orchestrator.ros.executor.ways import lean_way
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.script_file import parse_script
from bt_orchestrator.store.memory import MemoryStore


def main() -> None:
    """Run: setup_cost TASKS, so many in each of five sections, over two actions each."""
    types = installed_types()
    cell = parse_cell(cell_text(SECTIONS), 'cell.yaml', types)
    text = script_text(SECTIONS, int(sys.argv[1]))
    script = parse_script(text, 'line.yaml', cell, types)
    rclpy.init()
    node = Node('setup')
    gc.collect()
    before_mb, began = memory_mb(os.getpid()), time.process_time()
    gateway = RosGateway(node, cell, types, lean_way(node))
    orchestrator = Orchestrator(cell, gateway, RosClock(node), MemoryStore())
    answer = orchestrator.ask(AddJobs((Job('WO-1', script, 1),)))
    took_s = time.process_time() - began
    gc.collect()
    assert answer.accepted, answer.message
    print(json.dumps({'s': took_s, 'mb': memory_mb(os.getpid()) - before_mb}))


if __name__ == '__main__':
    main()
