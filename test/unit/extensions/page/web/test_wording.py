"""Drawings in the languages of the page: complete, and the same line."""

from __future__ import annotations

import asyncio
import html
import re
from dataclasses import replace

import pytest
from fakes.hand_made_shift import LINE, the_day
from fakes.line import THREE, Line
from fakes.long_line import LONG, long_line
from fakes.page_parts import status_of

from bt_orchestrator.extensions.page.web.scripts.endpoints import Drawings
from bt_orchestrator.extensions.page.web.wording import wordings
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.plant.shifts import PlantReason
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.model.words import AND, sentence
from bt_orchestrator.script.orders.parameter_uses import action_types
from bt_orchestrator.script.orders.plain_order import bound
from bt_orchestrator.store.memory import MemoryRecords, MemoryStore
from bt_orchestrator.view.drawing.account.beside_page import beside_page
from bt_orchestrator.view.drawing.account.page import account_page
from bt_orchestrator.view.drawing.line_state import Mark
from bt_orchestrator.view.report.account.account import account, whole
from bt_orchestrator.view.report.account.named_figures import By
from bt_orchestrator.view.report.beside import beside
from bt_orchestrator.view.report.reading import Reading

GERMAN = wordings()['de']
ENGLISH = re.compile(
    r'\b(the|of|for|is|to|and|by|which|with|not|no|time|item|section|stop|fault|own|attempt'
    r'|planned|made|lost|reason|good|answer|waiting|rejected|from|below|least|trend)\b'
)
SAID = 'cleared the jam'
"""The remark of a person."""


def test_english_wording_drops_program_terms() -> None:
    english = wordings()['en']
    text = 'waiting for section 2 to finish with WO-1/5'
    assert english.wait(Wait(text, WaitKind.TURN, sections=(2,))) == text
    hold = Wait('waiting for an answer to hold 1 (mark: task_result_false)', WaitKind.HOLD, '1')
    assert english.wait(hold) == 'waiting for an answer (hold 1)'
    assert english.failure('task_result_false', '') == 'done, but without success'


@pytest.mark.parametrize(
    ('language', 'words'),
    [
        ('en', 'waiting for answers to holds 1, 2 and 3'),
        ('de', 'wartet auf Antworten auf die Störungen 1, 2 und 3'),
    ],
)
def test_a_wait_for_several_holds_names_all(language: str, words: str) -> None:
    wait = Wait(
        'waiting for answers to holds 1, 2 and 3', WaitKind.HOLD, '1', holds=('1', '2', '3')
    )
    assert wordings()[language].wait(wait) == words


def test_drawing_has_same_parts_in_each_language() -> None:
    line = long_line()
    run = line.begin(LONG)
    run.go(until=2.5)
    script, drawings = run.job().job.script, Drawings()

    async def drawn(language: str, *, is_bare: bool = False) -> str:
        drawing = await drawings.drawn(
            digest(script), script, line.cell, status_of(run), language, is_bare=is_bare
        )
        return drawing.svg.decode()

    english, german = (asyncio.run(drawn(language)) for language in ('en', 'de'))
    assert english == asyncio.run(drawn('en')), 'another language was kept in its place'
    assert 'Legende' in german
    assert 'Legende' not in asyncio.run(drawn('de', is_bare=True))
    parts = r' id="([^"]+)"'
    assert re.findall(parts, english) == re.findall(parts, german)


@pytest.mark.parametrize('kind', WaitKind)
def test_each_wait_is_said(kind: WaitKind) -> None:
    text = GERMAN.wait(Wait('waiting', kind, 'a', (1, 2, 3, 4, 5), 'weld'))
    assert '{' not in text
    assert 'waiting' not in text


def test_wait_names_cell_state_and_counts_sections() -> None:
    complete = Wait('the cell is Complete', WaitKind.CELL_STATE, 'Complete')
    assert GERMAN.wait(complete) == 'die Zelle ist: Alle Aufträge fertig'
    assert GERMAN.wait(Wait('x', WaitKind.CELL_STATE, 'item')) == 'die Linie fährt leer und stoppt'
    many = Wait('x', WaitKind.TURN, sections=(1, 2, 3, 4, 5))
    assert GERMAN.wait(many) == 'wartet auf Station 1, Station 2, Station 3, 2 weitere'


