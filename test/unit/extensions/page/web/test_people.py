"""Logins, sessions that end and lock, and who somebody is without a login."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fakes.browser import Browser
from fakes.page_bench import ROLES, PeopleBench, log_in
from fakes.quick_users import PASSWORD, write_users

from bt_orchestrator.extensions.page.web import endpoint
from bt_orchestrator.extensions.page.web.access import IDLE_S, SESSION_S
from bt_orchestrator.extensions.page.web.people import MOST_OF_ONE, MOST_UNLOCKS
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.requests import TABLE
from bt_orchestrator.script.users.logins import FREE_ATTEMPTS, MOST_WAITING


@pytest.fixture
def benches() -> Iterator[list[PeopleBench]]:
    made: list[PeopleBench] = []
    yield made
    for bench in made:
        bench.close()


@pytest.fixture
def bench(tmp_path: Path, benches: list[PeopleBench]) -> PeopleBench:
    benches.append(PeopleBench(tmp_path))
    return benches[0]


def who(browser: Browser) -> str:
    name: str = browser.get('/api/me').json['name']
    return name


# --- login ----------------------------------------------------------------------------------


def test_login_sets_cookie_hidden_from_scripts(bench: PeopleBench) -> None:
    browser = bench.browser()
    answer = log_in(browser, 'ann')
    assert answer.json['name'] == 'ann'
    assert answer.json['role'] == 'operate'
    assert answer.json['how'] == 'page login'
    (cookie,) = answer.set_cookies
    assert {'HttpOnly', 'SameSite=strict', 'Path=/'} <= set(cookie.split('; '))
    assert 'Secure' not in cookie
    assert who(browser) == 'ann'
    assert who(bench.browser()) == ''


def test_under_tls_the_cookie_stays_there(tmp_path: Path, benches: list[PeopleBench]) -> None:
    bench = PeopleBench(tmp_path, certificate=tmp_path, key=tmp_path)
    benches.append(bench)
    (cookie,) = log_in(bench.browser(scheme='https'), 'ann').set_cookies
    assert 'Secure' in cookie.split('; ')


def test_what_one_may_comes_from_the_table(bench: PeopleBench) -> None:
    for name, role in ROLES.items():
        may = bench.logged_in(name).get('/api/me').json['may']
        assert may == {request.name: role in request.roles for request in TABLE}
    assert not any(bench.browser().get('/api/me').json['may'].values())


def test_wrong_password_and_unknown_name_look_alike(bench: PeopleBench) -> None:
    wrong = log_in(bench.browser(), 'ann', 'another one')
    unknown = log_in(bench.browser(), 'nobody')
    assert (wrong.status, wrong.body) == (unknown.status, unknown.body)
    assert wrong.status == 401
    assert not wrong.set_cookies


@pytest.mark.parametrize('body', [{}, {'name': 'ann'}, {'name': 1, 'password': PASSWORD}])
def test_a_login_without_texts(bench: PeopleBench, body: object) -> None:
    assert bench.browser().post('/api/login', body).status == 422


def test_guesses_must_wait(bench: PeopleBench) -> None:
    browser = bench.browser()
    for _ in range(FREE_ATTEMPTS):
        assert log_in(browser, 'ann', 'another one').status == 401
    answer = log_in(browser, 'ann')
    assert answer.status == 429, 'the right password as well: or a guess could be told from it'
    assert answer.json['wait_s'] == 1
    assert answer.headers['retry-after'] == '1'
    assert 'try again in 1 s' in answer.message
    bench.now += 1.0
    assert log_in(browser, 'ann').status == 200


def test_simultaneous_guesses_are_counted_at_once(bench: PeopleBench) -> None:
    browser = bench.browser()

    async def at_once() -> list[int]:
        guesses = [
            browser.posted('/api/login', {'name': 'ann', 'password': f'guess {number:04}'})
            for number in range(MOST_WAITING + 12)
        ]
        return [answer.status for answer in await asyncio.gather(*guesses)]

    statuses = bench.loop.run_until_complete(at_once())
    assert statuses.count(401) == FREE_ATTEMPTS
    assert set(statuses) == {401, 429}


def test_passwords_are_checked_one_at_a_time(bench: PeopleBench) -> None:
    assert bench.people._logins._checks._max_workers == 1


def test_a_new_login_ends_the_session_before(bench: PeopleBench) -> None:
    browser = bench.logged_in('ann')
    old = dict(browser.cookies)
    assert log_in(browser, 'eve').status == 200
    assert who(browser) == 'eve'
    assert who(bench.browser(cookies=old)) == ''


def test_logout_ends_it_for_good(bench: PeopleBench) -> None:
    browser = bench.logged_in('ann')
    old = dict(browser.cookies)
    assert browser.post('/api/logout').json['name'] == ''
    assert not browser.cookies
    assert who(bench.browser(cookies=old)) == ''


def test_one_user_has_so_many_sessions(bench: PeopleBench) -> None:
    browsers = [bench.logged_in('ann') for _ in range(MOST_OF_ONE + 1)]
    assert [who(browser) for browser in browsers] == ['', *['ann'] * MOST_OF_ONE]


# --- the end, and the lock ------------------------------------------------------------------


def test_a_session_ends(bench: PeopleBench) -> None:
    browser = bench.logged_in('ann')
    bench.now += SESSION_S - 1
    assert who(browser) == 'ann'
    bench.now += 1
    assert who(browser) == ''


def test_a_session_that_nobody_uses_locks(bench: PeopleBench) -> None:
    browser = bench.logged_in('ann')
    bench.now += IDLE_S - 1
    assert browser.get('/api/me').json['idle_s'] == 1.0
    assert not browser.get('/api/me').json['is_locked']
    bench.now += 1
    locked = browser.get('/api/me').json
    assert (locked['is_locked'], locked['name']) == (True, 'ann')


def test_only_user_activity_keeps_session_open(bench: PeopleBench) -> None:
    browser = bench.logged_in('ann')
    bench.now += IDLE_S - 1
    browser.get('/api/look')
    assert browser.post('/api/active').json['idle_s'] == IDLE_S
    bench.now += IDLE_S - 1
    assert not browser.get('/api/me').json['is_locked']
    browser.get('/api/look')
    bench.now += 1
    assert browser.post('/api/active').json['is_locked'], 'no sign of life unlocks it'


def test_whatever_is_posted_keeps_it_open(bench: PeopleBench) -> None:
    browser = bench.logged_in('ann')
    bench.now += IDLE_S - 1
    assert browser.post('/api/echo').status == 200
    assert browser.get('/api/me').json['idle_s'] == IDLE_S


def test_password_alone_unlocks_session(bench: PeopleBench) -> None:
    browser = bench.logged_in('ann')
    assert browser.post('/api/lock').json['is_locked']
    refused = browser.post('/api/unlock', {'password': 'another one'})
    assert (refused.status, refused.message) == (401, 'this is not the password')
    assert browser.get('/api/me').json['is_locked']
    assert not browser.post('/api/unlock', {'password': PASSWORD}).json['is_locked']


def test_wrong_passwords_end_only_the_locked_session(bench: PeopleBench) -> None:
    browser, other = bench.logged_in('ann'), bench.logged_in('ann')
    browser.post('/api/lock')
    for _ in range(MOST_UNLOCKS):
        assert browser.post('/api/unlock', {'password': 'another one'}).status == 401
    assert 'has ended' in browser.post('/api/unlock', {'password': PASSWORD}).message
    assert who(browser) == ''
    other.post('/api/lock')
    assert other.post('/api/unlock', {'password': PASSWORD}).status == 200


# --- the file of users ----------------------------------------------------------------------


def test_another_role_counts_at_once(bench: PeopleBench) -> None:
    browser = bench.logged_in('ann')
    write_users(bench.users, {**ROLES, 'ann': Role.VIEW})
    me_now = browser.get('/api/me').json
    # The same password with another salt is another password.
    assert me_now['role'] == ''
    browser = bench.logged_in('ann')
    bench.people._users._file.change_role('ann', Role.ENGINEER)
    assert browser.get('/api/me').json['role'] == 'engineer'


def test_a_removed_user_is_out_at_once(bench: PeopleBench) -> None:
    browser = bench.logged_in('ann')
    write_users(bench.users, {'eve': Role.ENGINEER})
    assert who(browser) == ''
    write_users(bench.users, ROLES)
    assert who(browser) == '', 'the session is over, whoever has the name later'


def test_a_damaged_file_lets_nobody_in(bench: PeopleBench) -> None:
    browser = bench.logged_in('ann')
    bench.users.chmod(0o644)
    assert who(browser) == ''
    answer = log_in(bench.browser(), 'ann')
    assert answer.status == 503
    assert 'chmod 600' in answer.message


def test_without_a_file_there_are_no_users(bench: PeopleBench) -> None:
    bench.users.unlink()
    assert log_in(bench.browser(), 'ann').status == 401


# --- without a login ------------------------------------------------------------------------


def test_a_trusted_computer_is_its_user_an_engineer(
    tmp_path: Path, benches: list[PeopleBench]
) -> None:
    bench = PeopleBench(tmp_path, local_user='pat')
    benches.append(bench)
    me_now = bench.browser().get('/api/me').json
    assert (me_now['name'], me_now['role'], me_now['how']) == ('pat', 'engineer', 'this computer')
    assert who(bench.logged_in('ann')) == 'ann'
    assert who(bench.browser(address='10.0.0.9')) == ''


class TestBehindAProxy:
    @pytest.fixture
    def bench(self, tmp_path: Path, benches: list[PeopleBench]) -> PeopleBench:
        benches.append(
            PeopleBench(
                tmp_path,
                proxy_header='X-Remote-User',
                proxy_addresses=('10.0.0.2',),
                allowed_hosts=('page.example.org',),
            )
        )
        return benches[0]

    def test_header_gives_user_and_file_gives_role(self, bench: PeopleBench) -> None:
        browser = bench.browser(headers={'x-remote-user': 'ann'})
        me_now = browser.get('/api/me').json
        assert (me_now['name'], me_now['role'], me_now['how']) == ('ann', 'operate', 'proxy')
        assert not me_now['can_log_in']
        assert who(bench.browser(headers={'x-remote-user': 'ann'}, address='10.0.0.2')) == 'ann'

    def test_from_elsewhere_the_header_is_nothing(self, bench: PeopleBench) -> None:
        browser = bench.browser(headers={'x-remote-user': 'ann'}, address='10.0.0.3')
        assert who(browser) == ''
        refused = browser.get('/api/look')
        assert (refused.status, refused.json['why']) == (401, 'login')
        assert '10.0.0.3 is not the proxy of this page' in refused.message

    def test_nobody_looks_without_a_name(self, bench: PeopleBench) -> None:
        assert 'named no user in X-Remote-User' in bench.browser().get('/api/look').message
        browser = bench.browser(headers={'x-remote-user': 'joe'})
        assert 'joe is no user of this page; add one' in browser.get('/api/look').message

    def test_a_header_that_stands_there_twice_names_nobody(self, bench: PeopleBench) -> None:
        class Twice(Browser):
            def _headers(self, method: str, more: Any) -> list[tuple[bytes, bytes]]:
                own = super()._headers(method, more)
                return [(b'x-remote-user', b'eve'), *own]

        browser = Twice(bench.app, bench.loop, headers={'x-remote-user': 'ann'})
        assert who(browser) == ''

    def test_there_is_no_other_login(self, bench: PeopleBench) -> None:
        assert log_in(bench.browser(), 'ann').status == 403

    def test_the_origin_is_a_name_of_the_proxy(self, bench: PeopleBench) -> None:
        browser = bench.browser(headers={'x-remote-user': 'ann'})
        ours = browser.post('/api/echo', origin='https://page.example.org')
        assert ours.status == 200
        assert browser.post('/api/echo', origin='https://evil.example.org').status == 403


# --- the guards -----------------------------------------------------------------------------


def test_local_view_is_free_but_commands_need_login(bench: PeopleBench) -> None:
    assert bench.browser().get('/api/look').status == 200
    refused = bench.browser().post('/api/echo', {'a': 1})
    assert (refused.status, refused.json['why']) == (401, 'login')
    assert bench.logged_in('vic').post('/api/echo', {'a': 1}).json == {'body': {'a': 1}}


def test_remote_access_needs_login_first(tmp_path: Path, benches: list[PeopleBench]) -> None:
    bench = PeopleBench(tmp_path, host='0.0.0.0', certificate=tmp_path, key=tmp_path)
    benches.append(bench)
    browser = bench.browser(host='10.0.0.1:8080', scheme='https', address='10.0.0.9')
    assert browser.get('/api/look').status == 401
    assert browser.get('/api/me').status == 200
    assert browser.get('/static/app.js').status == 200
    assert browser.get('/api/none').status == 401, 'nobody learns what there is'
    assert log_in(browser, 'ann').status == 200
    assert browser.get('/api/look').json == {'who': 'ann'}


@pytest.mark.parametrize('host', ['evil.example.org', 'evil.example.org:8080', '10.0.0.1', ''])
def test_a_host_that_is_not_this_page(bench: PeopleBench, host: str) -> None:
    browser = bench.logged_in('ann')
    answer = browser.get('/api/me', host=host)
    assert answer.status == 403
    assert '--allow-host' in answer.message


@pytest.mark.parametrize(
    'origin',
    [
        '',
        'null',
        'http://evil.example.org',
        'http://127.0.0.1',
        'http://127.0.0.1:3000',
        'https://127.0.0.1:8080',
        'http://localhost:8080',
        'http://127.0.0.1:8080.evil.example.org',
    ],
)
def test_what_comes_from_another_page(bench: PeopleBench, origin: str) -> None:
    answer = bench.logged_in('ann').post('/api/echo', origin=origin)
    assert answer.status == 403
    assert 'http://127.0.0.1:8080' in answer.message


@pytest.mark.parametrize('kind', ['', 'text/plain', 'application/x-www-form-urlencoded'])
def test_what_a_form_could_send(bench: PeopleBench, kind: str) -> None:
    answer = bench.logged_in('ann').post('/api/echo', {'a': 1}, content_type=kind)
    assert answer.status == 415


@pytest.mark.parametrize(
    ('body', 'status'),
    [
        (b'{"a": [1, "text", null, 1.5, true]}', 200),
        (b'', 200),
        (b'[]', 422),
        (b'"text"', 422),
        (b'{', 422),
        (b'\xff\xfe', 422),
        (b'{"a": NaN}', 422),
        (b'{"a": "\\u0000"}', 422),
        (b'{"a\\u0000": 1}', 422),
        (b'{"a": "\\ud800"}', 422),
        (b'[' * 100_000, 422),
        (b'{"a":' + b'[' * 40 + b']' * 40 + b'}', 422),
        (b'{"a": ' + b'9' * 5000 + b'}', 422),
        (b'"' + b'x' * 1_000_001 + b'"', 413),
    ],
)
def test_bodies(bench: PeopleBench, body: bytes, status: int) -> None:
    answer = bench.logged_in('ann').post('/api/echo', body)
    assert answer.status == status, answer.body
    assert status == 200 or answer.message


def test_missing_request_body_times_out(
    bench: PeopleBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(endpoint, 'BODY_S', 0.01)
    browser = bench.logged_in('ann')
    browser.sends_whole = False
    answer = browser.post('/api/echo', {'a': 1})
    assert (answer.status, answer.message) == (408, 'the request did not come within 0.01 s')


def test_errors_are_a_sentence_and_no_traceback(bench: PeopleBench) -> None:
    answer = bench.browser().get('/api/fail')
    assert answer.status == 500
    assert b'secrets' not in answer.body
    assert b'Traceback' not in answer.body
    assert bench.browser().get('/api/none').message == (
        'GET /api/none: there is no such thing here'
    )
    assert bench.logged_in('ann').post('/api/look').status == 405


def test_every_answer_has_the_headers(bench: PeopleBench) -> None:
    browser = bench.browser()
    for path in ('/api/me', '/api/fail', '/api/none', '/static/app.js'):
        answer = browser.get(path)
        assert "default-src 'self'" in answer.headers['content-security-policy']
        assert "frame-ancestors 'none'" in answer.headers['content-security-policy']
        assert answer.headers['x-content-type-options'] == 'nosniff'
        is_api = path.startswith('/api/')
        assert answer.headers.get('cache-control') == ('no-store' if is_api else None)
    assert 'content-security-policy' in browser.get('/api/me', host='evil.org').headers
