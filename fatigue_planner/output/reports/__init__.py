"""The pages that people read: results of an experiment, a sensitivity study, the digital human."""
