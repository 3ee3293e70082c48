"""What people look at: figures, reports and the viewer."""

import contextlib
import os
import sys
from pathlib import Path
from unittest import mock

try:
    import matplotlib as _matplotlib
except ImportError:
    raise
except Exception:
    # a backend that is not installed here, as a notebook hands it on; a matplotlibrc in the working folder or at home
    with contextlib.chdir(Path(__file__).parent), mock.patch.dict(os.environ, {"MATPLOTLIBRC": os.devnull}):
        os.environ.pop("MPLBACKEND", None)
        for name in [name for name in sys.modules if name.partition(".")[0] == "matplotlib"]:
            del sys.modules[name]
        import matplotlib as _matplotlib  # noqa: F401