def test_states_and_failures_are_german_server_text_stays() -> None:
    for state in PackmlState:
        assert GERMAN.state(state) != state.value
    for mark in Mark:
        assert GERMAN.mark(mark) != mark.word
    for reason in Reason:
        assert GERMAN.failure(reason.value, '') != reason.value
    assert GERMAN.failure('timeout', 'Too late') == 'hat zu lange gedauert (Too late)'
    assert GERMAN.passed('timeout (Too late)') == 'hat zu lange gedauert (Too late)'
    assert GERMAN.passed('rejected item') == 'das Teil ist Ausschuss'
    assert GERMAN.passed('as somebody said') == 'as somebody said'


def test_engine_messages_are_german_on_german_page() -> None:
    restarted = sentence('unfinished', jobs=1, goals=2)
    assert GERMAN.message(restarted) == 'unfertige Aufträge: 1, laufende Ziele: 2'
    late = sentence('no_end', seconds=5, cause='timeout')
    text = GERMAN.failure('in_doubt', f'{late}; arm is blocked')
    assert 'kein Ende binnen 5 s' in text
    assert 'arm is blocked' in text
    why = 'no reject or abort_job: it is not known whether J/1 was placed in section 2'
    known = 'kein reject oder abort_job: es ist nicht bekannt, ob J/1 in Station 2 eingelegt wurde'
    assert GERMAN.message(why) == known


UNSAFE = [
    ('nothing was heard of it yet', 'von ihm wurde noch nichts gehört'),
    ('no message for 0.5 s', 'seit 0,5 s keine Nachricht'),
    ('its value is False', 'sein Wert ist False'),
    (
        "its value cannot be read: AttributeError('x; y')",
        "sein Wert ist nicht lesbar: AttributeError('x; y')",
    ),
    ('it has no publisher', 'er hat keinen Publisher'),
    (
        'it has 2 publishers: /a, /b (on this computer)',
        'er hat 2 Publisher: /a, /b (on this computer)',
    ),
    (
        'its publisher keeps old messages (transient local)',
        'sein Publisher hält alte Nachrichten vor (transient local)',
    ),
    ('it is False', 'it is False'),  # in journals of older versions
]
"""Why a safety input is not ready."""


@pytest.mark.parametrize(('english', 'german'), UNSAFE)
def test_safety_reasons_are_german_alone_and_in_sentences(english: str, german: str) -> None:
    whole = f'the safety input is not ready: {english}'
    text = f'der Sicherheitseingang ist nicht bereit: {german}'
    assert (GERMAN.message(english), GERMAN.message(whole)) == (german, text)
    assert wordings()['en'].message(whole) == whole
    assert GERMAN.wait(Wait(whole, WaitKind.CELL_STATE, 'Execute')) == text
    assert GERMAN.report(f'safety ({whole})') == f'der Sicherheitseingang fiel aus ({text})'


