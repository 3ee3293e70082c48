"""fatigue_planner's search without compilation: one decision per request, as pomdp_py_search.py.

`compare.py` starts it with NUMBA_DISABLE_JIT=1.
"""

import json
import sys
import time

import numpy as np
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp

from fatigue_planner.planners.registry import PomcpSettings, build_policy


def main() -> None:
    np.seterr(divide="ignore")  # log 0 at a node without visits, as in compiled code
    model = None
    for line in sys.stdin:
        request = json.loads(line)
        if "gain" in request:
            gain = np.array(request["gain"])
            model = FatiguePomdp(
                actions=tuple(str(a) for a in range(gain.shape[0])),
                preferences=tuple(str(u) for u in range(gain.shape[1])),
                gain=gain,
                offset=np.array(request["offset"]),
                observation=np.eye(gain.shape[1]),
                expertise=float(request["expertise"]),
                discount=request["discount"],
                entries=round(1 / request["cost_scale"]),
                live=np.arange(gain.shape[2]),
            )
            reply: dict[str, object] = {"ready": True}
        else:
            belief = Belief(np.array(request["states"]), np.array(request["weights"]))
            settings = PomcpSettings(**request["settings"])
            begin = time.process_time()
            decision = build_policy(model, settings).act(belief, np.random.default_rng(request["seed"]))
            reply = {"cpu_s": time.process_time() - begin, "values": decision.values.tolist()}
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
