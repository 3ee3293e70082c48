base = open("records.py").read()
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
copy = ('''    for j in range(state.size):
        state[j] = data.states[particle, j]
''', '''    state[:] = data.states[particle]
''')
make("copy", copy)
make("nobegin", ('''    for j in range(state.size):
        state[j] = data.states[particle, j]
''', ''))
make("const", ("int(rng.random() * preferences)", "(data.costs.size + int(state[0] * 1e9)) & 1"))
make("nostep", ("        cost = lanes.advance(data.gain, data.offset, state, first + preference * state.size)\n    else","        cost = data.gain[preference]\n    else"))
make("nodiv", ("tables.inverse[tried]", "0.01"))
