"""The answers that tests share: each is computed once while there is room, and the memory stays bounded."""

from functools import partial

import numpy as np

from tests.studies.solved_once import Kept, bytes_of, solved_once


def test_bytes_are_those_of_all_arrays_once():
    array = np.zeros(1000)
    assert 8000 < bytes_of(array) < 9000
    assert 8000 < bytes_of({"a": [array, array[::2], array.T]}) < 9000
    assert bytes_of((array, array.copy())) > 16000
    assert 8000 < bytes_of([lambda: array.sum(), partial(np.add, array)]) < 10_000


def test_the_answers_asked_for_last_are_kept():
    asked = []

    def solve(number):
        asked.append(number)
        return np.full(1000, number)

    answer = solved_once(solve, Kept(room=20_000))  # two arrays of 8 kB
    assert [answer(n)[0] for n in (1, 2, 1, 3, 1, 2)] == [1, 2, 1, 3, 1, 2]
    assert asked == [1, 2, 3, 2]


def test_an_answer_larger_than_the_room_is_kept_until_the_next():
    asked = []
    answer = solved_once(lambda number: asked.append(number) or np.zeros(1000), Kept(room=1))
    for number in (1, 1, 2, 1):
        answer(number)
    assert asked == [1, 2, 1]
