import sys
who, case, mx, N = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]); sys.argv = ["x", "kernel" if who == "cpp" else who, "0"]
exec(open("measure.py").read().split("cases =")[0])
n, m, b = list(models())[case]
if who == "cpp":
    h = SearchByHand(m)
    for i in range(N): h(b, 5000, .1, mx, i)
else:
    for i in range(N): run(kernels[mx], m, b, 5000, .1, i)
