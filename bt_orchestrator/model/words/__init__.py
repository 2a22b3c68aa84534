"""Sentences of the node as facts, from which each language can word them.

This is the catalogue of their English; `extensions/page/web/static/strings` has it in the
languages of the page.
A sentence is made of its facts, and `facts_of` reads them out of it again: records keep sentences.
"""

from __future__ import annotations

import string
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

from bt_orchestrator.model.words.answers import ANSWERS, REFUSALS

OVERRUN, SLOT_OCCUPIED = 'overrun', 'slot_occupied'
"""Reasons of holds that say it all: also the kinds of their sentences."""

SENTENCES: Mapping[str, str] = {
    'said': '{words}',
    # contests, and questions about held tasks
    'several_servers': '{count} servers of {action}: {servers}; stop all but one',
    'foreign_goal': 'it runs goal {goals}, which no task here waits for',
    'foreign_goals': 'it runs goals {goals}, which no task here waits for',
    'placed': 'was {item} placed in section {section}? mark_done if it was, else {answers}',
    'taken_out': 'was {item} taken out of section {section}? mark_done if it was, else {answers}',
    'wanted': 'later tasks use its results: {fields}; mark_done may give them',
    OVERRUN: 'the belt would carry {item} out of section {section}',
    SLOT_OCCUPIED: '{there} stands where {item} would be placed',
    'hold': 'hold {hold}',
    # pauses that must be named
    'unfinished': 'unfinished jobs: {jobs}, goals in flight: {goals}',
    'restored': 'the journal is a copy that ends with event {seq} of {time}; {words}. '
    'Compare belt and queue with what was done since, before anything starts',
    'missing': '{what}. The journal ends with event {seq} of {time}; {words}. Items may be '
    'further than it says, or packed: compare belt, counts and queue with the line, before '
    'anything starts',
    'unknown_goal': '{server} runs goal {goal}, accepted {time} by its clock, for which no task '
    'waits in the journal: the line may be further than the journal says. Compare belt and queue, '
    'and see to it that the goal ends, before anything starts',
    # what the rejects of a run have in common
    'rejects': '{count} rejects within {of} items: {items}',
    'rejects_tasks': 'by the tasks {tasks}',
    'rejects_task': 'all by task {task}',
    'rejects_component': 'all at {component}',
    'rejects_reason': 'all for the reason {reason}',
    'rejects_verdict': 'each time expected: {wanted}',
    'rejects_product': 'all of product {product}',
    'rejects_job': 'all of job {job}',
    'rejects_lot': 'all with lot {lot} of {name}',
    'twins': '{count} nodes answer as {name}, stop all but one: {words}',
    'twin_place': 'process {process} on {host}, with cell {cell}, since {time}',
    # why the line stands still
    'stopped': 'the cell was stopped',
    'starved': '{task} waits for {topic}',
    # why nothing starts
    'ending': 'the node ends',
    'unsafe': 'the safety input is not ready: {words}',
    'unsafe_unheard': 'nothing was heard of it yet',
    'unsafe_silent': 'no message for {seconds} s',
    'unsafe_value': 'its value is {value}',
    'unsafe_unreadable': 'its value cannot be read: {words}',
    'unsafe_unpublished': 'it has no publisher',
    'unsafe_publishers': 'it has {count} publishers: {publishers}',
    'unsafe_latched': 'its publisher keeps old messages (transient local)',
    'unsafe_unsent': 'it was not sent: the safety input is not ready',
    # why the end of a job is unknown
    'job_paused': '{job} is paused',
    'job_held': '{job} is held in the queue',
    'job_unreleased': '{job} waits for the release of its script',
    'job_awaits_start': '{job} waits for the start of its order',
    'job_needs': '{job} needs {names}, which is out of service',
    'job_needs_several': '{job} needs {names}, which are out of service',
    'one_more_waits': 'one more job waits',
    'more_wait': '{count} more jobs wait',
    'job_awaits_piece': '{job} waits for the approval of {item}',
    'awaits_answer': 'waiting for an answer to {held}',
    'awaits_answers': 'waiting for answers to holds {others} and {last}',
    'nothing_goes_on': 'nothing on the line can go on by itself',
    'run_given_up': 'the virtual run takes too long; it was given up',
    # ends of attempts
    'no_end': 'no end came within {seconds} s of the cancel request ({cause})',
    'after_restart': 'after a restart of the orchestrator: {words}',
    'after_take_over': 'after a take-over from another machine: {words}. Before retry, make sure '
    'that the process of the earlier leader is dead: it may send this goal late',
    'foreign_cancel': 'cancelled by somebody else: another client, an HMI, or the controller '
    'itself',
    'after_abort_canceled': 'after an abort of the cell: the controller cancelled the goal as '
    'asked; how far it came is not known',
    'after_abort_aborted': 'after an abort of the cell: the controller ended the goal as aborted; '
    'how far it came is not known',
    'withdrawn': 'withdrawn before it was sent',
    'no_server': 'no server of {action} within {seconds} s',
    'refused': 'refused by the server',
    'others_goal': 'it runs a goal of another client, {goal}',
    'not_sent': 'not sent: {words}',
    'not_known': 'the server does not know the goal (any more)',
    'silent': 'the server of {action} is there and does not answer',
    'gone': 'the server of {action} is gone',
    'refused_result': 'expected {wanted}; found {found}',
    'long_serial': 'expected a serial of at most {most} characters; found {found}',
    'serial_here': 'the serial {serial} is of {item}, which is in work; if this is the same item '
    'again, mark_done with the result {result}',
    'serial_before': 'the serial {serial} is in the history; if this is the same item again, '
    'mark_done with the result {result}',
    'setup_unknown': '{setup} of {component} is not known; the task needs {wanted}',
    'setup_other': '{setup} of {component} is {found}; the task needs {wanted}',
    # why a standby could not take over
    'standby_servers': 'it does not see the servers of {actions}',
    'standby_away': 'it cannot look at the journal: {words}',
    'standby_silent': 'it was heard last at {time}',
    # why answers are not offered
    'no_answers': 'no {answers}: {words}',
    'none_to_abort': 'no job on the belt is left to abort',
    'missing_again': 'the result would be missing again',
    'would_stay': 'the item would not leave the belt',
    'aborting': 'the job is being aborted',
    'good_items': 'rounds are for good items',
    'cancelled_with_job': 'the task was cancelled with its job',
    'would_be_skipped': 'the task would be skipped ({why})',
    'rejected': 'the item is rejected already',
    'not_there': 'the item is not on the belt',
    'belt_released': 'the section has released the belt',
    'placed_unknown': 'it is not known whether {item} was placed in section {section}',
    'taken_out_unknown': 'it is not known whether {item} was taken out of section {section}',
    # what is wrong with an order
    'order_id': '{id} cannot be an order id: {words}',
    'id_empty': 'it is empty',
    'id_slash': 'a slash separates the order from the number of the item',
    'id_space': 'it begins or ends with a space',
    'id_unprintable': 'it has characters that cannot be printed',
    'id_sign': 'it has `<` or `>`, which pages and reports take for the begin of a command',
    'id_long': 'it has {count} characters, at most {most} are allowed',
    'id_instead': 'write for instance `{id}`',
    'id_used': '{job} is the id of another job',
    'id_other': 'choose another',
    'most_items': '`quantity` is {quantity}, and an order of this cell has at most {most} items',
    'less_items': 'order less at a time, or raise `most_items` in the cell file',
    'quantity': '`quantity` must be from 1 to {most}, not {given}',
    'one_item': 'order at least one item',
    'param_missing': 'the parameter `{name}` is missing',
    'param_add': 'add `{name}`, of type {type}, to `params`',
    'param': 'the parameter `{name}` must be {needed}, not {given}',
    'param_in_goal': '`{name}` must be {needed} for `{field}` of the task `{task}`, not {given}',
    'in_condition': '`{name}` must be {needed} in a condition of the task `{task}`, not {given}',
    'crossed': 'no value is between {low} and {high} in a condition of the task `{task}`',
    'lower_first': 'the lower bound comes first',
    'key': '`{key}` must be {needed}, not {given}',
    'priority_is': 'the higher the more urgent; 0 is for ordinary orders',
    'at_least': 'at least {low}',
    'at_most': 'at most {high}',
    'years': '`{key}` must be between 1970 and 2038',
    'years_why': 'messages of ROS 2 carry no other times',
    'due_first': '`due` lies before `start`',
    'other_zone': 'is one of them of another time zone?',
    'whole': 'a whole number ({type})',
    'whole_from': 'a whole number from {low} to {high} ({type})',
    'number': 'a number ({type})',
    'finite': 'a finite number ({type})',
    'boolean': 'true or false ({type})',
    'text': 'text ({type})',
    'text_most': 'text of at most {most} characters ({type})',
    'in_range': 'choose a number in that range',
    'measured': 'give a number that was measured; NaN and infinity are refused',
    'bare_whole': 'write a whole number, without quotes',
    'bare_number': 'write a number, without quotes',
    'bare': 'write {value} without quotes',
    'bare_boolean': 'write true or false, without quotes',
    'shorten': 'shorten it',
    'given_number': 'the number {number}',
    'given_text': 'the text {text}',
    'given_nothing': 'nothing',
    **REFUSALS,
    **ANSWERS,
}
"""By kind. `said`: words of a device or a person, or others that are known in words only."""

