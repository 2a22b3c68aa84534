"""Every attack, in the order in which a line has to bear them."""

from __future__ import annotations

from attack.attacks.attack import Attack
from attack.attacks.files import Copies, Disk, Lock
from attack.attacks.graph import Parameters, States, Streams, Subscribers
from attack.attacks.orders import Goals, Large, Orders, Paths
from attack.attacks.process import Clock, Stopped
from attack.attacks.requests import Departures, Garbage, History, Pauses, Reasons, Refusals
from attack.attacks.servers import Cancels, ForeignGoals, Results, SecondServer, Twin
from attack.attacks.signatures import Signatures

ATTACKS: dict[str, Attack] = {
    attack.name: attack
    for attack in (
        Results(),
        Paths(),
        Large(),
        Orders(),
        Goals(),
        Garbage(),
        Reasons(),
        Refusals(),
        Departures(),
        Pauses(),
        Signatures(),
        History(),
        SecondServer(),
        ForeignGoals(),
        Cancels(),
        Twin(),
        Parameters(),
        Streams(),
        States(),
        Subscribers(),
        Copies(),
        Lock(),
        Stopped(),
        Clock(),
        Disk(),
    )
}
