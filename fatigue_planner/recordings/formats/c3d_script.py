"""Reads C3D files with two libraries in a process of its own; see `core.reading_process` for how it is asked.

It imports nothing of fatplan. No name, date or remark of the file is in its answer but the labels of points. The answer
has `about` and the arrays: positions (n, k, 3), then force, moment (m, 3) and corners (4, 3) of every plate.
"""

import json
import os
import resource
import signal
import sys
import tempfile
import warnings
from multiprocessing.connection import Connection
from typing import Any

import c3d
import ezc3d
import numpy as np

# Address space: of Python and its libraries, and for every byte of the file; ezc3d has an object per point.
OWN_BYTES, PER_BYTE = 900 * 2**20, 100
# Points that both libraries see may differ by rounding: this share of the largest coordinate.
ROUNDING = 1e-4
# The groups of POINT that name what is stored among the points and is none.
NO_POINTS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")
MAX_LABEL_LISTS = 100

Array = np.ndarray[Any, Any]


def read(content: bytes, request: dict[str, Any]) -> tuple[dict[str, Any], list[Array]]:
    """What the readers say, and the arrays of the one that is believed. Raises ValueError if none can read it."""
    wanted, refused, found = request["reader"], {}, {}
    for name, reader in (("ezc3d", _by_ezc3d), ("c3d", _by_c3d)):
        if wanted in (None, name):
            try:
                found[name] = reader(content)
            except Exception as error:  # either may raise anything on a damaged file
                refused[name] = f"{type(error).__name__}: {error}"[:200]
    if not found:
        raise ValueError("; ".join(f"{name}: {why}" for name, why in refused.items()))
    chosen = next(iter(found))
    about, arrays = found[chosen]
    if len(found) > 1:
        about["difference"] = _difference(*(each[0] for _, each in found.values()))
    return about | {"reader": chosen, "refused": refused}, arrays


def _by_ezc3d(content: bytes) -> tuple[dict[str, Any], list[Array]]:
    file = os.memfd_create("c3d")  # it reads by name only
    try:
        os.write(file, content)
        path = f"/proc/self/fd/{file}"
        data = ezc3d.c3d(path)
        plates, no_plates = [], ""
        if "FORCE_PLATFORM" in data["parameters"]:
            try:
                plates = ezc3d.c3d(path, extract_forceplat_data=True)["data"]["platform"]
            except Exception as error:
                no_plates = str(error)[:200]
    finally:
        os.close(file)
    parameters = data["parameters"]

    def values(key: str, group: str = "POINT") -> list[Any]:
        return list(parameters.get(group, {}).get(key, {}).get("value", []))

    points = data["data"]["points"][:3].transpose(2, 1, 0)
    if points.size == 0:
        raise ValueError("no points found")
    unseen = data["data"]["meta_points"]["residuals"][0].T < 0
    position = np.where(unseen[..., None], np.nan, points)
    plates = [plate for plate in plates if plate["force"].size]
    about = _about(values, float(data["header"]["points"]["frame_rate"])) | {
        "no_plates": no_plates,
        "plates": [{"moment_unit": str(plate["unit_moment"])} for plate in plates],
        "plate_types": [int(kind) for kind in values("TYPE", "FORCE_PLATFORM")],
    }
    arrays = [position]
    for plate in plates:
        arrays += [plate["force"].T, plate["moment"].T, plate["corners"].T]
    return about, arrays


def _by_c3d(content: bytes) -> tuple[dict[str, Any], list[Array]]:
    with tempfile.TemporaryFile() as file:  # unlike a stream in memory, a file refuses a negative length
        file.write(content)
        return _all_of(c3d.Reader(file))


def _all_of(reader: c3d.Reader) -> tuple[dict[str, Any], list[Array]]:

    def values(key: str) -> list[Any]:
        parameter = reader.get(f"POINT:{key}")
        if parameter is None:
            return []
        try:
            return list(parameter.string_array if parameter.bytes_per_element < 0 else [parameter.float_value])
        except Exception:  # a parameter that is not what it should be
            return []

    frames = [points for _, points, _ in reader.read_frames(copy=True)]
    points = np.array(frames)
    if points.size == 0:
        raise ValueError("no points found")
    position = np.where(points[..., 3:4] < 0, np.nan, points[..., :3]).astype(float)
    no_plates = "the plates can only be read with ezc3d" if reader.get("FORCE_PLATFORM:TYPE") is not None else ""
    about = _about(values, float(reader.header.frame_rate))
    return about | {"no_plates": no_plates, "plates": [], "plate_types": []}, [position]


def _about(values: Any, header_rate: float) -> dict[str, Any]:
    def texts(key: str) -> list[str]:
        return [str(text).strip().encode("utf-8", "backslashreplace").decode() for text in values(key)]

    names = ["LABELS", *(f"LABELS{number}" for number in range(2, MAX_LABEL_LISTS))]
    rate = values("RATE")
    return {
        "labels": [label for name in names for label in texts(name)],
        "unit": next(iter(texts("UNITS")), ""),
        "rate": float(rate[0]) if rate else header_rate,
        "up": next(iter(texts("Y_SCREEN")), ""),
        "no_points": {group: texts(group) for group in NO_POINTS},
    }


def _difference(first: Array, second: Array) -> dict[str, float]:
    """By how much two readings differ, and in which share of the points one is missing in one of them only."""
    if first.shape != second.shape:
        return {"shape": 1.0}
    seen, also = (np.isfinite(points).all(axis=-1) for points in (first, second))
    both = seen & also
    if (share := float((seen != also).mean())) > 0.001:
        return {"missing": share}
    apart = float(abs(first - second)[both].max(initial=0.0))
    return {"apart": apart} if apart > ROUNDING * abs(first[both]).max(initial=0.0) else {}


def _answer(connection: Connection, content: bytes, request: dict[str, Any]) -> None:
    most = OWN_BYTES + PER_BYTE * len(content)
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    try:
        about, arrays = read(content, request)
        arrays = [np.ascontiguousarray(array, dtype="<f8") for array in arrays]
    except Exception as error:
        connection.send_bytes(json.dumps({"error": f"cannot be read as C3D ({error})"[:500]}).encode())
    else:
        shapes = [[array.dtype.str, array.shape] for array in arrays]
        connection.send_bytes(json.dumps({"about": about, "shapes": shapes}).encode())
        for array in arrays:
            connection.send_bytes(array.tobytes())


def main(descriptor: int) -> None:
    """Answer requests until the other end is closed."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.simplefilter("ignore")
    connection = Connection(descriptor)
    connection.send_bytes(b"")
    while True:
        try:
            request = json.loads(connection.recv_bytes())
            content = connection.recv_bytes()
        except EOFError:
            return
        signal.setitimer(signal.ITIMER_PROF, request["most_seconds"])  # ends this process, whatever it computes
        _answer(connection, content, request)
        signal.setitimer(signal.ITIMER_PROF, 0)
        del content


if __name__ == "__main__":
    main(int(sys.argv[1]))