OR, AND = ' | ', '; '
"""Between possible answers; between sentences."""

_LONGEST, _MOST_PARTS = 4, 40
"""Parts of one sentence that has `; ` itself; of a message, beyond which nothing is looked for."""

_MOST_CHARACTERS = 10_000
"""Of a message that is read and remembered; longer ones have a text of somebody else."""

_NAMES = ('held', 'message')
"""Places of the name of a hold, and of its message: their brackets are closed."""

_FREE = ('words', 'what', 'needed', 'given', 'anew', 'pace', *_NAMES)
"""Places of what may be several sentences itself."""

Worded = Callable[[Mapping[str, str]], Mapping[str, str]]
"""Returns the values of a sentence as a language says them."""


def _as_they_are(values: Mapping[str, str]) -> Mapping[str, str]:
    return values


@dataclass(frozen=True)
class Words:
    """The facts of one sentence."""

    kind: str
    """The kind of the sentence."""
    values: Mapping[str, str] = field(default_factory=dict)
    """The things that it names."""

    def text(
        self,
        sentences: Mapping[str, str] = SENTENCES,
        or_: str = 'or',
        worded: Worded = _as_they_are,
    ) -> str:
        """Return the sentence in a language.

        :param sentences: its catalogue
        :param or_: its word between alternatives
        :param worded: its words for what stands in the places of a sentence
        """
        answers = self.values.get('answers', '').replace(OR, f' {or_} ')
        inner = {
            name: text_of(facts_of(value), value, sentences, or_, worded)
            for name, value in self.values.items()
            if name in _FREE
        }
        return sentences[self.kind].format(**{**worded(self.values), 'answers': answers, **inner})


