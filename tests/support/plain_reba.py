"""REBA once more, for one instant and side: branches instead of arrays, and the tables of another transcription.

The tables are as in rs9000/ergonomics, transcribed digit by digit, A-C for 10-12; a row of table A is a neck, with
trunk and legs along it, of B an upper arm, with lower arm and wrist along it.
"""

TABLE_A = """
1234 2345 2456 3567 4678
1234 3456 4567 5678 6789
3356 4567 5678 6789 7899
"""
TABLE_B = "122123 123234 345455 455567 678788 788899"
TABLE_C = """
111233456777 122344566778 233345677888 344456788999
444567889999 66678899AAAA 7778999AABBB 8889AAAAABBB
999AAABBBCCC AAABBBBCCCCC BBBBCCCCCCCC CCCCCCCCCCCC
"""


def table_a(neck: int, trunk: int, legs: int) -> int:
    return int(TABLE_A.split()[5 * (neck - 1) + trunk - 1][legs - 1])


def table_b(upper: int, lower: int, wrist: int) -> int:
    return int(TABLE_B.split()[upper - 1][3 * (lower - 1) + wrist - 1])


def table_c(a: int, b: int) -> int:
    return int(TABLE_C.split()[min(a, 12) - 1][min(b, 12) - 1], 16)


def reba(
    seen: dict[str, float], side: str, load_kg: tuple[float, float], coupling: int, more: set[str], works: bool
) -> int:
    """The score; load_kg: of this arm and of both; more: of `repeated`, `shock`, `raised`, `supported`, `rapid`.

    `raised` and `supported` are true of an arm that works.
    """
    neck = 2 if seen["neck"] > 20 or seen["neck"] < -5 else 1
    if abs(seen["neck_twist"]) > 20 or abs(seen["neck_side"]) > 10:
        neck += 1
    bend = seen["trunk"]
    if -5 <= bend <= 5:
        trunk = 1
    elif -20 <= bend <= 20:
        trunk = 2
    else:
        trunk = 4 if bend > 60 else 3
    if abs(seen["trunk_twist"]) > 20 or abs(seen["trunk_side"]) > 10:
        trunk += 1
    legs = 2 if min(seen["right_foot_share"], seen["left_foot_share"]) < 0.1 else 1
    knee = max(seen["right_knee"], seen["left_knee"])
    legs += 2 if knee > 60 else 1 if knee >= 30 else 0
    a = table_a(neck, trunk, legs) + (2 if load_kg[1] > 10 else 1 if load_kg[1] >= 5 else 0) + ("shock" in more)
    arm, raised = seen[f"{side}_arm"], seen[f"{side}_arm_raised"]
    upper = 1 if -20 <= arm <= 20 else 2 if arm <= 45 else 3 if arm <= 90 else 4
    upper += (seen[f"{side}_arm_abducted"] > 30) + (works and "raised" in more)
    if (works and "supported" in more) or (raised <= 20 and abs(arm) > 20):
        upper -= 1
    lower = 1 if 60 <= seen[f"{side}_elbow"] <= 100 else 2
    wrist = 1 if abs(seen[f"{side}_wrist"]) <= 15 else 2
    wrist += abs(seen[f"{side}_deviation"]) > 20
    b = table_b(min(6, max(1, upper)), lower, wrist) + (coupling if load_kg[0] > 0 else 0)
    return table_c(a, b) + ("repeated" in more) + ("rapid" in more)
