"""Plug-ins that leave no trace in the process that loads them."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from fatigue_planner.core import plugins
from fatigue_planner.output.reports.results import report


@contextmanager
def forgotten_plugins() -> Iterator[None]:
    """What is registered within is unknown afterwards."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(plugins, "_SOURCES", {})
        for registry in plugins._REGISTRIES:
            monkeypatch.setattr(registry, "_kinds", dict(registry._kinds))
            monkeypatch.setattr(registry, "_adapter", None)
        monkeypatch.setattr(report, "SECTIONS", dict(report.SECTIONS))
        yield
    plugins.load_installed_plugins.cache_clear()
    for name in [name for name in sys.modules if name.startswith(plugins.MODULE_PREFIX)]:
        del sys.modules[name]
