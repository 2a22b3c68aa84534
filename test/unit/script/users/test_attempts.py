"""How often somebody may try to log in, with a clock that is set."""

from __future__ import annotations

from bt_orchestrator.script.users.logins import (
    FORGOTTEN_S,
    FREE_ATTEMPTS,
    FREE_ATTEMPTS_OF_MANY,
    LONGEST_WAIT_S,
    MOST_KNOWN,
    Attempts,
)


def fail(attempts: Attempts, count: int, name: str = 'ann', address: str = 'here') -> None:
    for _ in range(count):
        attempts.begin(name, address, 0.0)


def test_the_first_failures_cost_nothing() -> None:
    attempts = Attempts()
    assert attempts.wait_s('ann', 'here', 0.0) == 0.0
    fail(attempts, FREE_ATTEMPTS - 1)
    assert attempts.wait_s('ann', 'here', 0.0) == 0.0


def test_each_further_attempt_doubles_wait_up_to_limit() -> None:
    attempts = Attempts()
    waits = []
    fail(attempts, FREE_ATTEMPTS)
    for _ in range(8):
        waits.append(attempts.wait_s('ann', 'here', 0.0))
        fail(attempts, 1)
    assert waits == [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, LONGEST_WAIT_S, LONGEST_WAIT_S]


def test_the_wait_passes() -> None:
    attempts = Attempts()
    fail(attempts, FREE_ATTEMPTS + 2)
    assert attempts.wait_s('ann', 'here', 3.0) == 1.0
    assert attempts.wait_s('ann', 'here', 4.0) == 0.0


def test_failures_are_forgotten() -> None:
    attempts = Attempts()
    fail(attempts, FREE_ATTEMPTS + 8)
    assert attempts.wait_s('ann', 'here', FORGOTTEN_S) == 0.0
    attempts.begin('ann', 'here', FORGOTTEN_S)
    assert attempts.wait_s('ann', 'here', FORGOTTEN_S) == 0.0


def test_guesses_at_one_user_do_not_block_others() -> None:
    attempts = Attempts()
    fail(attempts, 10 * FREE_ATTEMPTS_OF_MANY)
    assert attempts.wait_s('ann', 'here', 0.0) == LONGEST_WAIT_S
    assert attempts.wait_s('bob', 'here', 0.0) == 0.0
    assert attempts.wait_s('ann', 'there', 0.0) == 0.0


def test_a_name_is_guarded_from_all_addresses() -> None:
    attempts = Attempts()
    for number in range(FREE_ATTEMPTS_OF_MANY):
        attempts.begin('ann', f'address {number}', 0.0)
    assert attempts.wait_s('ann', 'yet another one', 0.0) > 0
    assert attempts.wait_s('bob', 'yet another one', 0.0) == 0.0


def test_an_address_cannot_try_many_names() -> None:
    attempts = Attempts()
    for number in range(FREE_ATTEMPTS_OF_MANY):
        attempts.begin(f'name {number}', 'here', 0.0)
    assert attempts.wait_s('another name', 'here', 0.0) > 0
    assert attempts.wait_s('another name', 'there', 0.0) == 0.0


def test_success_does_not_wash_the_address_clean() -> None:
    attempts = Attempts()
    for number in range(FREE_ATTEMPTS_OF_MANY):
        attempts.begin(f'name {number}', 'here', 0.0)
        attempts.begin('mine', 'here', 0.0)
        attempts.succeeded('mine', 'here')
    assert attempts.wait_s('mine', 'there', 0.0) == 0.0
    assert attempts.wait_s('another name', 'here', 0.0) > 0


def test_success_does_not_wash_the_name_clean_elsewhere() -> None:
    attempts = Attempts()
    for number in range(FREE_ATTEMPTS_OF_MANY):
        attempts.begin('ann', f'address {number}', 0.0)
        attempts.begin('ann', 'home', 0.0)
        attempts.succeeded('ann', 'home')
    assert attempts.wait_s('ann', 'address 0', 0.0) > 0


def test_made_up_names_do_not_fill_memory() -> None:
    attempts = Attempts()
    for number in range(3 * MOST_KNOWN):
        attempts.begin(f'name {number}', f'address {number}', 0.0)
    assert len(attempts._known) <= MOST_KNOWN
