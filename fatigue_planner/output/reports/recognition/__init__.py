"""The report of a recogniser: confusions, how soon a reaction is known, whether its probabilities are true."""
