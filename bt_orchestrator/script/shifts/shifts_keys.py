"""The keys of the files of a plant: shifts, and reasons for stops."""

from __future__ import annotations

from bt_orchestrator.model.plant.shifts import DAYS, LEAST_MICRO_STOP_S, MICRO_STOP_S
from bt_orchestrator.script.keys import Key, Kind, Table
from bt_orchestrator.script.names import ID_FORM

CLOCK_FORM = '(?:[01][0-9]|2[0-3]):[0-5][0-9]|24:00'

_HOURS = (
    Key(
        'from',
        Kind.TEXT,
        'time of the clock at which it begins',
        '06:00',
        required=True,
        form=CLOCK_FORM,
    ),
    Key(
        'to',
        Kind.TEXT,
        'time of the clock at which it ends; not later than `from`: on the next day',
        '14:00',
        required=True,
        form=CLOCK_FORM,
    ),
)

BREAK = Table('a break', _HOURS)

SHIFT = Table(
    'a shift',
    (
        *_HOURS,
        Key(
            'breaks',
            Kind.LIST,
            'times within it that are not planned',
            '[{from: 09:00, to: 09:15}]',
            of=(BREAK,),
        ),
        Key(
            'days',
            Kind.NAMES,
            f'days of the week on which it begins ({", ".join(DAYS)}); absent: every day',
            '[mon, tue, wed, thu, fri]',
        ),
    ),
)

TARGET = Table(
    'a target',
    tuple(
        Key(name, Kind.SHARE, meaning, example, minimum=0, maximum=1)
        for name, meaning, example in (
            ('oee', 'OEE that the plant wants', '0.75'),
            ('availability', 'the same for the availability', '0.9'),
            ('performance', 'the same for the performance', '0.9'),
            ('quality', 'the same for the quality', '0.98'),
        )
    ),
)

SHIFTS = Table(
    'a file of shifts',
    (
        Key(
            'shifts',
            Kind.MAPPING,
            'the shifts by name',
            '{early: {from: 06:00, to: 14:00}}',
            required=True,
            of=(SHIFT,),
            name_form=ID_FORM,
            fewest=1,
        ),
        Key(
            'zone',
            Kind.TEXT,
            'time zone of all times in the file (IANA name); absent: that of the computer',
            'Europe/Berlin',
        ),
        Key(
            'target',
            Kind.TABLE,
            'figures that the plant wants; a report says where they are reached',
            '{oee: 0.75}',
            of=(TARGET,),
        ),
        Key(
            'micro_stop',
            Kind.SECONDS,
            'an own fault that is shorter is a micro-stop, any other a breakdown',
            '120',
            default=MICRO_STOP_S,
            minimum=LEAST_MICRO_STOP_S,
        ),
    ),
)


# The keys of a file of reasons.

LANGUAGE_FORM = '[a-z]{2,3}'

REASON = Table(
    'a reason',
    (
        Key(
            'words',
            Kind.MAPPING,
            'the reason in the languages of the plant, by their codes (`en`, `de`)',
            '{en: material jam, de: Materialstau}',
            required=True,
            members=Kind.TEXT,
            fewest=1,
            name_form=LANGUAGE_FORM,
        ),
        Key(
            'group',
            Kind.TEXT,
            'reasons of one group stand together; absent: those of no group',
            'material',
        ),
    ),
)

REASONS = Table(
    'a file of reasons',
    (
        Key(
            'reasons',
            Kind.MAPPING,
            'the reasons for stops of the line, by code',
            '{JAM: {words: {en: material jam}, group: material}}',
            required=True,
            of=(REASON,),
            name_form=ID_FORM,
            fewest=1,
        ),
    ),
)
