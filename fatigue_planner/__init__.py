"""fatplan: plan a cobot's choices so that a worker's fatigue stays low in the long run."""

from importlib.metadata import version

__version__ = version("fatigue-planner")
