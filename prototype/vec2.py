from vec import *
@numba.njit(nogil=True,error_model="numpy")
def acc_f(gain, offset, row, state, acc):
    # acc lanes in memory
    g = gain[row]; o = offset[row]
    acc[:] = 0.0
    for b in range(state.shape[0]):
        for k in range(8):
            f = g[b, k] * state[b, k] + o[b, k]
            state[b, k] = f
            acc[k] += f * f
    return ((acc[0] + acc[1]) + (acc[2] + acc[3])) + ((acc[4] + acc[5]) + (acc[6] + acc[7]))
@numba.njit(nogil=True,error_model="numpy")
def half_g(gain, offset, row, state, sq):
    # squares into memory, halved by vector loops: n a power-of-two multiple ...
    n = state.size
    for j in range(n):
        f = gain[row, j] * state[j] + offset[row, j]
        state[j] = f
        sq[j] = f * f
    s0 = s1 = s2 = s3 = 0.0
    for j in range(0, n, 4):
        s0 += sq[j]; s1 += sq[j+1]; s2 += sq[j+2]; s3 += sq[j+3]
    return (s0 + s1) + (s2 + s3)
def mk(f):
    @numba.njit
    def loop(g, o, s, a, rows, n):
        t = 0.0
        for i in range(n):
            t += f(g, o, rows[i & 1023], s, a)
        return t
    return loop
rng = np.random.default_rng(0)
for L in (32, 80):
    for f, lanes in ((acc_f, 8), (half_g, 0)):
        g = rng.random((4, L)) * .5; o = rng.random((4, L)); s = rng.random(L); rows = rng.integers(0, 4, 1024); a = np.zeros(L)
        if lanes: g = g.reshape(4, -1, lanes); o = o.reshape(4, -1, lanes); s = s.reshape(-1, lanes)
        l = mk(f); l(g, o, s, a, rows, 10); best = 9
        for _ in range(7):
            t = time.process_time(); l(g, o, s, a, rows, 200000); best = min(best, time.process_time() - t)
        asm = list(f.inspect_asm().values())[0]
        print(L, f.__name__, "%.2f ns" % (best / 200000 * 1e9), {k: len(re.findall(k, asm)) for k in ("mulpd", "addpd", "mulsd", "addsd", "zmm", "cmov")})
