import sys, re, importlib
import numpy as np
exec(open("measure.py").read().split("cases =")[0])
k = kernels[int(sys.argv[2]) if len(sys.argv)>2 else 0]
n, m, b = next(iter(models())); run(k, m, b, 10, .1, 0)
# force recompilation w/o cache for asm
f = numba.njit(nogil=True, error_model="numpy", _nrt=False)(k.py_func) if (numba:=importlib.import_module("numba")) else 0
run(f, m, b, 10, .1, 0)
asm = f.inspect_asm(f.signatures[0]); ll = f.inspect_llvm(f.signatures[0])
open("/tmp/k.s","w").write(asm); open("/tmp/k.ll","w").write(ll)
body = asm
print("lock", len(re.findall(r"\block\b", body)), "NRT", len(re.findall("NRT_(inc|dec)ref", body)))
from collections import Counter
print(Counter(re.findall(r"call\S*\s+(\S+)", body)).most_common(30))
print(len(body.splitlines()))
for d in (1, 1000, 5000):
    best = 9
    for _ in range(50):
        t = time.perf_counter(); run(k, m, b, d, .1, 0); best = min(best, time.perf_counter() - t)
    print(d, best * 1e6, "us")
