"""The process that writes a journal: events come as lines of JSON, and what is on the disk is reported back.

No answer to the robot waits for a disk. A commit that fails is not tried again: after a failed fsync a second one may
report success although the data are gone. The process says so and ends.
"""

import json
import os
import signal
import sqlite3
import sys
from contextlib import closing, suppress
from pathlib import Path

from fatigue_planner.live.journal_file import append, connect, last_row

STDIN, STDOUT = 0, 1
CHUNK_BYTES = 1 << 16


def main(path: Path) -> None:
    """Append what comes on standard input until it ends; the database is then whole without its write-ahead log."""
    for stop in (signal.SIGINT, signal.SIGTERM):
        signal.signal(stop, signal.SIG_IGN)  # it ends when its session does, with everything written
    try:
        with closing(connect(path)) as connection:
            number, digest = last_row(connection)
            _say({"durable": number})
            rest = b""
            while chunk := os.read(STDIN, CHUNK_BYTES):
                *lines, rest = (rest + chunk).split(b"\n")
                rows, workers = [], []
                for message in map(json.loads, lines):
                    if "worker" in message:
                        workers.append(message["worker"])
                    elif message["row"][0] > number:  # sent again after a process before this one had ended
                        rows.append(tuple(message["row"]))
                for worker in workers:
                    connection.execute("INSERT OR IGNORE INTO worker VALUES (?, ?)", worker)
                if rows:
                    digest = append(connection, digest, rows)
                    number = rows[-1][0]
                if lines:
                    _say({"durable": number})
    except (sqlite3.Error, OSError) as error:
        _say({"failed": f"{type(error).__name__}: {error}"})


def _say(what: dict[str, object]) -> None:
    with suppress(BrokenPipeError):  # the session was killed; what it had handed over is written all the same
        os.write(STDOUT, json.dumps(what).encode() + b"\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
