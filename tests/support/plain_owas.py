"""OWAS once more, for one instant: branches instead of arrays, and the table of another transcription.

The table is as in rs9000/ergonomics, transcribed digit by digit: back and arms down, seven legs along, each with three
loads. It differs from most others in two cells, which are marked with the usual value there.
"""

TABLE = """
111 111 111 222 222 111 111  111 111 111 222 222 111 111  111 111 111 223 223 111 112
223 223 223 333 333 222 233  223 223 233 344 344 334 234  334 223 333 344 444 444 234
111 111 112 333 444 111 111  223 111 112 444 444 333 111  223 111 233 444 444 444 112
233 223 233 444 444 444 234  334 234 334 444 444 444 234  444 234 334 444 444 444 234
"""
# Back, arms, legs, load: this table, the usual one.
DIFFERENCES = {(3, 3, 7, 3): (2, 1), (4, 1, 3, 2): (3, 2)}


def category(back: int, arms: int, legs: int, load: int) -> int:
    return int(TABLE.split()[21 * (back - 1) + 7 * (arms - 1) + legs - 1][load - 1])


def owas(seen: dict[str, float], load_kg: float) -> int:
    bent = abs(seen["trunk"]) > 20
    turned = max(abs(seen["trunk_twist"]), abs(seen["trunk_side"])) > 20
    back = 4 if bent and turned else 3 if turned else 2 if bent else 1
    arms = 1 + sum(1 for side in ("right", "left") if seen[f"{side}_arm_raised"] >= 90)
    right, left = (seen[f"{side}_knee"] > 30 for side in ("right", "left"))
    if seen["right_foot_share"] < 0.1:
        legs = 5 if left else 3
    elif seen["left_foot_share"] < 0.1:
        legs = 5 if right else 3
    else:
        legs = 4 if right and left else 2
    code = (back, arms, legs, 1 if load_kg < 10 else 2 if load_kg <= 20 else 3)
    return DIFFERENCES[code][1] if code in DIFFERENCES else category(*code)
