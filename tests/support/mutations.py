"""Hypothesis' strategies for damaged files."""

from hypothesis import strategies as st

LENGTHS = st.sampled_from([0, 1, 2, 4, 8, 40, 400])


@st.composite
def damaged(
    draw: st.DrawFn, content: bytes, positions: st.SearchStrategy[int], pieces: st.SearchStrategy[bytes]
) -> bytes:
    """Content with one to eight changes: a flipped bit, a piece overwritten, replaced or repeated, a lost end."""
    data = bytearray(content)
    for _ in range(draw(st.sampled_from([1, 1, 1, 2, 4, 8]))):
        start = min(draw(positions), len(data) - 1)
        change = draw(st.sampled_from(["flip", "overwrite", "overwrite", "replace", "repeat", "end"]))
        length = draw(LENGTHS)
        if change == "flip":
            data[start] ^= 1 << draw(st.integers(0, 7))
        elif change == "overwrite":
            piece = draw(pieces)
            data[start : start + len(piece)] = piece
        elif change == "replace":
            data[start : start + length] = draw(pieces)
        elif change == "repeat":
            data[start:start] = data[start : start + length] * draw(st.sampled_from([1, 2, 50]))
        elif start > len(content) // 2:
            del data[start:]
    return bytes(data)
