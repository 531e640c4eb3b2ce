"""The solvers: roots, segments between events, time stepping, cycle means, averaged equations, shooting."""
