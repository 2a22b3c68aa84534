"""Keeps Fast DDS off shared memory, where the user has not said what it is to use.

A killed process leaves its segments and locks in /dev/shm. Whoever comes next complains of them in
front of every output, waits for them, or hears nothing. UDP over the loopback interface costs
a few microseconds more and leaves nothing behind. A datagram that is lost there, because a socket
is full, is sent again after a twentieth of a second (by default after up to three).

scripts/bootstrap copies this file and its profiles beside the variables of its environment, where
every Python process reads them; so it imports little.
"""

import os
from collections.abc import MutableMapping

PROFILE = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'fast_dds_udp.xml')
OLD_PROFILE = os.path.join(os.path.dirname(PROFILE), 'fast_dds_udp_2.xml')
"""For Fast DDS 2, which has another name for a period, and refuses a file with the later one."""

TRANSPORTS = 'FASTDDS_BUILTIN_TRANSPORTS'
PROFILES = 'FASTDDS_DEFAULT_PROFILES_FILE'
OLD_PROFILES = 'FASTRTPS_DEFAULT_PROFILES_FILE'
"""The only name that Fast DDS 2 reads, and that later versions warn of."""
OLD_DISTROS = ('humble', 'iron', 'jazzy')

FOUND_BY_ITSELF = ('DEFAULT_FASTDDS_PROFILES.xml', 'DEFAULT_FASTRTPS_PROFILES.xml')
"""Files that Fast DDS reads where a program is started."""


def keep_off_shared_memory(environ: MutableMapping[str, str]) -> None:
    """Set what is to be set before the first participant is made; what is set already stays."""
    own = any(environ.get(name) for name in (TRANSPORTS, PROFILES, OLD_PROFILES))
    if own or any(os.path.exists(name) for name in FOUND_BY_ITSELF):
        return
    # The first says nothing while ROS_AUTOMATIC_DISCOVERY_RANGE is LOCALHOST: there rmw_fastrtps
    # adds shared memory by itself. Then the profile says where to listen, which is UDP alone.
    environ[TRANSPORTS] = 'UDPv4'
    if environ.get('ROS_DISTRO') in OLD_DISTROS:
        environ[OLD_PROFILES] = OLD_PROFILE
    else:
        environ[PROFILES] = PROFILE
