"""RULA once more, for one instant and side, from angles in degrees: branches instead of arrays, another transcription.

The tables are as in the file "RULA Scoring Tables" of a public Python program, transcribed digit by digit; a row of
table A is an upper arm and lower arm, with wrist and twist along it, of B a neck, with trunk and legs along it.
"""

TABLE_A = """
12222333 22223333 23333344
23333444 33333444 34444455
33444455 34444455 44444555
44444555 44444555 44455566
55555667 56666777 66677778
77777889 88888999 99999999
"""
TABLE_B = "132334556677 232345556777 333445566777 555667777788 777778888888 888888899999"
TABLE_C = "1233455 2234455 3334456 3334566 4445677 4456677 5566777 5567777"


def table_a(upper: int, lower: int, wrist: int, twist: int) -> int:
    return int(TABLE_A.split()[3 * (upper - 1) + lower - 1][2 * (wrist - 1) + twist - 1])


def table_b(neck: int, trunk: int, legs: int) -> int:
    return int(TABLE_B.split()[neck - 1][2 * (trunk - 1) + legs - 1])


def table_c(c: int, d: int) -> int:
    return int(TABLE_C.split()[min(c, 8) - 1][min(d, 7) - 1])


def rula(
    seen: dict[str, float],
    side: str,
    half_width_m: float,
    load_kg: tuple[float, float],
    more: set[str],
    works: bool,
) -> int:
    """The grand score; load_kg: of this arm and of both; more: of `repeated`, `shock`, `raised`, `supported`.

    The last three are true of an arm that works, shocks of the body, too.
    """
    arm, elbow, out = (seen[f"{side}_{name}"] for name in ("arm", "elbow", "hand_out_m"))
    if arm < -20:
        upper = 2
    elif arm <= 20:
        upper = 1
    elif arm <= 45:
        upper = 2
    else:
        upper = 3 if arm <= 90 else 4
    if seen[f"{side}_arm_abducted"] > 30:
        upper += 1
    if works:
        upper += ("raised" in more) - ("supported" in more)
    lower = 1 if 60 <= elbow <= 100 else 2
    if out < 0 or out > half_width_m + 0.25:
        lower += 1
    bent = abs(seen[f"{side}_wrist"])
    wrist = 1 if bent <= 5 else 2 if bent <= 15 else 3
    wrist += abs(seen[f"{side}_deviation"]) > 20
    twist = 2 if abs(seen[f"{side}_pronation"]) >= 60 else 1
    neck = 4 if seen["neck"] < -5 else 1 if seen["neck"] <= 10 else 2 if seen["neck"] <= 20 else 3
    neck += (abs(seen["neck_twist"]) > 20) + (abs(seen["neck_side"]) > 10)
    bend = seen["trunk"]
    trunk = 1 if abs(bend) <= 5 else 2 if bend <= 20 else 3 if bend <= 60 else 4
    trunk += (abs(seen["trunk_twist"]) > 20) + (abs(seen["trunk_side"]) > 10)
    legs = 2 if min(seen["right_foot_share"], seen["left_foot_share"]) < 0.1 else 1
    muscle = "repeated" in more
    force = _force(load_kg[0], more if works else more - {"shock"}), _force(load_kg[1], more)
    c = table_a(max(1, min(6, upper)), lower, wrist, twist) + muscle + force[0]
    return table_c(c, table_b(neck, trunk, legs) + muscle + force[1])


def _force(load_kg: float, more: set[str]) -> int:
    if "shock" in more:
        return 3
    if load_kg < 2:
        return 0
    if "repeated" in more:
        return 2 if load_kg <= 10 else 3
    return 1 if load_kg <= 10 else 2
