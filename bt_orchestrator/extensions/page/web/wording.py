"""Words in the languages of the page, from the same files as all its words."""

from __future__ import annotations

import json
import re
import string
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import Any

from bt_orchestrator.model.hold_words import why_words
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.model.words import facts_of, text_of
from bt_orchestrator.view.drawing.line_state import Mark
from bt_orchestrator.view.drawing.wording import Wording

_STRINGS = Path(__file__).parent / 'static' / 'strings'

_FEW = 3
"""Of more sections than these only their number is said."""

_OF_HOLDS = (WaitKind.HOLD, WaitKind.PAUSE)

_NAMED = {
    WaitKind.JOB: ('name', 'job_named'),
    WaitKind.COMPONENT: ('task', 'component_task'),
    WaitKind.ZONE: ('task', 'zone_task'),
}
"""Kinds of waits that say more when they name somebody."""

_SKIPPED = 'skip_'

_LONG = r'[-\N{MINUS SIGN}]?\d[\d:.]*(?: s)?|-'

_PLACES: Mapping[str, str] = {
    'number': r'\d+',
    'reason': r'\w+',
    'bound': r'.+ [<>].*',
    **dict.fromkeys(('among', 'hourly'), r'[\d.]+'),
    **dict.fromkeys(('work', 'piece', 'spot', 'person', 'device', 'names', 'others'), r'[^,]+'),
    'reply': r'\w+',
    **dict.fromkeys(('long', 'whole_long'), _LONG),
    **dict.fromkeys(('share', 'second_share'), r'[-+]?[\d.]+ %|-'),
    'moment': r'[\d: -]+',
    **dict.fromkeys(('begin_day', 'end_day'), r'\d{4}-\d\d-\d\d.*?'),
    **dict.fromkeys(('action', 'value', 'low', 'high'), r'\S+'),
}
"""Patterns of what stands in a place of the node's English; elsewhere it is anything."""

_FIGURE = re.compile(r'[-+\N{MINUS SIGN}]?[\d:.]+(?: s| %| points)?')
_HELD = re.compile(r'(?:(?P<what>.*?): )?(?P<reason>\w+)(?: \((?P<message>.*)\))?')
"""A held part, with the reason."""
_INDENT = re.compile(r'(- | +)?(.*)', re.DOTALL)
_NUMBER = '0.5'
"""Key of the way in which a number is written."""
_NESTED = ('cause', 'figure', 'held')
"""Places of words in those of a report."""

_BETWEEN, _AND = '; ', ', '
"""Between the sentences of a message in the behaviour tree; between the parts of one."""

_CONDITIONS = ('wanted', 'condition')
"""Places of a condition in sentences of the node."""

_GROUPS: Mapping[str, str] = {
    **{group: group for group in ('reason', 'state', 'role', 'job_state')},
    **dict.fromkeys(('known', 'kind', 'control', 'door', 'left', 'person', 'way'), 'place'),
    **dict.fromkeys(('jobs', 'others', 'holds', 'items', 'components', 'scripts'), 'place'),
}
"""Places of a word of the node, with the group that says it."""

_BUTTONS: Mapping[str, str] = {'request': '', 'verb': 'cell.', 'answer': 'hold.', 'method': 'job.'}
"""Places of a request, with what precedes its word there."""

_SEVERAL: Mapping[str, tuple[str, str]] = {
    'states': (' or ', 'state'),
    'roles': (' or ', 'role'),
    'job_states': (' or ', 'job_state'),
    'people': (' or ', 'person'),
    'verbs': (', ', 'verb'),
    'replies': (', ', 'answer'),
    'named_holds': (', ', 'hold_name'),
}
"""Places of several things: what stands between them, and the place that one would have."""

_JOINED = ('components', 'names')
"""Places of names of components, which have no space."""

