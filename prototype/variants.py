base = open("records.py").read()
def make(name, *subs, src=base):
    for a, b in subs:
        assert a in src, (name, a)
        src = src.replace(a, b)
    open(f"v_{name}.py", "w").write(src); return src
d = ('''    for index in range(probabilities.size - 1):
        threshold -= probabilities[index]
        if threshold < 0:
            return index
    return probabilities.size - 1
''', '''    index, below = 0, 0.0
    for i in range(probabilities.size - 1):
        below += probabilities[i]
        index += threshold >= below
    return index
''')
l = open("lanes.py").read()
for w in (4, 16):
    open(f"lanes{w}.py", "w").write(l.replace("WIDTH = 8", f"WIDTH = {w}"))
    make(f"w{w}", ("import lanes\n", f"import lanes{w} as lanes\n"))
make("draw", d)
make("draw16", d, ("import lanes\n", "import lanes16 as lanes\n"))
