"""POMCP and POMCP-Max: the tree search and its parts (UCB1, backups, leaf values). `search.py` is read first."""
