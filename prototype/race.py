"""Interleaved race of kernel modules named on the command line; ratios to C++."""
import sys
MODS = sys.argv[1:]; sys.argv = ["x", MODS[0], "0"]
exec(open("measure.py").read().split("cases =")[0])
import os
Ms = [importlib.import_module(x) for x in MODS]; ks = [M.kernels() for M in Ms]
ROUNDS = int(os.environ.get("ROUNDS", 61))
print(f"{'':26s}", "   cpp ms", *(f"{x:>10s}" for x in MODS))
keep = list(models())
for M in Ms[1:]: M._TABLES = Ms[0]._TABLES
for n, m, b in keep:
    if n == "multiple_novice": continue
    h = SearchByHand(m)
    for mx in (0, 1):
        T = [[] for _ in range(len(Ms) + 1)]
        for i in range(ROUNDS):
            t = time.process_time(); h(b, 5000, .1, mx, i); T[0].append(time.process_time() - t)
            for M in Ms[1:]: M._MEMORY = Ms[0]._MEMORY
            for j, (M, k) in sorted(enumerate(zip(Ms, ks)), key=lambda p: (p[0] + i) % len(Ms)):
                r = np.random.default_rng(i)
                t = time.process_time(); M.run(k[mx], m, b, 5000, .1, r); T[j + 1].append(time.process_time() - t)
        T = np.array(T)[:, 2:]
        print(f"{n:20s} {'max ' if mx else 'mean'}  {np.median(T[0])*1e3:8.3f}", *(f"{np.median(t/T[0]):10.3f}" for t in T[1:]), flush=True)
