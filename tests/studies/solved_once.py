"""Fields that several tests ask for are solved once in a process."""

import pickle
from inspect import signature


def solved_once(solve):
    """Return a solver that keeps its answers, and says again what it said."""
    known = {}

    def answer(*given, **options):
        progress = options.pop("progress", None)
        question, said = pickle.dumps((given, sorted(options.items()))), []
        if question not in known:
            heard = {"progress": said.append} if "progress" in signature(solve).parameters else {}
            known[question] = solve(*given, **options, **heard), said
        found, said = known[question]
        for text in said if progress else ():
            progress(text)
        return found

    return answer
