import sys
base = open("kernel.py").read()
def make(name, *subs, src=base):
    for a, b in subs:
        assert a in src, (name, a)
        src = src.replace(a, b)
    open(f"v_{name}.py", "w").write(src); return src
make("rng", ('''@part
def draw(''', '''@part
def uniform(data):
    x = data.seed[0]
    x ^= x << np.uint64(13)
    x ^= x >> np.uint64(7)
    x ^= x << np.uint64(17)
    data.seed[0] = x
    return np.float64(np.int64(x >> np.uint64(11))) * 1.1102230246251565e-16


@part
def draw('''), ("rng.random()", "uniform(data)"), ("    weights: np.ndarray\n", "    weights: np.ndarray\n    seed: np.ndarray\n"),
    ("padded(belief.states), belief.weights,\n", "padded(belief.states), belief.weights, np.empty(1, np.uint64),\n"),
    ("    tree, work = _MEM", "    data.seed[0] = rng.integers(1 << 63)\n    tree, work = _MEM"))
# compile-time sizes
CT = [("tree.actions", "ACTIONS"), ("    actions, observations = ACTIONS, tree.observations\n    stride = tree.stride.size\n", "    actions, observations = ACTIONS, OBSERVATIONS\n    stride = STRIDE\n"),
      ("preferences = data.costs.size", "preferences = PREFERENCES"),
      ("def aligned(", "ACTIONS = OBSERVATIONS = PREFERENCES = 2\nSTRIDE = 8\n\n\ndef aligned(")]
make("ct", *[c for c in CT])
# reuse the costs of the candidates
make("reuse", ('''        preference = draw(data.chances, total * rng.random())
        cost = lanes.advance(data.gain, data.offset, state, first + preference * state.size)
''', '''        preference = draw(data.chances, total * rng.random())
        cost = data.costs[preference]
        row = first + preference * state.size
        for j in range(state.size):
            state[j] = data.gain[row + j] * state[j] + data.offset[row + j]
'''))
# branchless select
make("select", ('''    best, best_score = 0, -np.inf
    for action in range(tree.actions):
        score = tree.reals[here + action] + width * tables.inverse_root[tree.counts[counts_at + 1 + action]]
        if score > best_score:
            best, best_score = action, score
''', '''    best = 0
    best_score = tree.reals[here] + width * tables.inverse_root[tree.counts[counts_at + 1]]
    for action in range(1, tree.actions):
        score = tree.reals[here + action] + width * tables.inverse_root[tree.counts[counts_at + 1 + action]]
        better = score > best_score
        best = action if better else best
        best_score = score if better else best_score
'''))
# no vector intrinsic -> previous scalar loop
