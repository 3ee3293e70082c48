"""Ratio to C++, interleaved."""
import sys, time, pickle
sys.path.insert(0, "../benchmarks/search")
import numpy as np
from fatigue_planner.pomdp.model import FatiguePomdp
from fatigue_planner.pomdp.belief import Belief
from by_hand import SearchByHand
import importlib
K = importlib.import_module(sys.argv[1] if len(sys.argv) > 1 else "kernel")
P = pickle.load(open("/tmp/problems.pkl", "rb"))
def models():
    for name, (d, s, w) in P.items():
        yield name, FatiguePomdp(actions=("a","b"), preferences=("a","b"), live=np.arange(d["gain"].shape[-1]), **d), Belief(s, w)
    rng = np.random.default_rng(5); d = dict(P["single_novice"][0])
    d["gain"] = rng.uniform(.6, .99, (2, 2, 78)); d["offset"] = rng.uniform(0, .1, (2, 2, 78)) * (1 - d["gain"])
    for n, e in (("78 novice", 0.0), ("78 expert", np.inf)):
        d["expertise"] = e
        yield n, FatiguePomdp(actions=("a","b"), preferences=("a","b"), live=np.arange(78), **d), Belief(np.zeros((1, 78)), np.ones(1))
t0 = time.process_time()
kernels = K.kernels()
T = None
def run(kernel, m, b, descents, c, seed):
    return K.run(kernel, m, b, descents, c, np.random.default_rng(seed))
cases = [(n, m, b, c, mx) for n, m, b in models() for c in (.1, .001) for mx in (0, 1) if not (__import__("os").environ.get("QUICK") and (c < .1 or n[:3] == "mul" or not n.startswith(__import__("os").environ["QUICK"].strip("1"))))]
first = {}
for mx in (0, 1):
    t = time.process_time(); run(kernels[mx], *cases[0][1:3], 10, .1, 0); print("compile", mx, "%.2f s" % (time.process_time() - t))
H = {}
R = {}
for n, m, b, c, mx in cases:
    if n not in H: H[n] = SearchByHand(m)
    t1, t2, V, W = [], [], [], []
    for i in range(int(sys.argv[2]) if len(sys.argv) > 2 else 41):
        t = time.process_time(); r = H[n](b, 5000, c, mx, i); t1.append(time.process_time() - t)
        rng = np.random.default_rng(i)
        t = time.process_time(); v, tried, depth = K.run(kernels[mx], m, b, 5000, c, rng); t2.append(time.process_time() - t)
        V.append(r.values); W.append(v)
    V, W = np.array(V), np.array(W)
    z = np.abs(V.mean(0) - W.mean(0)) / np.sqrt((V.var(0) + W.var(0)) / len(V) + 1e-32)
    ratio = np.median(t2) / np.median(t1)
    print(f"{n:16s} c={c:<6} {'max ' if mx else 'mean'} cpp {np.median(t1)*1e3:.3f} numba {np.median(t2)*1e3:.3f} ratio {ratio:.2f} (quartiles {np.quantile(np.array(t2)/np.array(t1),.25):.2f}-{np.quantile(np.array(t2)/np.array(t1),.75):.2f}) depth {r.depth:.2f} {depth:.2f} z {z.max():.1f} diff {np.abs(V-W).max():.1e}")
