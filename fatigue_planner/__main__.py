"""`python -m fatigue_planner`: the command `fatplan`."""

from fatigue_planner.cli.entry import run

if __name__ == "__main__":
    run()
