"""The page of an assessed station, in the languages of `texts`, and the comparison of two assessments."""
