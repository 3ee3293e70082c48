"""A gateway to a PLC by OPC UA (asyncua): pose and cycle number go out, what was executed and what was seen come in."""

import asyncio
import os

from asyncua import Client
from face import tried

URL = os.environ.get("OPC_UA_URL", "opc.tcp://192.0.2.10:4840")
NAMESPACE = "ns=2;s=fatplan."
POSES = {"high": 1, "low": 2}  # as taught in the robot
REACTIONS = {1: "arm", 2: "back"}  # 0: nothing was seen


async def follow(plc: Client) -> None:
    """Write what to do; when the PLC says that a cycle has ended, tell what was done and seen."""
    nodes = {name: plc.get_node(NAMESPACE + name) for name in ("pose", "cycle", "executed", "seen", "ended_cycle")}
    names = {number: name for name, number in POSES.items()}
    while True:
        await asyncio.sleep(0.1)
        decision = tried("decide")
        if not decision or decision["action"] not in POSES:
            continue  # the PLC has a default pose of its own
        await nodes["pose"].write_value(POSES[decision["action"]])
        await nodes["cycle"].write_value(decision["cycle"])  # last: the PLC waits for a new number
        if await nodes["ended_cycle"].read_value() == decision["cycle"]:
            done, seen = [await nodes[name].read_value() for name in ("executed", "seen")]
            if done in names:
                said = {"observation": REACTIONS[seen]} if seen in REACTIONS else {}
                tried("observe", cycle=decision["cycle"], executed=names[done], **said)
            else:
                tried("skip", cycle=decision["cycle"])


async def main() -> None:
    """Connect, and follow until the connection breaks; a service manager starts it again."""
    async with Client(URL) as plc:
        await follow(plc)


if __name__ == "__main__":
    asyncio.run(main())
