"""Per-step cost against tree size; growing a tree by a second call."""
import sys
exec(open("measure.py").read().split("cases =")[0])
n, m, b = next(iter(models())); h = SearchByHand(m)
for d in (1000, 5000, 20000, 100000):
    a, c = [], []
    for i in range(9 if d > 9000 else 41):
        t = time.process_time(); r = h(b, d, .1, 0, i); a.append((time.process_time() - t) / d / r.depth)
        rng = np.random.default_rng(i)
        t = time.process_time(); v, _, depth = K.run(kernels[0], m, b, d, .1, rng); c.append((time.process_time() - t) / d / depth)
    print(f"{d}: C++ {np.median(a)*1e9:.1f} ns a step, numba {np.median(c)*1e9:.1f}, ratio {np.median(np.array(c)/np.array(a)):.2f}, depth {depth:.2f}", flush=True)
# second call
tree, work = K.new_tree(3001, 2, 2), K.workspace(3001, 32)
data, T, rng = K._DATA[id(m)], K._TABLES[5000], np.random.default_rng(0)
for part in (1000, 2000, 500): kernels[0](data, tree, T, work, part, .1, m.discount, rng)
one = K.new_tree(3001, 2, 2); kernels[0](data, one, T, work, 3000, .1, m.discount, np.random.default_rng(0))
print("grown in parts:", tree.size, (tree.nodes.view(np.uint8) == one.nodes.view(np.uint8)).all())