REFUSALS = [
    (
        'the cell is Stopped; start is for Idle; possible now: reset, pause, resume, abort',
        (
            'die Zelle ist: Gestoppt; „Start“ geht nur bei: Bereit; jetzt möglich: '
            '„Zurücksetzen“, „Pause“, „Fortsetzen“, „Abbruch“'
        ),
    ),
    (
        'WO-1 is Running; Start (release) is for jobs that are NotAllowedToStart',
        'WO-1 ist im Zustand „läuft“; „Freigeben“ geht nur im Zustand zurückgehalten',
    ),
    (
        'WO-1 is aborting already and ends when its last item has left the line',
        (
            'WO-1 ist schon im Zustand „wird abgebrochen“ und endet, wenn das letzte Teil die '
            'Linie verlassen hat'
        ),
    ),
    (
        (
            'WO-1 is not released: its script was generated and is not released for this '
            'cell; release-script aa11 (by an engineer) lets it start in its turn'
        ),
        (
            'WO-1 ist nicht freigegeben: das Skript wurde erzeugt und ist für diese Zelle '
            'nicht freigegeben; „Skript freigeben“ (aa11, durch Techniker) lässt ihn '
            'beginnen, wenn er an der Reihe ist'
        ),
    ),
    (
        'cell.start is refused: the safety input is not ready: it has no publisher',
        (
            '„Start“ wird abgelehnt: der Sicherheitseingang ist nicht bereit: er hat keinen '
            'Publisher'
        ),
    ),
    (
        'a2 gets no goal: it is in doubt; answer hold 1 (mark: in_doubt) first',
        (
            'a2 bekommt keine Aufgabe: es ist unklar, wie weit sie kam; zuerst Störung 1 '
            '(mark: niemand weiß, wie weit es kam) beantworten'
        ),
    ),
    (
        (
            'hold 1 (mark: aborted) can be answered with retry, skip; an engineer may also: '
            "abort_job; found 'fly'"
        ),
        (
            'Antworten auf Störung 1 (mark: der Controller hat abgebrochen): „Noch einmal“, '
            "„Überspringen“; auch möglich für Techniker: „Auftrag abbrechen“; gefunden: 'fly'"
        ),
    ),
    (
        (
            'hold 1 (mark: aborted) has no answer for this role; an operator or an engineer '
            "may: retry; found 'fly'"
        ),
        (
            'Störung 1 (mark: der Controller hat abgebrochen) kann mit dieser Rolle nicht '
            'beantwortet werden; möglich für Bediener oder Techniker: „Noch einmal“; '
            "gefunden: 'fly'"
        ),
    ),
    (
        (
            'no pause is yours; hold 3 (paused, somebody: x; y); the person who paused '
            'resumes, or name the hold to release it for that person'
        ),
        (
            'keine der Pausen ist eine eigene; Störung 3 (pausiert, somebody: x; y); '
            'fortsetzen kann, wer pausiert hat; oder die Pause nennen, um sie für andere '
            'aufzuheben'
        ),
    ),
    (
        'the cell is not paused; it waits for answers to hold 1, hold 2',
        'die Zelle ist nicht pausiert; sie wartet auf Antwort auf Störung 1, Störung 2',
    ),
    (
        (
            'slot 2: the cell believes empty, not WO-1/3; no such item is on the line; take '
            'it off and say empty'
        ),
        (
            'Platz 2: nach Stand der Zelle leer, nicht WO-1/3; ein solches Teil ist nicht auf '
            'der Linie; es herunternehmen und leer angeben'
        ),
    ),
    (
        'there are items on the belt: 1=empty,2=WO-1/3; take them off, each with remove-item',
        (
            'auf dem Band sind Teile: 1=leer,2=WO-1/3; herunternehmen, jedes mit „Teil wurde '
            'entnommen“'
        ),
    ),
    (
        (
            'K is held in the queue; K needs arm and belt_2, which are out of service; 3 more '
            'jobs wait'
        ),
        (
            'K ist in der Warteschlange zurückgehalten; K braucht arm und belt_2, außer Betrieb; '
            '3 weitere Aufträge warten'
        ),
    ),
    (
        'Bread and Butter needs arm, which is out of service; one more job waits',
        'Bread and Butter braucht arm, außer Betrieb; ein weiterer Auftrag wartet',
    ),
    (
        'K needs arm, which is out of service; made anew without arm and oven',
        'K braucht arm, außer Betrieb; neu erzeugt ohne arm und oven',
    ),
    (
        'there is no hold 9; holds now: 1, 2 and 30 more',
        'eine Störung 9 gibt es nicht; jetzt offen: 1, 2 und 30 weitere',
    ),
    (
        'job.move needs position: place in the queue, from 1',
        '„Verschieben“ braucht position: Platz in der Reihe, ab 1',
    ),
    (
        'job of job.move is text (id of the job); found 7',
        'job von „Verschieben“ muss ein Text sein (Nummer des Auftrags); gefunden: 7',
    ),
    (
        (
            'job.move moves the line, which is in local: only its panels may do that, and '
            'somebody who claims to be Bob (ros unauthenticated) is at none; nothing was '
            'done; give control back at a panel with remote; without one, start the node anew '
            'with --control remote'
        ),
        (
            '„Verschieben“ bewegt die Linie, und sie ist auf Lokal: das dürfen nur ihre '
            'Bedientafeln, und Bob (Name ungeprüft) (über ROS, ungeprüft) ist an keiner; es '
            'ist nichts geschehen; die Bedienung an einer Bedientafel mit „Fern“ zurückgeben; '
            'ohne eine den Knoten neu starten, mit --control remote'
        ),
    ),
    (
        (
            '`start` must be a date and time with its time zone, not `noon`; write for '
            'instance 2026-05-18T06:00:00+02:00, or 2026-05-18T04:00:00Z'
        ),
        (
            '`start` muss Datum und Uhrzeit mit Zeitzone sein, nicht `noon`; zum Beispiel '
            '2026-05-18T06:00:00+02:00 oder 2026-05-18T04:00:00Z schreiben'
        ),
    ),
]


