import numba, numpy as np, time, re
@numba.njit(nogil=True,error_model="numpy")
def adv_a(gain, offset, row, state):
    s0 = s1 = s2 = s3 = 0.0
    for j in range(0, state.size, 4):
        f0 = gain[row, j] * state[j] + offset[row, j]
        f1 = gain[row, j + 1] * state[j + 1] + offset[row, j + 1]
        f2 = gain[row, j + 2] * state[j + 2] + offset[row, j + 2]
        f3 = gain[row, j + 3] * state[j + 3] + offset[row, j + 3]
        state[j], state[j + 1], state[j + 2], state[j + 3] = f0, f1, f2, f3
        s0 += f0 * f0; s1 += f1 * f1; s2 += f2 * f2; s3 += f3 * f3
    return (s0 + s1) + (s2 + s3)
@numba.njit(nogil=True,error_model="numpy")
def adv_b(gain, offset, row, state):
    # elementwise loop first (vectorised by LLVM), then the sums
    n = state.size
    for j in range(n):
        state[j] = gain[row, j] * state[j] + offset[row, j]
    s0 = s1 = s2 = s3 = 0.0
    for i in range(n // 4):
        j = 4 * i
        s0 += state[j] * state[j]; s1 += state[j+1] * state[j+1]; s2 += state[j+2] * state[j+2]; s3 += state[j+3] * state[j+3]
    return (s0 + s1) + (s2 + s3)
@numba.njit(nogil=True,error_model="numpy")
def adv_c(gain, offset, row, state):
    # blocks of 4: (rows, blocks, 4), state (blocks, 4)
    s0 = s1 = s2 = s3 = 0.0
    for j in range(state.shape[0]):
        f0 = gain[row, j, 0] * state[j, 0] + offset[row, j, 0]
        f1 = gain[row, j, 1] * state[j, 1] + offset[row, j, 1]
        f2 = gain[row, j, 2] * state[j, 2] + offset[row, j, 2]
        f3 = gain[row, j, 3] * state[j, 3] + offset[row, j, 3]
        state[j, 0] = f0; state[j, 1] = f1; state[j, 2] = f2; state[j, 3] = f3
        s0 += f0 * f0; s1 += f1 * f1; s2 += f2 * f2; s3 += f3 * f3
    return (s0 + s1) + (s2 + s3)
@numba.njit(nogil=True,error_model="numpy")
def adv_d(gain, offset, row, state):
    # 8 lanes, blocks
    s0 = s1 = s2 = s3 = s4=s5=s6=s7=0.0
    for j in range(state.shape[0]):
        f0 = gain[row, j, 0] * state[j, 0] + offset[row, j, 0]
        f1 = gain[row, j, 1] * state[j, 1] + offset[row, j, 1]
        f2 = gain[row, j, 2] * state[j, 2] + offset[row, j, 2]
        f3 = gain[row, j, 3] * state[j, 3] + offset[row, j, 3]
        f4 = gain[row, j, 4] * state[j, 4] + offset[row, j, 4]
        f5 = gain[row, j, 5] * state[j, 5] + offset[row, j, 5]
        f6 = gain[row, j, 6] * state[j, 6] + offset[row, j, 6]
        f7 = gain[row, j, 7] * state[j, 7] + offset[row, j, 7]
        state[j, 0] = f0; state[j, 1] = f1; state[j, 2] = f2; state[j, 3] = f3
        state[j, 4] = f4; state[j, 5] = f5; state[j, 6] = f6; state[j, 7] = f7
        s0 += f0 * f0; s1 += f1 * f1; s2 += f2 * f2; s3 += f3 * f3
        s4 += f4 * f4; s5 += f5 * f5; s6 += f6 * f6; s7 += f7 * f7
    return ((s0 + s1) + (s2 + s3)) + ((s4 + s5) + (s6 + s7))
@numba.njit(nogil=True,error_model="numpy")
def adv_e(gain, offset, row, state):
    # interleaved (rows, blocks, 2, 4)
    n = state.size
    g = gain[row]; o = offset[row]
    for j in range(n):
        state[j] = g[j] * state[j] + o[j]
    s0 = s1 = s2 = s3 = 0.0
    for j in range(0, n, 4):
        f = state[j:j+4]
        s0 += f[0]*f[0]; s1 += f[1]*f[1]; s2 += f[2]*f[2]; s3 += f[3]*f[3]
    return (s0 + s1) + (s2 + s3)
def mk(f):
    @numba.njit
    def loop(g, o, s, rows, n):
        t = 0.0
        for i in range(n):
            t += f(g, o, rows[i & 1023], s)
        return t
    return loop
if __name__ == "__main__":
    rng = np.random.default_rng(0)
    for L in (32, 80):
        for f, lanes in ((adv_a, 0), (adv_b, 0), (adv_c, 4), (adv_d, 8), (adv_e, 0)):
            g = rng.random((4, L)) * .5; o = rng.random((4, L)); s = rng.random(L); rows = rng.integers(0, 4, 1024)
            if lanes: g = g.reshape(4, -1, lanes); o = o.reshape(4, -1, lanes); s = s.reshape(-1, lanes)
            l = mk(f); l(g, o, s, rows, 10); best = 9
            for _ in range(7):
                t = time.process_time(); l(g, o, s, rows, 200000); best = min(best, time.process_time() - t)
            asm = list(f.inspect_asm().values())[0]
            print(L, f.__name__, "%.2f ns" % (best / 200000 * 1e9), {k: len(re.findall(k, asm)) for k in ("mulpd", "addpd", "mulsd", "addsd", "zmm", "cmov")})
