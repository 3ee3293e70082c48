"""Agents that know nothing of fatplan, as a plug-in."""


def first(observation, rng):
    return 0


def drawing(observation, rng):
    return "a" if rng.random() < 0.5 else "b"


class Turns:
    """Every action in turn; the second time the same observation comes in a row, the first one again."""

    def __init__(self):
        self.seen = []

    def __call__(self, observation, rng):
        self.seen.append(observation)
        return len(self.seen) % 2


class Trained:
    """Acts by the bytes it is made from: byte o says what to do after observation o."""

    def __init__(self, data):
        self.table = data

    def __call__(self, observation, rng):
        return self.table[observation]


class Other(Trained):
    pass


class NoCall:
    pass


number = 3


def of_one(observation):
    return 0


def answering(observation, rng):
    return ANSWER


def failing(observation, rng):
    return 1 / 0


ANSWER = 7
