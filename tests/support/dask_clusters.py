"""A scheduler and workers in processes of their own, as `dask scheduler` and `dask worker` start them."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil

SUPPORT = Path(__file__).parent
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL")}


class Cluster:
    """A scheduler on this machine, at `address`; what is started here is ended by `close`."""

    def __init__(self, folder: Path, scheme: str = "tcp", environment: Mapping[str, str] = {}) -> None:
        self._folder, self._environment = folder, environment
        self.workers: list[subprocess.Popen[bytes]] = []
        file = folder / "scheduler.json"
        options = ["--port", "0", "--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(file)]
        options += ["--idle-timeout", "3600 seconds"]  # ends, and with it the workers, whatever becomes of the tests
        self.scheduler = self._start("scheduler", [*options, "--protocol", scheme], {})
        try:
            self.address = self._address_in(file)
        except BaseException:
            self.close()
            raise

    def _address_in(self, file: Path) -> str:
        """What the scheduler writes as soon as it can be reached; not all at once."""
        deadline = time.monotonic() + 60
        while True:
            assert self.scheduler.poll() is None and time.monotonic() < deadline, self.log("scheduler")
            with suppress(FileNotFoundError, json.JSONDecodeError):
                return str(json.loads(file.read_text())["address"])
            time.sleep(0.05)

    def add(self, *options: str, nanny: bool = True, **environment: str) -> None:
        """Start a worker; without a nanny it is one process and needs to be told to use one thread."""
        name = f"worker-{len(self.workers)}"
        kind = "--nanny" if nanny else "--no-nanny"
        folder = ["--local-directory", str(self._folder / name)]
        own = environment if nanny else ONE_THREAD | environment
        options = (self.address, "--nthreads", "1", kind, "--no-dashboard", *folder, *options)
        self.workers.append(self._start("worker", list(options), own))

    def kill_one(self, rng: random.Random) -> None:
        """Kill one of the processes that do the work, which a nanny has as children, if there is one."""
        found = []
        for worker in self.workers:
            with suppress(psutil.NoSuchProcess):
                process = psutil.Process(worker.pid)
                children = [child for child in process.children() if "spawn_main" in " ".join(child.cmdline())]
                found += children if "--nanny" in process.cmdline() else [process]
        with suppress(psutil.NoSuchProcess, IndexError):
            rng.choice(found).kill()

    def log(self, name: str) -> str:
        return "\n".join(path.read_text() for path in sorted(self._folder.glob(f"{name}*.log")))

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
        for process in (*self.workers, self.scheduler):
            process.wait()

    def _start(self, kind: str, options: list[str], own: Mapping[str, str]) -> subprocess.Popen[bytes]:
        paths = os.pathsep.join(
            [*filter(None, [own.get("PYTHONPATH")]), str(SUPPORT), str(SUPPORT.parent), str(SUPPORT.parents[1])]
        )
        environment = os.environ | self._environment | own | {"PYTHONPATH": paths}
        name = f"{kind}-{len(self.workers)}" if kind == "worker" else kind
        with (self._folder / f"{name}.log").open("wb") as log:
            return subprocess.Popen(
                [sys.executable, "-m", "dask", kind, *options],
                env=environment,
                stdout=log,
                stderr=log,
                cwd=self._folder,
                start_new_session=True,
            )


@contextmanager
def cluster(folder: Path, workers: int = 2, nanny: bool = True, **options: object) -> Iterator[Cluster]:
    """A scheduler with some workers of one thread."""
    folder.mkdir(parents=True, exist_ok=True)
    it = Cluster(folder, **options)  # type: ignore[arg-type]
    try:
        for _ in range(workers):
            it.add(nanny=nanny)
        yield it
    finally:
        it.close()
