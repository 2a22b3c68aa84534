"""Has Fast DDS not wait for a client that does not hear an answer.

Before it sends an answer it waits until the client's way back is known, for as long as a writer
may block: 0.1 s by default. A client that has left after many questions is waited for with the
answer to each that is still in the queue, in the thread that carries out everything. The services
of patient_service.py send such answers again, and wait in no thread.

How long a writer may block can be said in a profile alone. Fast DDS reads the file that the
environment names when the participant of a process is made, and ROS 2 takes the profile named
"service" for all writers of answers. So for that moment the environment names a copy of the same
file with this profile added. Other processes, whose services have no such patience, keep theirs.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, MutableMapping
from contextlib import contextmanager
from pathlib import Path

from bt_orchestrator.ros.fast_dds import OLD_DISTROS, OLD_PROFILES, PROFILES

SERVICE = 'profile_name="service"'
_END = '</profiles>'
_EMPTY = f'<dds xmlns="http://www.eprosima.com"><profiles>{_END}</dds>'

_PROMPT = f"""
  <data_writer {SERVICE}>
    <qos>
      <reliability>
        <kind>RELIABLE</kind>
        <max_blocking_time><sec>0</sec><nanosec>1000000</nanosec></max_blocking_time>
      </reliability>
    </qos>
    <times>
      <{{period}}><sec>0</sec><nanosec>50000000</nanosec></{{period}}>
    </times>
  </data_writer>
"""
"""One millisecond. The heartbeat is that of fast_dds_udp.xml, which this profile replaces."""


@contextmanager
def prompt_answers(environ: MutableMapping[str, str]) -> Iterator[None]:
    """Have the participant made in this block drop answers without a reader at once.

    A profile for services that the user has written stays; so does a file that cannot be read,
    of which Fast DDS will complain.
    """
    is_old = environ.get('ROS_DISTRO') in OLD_DISTROS
    name = OLD_PROFILES if is_old or _names_only_the_old(environ) else PROFILES
    before = environ.get(name)
    profiles = _with_prompt(before, 'heartbeatPeriod' if is_old else 'heartbeat_period')
    if profiles is None:
        yield
        return
    with tempfile.NamedTemporaryFile('w', suffix='.xml') as file:
        file.write(profiles)
        file.flush()
        environ[name] = file.name
        try:
            yield
        finally:
            if before is None:
                del environ[name]
            else:
                environ[name] = before


def _names_only_the_old(environ: MutableMapping[str, str]) -> bool:
    return bool(environ.get(OLD_PROFILES)) and not environ.get(PROFILES)


def _with_prompt(file: str | None, period: str) -> str | None:
    """Return the text of a file with the profile added; None if it is to stay."""
    try:
        text = Path(file).read_text('utf-8') if file else _EMPTY
    except (OSError, UnicodeError):
        return None
    head, end, tail = text.rpartition(_END)
    if not end or SERVICE in text:
        return None
    return head + _PROMPT.format(period=period) + end + tail
