"""Dump trees of small searches, to compare compiled and plain runs bit by bit."""
import sys, hashlib
exec(open("measure.py").read().split("cases =")[0])
import dataclasses
for n, m, b in models():
    for beta in (m.expertise, 2000.0):
        mm = dataclasses.replace(m, expertise=beta)
        for mx in (0, 1):
            v, tried, depth = K.run(kernels[mx], mm, b, 400, .1, np.random.default_rng(3))
            tree, work = K._MEMORY[400, 2, -(-m.gain.shape[-1] // 8) * 8]
            first = hashlib.sha256(tree.nodes[:tree.size[0]].tobytes()).hexdigest()[:12]
            K._DATA.clear()
            print(n, beta, mx, v, tried.tolist(), first)