_SLOTS = ('belt', 'content', 'stated')
_EMPTY_SLOT = re.compile(r'(?<![^=])empty(?![^,])')
_CLAIMED = re.compile('somebody who claims to be (.+)')
_KNOWN_AS = re.compile(r'(.+) \(([a-z ]+)\)')
_UNNAMED = ('somebody', 'this sender')
_AND_MORE = re.compile('(.+) and ([0-9]+) more')
_VERB_OF = re.compile(r'.*\((.+)\)')
"""The verb in the title of a method."""


@cache
def wordings() -> Mapping[str, PageWording]:
    """Return the words of each language of the page."""
    by_language: dict[str, PageWording] = {}
    for path in sorted(_STRINGS.glob('*.json')):
        words = json.loads(path.read_text(encoding='utf-8'))
        kind = EnglishWording if path.stem == 'en' else PageWording
        by_language[path.stem] = kind(words, path.stem)
    return by_language


@cache
def _patterns(group: str) -> Sequence[tuple[str, re.Pattern[str]]]:
    """Return how the node's English is read, by key: the English words of the page say it."""
    english = json.loads((_STRINGS / 'en.json').read_text(encoding='utf-8'))[group]
    return [
        (key, re.compile(_pattern(form)))
        for key, words in english.items()
        for form in (words.values() if isinstance(words, dict) else [words])
    ]


def _pattern(words: str) -> str:
    """Return the pattern of a sentence; words behind a space may stand anywhere in one."""
    pieces = (
        re.escape(literal) + (f'(?P<{name}>{_PLACES.get(name, ".+")})' if name else '')
        for literal, name, _, _ in string.Formatter().parse(words)
    )
    return f'{"" if words.startswith(" ") else "^"}{"".join(pieces)}'


@lru_cache(maxsize=4096)
def _read(group: str, english: str) -> tuple[str, Mapping[str, str]] | None:
    """Return which words of a group these are, and what stands in their places."""
    matches = ((key, pattern.fullmatch(english)) for key, pattern in _patterns(group))
    return next(((key, match.groupdict()) for key, match in matches if match), None)


def said_in_each(message: str) -> dict[str, str]:
    """Return a message of the node by language; see `PageWording.message`."""
    return {name: words.message(message) for name, words in wordings().items()}


