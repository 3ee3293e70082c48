"""A stand-in of a UR controller: RTDE protocol version 2 over TCP, and robot programs that echo what they execute.

It is a process of its own, for ur_rtde holds Python's lock while it connects.

Packages are a size (uint16, big-endian, header included), a type (uint8) and a payload; see the RTDE guide of Universal
Robots. Inputs and outputs are named in recipes, which the client sets up before it starts.
"""

import json
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Self

PORT = 30004
PERIOD_S = 0.02
TYPES = {"DOUBLE": "d", "INT32": "i", "UINT32": "I", "UINT8": "B", "UINT64": "Q", "VECTOR6D": "6d"}


def type_of(name: str) -> str:
    """The type of a field, as far as clients here ask for it."""
    if "int_register" in name:
        return "INT32"
    if name == "timestamp" or name.endswith("fraction") or "double_register" in name:
        return "DOUBLE"
    if "analog_output_" in name:
        return "UINT8" if name.endswith(("mask", "type")) else "DOUBLE"
    if name in ("speed_slider_mask", "robot_status_bits", "runtime_state"):
        return "UINT32"
    return "UINT8"


def form(names: list[str]) -> str:
    """How fields are packed."""
    return ">" + "".join(TYPES[type_of(name)] for name in names)


class Client:
    """What a client has set up."""

    def __init__(self) -> None:
        self.outputs: list[str] = []
        self.inputs: dict[int, list[str]] = {}
        self.streaming = False

    def reply(self, kind: str, payload: bytes) -> bytes:
        """What is answered to a request."""
        if kind == "v":
            return struct.pack(">4I", 5, 12, 0, 0)
        if kind in "SP":
            self.streaming = kind == "S"
        if kind not in "OI":
            return b"\x01"
        names = [name for name in payload[8 if kind == "O" else 0 :].decode().split(",") if name]
        number = 1
        if kind == "O":
            self.outputs = names
        else:
            number = len(self.inputs) + 1
            self.inputs[number] = names
        return bytes([number]) + ",".join(map(type_of, names)).encode()

    def inputs_of(self, payload: bytes) -> dict[str, int]:
        """The inputs that a package holds."""
        names = self.inputs[payload[0]]
        return dict(zip(names, map(int, struct.unpack(form(names), payload[1:])), strict=True))


class Controller:
    """Serves one address; `registers` are the integer registers, by name, of inputs and outputs.

    program: what the robot does with its registers, called every few milliseconds.
    """

    def __init__(self, host: str, program: Callable[[dict[str, int]], None] = lambda _: None) -> None:
        self.host, self.program = host, program
        self.registers: dict[str, int] = {}
        self.clients = 0
        self._began = time.monotonic()
        self._open: list[socket.socket] = []
        self._frozen = threading.Event()
        self.start()

    def start(self) -> None:
        """Switch on."""
        self._on = True
        self._listening = socket.create_server((self.host, PORT))
        self._threads = [threading.Thread(target=self._accept, daemon=True)]
        self._threads[0].start()

    def stop(self) -> None:
        """Switch off: all connections end."""
        self._on = False
        for one in (self._listening, *self._open):
            with suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()
        for thread in self._threads:
            thread.join(5)
        self._open = []

    def freeze(self, frozen: bool) -> None:
        """Keep the connections, but say nothing any more, as when a cable is pulled."""
        (self._frozen.set if frozen else self._frozen.clear)()

    def _accept(self) -> None:
        while self._on:
            try:
                client, _ = self._listening.accept()
            except OSError:
                return
            self._open.append(client)
            self.clients += 1
            self._threads.append(threading.Thread(target=self._serve, args=(client,), daemon=True))
            self._threads[-1].start()

    def _serve(self, client: socket.socket) -> None:
        one, buffer = Client(), b""
        client.settimeout(PERIOD_S)
        while self._on:
            try:
                buffer += (chunk := client.recv(4096))
                if not chunk:
                    return
            except TimeoutError:
                pass
            except OSError:
                return
            while len(buffer) >= 3 and len(buffer) >= (size := struct.unpack(">H", buffer[:2])[0]):
                kind, payload, buffer = chr(buffer[2]), buffer[3:size], buffer[size:]
                if kind == "U":
                    self.registers.update(one.inputs_of(payload))
                else:
                    self._send(client, kind, one.reply(kind, payload))
            if not self._frozen.is_set():
                self.program(self.registers)
                if one.streaming:
                    known = {"timestamp": time.monotonic() - self._began, **self.registers}
                    values = [known.get(name, 0) for name in one.outputs]
                    self._send(client, "U", b"\x01" + struct.pack(form(one.outputs), *values))

    def _send(self, client: socket.socket, kind: str, payload: bytes) -> None:
        with suppress(OSError):
            client.sendall(struct.pack(">HB", 3 + len(payload), ord(kind)) + payload)


class ControllerProcess:
    """A controller in a process of its own, on an address of this machine."""

    def __init__(self, host: str) -> None:
        self.host = host
        command = [sys.executable, str(Path(__file__)), host]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.ask()

    def ask(self, *words: object) -> dict[str, int]:
        """Let it do something (see `PROGRAMS`, and "stop", "start", "freeze", "thaw"); its registers afterwards."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(" ".join(map(str, words)) + "\n")
        self._process.stdin.flush()
        return dict(json.loads(self._process.stdout.readline()))

    def close(self) -> None:
        """End it."""
        with self._process as running:
            running.kill()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


ASKED_POSE, ASKED_CYCLE = "input_int_register_42", "input_int_register_43"
POSE, CYCLE = "output_int_register_36", "output_int_register_37"


def echo(registers: dict[str, int]) -> None:
    """Execute what is asked, and say so."""
    registers[POSE], registers[CYCLE] = registers.get(ASKED_POSE, 0), registers.get(ASKED_CYCLE, 0)


def other(registers: dict[str, int]) -> None:
    """Execute the other one of two poses."""
    registers[POSE], registers[CYCLE] = 3 - registers.get(ASKED_POSE, 0), registers.get(ASKED_CYCLE, 0)


def absurd(registers: dict[str, int]) -> None:
    """Say what cannot be."""
    registers[POSE], registers[CYCLE] = -7, 2**31 - 1


PROGRAMS: dict[str, Callable[[dict[str, int]], None]] = {
    "echo": echo, "other": other, "absurd": absurd, "silent": lambda _: None,
}  # fmt: skip


def main(host: str) -> None:
    """Serve, and do what comes on standard input."""
    controller = Controller(host, echo)
    for line in sys.stdin:
        match line.split():
            case ["stop"]:
                controller.stop()
            case ["start"]:
                controller.start()
            case ["freeze" | "thaw" as word]:
                controller.freeze(word == "freeze")
            case ["set", name, value]:
                controller.registers[name] = int(value)
            case [name] if name in PROGRAMS:
                controller.program = PROGRAMS[name]
        print(json.dumps({**controller.registers, "clients": controller.clients}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
