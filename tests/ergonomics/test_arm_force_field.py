"""The Arm Force Field: the authors' example, their coefficients from another of their scripts, hands of a motion."""

from dataclasses import replace

import numpy as np
import pytest

from fatigue_planner.ergonomics import arm_force_field as field
from fatigue_planner.ergonomics.indicators.arm_force_field import ArmForceField, exerted_n, strengths
from fatigue_planner.ergonomics.indicators.percent_capable import capable_percent
from fatigue_planner.ergonomics.operation import Operation
from fatigue_planner.ergonomics.registry import evaluate
from fatigue_planner.ergonomics.stated import Circumstances
from fatigue_planner.reactions.reaction import Reaction

# The example of the script: hand, wrist, elbow, shoulder of the left, then the right arm, C7 and L5/S1, in m; left,
# up, forward.
POINTS = np.array([
    [0.29034, 0.91934, 0.29134], [0.26170, 0.96619, 0.23538], [0.19100, 1.11068, 0.09171],
    [0.09191, 1.30461, -0.06136], [-0.37368, 1.20097, 0.360862], [-0.36905, 1.20173, 0.28260],
    [-0.42676, 1.28636, 0.09280], [-0.21538, 1.32291, -0.06481], [-0.06385, 1.35457, -0.06182],
    [-0.06300, 0.95253, -0.07984],
])[:, None]  # fmt: skip
# The hidden layer as in the authors' Matlab script, to four decimals.
HIDDEN = """
.0396 .5136 -.1615 .5336 .3926 .7784 -.0902 -.0259 -.3187 .1409 -.1015 .2237 .0185 .2849 .0966 .2747 .0260 .0880
-.5746 -.5028 -.0346 .3401 .2056 .3016 .3007 -.0493 -.0304 .8771 -.7025 -.7010 -.4056 .3227 .4021 .3610 -.1992 -.2431
-.0557 .0491 .0732 -.3808 .2394 -.4722 .4100 .2705 -.2550 .1450 -.4810 -.2546 .3465 .0709 .4788 .2216 -.4773 -.2051
.3611 .2246 .2554 -.4630 -.3230 -.5781 .2133 .1465 .0377 .4973 -.2099 .6795 .1627 .0219 -.0659 .4337 .1040 .7511
.2706 -.6403 .0848 .3126 -.4783 .4418 -.0566 -.5085 .1352 .5188 .0647 -.2940 -.6337 -.2026 .5240 -.1340 -.4554 .4529
-.3350 -.4358 .4465 -.0375 -.7067 .2756 .2248 .3300 .1822 .3533 .5186 -.9299 .3321 .4971 -.2925 -.1626 .2984 -.0128
-.2165 .4990 .0217 .1149 .5063 .2318 .6101 .2567 .0145 .5711 -.2946 .0266 .5048 -.3793 -.0454 .1801 .1372 .0979
.3913 -.0073 .1755 .0524 .1244 -.3667 .9309 .6956 -.1477 -.1508 .2167 .1728 -.8903 -.0680 .4472 -.0896 .3045 .4884
-.4947 .1939 -.1364 .9642 -.3823 -.8582 .5678 .0183 .0734 -.3039 -.2106 -.6436 -1.7207 -.1054 .4872 -.4074 .0791 .0686
-.3073 .1254 .3129 -.6843 .7813 .3975 .1526 .1362 .0096 .0173 -.4714 .2260 -.2578 .3523 -.1745 -.0406 -.5426 -.1430
-.0791 -.4438 -.4788 .5757 .0303 -.6913 .2852 -.0843 -.2630 -.3190 .0875 -.5424 .2142 .4311 .0024 .0723 -.3239 -.4829
.1418 .0761 -.5284 -.0011 -.2474 -.1732 -.3190 -.4959 .1190 .5403 .0639 -.2305 -.0813 .2206 -.0941 -.3565 -.6196 .1156
.0132 -.8766 -.0504 -.0876 .1449 .8244 -.0540 .1144 -.0400 .4347 -.0814 .5068 1.0402 -.4421 -.2863 .2309 -.0824 -.5335
"""


