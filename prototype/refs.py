import sys
exec(open("measure.py").read().split("cases =")[0])
import numba, re
n, m, b = next(iter(models()))
for f in (K.begin, K.step, K.ucb1, K.backup_mean, K.backup_max):
    g = numba.njit(nogil=True, error_model="numpy")(f.py_func)
    # types via the cached dispatcher
    sigs = f.signatures
    print(f.__name__, len(sigs))
