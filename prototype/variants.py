"""Variants of records.py with one lever taken back each."""
base = open("records.py").read()
def make(name, *subs, src=base):
    for a, b in subs:
        assert a in src, (name, a)
        src = src.replace(a, b)
    open(f"v_{name}.py", "w").write(src); return src
nrt = (', "_nrt": False}', '}')
inline = ("numba.njit(forceinline=True, **OPTIONS)", "numba.njit(**OPTIONS)")
make("nrt", nrt)
make("noinline", inline)
make("nrt_noinline", nrt, inline)
scalar = '''
@part
def s_advance(gain, offset, state, first):
    s0 = s1 = s2 = s3 = 0.0
    for j in range(0, state.size, 4):
        f0 = gain[first + j] * state[j] + offset[first + j]
        f1 = gain[first + j + 1] * state[j + 1] + offset[first + j + 1]
        f2 = gain[first + j + 2] * state[j + 2] + offset[first + j + 2]
        f3 = gain[first + j + 3] * state[j + 3] + offset[first + j + 3]
        state[j], state[j + 1], state[j + 2], state[j + 3] = f0, f1, f2, f3
        s0 += f0 * f0
        s1 += f1 * f1
        s2 += f2 * f2
        s3 += f3 * f3
    return (s0 + s1) + (s2 + s3)
'''
sq = scalar.replace("s_advance", "s_squares").replace("        state[j], state[j + 1], state[j + 2], state[j + 3] = f0, f1, f2, f3\n", "")
mv = '''
@part
def s_move(gain, offset, state, first):
    for j in range(state.size):
        state[j] = gain[first + j] * state[j] + offset[first + j]
'''
make("scalar", ("# --- the fatigue problem", scalar + sq + mv + "\n# --- the fatigue problem"), ("lanes.advance(", "s_advance("), ("lanes.squares_after(", "s_squares("), ("lanes.move(", "s_move("))
make("move_only_python", ("# --- the fatigue problem", mv + "\n# --- the fatigue problem"), ("lanes.move(", "s_move("))
make("recompute", ("lanes.move(", "cost = lanes.advance("), ("        cost = data.costs[preference]\n", ""))
make("unaligned", ("    raw = np.zeros(array.nbytes + 64, np.uint8)", "    raw = np.zeros(array.nbytes + 80, np.uint8)"), ("    skip = -raw.ctypes.data % 64\n", "    skip = -raw.ctypes.data % 64 + 16\n"))
make("notables", ('''    width = c * tables.root_log[node.visited - 1]
''', '''    log_times = np.log(float(max(node.visited - 1, 1)))
'''), ("        score = node.value[action] + width * tables.inverse_root[node.tried[action]]\n", '''        if node.tried[action] == 0:
            return action
        score = node.value[action] + c * np.sqrt(log_times / node.tried[action])
'''), ("* tables.inverse[tried]", "/ tried"))
make("logtable", ('''    width = c * tables.root_log[node.visited - 1]
''', '''    log_times = tables.root_log[node.visited - 1]
'''), ("        score = node.value[action] + width * tables.inverse_root[node.tried[action]]\n", '''        if node.tried[action] == 0:
            return action
        score = node.value[action] + c * np.sqrt(log_times / node.tried[action])
'''), ("    root_log = np.sqrt(np.log(np.maximum(n, 1)))", "    root_log = np.log(np.maximum(n, 1))"))
make("freshmem", ("    tree, work = _MEMORY[key]\n", "    tree, work = _MEMORY.pop(key)\n"))
make("tables_each", ("    if descents not in _TABLES:\n", "    if True:\n"))
make("int64", ('"visited", np.uint32', '"visited", np.int64'), ('"tried", np.uint32', '"tried", np.int64'), ('"child", np.uint32', '"child", np.int64'),
     ("np.uint32(1)", "1"), ("here = np.uint32(0)", "here = 0"), ("np.empty(capacity, np.uint32), np.empty(capacity, np.uint32)", "np.empty(capacity, np.int64), np.empty(capacity, np.int64)"))
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
# max backup over all successors, as the textbook has it
make("maxbook", ("    mean_", "    mean_") if "    mean_" in base else ("def backup_max(node, carried):", "def backup_max(node, carried):"))
