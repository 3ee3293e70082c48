"""Ratios to C++ of kernel variants, each in processes of its own, in turn; medians over processes."""
import os, re, subprocess, sys, statistics
from collections import defaultdict
base, variants, repeats = sys.argv[1], sys.argv[2:], int(os.environ.get("REPEATS", 3))
R = defaultdict(lambda: defaultdict(list))
for _ in range(repeats):
    for v in [base, *variants]:
        out = subprocess.run([sys.executable, "measure.py", v, os.environ.get("ROUNDS", "31")], capture_output=True, text=True, env={**os.environ, "QUICK": os.environ.get("QUICK", "1")})
        if out.returncode: print(v, out.stderr[-600:])
        for line in out.stdout.splitlines():
            if m := re.match(r"(.*?)\s+c=0.1\s+(\w+).*ratio ([\d.]+)", line): R[v][m[1] + " " + m[2]].append(float(m[3]))
names = list(R[base])
print(" " * 14, *(f"{n:>18s}" for n in names))
for v in [base, *variants]: print(f"{v:14s}", *(f"{statistics.median(R[v][n]) if R[v][n] else 0:18.2f}" for n in names))