ANSWERS = [
    ('hold 3: mark_done', 'Störung 3: „Wurde erledigt“'),
    (
        'still paused: hold 2 (paused, Bob: lunch)',
        'weiterhin pausiert: Störung 2 (pausiert, Bob: lunch)',
    ),
    (
        (
            'WO-1 ends when its items on the line are finished\nWO-1-rest is queued first, with 2 '
            'items, made anew without press: 4.0 s per item (+33 %)\nwhen it has stopped, the '
            'cell waits for reset and start, for Ann (page login) said stop after item: the press'
        ),
        (
            'WO-1 endet, wenn seine Teile auf der Linie fertig sind\nWO-1-rest ist als Erstes '
            'eingereiht, mit 2 Teilen, neu erzeugt ohne press: 4,0 s je Teil (+33 %)\nwenn sie '
            'gestoppt hat, wartet die Zelle auf „Zurücksetzen“ und „Start“, denn Ann (Anmeldung '
            'an der Seite) hat „Nach dem aktuellen Teil“ verlangt: the press'
        ),
    ),
]


@pytest.mark.parametrize(('english', 'german'), [*REFUSALS, *ANSWERS])
def test_answers_are_german_with_button_labels(english: str, german: str) -> None:
    assert GERMAN.message(english) == german


def test_refusals_name_the_buttons_of_an_english_page() -> None:
    message, text = 'cell.reset needs a reason', '“Reset” needs a reason'
    rest = ', for the record; nothing was done'
    assert wordings()['en'].message(f'{message}{rest}') == f'{text}{rest}'


def test_reasons_of_unknown_ends_are_german() -> None:
    line = Line()
    run = line.begin(THREE, 3)
    run.submit('K', line.script(THREE), 2)
    run.control('hold', 'K')
    run.go(until=1.0)
    run.service('a2', out=True)
    why = run.sim.status().jobs[1].end_unknown
    held = 'K ist in der Warteschlange zurückgehalten'
    assert GERMAN.message(why) == f'{held}; K braucht a2, außer Betrieb'
    for english, german in (
        ('J waits for the approval of J/1', 'J wartet auf die Freigabe von J/1'),
        (
            'waiting for an answer to hold 1 (work: aborted)',
            'wartet auf Antwort auf Störung 1 (work: der Controller hat abgebrochen)',
        ),
        (
            'waiting for answers to holds 1, 2 and 3',
            'wartet auf Antwort auf die Störungen 1, 2 und 3',
        ),
    ):
        assert GERMAN.message(english) == german


@pytest.mark.parametrize(
    ('words', 'german'),
    [
        ('${results.a.x} from 4.8 to ${params.most}', '${results.a.x} von 4.8 bis ${params.most}'),
        ('when ${results.a.x} at least 5', 'wenn ${results.a.x} mindestens 5'),
        ('unless ${results.a.b} is not 3', 'außer ${results.a.b} nicht 3'),
        ('(${a} at most 5 and ${b}) or ${c} = 2', '(${a} höchstens 5 und ${b}) oder ${c} = 2'),
        ('${results.a.x} one of 1, 2', '${results.a.x} eines von 1, 2'),
    ],
)
def test_conditions_are_said_and_their_values_stay(words: str, german: str) -> None:
    assert GERMAN.condition(words) == german
    assert wordings()['en'].condition(words) == words