def example(side: str, mirrored: bool) -> tuple[float, float]:
    """Strength of 75 % of women, and the share in % who can exert 50 N up."""
    axes = field.shoulder_axes(POINTS[7], POINTS[3], POINTS[8], POINTS[9])
    first = 0 if side == "left" else 4
    hand, wrist, elbow = (field.outwards(POINTS[first + k] - POINTS[first + 3], axes, side) for k in range(3))
    force = field.outwards(np.array([[0.0, 1.0, 0.0]]), axes, side)
    down = field.outwards(np.array([[0.0, -1.0, 0.0]]), axes, side if mirrored else "right")
    mean, gravity = field.strength_n(hand, force), field.gravity_n(hand, wrist, elbow, force, down, 73.5)
    quarter = -0.6744897501960817 * field.VARIATION
    share = capable_percent(50 - gravity, mean, field.VARIATION)
    return float((mean * (1 + quarter) + gravity)[0]), float(share[0])


def test_the_authors_example() -> None:
    """Left hand: 78.15 N and 94.8 %, with gravity not mirrored as in the script; mirrored, half a newton more."""
    strength, share = example("left", mirrored=False)
    assert (round(strength, 2), round(share, 1)) == (78.15, 94.8)
    assert [round(value, 1) for value in example("left", mirrored=True)] == [78.6, 95.0]
    assert example("right", mirrored=True) == example("right", mirrored=False)


def test_the_coefficients_are_those_of_the_other_script() -> None:
    np.testing.assert_allclose(field.network().hidden, [
        [float(number) for number in row.split()] for row in HIDDEN.strip().split("\n")
    ], atol=5.1e-5)  # fmt: skip


def test_strength_is_bounded_by_what_was_found() -> None:
    """Far outside what was measured, the table's least and most hold: below the shoulder, forwards and down."""
    hand = np.array([[0.5, -0.4, 0.1], [0.05, -0.02, 0.0]])
    force = np.array([[0.7, -0.7, 0.1], [-0.1, 0.99, 0.05]])
    found = field.strength_n(hand, force / np.linalg.norm(force, axis=1, keepdims=True))
    known = field.network()
    for strength, code in zip(found, ((0, 2, 0, 2), (0, 0, 2, 2)), strict=True):
        place = int(np.ravel_multi_index(code, (3, 3, 3, 3)))
        assert known.least_n[place] <= strength <= known.most_n[place]


def test_left_and_right_are_alike(reactions: tuple[Reaction, ...]) -> None:
    """The stance is symmetrical, so both arms are as strong in it."""
    operation = Operation.of(reactions[0])
    up = np.tile([0.0, 0.0, 30.0], (160, 1))
    right, left = (strengths(operation, side, up) for side in ("right", "left"))
    for one, other in zip(right, left, strict=True):
        assert one[0] == pytest.approx(other[0], rel=1e-6)


def test_what_the_hands_exert(reactions: tuple[Reaction, ...]) -> None:
    """The paper's right hand holds 5 kg up; a force on the left one is met by the opposite; a load may be stated."""
    force = np.zeros_like(reactions[0].motion.hand_force_n)
    force[:, 3:] = 10, -20, -30
    pushed = replace(reactions[0], motion=replace(reactions[0].motion, hand_force_n=force))
    np.testing.assert_allclose(exerted_n(Operation.of(pushed))[7], [[0, 0, 49.05], [-10, 20, 30]])
    stated = exerted_n(Operation.of(reactions[0], Circumstances(load_kg=2)))
    np.testing.assert_allclose(stated[7], [[0, 0, 19.62], [0, 0, 0]])


def test_the_share_of_a_motion(reactions: tuple[Reaction, ...]) -> None:
    operation = Operation.of(reactions[0])
    (found,) = evaluate([operation], indicators=[ArmForceField()])
    exerted = exerted_n(operation)[:, 0]
    strength, gravity = strengths(operation, "right", exerted)
    shares = capable_percent(5 * 9.81 - gravity, strength, 0.277)
    assert found.value is not None
    assert found.value.low == pytest.approx(float(shares.min()))
    assert found.worst is not None
    assert found.worst.side == "right"
    heavier = replace(operation, stated=Circumstances(load_kg=15))
    (more,) = evaluate([heavier], indicators=[ArmForceField()])
    assert more.value is not None
    assert more.value.low < found.value.low
    (nothing,) = evaluate([replace(operation, stated=Circumstances(load_kg=0))], indicators=[ArmForceField()])
    assert not nothing.applies
