"""Every word of the page stands in both languages, is used, and says what the table says."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from fakes.page_files import LANGUAGES, STATIC, keys_asked_for, modules, words

from bt_orchestrator.model.by import Role
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.requests import REQUESTS
from bt_orchestrator.model.stop_reason import NAMED, PAUSED, StopReason
from bt_orchestrator.model.wait import WaitKind
from bt_orchestrator.model.words import SENTENCES
from bt_orchestrator.view.drawing import card, line, mark

DRAWING = 'drawing.'
OF_THE_NODE = ('wait.', 'message.', 'condition.', 'twig.', 'twig_message.', 'report.', 'place.')
"""Words that the page has from its node (`extensions/page/web/wording.py`)."""
DRAWINGS = Path(card.__file__).parent


def test_both_languages_have_the_same_keys() -> None:
    assert words('en').keys() == words('de').keys()


def test_placeholders_match_in_both_languages() -> None:
    for key, text in words('en').items():
        assert _places(text) == _places(words('de')[key]), key


def test_every_key_that_is_asked_for_exists() -> None:
    known = words('en')
    for path, key in keys_asked_for():
        stem = key.removesuffix('${')
        hit = any(word.startswith(stem) for word in known) if key.endswith('${') else key in known
        assert hit, f'{path.name} asks for {key}'


def test_every_key_is_used() -> None:
    source = '\n'.join(path.read_text(encoding='utf-8') for path in modules())
    stems = tuple(key.removesuffix('${') for _, key in keys_asked_for() if key.endswith('${'))
    unused = [
        key
        for key in words('en')
        if f"'{key}'" not in source and not key.startswith((*stems, DRAWING, *OF_THE_NODE))
    ]
    assert unused == []


def test_drawing_texts_are_keyed_by_their_english() -> None:
    pairs = words('en').items()
    known = {key.removeprefix(DRAWING): text for key, text in pairs if key.startswith(DRAWING)}
    assert known == {key: key for key in known}
    assert known.keys() == {*_said(), *_tables()}


def _said() -> Iterator[str]:
    """Yield all words that the drawing says, but those of tables."""
    for path in DRAWINGS.glob('*.py'):
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
            match node:
                case ast.Call(func=func, args=[ast.Constant(value=str(said)), *_]):
                    if ast.unparse(func).endswith('say'):
                        yield said


def _tables() -> Iterator[str]:
    yield from (card.OFF_BELT, card.NEEDS_NO_BELT, card.AT_REST, mark.NOT_BEGUN)
    yield from (*card.POLICY.values(), *card.RUNS_FOR.values(), *mark.MEANINGS.values())
    yield from (line.INITIALIZATION, line.BELT_MOVES, line.GROUP)
    yield from (line.FLAG_IS, line.FLAG_SET, line.FLAG_TAKEN)


def test_requests_have_texts_in_all_languages() -> None:
    english = words('en')
    for language in LANGUAGES:
        known = words(language)
        for name, request in REQUESTS.items():
            assert {f'word.{name}', f'effect.{name}'} <= known.keys()
            for parameter in request.parameters:
                if parameter is not request.subject:
                    assert f'parameter.{name}.{parameter.name}' in known
    assert {name: english[f'effect.{name}'] for name in REQUESTS} == {
        name: request.effect for name, request in REQUESTS.items()
    }


def test_states_reasons_roles_and_waits_have_words() -> None:
    known = words('de').keys()
    assert {f'state.{state.value}' for state in PackmlState} <= known
    assert {f'stop_reason.{reason.value}' for reason in StopReason} <= known
    assert {f'role.{role.value}' for role in Role} <= known
    assert {f'wait.{kind.value}' for kind in WaitKind} <= known
    reasons = {*NAMED, PAUSED, *(reason.value for reason in Reason)}
    assert {f'reason.{reason}' for reason in reasons} <= known


def test_node_sentences_match_the_node_catalogue() -> None:
    english = {key: text for key, text in words('en').items() if key.startswith('message.')}
    assert english.pop('message.or') == 'or'
    assert english == {f'message.{kind}': text for kind, text in SENTENCES.items()}


def test_english_and_german_texts_are_not_mixed() -> None:
    assert not [key for key, text in words('en').items() if re.search('[äöüß]', str(text))]
    same = [key for key, text in words('en').items() if ' ' in str(text)]
    assert [key for key in same if words('de')[key] == words('en')[key] and _is_prose(key)] == []


def test_languages_are_those_of_the_modules() -> None:
    source = (STATIC / 'core' / 'text.js').read_text(encoding='utf-8')
    assert all(f'{language}:' in source for language in LANGUAGES)


def _places(text: object) -> set[str]:
    if isinstance(text, dict):
        return {place for value in text.values() for place in _places(value)}
    return set(re.findall(r'\{(\w+)\}', str(text)))


def _is_prose(key: str) -> bool:
    text = re.sub(r'\{\w+\}', '', str(words('en')[key]))
    return len(re.findall(r'[A-Za-z]{3,}', text)) > 1
