"""How fatigue grows and fades: the kinds of fatigue laws; see `law.py`."""