def text_of(
    facts: Sequence[Words],
    otherwise: str,
    sentences: Mapping[str, str],
    or_: str,
    worded: Worded = _as_they_are,
) -> str:
    """Return a message in a language.

    :param otherwise: the same in English, where the language lacks a sentence
    """
    if not facts or not {fact.kind for fact in facts} <= sentences.keys():
        return otherwise
    return AND.join(fact.text(sentences, or_, worded) for fact in facts)


def sentence(kind: str, /, **values: object) -> str:
    """Return a sentence of the catalogue in English."""
    return SENTENCES[kind].format(**values)


def joined(*sentences: str) -> str:
    """Return a message of several sentences; empty ones are left out."""
    return AND.join(filter(None, sentences))


def facts_of(message: str) -> tuple[Words, ...]:
    """Return the facts of a message that was made of sentences; empty: it has no such sentence."""
    return _facts_of(message) if len(message) <= _MOST_CHARACTERS else ()


@lru_cache(maxsize=256)
def _facts_of(message: str) -> tuple[Words, ...]:
    parts, facts = message.split(AND)[:_MOST_PARTS], list[Words]()
    while parts:
        runs = (
            (size, _read(AND.join(parts[:size]), size))
            for size in range(min(_LONGEST, len(parts)), 0, -1)
        )
        quote = Words('said', {'words': parts[0]})
        size, known = next(((size, words) for size, words in runs if words), (1, quote))
        facts.append(known)
        del parts[:size]
    is_whole = message.count(AND) < _MOST_PARTS
    return tuple(facts) if is_whole and any(fact.kind != 'said' for fact in facts) else ()


