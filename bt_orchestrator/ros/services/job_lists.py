"""`~/queue/list` and `~/list_jobs`: the jobs of the cell, page by page."""

from __future__ import annotations

from typing import Any

from bt_orchestrator_interfaces.srv import ListJobs, QueueList
from rclpy.node import Node

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime import listed_jobs
from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.limits import QUEUE_PAGE, fitting
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.ros.services.serving import serve
from bt_orchestrator.ros.types.status_messages import job_message, listed_message


def serve_lists(node: Node, overview: Overview, state: CellState) -> None:
    """Offer both services."""

    async def answer_queue(request: Any, response: Any) -> None:
        list_queue(state, overview, request, response)

    async def answer_jobs(request: Any, response: Any) -> None:
        list_jobs(state, overview, request, response)

    serve(node, QueueList, 'queue/list', answer_queue)
    serve(node, ListJobs, 'list_jobs', answer_jobs)


def list_queue(state: CellState, overview: Overview, request: Any, response: Any) -> None:
    """Fill a response with jobs of the queue (bt_orchestrator_interfaces/srv/QueueList)."""
    place = state.jobs.place(request.after)
    if request.after and not place:
        response.message = f'{request.after} is not in the queue'
        return
    most = min(request.most or QUEUE_PAGE, QUEUE_PAGE)
    response.accepted, response.queued = True, state.jobs.waiting
    told = [(job, _details(job)) for job in state.jobs.queue(place + 1, most)]
    told = list(fitting(told, listed_jobs.PAGE_BYTES, lambda one: len(one[1])))
    response.jobs = [job_message(overview.job(job)) for job, _ in told]
    response.details = [details for _, details in told]


def list_jobs(state: CellState, overview: Overview, request: Any, response: Any) -> None:
    """Fill a response with listed jobs (bt_orchestrator_interfaces/srv/ListJobs)."""
    try:
        if request.job:
            jobs = [listed_jobs.told_of(listed_jobs.find(state, request.job), overview)]
        else:
            jobs = listed_jobs.page(state, overview, request.after, request.most)
    except CommandRefused as why:
        response.message = str(why)
        return
    response.accepted, response.jobs = True, list(map(listed_message, jobs))


def _details(job: JobState) -> str:
    details = job.job.terms.details
    return json_of(details) if details else ''
