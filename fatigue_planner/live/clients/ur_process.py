"""The process in which ur_rtde lives: poses come as lines on standard input, what the registers hold goes out as lines.

ur_rtde 1.6.5 holds Python's lock while it waits for a controller that does not answer, and ends the process if an
interface is destroyed whose connection is broken; so it has one that may be killed.
"""

import json
import os
import select
import sys

from rtde_io import RTDEIOInterface
from rtde_receive import RTDEReceiveInterface

STDIN, STDOUT = 0, 1  # to which it prints
EVERY_S, FREQUENCY_HZ = 0.02, 50.0
POSE, CYCLE = 42, 43
# It reads 36 to 43, whatever its documentation says.
ECHOED = (36, 37, 38)


def main(host: str) -> None:
    """Write and read registers until standard input ends or the connection breaks."""
    told = os.dup(STDOUT)
    os.dup2(os.open(os.devnull, os.O_WRONLY), STDOUT)
    variables = ["timestamp", *(f"output_int_register_{number}" for number in ECHOED)]
    receive = RTDEReceiveInterface(host, FREQUENCY_HZ, variables, False, True)
    send = RTDEIOInterface(host, False, True)
    rest = b""
    while receive.isConnected():
        if select.select([STDIN], [], [], EVERY_S)[0]:
            said = os.read(STDIN, 4096)
            if not said:
                return
            *lines, rest = (rest + said).split(b"\n")
            for line in lines:
                pose, cycle = json.loads(line)
                send.setInputIntRegister(POSE, pose)
                send.setInputIntRegister(CYCLE, cycle)  # last: the program waits for a new one
        values = [receive.getTimestamp(), *(receive.getOutputIntRegister(number) for number in ECHOED)]
        os.write(told, json.dumps(values).encode() + b"\n")


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except (RuntimeError, OSError):
        os._exit(1)
    os._exit(0)
