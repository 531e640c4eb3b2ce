"""Fields that several tests ask for are solved once in a process."""

import pickle
from functools import wraps


def solved_once(solve):
    """Return a solver that keeps all its answers; a test of many large fields takes its ``__wrapped__``."""
    known = {}

    @wraps(solve)
    def answer(*given, **options):
        question = pickle.dumps((given, sorted(options.items())))
        if question not in known:
            known[question] = solve(*given, **options)
        return known[question]

    return answer