class PageWording(Wording):
    """A language whose words stand in a file of the page."""

    def __init__(self, strings: Mapping[str, Mapping[str, Any]], language: str) -> None:
        """Take the words, by group and name; those of drawings and reports by their English."""
        self._strings = strings
        self.language = language
        self._point = strings['report'][_NUMBER][1]

    def say(self, words: str, /, **values: object) -> str:
        """Return words of the drawing, with values in the places in braces."""
        return str(self._strings['drawing'][words].format(**values))

    def mark(self, mark: Mark) -> str:
        """Return the word of a mark."""
        return self._word('mark', mark.name.lower())

    def state(self, state: PackmlState) -> str:
        """Name a state of the cell."""
        return self._word('state', state.value)

    def job_state(self, state: str) -> str:
        """Name a state of a job."""
        return self._word('job_state', state)

    def wait(self, wait: Wait, task: str = '', reason: str = '') -> str:
        """Say what something waits for.

        :param task: that is held, if one is waited for
        :param reason: why it is held
        """
        if wait.kind is WaitKind.CELL_STATE:
            is_known = facts_of(wait.reason)
            return self.message(wait.reason) if is_known else self._cell_state(wait.name)
        if wait.holds:
            *others, last = wait.holds
            names = f'{", ".join(others)} {self._word("stands", "and")} {last}'
            return self._word('wait', 'holds').format(names=names)
        if task and wait.kind in _OF_HOLDS:
            why = self._word('reason', reason)
            return self._word('wait', 'hold_of').format(name=wait.name, task=task, reason=why)
        kind, sections = wait.kind.value, self._sections(wait.sections)
        by, key = _NAMED.get(wait.kind, ('', kind))
        if by and not getattr(wait, by):
            key = kind
        holder = ', '.join(filter(None, (wait.task, sections)))
        values = {'name': wait.name, 'task': wait.task, 'sections': sections, 'holder': holder}
        return self._word('wait', key).format(**values)

    def message(self, message: str) -> str:
        """Say a message of the node, which is in English."""
        if len(lines := message.split('\n')) > 1:
            return '\n'.join(map(self.message, lines))
        known = self._strings['message']
        return text_of(facts_of(message), message, known, known['or'], self._in_words)

    def _in_words(self, values: Mapping[str, str]) -> Mapping[str, str]:
        """Return what stands in the places of a sentence, where it is words of the node."""
        worded = {name: self._at(name, value) for name, value in values.items()}
        if 'meaning' in values:
            by_subject = self._word('parameter', values['parameter'], values['meaning'])
            name = f'{values["request"]}.{values["parameter"]}'
            worded['meaning'] = self._word('parameter', name, by_subject)
        return worded

    def _at(self, place: str, value: str) -> str:
        if place == 'hold_name':
            return self.message(value)
        if place in _SEVERAL:
            between, kind = _SEVERAL[place]
            parts = [self._at(kind, part) for part in value.split(between)]
            return between.replace('or', self._word('message', 'or')).join(parts)
        if place in _CONDITIONS:
            return self.condition(value)
        if place in _SLOTS:
            return _EMPTY_SLOT.sub(self._word('place', 'empty'), value)
        if place in _BUTTONS:
            return self._button(_BUTTONS[place], value)
        if place == 'who':
            return self._who(value)
        if place == 'seconds':
            return value.replace('.', self._point)
        if place in _JOINED and not _AND_MORE.fullmatch(value):
            value = value.replace(' and ', f' {self._word("stands", "and")} ')
        return self._listed(_GROUPS[place], value) if place in _GROUPS else value

    def _button(self, before: str, value: str) -> str:
        titled = _VERB_OF.fullmatch(value) if before == _BUTTONS['method'] else None
        name = f'{before}{titled[1] if titled else value}'
        word = self._word('word', name.lower().replace(' ', '_') if before else name, '')
        return self._word('unit', 'quoted').format(words=word) if word else value

    def _who(self, value: str) -> str:
        if claimed := _CLAIMED.fullmatch(value):
            return self._word('login', 'claims').format(name=claimed[1])
        if known := _KNOWN_AS.fullmatch(value):
            return f'{known[1]} ({self._word("place", known[2])})'
        return self._word('place', value) if value in _UNNAMED else value

    def _listed(self, group: str, value: str) -> str:
        """Return a word, or names, which stay."""
        if group == 'place' and (listed := _AND_MORE.fullmatch(value)):
            return self._word('place', 'more').format(names=listed[1], count=listed[2])
        return self._word(group, value)

    def report(self, words: str) -> str:
        """Say words, or a figure, of a report, which are in English."""
        indent, words = _INDENT.fullmatch(words).groups('')  # type: ignore[union-attr]
        return f'{indent}{self._report(words)}'

    def _report(self, english: str) -> str:
        if _FIGURE.fullmatch(english):
            number, _, unit = english.partition(' ')
            return ' '.join(
                filter(None, (number.replace('.', self._point), self._word('report', unit)))
            )
        if (known := _read('report', english)) is not None:
            key, values = known
            worded = {name: self._place(name, value) for name, value in values.items()}
            return str(self._strings['report'][key].format(**worded))
        held = _HELD.fullmatch(english)
        if held is not None and held['reason'] in self._strings['reason']:
            head = f'{self._report(held["what"])}: ' if held['what'] else ''
            return head + self.failure(held['reason'], held['message'] or '')
        parts = english.split(_AND)
        if len(parts) > 1:
            return _AND.join(map(self._report, parts))
        task, _, reason = english.rpartition(' ')
        if not task:
            return self._word('reason', english)
        word = self._word('reason', reason)
        return english if word == reason else f'{task}: {word}'

    def _place(self, name: str, value: str) -> str:
        if name in _NESTED:
            return self._report(value)
        if name == 'reply':
            return self.answer(value)
        if name == 'limits':
            return self.condition(value)
        if name in ('reason', 'state'):
            return self._word(name, value)
        return self._report(value) if _FIGURE.fullmatch(value) else value

    def condition(self, words: str) -> str:
        """Say a condition, which is in English; its names and values stay."""
        known = self._strings['condition']
        for name, pattern in _patterns('condition'):
            words = pattern.sub(partial(_said, known[name]), words)
        return words

    def twig(self, name: str) -> str:
        """Name a behaviour; names of tasks, jobs and topics stay."""
        return self._twig('twig', name)

    def twig_message(self, message: str, waits: Mapping[str, str]) -> str:
        """Say the message of a behaviour.

        :param waits: the sentences of the waits of now, by the node's
        """
        if message in waits:  # it may have several parts itself
            return waits[message]
        return _BETWEEN.join(
            waits.get(sentence) or _AND.join(self._messages(sentence))
            for sentence in message.split(_BETWEEN)
        )

    def failure(
        self, reason: str, message: str, controller_said: str = '', topic_says: str = ''
    ) -> str:
        """Say why something failed."""
        given = {'controller_says': controller_said, 'topic_says': topic_says}
        controller, topic = (
            self._word('reason', key).format(words=words) if words else ''
            for key, words in given.items()
        )
        words = '; '.join(filter(None, (controller, self.message(message), topic)))
        return why_words(self._word('reason', reason), words)

    def passed(self, reason: str) -> str:
        """Say why a task was skipped, or failed while the cycle goes on."""
        skipped = self._strings['item'].get(f'{_SKIPPED}{reason.replace(" ", "_")}')
        if skipped is not None:
            return str(skipped)
        word, _, message = reason.partition(' (')
        return self.failure(word, message.removesuffix(')'))

    def hold(self, hold: Hold) -> str:
        """Name a hold."""
        name = self._word('chain', 'hold').format(name=hold.id)
        why = self.failure(hold.reason, hold.message, hold.controller_said, hold.topic_says)
        return f'{name} ({why})'

    def answer(self, word: str) -> str:
        """Name an answer to a hold."""
        return self._word('word', f'hold.{word}', self._word('word', f'cell.{word}', word))

    def _messages(self, sentence: str) -> Iterator[str]:
        for part in sentence.split(_AND):
            yield self._twig('twig_message', part)

    def _twig(self, group: str, english: str) -> str:
        if (known := _read(group, english)) is None:
            return english
        key, values = known
        words = self._strings[group][key]
        if not isinstance(words, str):
            words = words['one' if values['number'] == '1' else 'other']
        return str(words.format(**self._in_words(values)))

    def _cell_state(self, name: str) -> str:
        if name in ('item', 'job'):
            return self._word('wait', 'stop_after')
        return self._word('wait', 'cell_state').format(name=self._word('state', name))

    def _sections(self, numbers: tuple[int, ...]) -> str:
        pattern = self._word('part', 'section')
        named = [pattern.format(number=number) for number in numbers[:_FEW]]
        if (more := len(numbers) - len(named)) > 0:
            plural = self._strings['wait']['more_sections']
            named.append(plural['one' if more == 1 else 'other'].format(count=more))
        return ', '.join(named)

    def _word(self, group: str, name: str, otherwise: str | None = None) -> str:
        """Return a word; an unknown one stays unchanged."""
        return str(self._strings[group].get(name, name if otherwise is None else otherwise))


def _said(words: str, match: re.Match[str]) -> str:
    return words.format(**match.groupdict())


class EnglishWording(PageWording):
    """English as the page has it: without the words of programs, such as reasons of holds."""

    def report(self, words: str) -> str:
        """Say words of a report: they are in English."""
        return words

    def wait(self, wait: Wait, task: str = '', reason: str = '') -> str:
        """Say what something waits for: in the node's sentence, if it is short and of no hold."""
        is_own = wait.kind in _OF_HOLDS or len(wait.sections) > _FEW
        return super().wait(wait, task, reason) if is_own else wait.reason