def _read(text: str, size: int) -> Words | None:
    """Return the sentence that a text is; of several, the one with the most words of its own.

    :param size: number of its parts
    """
    by_begin = _PATTERNS[size]
    near = by_begin.get(text[:_BEGIN], by_begin[''])
    return next(
        (
            Words(pattern.kind, values)
            for pattern in near
            if pattern.telling in text and (values := _values(pattern.pieces, text)) is not None
        ),
        None,
    )


def _values(pieces: Sequence[tuple[str, str | None]], text: str) -> dict[str, str] | None:
    """Return what stands in the places of a sentence; None: the text is another one."""
    values: dict[str, str] = {}
    at, name = 0, None
    for literal, following in pieces:
        is_last = following is None
        start = at
        if name is not None:
            start = len(text) - len(literal) if is_last else text.find(literal, at + 1)
        if start < at or not text.startswith(literal, start):
            return None
        if name is not None and values.setdefault(name, text[at:start]) != text[at:start]:
            return None
        at, name = start + len(literal), following
    if at != len(text) or not all(_may_stand(value, name) for name, value in values.items()):
        return None
    if 'answers' in values:
        values['answers'] = values['answers'].replace(' or ', OR)
    return values


def _may_stand(value: str, place: str) -> bool:
    if place in _NAMES:
        is_named = place != 'held' or value.startswith('hold ')
        return is_named and _is_closed(value)
    return bool(value) and (AND not in value or place in _FREE)


def _is_closed(text: str) -> bool:
    """Tell whether each bracket that a text opens is closed in it, and no other one."""
    depth = 0
    for char in text:
        depth += (char == '(') - (char == ')')
        if depth < 0:
            return False
    return bool(text) and not depth


# The sentences as patterns, by how many parts a text has and how it begins: a text of somebody
# else is compared with few of them.

_BEGIN = 3


class _Pattern(NamedTuple):
    kind: str
    pieces: Sequence[tuple[str, str | None]]
    """Each piece of the sentence with the place behind it, the last one without."""
    telling: str
    """The longest piece."""

    @property
    def begin(self) -> str:
        """The characters that it is looked for by; empty: it begins with a place, or nearly."""
        first, _ = self.pieces[0]
        return first[:_BEGIN] if len(first) >= _BEGIN else ''

    @property
    def words(self) -> int:
        """The number of characters of its own."""
        return sum(len(literal) for literal, _ in self.pieces)

    def may_have(self, size: int) -> bool:
        """Tell whether a text of so many parts may be this sentence."""
        own = 1 + sum(literal.count(AND) for literal, _ in self.pieces)
        is_free = any(name in _FREE for _, name in self.pieces)
        return own == size or (own < size and is_free)


def _pattern(kind: str, template: str) -> _Pattern:
    pieces = [(literal, name) for literal, name, _, _ in string.Formatter().parse(template)]
    if pieces[-1][1] is not None:
        pieces.append(('', None))
    return _Pattern(kind, pieces, max((literal for literal, _ in pieces), key=len))


def _by_begin(patterns: Sequence[_Pattern]) -> Mapping[str, Sequence[_Pattern]]:
    """Return the patterns by the first characters of a text; empty: it begins in another way."""
    begins = {'', *(pattern.begin for pattern in patterns)}
    return {begin: [p for p in patterns if p.begin in ('', begin)] for begin in begins}


_ALL = sorted(
    (_pattern(kind, text) for kind, text in SENTENCES.items() if kind != 'said'),
    key=lambda pattern: -pattern.words,
)
_PATTERNS = {
    size: _by_begin([pattern for pattern in _ALL if pattern.may_have(size)])
    for size in range(1, _LONGEST + 1)
}
