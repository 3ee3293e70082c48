"""Random numbers drawn in compiled code are NumPy's."""

import numpy as np
import pytest

from fatigue_planner.core.jit import kernel
from fatigue_planner.core.pcg64 import below, go_on, uniform, words_of


@kernel
def draw_some(source: object, drawn: np.ndarray) -> None:
    for i in range(drawn.size):
        drawn[i] = uniform(source)


def test_words_give_numpys_numbers_compiled_or_not() -> None:
    for seed in range(5):
        expected = np.random.default_rng(seed).random(1000)
        words = [words_of(np.random.default_rng(seed)) for _ in range(2)]
        drawn = np.empty(1000)
        draw_some(words[0], drawn)
        assert np.array_equal(drawn, expected)
        assert np.array_equal([uniform(words[1]) for _ in range(1000)], expected)
        assert np.array_equal(*words)


@kernel
def draw_some_below(source: object, count: int, drawn: np.ndarray) -> None:
    for i in range(drawn.size):
        drawn[i] = below(source, count)


@pytest.mark.parametrize("count", [1, 2, 3, 8, 1000])
def test_a_number_below_another_takes_one_uniform_number(count: int) -> None:
    expected = (np.random.default_rng(count).random(1000) * count).astype(int)
    sources = [words_of(np.random.default_rng(count)), np.random.default_rng(count)]
    drawn = np.empty(1000)
    for source in sources:
        draw_some_below(source, count, drawn)
        assert np.array_equal(drawn, expected)
    words = words_of(np.random.default_rng(count))
    assert [below(words, count) for _ in range(1000)] == expected.tolist()
    assert words is not None and np.array_equal(words, sources[0])


def test_a_generator_goes_on_where_its_words_have_come_to() -> None:
    rng, other = (np.random.default_rng(3) for _ in range(2))
    assert rng.integers(7, size=3, dtype=np.uint32).tolist() == other.integers(7, size=3, dtype=np.uint32).tolist()
    words = words_of(rng)
    assert words is not None
    assert [uniform(words) for _ in range(10)] == other.random(10).tolist()
    go_on(rng, words)
    assert rng.bit_generator.state == other.bit_generator.state  # also the half of a number that is left


def test_of_another_generator_numbers_are_asked_for() -> None:
    rng, other = (np.random.Generator(np.random.MT19937(3)) for _ in range(2))
    assert words_of(rng) is None
    assert words_of(np.random.Generator(np.random.PCG64DXSM(3))) is None
    drawn = np.empty(10)
    draw_some(rng, drawn)
    assert np.array_equal(drawn, other.random(10))
    assert uniform(rng) == other.random()
