"""The other end of an environment, in Python: a simulation, and what connects it."""
