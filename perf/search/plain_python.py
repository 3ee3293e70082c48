"""fatigue_planner's search without compilation: one decision per request, as pomdp_py_search.py.

`compare.py` starts it with NUMBA_DISABLE_JIT=1.
"""

import json
import sys
import time
from dataclasses import replace

import numpy as np
from problems import affine_model, rested

from fatigue_planner.planners.pomcp.policy import PomcpSettings


def main() -> None:
    belief = None
    for line in sys.stdin:
        request = json.loads(line)
        if "gain" in request:
            gain, offset = np.array(request["gain"]), np.array(request["offset"])
            entries = round(1 / request["cost_scale"])
            belief = rested(affine_model(gain, offset, float(request["expertise"]), request["discount"], entries))
            reply: dict[str, object] = {"ready": True}
        else:
            assert belief is not None
            states = np.array([belief.model.state(fatigue) for fatigue in np.array(request["states"])])
            belief = replace(belief, states=states, weights=np.array(request["weights"]))
            policy = PomcpSettings(**request["settings"]).build()
            begin = time.process_time()
            decision = policy.act(belief, np.random.default_rng(request["seed"]))
            reply = {"cpu_s": time.process_time() - begin, "values": decision.values.tolist()}
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
