exec(open("measure.py").read().split("cases =")[0])
import timeit
n, m, b = next(iter(models())); k = kernels[0]; run(k, m, b, 5000, .1, 0)
rng = np.random.default_rng(0)
data = K._DATA[id(m)]; T = K._TABLES[5000]
def tm(label, f, N=300):
    v = sorted(timeit.repeat(f, number=1, repeat=N)); print(label, "%.1f us (min %.1f)" % (v[N//2]*1e6, v[0]*1e6))
tm("default_rng", lambda: np.random.default_rng(0))
tm("pad", lambda: K.padded(b.states))
tm("tree", lambda: K.new_tree(5001, 2, 2))
tm("work", lambda: K.workspace(5001, 32))
tree = K.new_tree(5001, 2, 2); w = K.workspace(5001, 32)
tm("kernel 0 descents (boxing)", lambda: k(data, tree, T, w, 0, .1, .95, rng))
def whole():
    tree.reals[:] = 0; tree.counts[6] = 1; tree.size[0] = 1
    k(data, tree, T, w, 5000, .1, .95, rng)
tm("kernel 5000 in warm memory", whole)
def fresh():
    t = K.new_tree(5001, 2, 2); k(data, t, T, w, 5000, .1, .95, rng)
tm("kernel 5000 in fresh memory", fresh)
tm("all", lambda: run(k, m, b, 5000, .1, 0))
