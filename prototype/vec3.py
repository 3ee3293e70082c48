import sys
from vec import *
import lanes
@numba.njit(nogil=True,error_model="numpy")
def intr(gain, offset, row, state):
    return lanes.advance(gain, offset, state, row*state.size)
@numba.njit(nogil=True,error_model="numpy")
def c8(gain, offset, row, state):
    # two groups of 4
    s0 = s1 = s2 = s3 = 0.0
    r0 = r1 = r2 = r3 = 0.0
    for j in range(state.shape[0]):
        f0 = gain[row, j, 0] * state[j, 0] + offset[row, j, 0]
        f1 = gain[row, j, 1] * state[j, 1] + offset[row, j, 1]
        f2 = gain[row, j, 2] * state[j, 2] + offset[row, j, 2]
        f3 = gain[row, j, 3] * state[j, 3] + offset[row, j, 3]
        state[j, 0] = f0; state[j, 1] = f1; state[j, 2] = f2; state[j, 3] = f3
        s0 += f0 * f0; s1 += f1 * f1; s2 += f2 * f2; s3 += f3 * f3
        f0 = gain[row, j, 4] * state[j, 4] + offset[row, j, 4]
        f1 = gain[row, j, 5] * state[j, 5] + offset[row, j, 5]
        f2 = gain[row, j, 6] * state[j, 6] + offset[row, j, 6]
        f3 = gain[row, j, 7] * state[j, 7] + offset[row, j, 7]
        state[j, 4] = f0; state[j, 5] = f1; state[j, 6] = f2; state[j, 7] = f3
        r0 += f0 * f0; r1 += f1 * f1; r2 += f2 * f2; r3 += f3 * f3
    return ((s0+r0) + (s1+r1)) + ((s2+r2) + (s3+r3))
@numba.njit(nogil=True,error_model="numpy")
def c4t(gain, offset, row, state):
    # tuple of lanes, 1-D with unsigned
    s0 = s1 = s2 = s3 = 0.0
    for j in range(state.shape[0]):
        a, b, c, d = gain[row, j, 0] * state[j, 0] + offset[row, j, 0], gain[row, j, 1] * state[j, 1] + offset[row, j, 1], gain[row, j, 2] * state[j, 2] + offset[row, j, 2], gain[row, j, 3] * state[j, 3] + offset[row, j, 3]
        state[j, 0], state[j, 1], state[j, 2], state[j, 3] = a,b,c,d
        s0 += a*a; s1 += b*b; s2 += c*c; s3 += d*d
    return (s0 + s2) + (s1 + s3)
rng = np.random.default_rng(0)
for rep in range(2):
  for L in (32, 80):
    for f, ln in ((intr, 0),(c8, 8),(c4t, 4),(adv_c,4)):
        g = rng.random((4, L)) * .5; o = rng.random((4, L)); s = rng.random(L); rows = rng.integers(0, 4, 1024)
        if f is intr: g=g.ravel(); o=o.ravel()
        if ln: g = g.reshape(4, -1, ln); o = o.reshape(4, -1, ln); s = s.reshape(-1, ln)
        l = mk(f); l(g, o, s, rows, 10); best = 9
        for _ in range(7):
            t = time.process_time(); l(g, o, s, rows, 200000); best = min(best, time.process_time() - t)
        asm = list(f.inspect_asm().values())[0] if f.inspect_asm() else ""
        print(L, f.__name__, "%.2f ns" % (best / 200000 * 1e9), {k: len(re.findall(k, asm)) for k in ("mulpd", "addpd", "mulsd", "addsd", "zmm", "ymm","cmov")})
