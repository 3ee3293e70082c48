"""A workstation as an ergonomist describes it, and what is to be said of it: who can work where, and how well."""
