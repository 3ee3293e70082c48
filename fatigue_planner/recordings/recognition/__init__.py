"""Which reaction a motion is: a recogniser learnt from repetitions, how often it errs, how soon it knows."""