def test_mistakes_of_an_order_are_german() -> None:
    line = Line()
    params = 'params: {n: {type: int}, lot: {type: str}, hot: {type: bool}}\n'
    script = line.script(params + THREE)
    order = {
        'script': 'made',
        'quantity': 0,
        'start': '2026-05-18T06:00:00Z',
        'due': '2026-05-17T06:00:00Z',
        'params': {'n': '7x', 'hot': 3},
    }
    wrong = bound(order, script, action_types(line.cell, line.types))
    assert not isinstance(wrong, Job)
    texts = {mistake.field: GERMAN.message(f'{mistake.what}; {mistake.hint}') for mistake in wrong}
    assert texts == {
        'quantity': '`quantity` muss mindestens 1 sein, nicht die Zahl 0; zum Beispiel '
        '`quantity: 12` schreiben',
        'due': 'das späteste Ende liegt vor dem Beginn; ist eine der Zeiten aus einer anderen '
        'Zeitzone?',
        'params.n': 'der Parameter `n` muss eine ganze Zahl (int) sein, nicht der Text `7x`; '
        'eine ganze Zahl ohne Anführungszeichen schreiben',
        'params.lot': 'der Parameter `lot` fehlt; `lot` angeben, vom Typ str',
        'params.hot': 'der Parameter `hot` muss true oder false (bool) sein, nicht die Zahl 3; '
        'true oder false ohne Anführungszeichen schreiben',
    }


def test_what_a_verdict_expected_is_german() -> None:
    text = sentence('refused_result', wanted='${results.a.x} at least 5', found='4.2')
    assert GERMAN.message(text) == 'erwartet: ${results.a.x} mindestens 5; gefunden: 4.2'


@pytest.mark.parametrize(
    ('name', 'german'),
    [
        ('section 12', 'Station 12'),
        ('flag camera_read < 3', 'Flag camera_read < 3'),
        ('up to 1 more round', 'bis zu 1 weitere Runde'),
        ('up to 2 more rounds', 'bis zu 2 weitere Runden'),
        ('retry up to 2 times', 'bis zu 2 neue Versuche'),
        (
            'fails unless ${results.a.x} from 4 to 5',
            'misslingt, außer: ${results.a.x} von 4 bis 5',
        ),
        ('when ${a} at least 2', 'wenn ${a} mindestens 2'),
        ('unless ${a}', 'außer ${a}'),
        ('flag (TASK_A)', 'flag (TASK_A)'),
        ('WO-1', 'WO-1'),
    ],
)
def test_behaviour_names_are_german_task_names_stay(name: str, german: str) -> None:
    assert GERMAN.twig(name) == german
    assert wordings()['en'].twig(name) == name


@pytest.mark.parametrize(
    ('message', 'german'),
    [
        ('', ''),
        ('WO-1/2', 'WO-1/2'),
        ('round 2, attempt 3', 'Runde 2, Versuch 3'),
        ('attempt 2; running at /arm/task', 'Versuch 2; läuft bei /arm/task'),
        ('failed: timeout', 'fehlgeschlagen: hat zu lange gedauert'),
        ('waiting for b, c; attempt 2', 'wartet auf b und c; Versuch 2'),
    ],
)
def test_messages_of_behaviours_are_german(message: str, german: str) -> None:
    waits = {'waiting for b, c': 'wartet auf b und c'}
    assert GERMAN.twig_message(message, waits) == german


def test_english_behaviour_messages_have_no_program_terms() -> None:
    assert wordings()['en'].twig_message('failed: timeout', {}) == 'failed: took too long'


def test_what_rejects_have_in_common_is_german() -> None:
    facts = ('${results.weigh.measurement} at least 1', 'result_refused')
    text = AND.join(
        [
            sentence('rejects', count=3, of=10, items='J/1, J/3, J/4'),
            sentence('rejects_reason', reason=facts[1]),
            sentence('rejects_verdict', wanted=facts[0]),
        ]
    )
    assert GERMAN.message(text) == (
        'Ausschuss 3 innerhalb von 10 Teilen: J/1, J/3, J/4; jedes Mal: das Ergebnis ist nicht, '
        'wie es sein muss; jedes Mal erwartet: ${results.weigh.measurement} mindestens 1'
    )


