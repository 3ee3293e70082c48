"""The kinds of indicators, one file each; see `indicator.py`."""
