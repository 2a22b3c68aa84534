"""The line and the queue: whatever is done to them, as a plain list would have it."""

from __future__ import annotations

import copy
from dataclasses import replace

from fakes.line import THREE, Line, with_section
from fakes.profiles import examples
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.model.state import JobState
from bt_orchestrator.model.state.live_jobs import LiveJobs

LINE = Line()
FLAGS = 'lateral_dependencies:\n  - {flag: %s, upstream: place, downstream: work}\n'
SCRIPTS = {
    'plain': LINE.script(THREE),
    'seen': LINE.script(THREE + FLAGS % 'seen'),
    'both': LINE.script(with_section(2, '- {id: work, @b2}') + FLAGS % 'seen'),
}


def job(name: str, script: str, *, held: bool, priority: int | None = None) -> JobState:
    """Return a job; with a priority its place follows from that."""
    order = Job(name, SCRIPTS[script], 1, terms=Terms(priority or 0))
    return JobState(order, script, held=held, ranked=priority is not None)


class Plain:
    """The same in lists, from the first to the last."""

    def __init__(self) -> None:
        self.line: list[JobState] = []
        self.queue: list[JobState] = []

    @property
    def every(self) -> list[JobState]:
        return [*self.line, *self.queue]

    def read(self, jobs: LiveJobs) -> None:
        """Take the jobs as they are now, in the order that they are to have."""
        self.line = [jobs[state.job.id] for state in self.line]
        self.queue = [jobs[state.job.id] for state in self.queue]

    def check(self, jobs: LiveJobs) -> None:
        names = [state.job.id for state in self.every]
        assert list(jobs) == names
        assert list(jobs.values()) == self.every
        assert len(jobs) == len(names)
        assert jobs.queue() == self.queue
        assert jobs.queue(2, 3) == self.queue[1:4]
        assert jobs.first(2) == [*self.line, *self.queue[:2]]
        assert jobs.waiting == len(self.queue)
        assert [jobs.place(state.job.id) for state in self.line] == [0] * len(self.line)
        places = [jobs.place(state.job.id) for state in self.queue]
        assert places == list(range(1, len(self.queue) + 1))
        assert jobs.place('nobody') == 0
        may = [state for state in self.queue if not state.held and not state.aborting]
        assert jobs.next is (may[0] if may else None)
        assert jobs.any_allowed is any(not state.held for state in self.every)
        at_work = [state for state in self.queue if state.aborting or state is jobs.next]
        assert jobs.at_work() == [*self.line, *at_work]
        for number, state in enumerate(self.every):
            before = [other for other in self.every[:number] if not other.held]
            assert list(jobs.before(state.job.id)) == before
        for digest in SCRIPTS:
            assert jobs.users(digest) == sum(state.digest == digest for state in self.every)
        flags = {d.flag for state in self.every for d in state.job.script.dependencies}
        assert jobs.names_flag('seen') is ('seen' in flags)
        again = LiveJobs(self.every)
        assert again == jobs
        buts = ['', *(state.job.id for state in self.queue)]
        for priority in range(4):
            urgency = Terms(priority).urgency
            places = [
                self.place_for(urgency, but) for but in ('', *(n.job.id for n in self.queue))
            ]
            for each in (jobs, again):
                assert places == [each.place_for(urgency, but) for but in buts]

    def place_for(self, urgency: tuple[int, float], but: str = '') -> int:
        """Return the place before the first ranked one that is less urgent."""
        queue = [row for row in self.queue if row.job.id != but]
        late = (n for n, row in enumerate(queue) if row.ranked and row.job.terms.urgency > urgency)
        return next(late, len(queue)) + 1


@examples(150, 2000)
@given(st.data())
def test_it_is_as_in_a_list(data: st.DataObject) -> None:
    jobs, plain = LiveJobs(), Plain()
    for number in range(data.draw(st.integers(1, 25))):
        acts = ['add', 'add', 'insert', 'rank', 'rank', 'arrange']
        lasting = [state for state in plain.queue if not state.aborting]
        may_start = [state for state in lasting if not state.held]
        acts += ['hold', 'release', 'move', 'change'] if lasting else []
        acts += ['start'] if may_start else []
        acts += ['remove', 'abort'] if plain.every else []
        act = data.draw(st.sampled_from(acts))
        if act == 'arrange':
            names = [state.job.id for state in plain.queue]
            first = data.draw(st.integers(0, len(names)))
            wanted = data.draw(st.permutations(names[:first]))
            jobs.arrange(wanted)
            plain.queue[:first] = [jobs[name] for name in wanted]
        elif act in ('add', 'insert', 'rank'):
            script = data.draw(st.sampled_from(sorted(SCRIPTS)))
            priority = data.draw(st.integers(0, 3)) if act == 'rank' else None
            held = data.draw(st.booleans())
            new = job(f'J{number}', script, held=held, priority=priority)
            last = len(plain.queue) + 1
            place = data.draw(st.integers(1, last)) if act == 'insert' else None
            if act == 'rank':
                place = plain.place_for(new.job.terms.urgency)
            jobs.add(new, place)
            plain.queue.insert((place or last) - 1, new)
        else:
            among = may_start if act == 'start' else lasting
            among = plain.every if act in ('remove', 'abort') else among
            state = data.draw(st.sampled_from(among))
            is_queued, before = state in plain.queue, copy.deepcopy(state)
            _act(act, state, jobs, plain, data)
            assert not is_queued or state == before, 'a job in the queue was changed in place'
            plain.read(jobs)
        plain.check(jobs)


def _act(act: str, job_state: JobState, jobs: LiveJobs, plain: Plain, data: st.DataObject) -> None:
    name = job_state.job.id
    if act == 'start':
        jobs.start(name, 1.0)
        assert jobs[name].started_at == 1.0
        plain.queue.remove(job_state)
        plain.line.append(job_state)
    elif act in ('hold', 'release'):
        jobs.hold(name, held=act == 'hold')
        assert jobs[name].held is (act == 'hold')
    elif act == 'move':
        place = data.draw(st.integers(1, len(plain.queue)))
        jobs.move(name, place)
        plain.queue.remove(job_state)
        plain.queue.insert(place - 1, job_state)
    elif act == 'change':
        digest = data.draw(st.sampled_from(sorted(SCRIPTS)))
        with jobs.changing(name) as changed:
            changed.job = replace(changed.job, script=SCRIPTS[digest], quantity=2)
            changed.digest = digest
        assert jobs[name].digest == digest
    elif act == 'abort':
        jobs.abort(name, 'why')
        assert jobs[name].aborting
    else:
        assert jobs.remove(name) is job_state
        (plain.line if job_state in plain.line else plain.queue).remove(job_state)


def test_there_is_always_room_between_two_jobs() -> None:
    """A hundred times at one place: numbers between two others come to an end before that."""
    jobs, plain = LiveJobs(), Plain()
    for number in range(100):
        new = job(f'J{number}', 'plain', held=False)
        at = min(number, 1)
        jobs.add(new, at + 1)
        plain.queue.insert(at, new)
    plain.check(jobs)