@pytest.mark.parametrize(
    ('english', 'german'),
    [
        ('OEE', 'OEE'),
        ('56.8 %', '56,8 %'),
        ('-0:08:30', '-0:08:30'),
        ('22.0 s', '22,0 s'),
        ('+3.1 points', '+3,1 Punkte'),
        ('-', '-'),
        ('- own fault', '- eigene Störung'),
        ('    waiting for an answer', '    wartet auf Antwort'),
        ('own fault, a2, TASK_A timeout', 'eigene Störung, a2, TASK_A: hat zu lange gedauert'),
        ('a2, a3 not ready', 'a2, a3 nicht bereit'),
        ('retry by ann', '„Noch einmal“ von ann'),
        ('resume by ann', '„Fortsetzen“ von ann'),
        ('paused (ann: lunch)', 'pausiert (ann: lunch)'),
        ('the cell was stopped', 'die Zelle wurde gestoppt'),
        (
            'orders waited for 0:10:00: held in the queue',
            'Aufträge warteten 0:10:00: in der Warteschlange angehalten',
        ),
        (
            'section 2, work (TASK_A) of J/1 at a2 (/a2/do), attempt 1 of 1: timeout (jam)',
            (
                'Station 2, work (TASK_A) von J/1 an a2 (/a2/do), Versuch 1 von 1: '
                'hat zu lange gedauert (jam)'
            ),
        ),
        (
            '05-18 07:00:00, 0:20:00: section 2, J/1: too_many_rejects (all of job J)',
            '05-18 07:00:00, 0:20:00: Station 2, J/1: zu viel Ausschuss (immer Auftrag J)',
        ),
        (
            'weigh at a2 result_refused (${results.weigh.x} at least 1), by the script',
            (
                'weigh an a2: das Ergebnis ist nicht, wie es sein muss '
                '(${results.weigh.x} mindestens 1), durch das Skript'
            ),
        ),
        (
            'best Wed 05-20 (63.0 %), worst Mon 05-18 (56.8 %)',
            'am besten Mi 05-20 (63,0 %), am schlechtesten Mo 05-18 (56,8 %)',
        ),
        ('WO-1', 'WO-1'),
    ],
)
def test_words_of_a_report_are_german(english: str, german: str) -> None:
    assert GERMAN.report(english) == german
    assert wordings()['en'].report(english) == english


REASONS = {'JAM': PlantReason('JAM', {'en': 'material jam', 'de': 'Materialstau'}, 'Material')}


def test_a_german_report_has_no_english_words() -> None:
    """Of a day with every loss, a stop of which has a reason; names and remarks stay."""
    day, store = the_day(), MemoryStore('x')
    (hold,) = (fact for fact in day.events if isinstance(fact, e.HoldRaised) and fact.hold == '1')
    day.note('13:59', e.OperatorDecided(
        answer='classify', code='JAM', stop=f'x:{hold.seq + 1}', who='ann', reason='',
    ))  # fmt: skip
    store.append(day.events)
    reading = Reading(MemoryRecords(store), pytest.fail)
    period = replace(whole(reading, 'J'), reasons=REASONS)
    made = account(reading, replace(period, name='shift early of 2026-05-18'), LINE.cell)
    days = [
        (f'Mon 05-{number}', replace(period, name=f'2026-05-{number}')) for number in (18, 19, 20)
    ]
    report = beside(reading, days, LINE.cell)
    sheets = [account_page(made, GERMAN)]
    sheets += [beside_page(report, by, GERMAN) for by in (None, *By)]
    for sheet in sheets:
        assert '<html lang="de">' in sheet
        text = re.sub(r'<style>.*?</style>', '', sheet, flags=re.DOTALL)
        lines = map(html.unescape, re.findall(r'>([^<>]+)<', text))
        assert not [line for line in lines if ENGLISH.search(line) and SAID not in line]
    assert 'Materialstau' in sheets[0]
    assert 'Materialstau' in sheets[1]
