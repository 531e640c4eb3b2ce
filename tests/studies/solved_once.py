"""Fields that several tests ask for are solved once in a process, as long as there is room to keep them."""

import gc
import pickle
import sys
from collections import OrderedDict
from functools import wraps
from types import BuiltinFunctionType, FunctionType, ModuleType

import numpy as np

ROOM = 600_000_000  # bytes of all kept answers; the field of a small motor takes 40 MB, of twente 90


def bytes_of(root) -> int:
    """Return the memory of an object with all that it refers to, but for code; what a closure holds counts."""
    seen: set[int] = set()
    total, waiting = 0, [root]
    while waiting:
        each = waiting.pop()
        if id(each) in seen or isinstance(each, type | ModuleType | BuiltinFunctionType | np.ufunc):
            continue
        seen.add(id(each))
        if isinstance(each, FunctionType):
            waiting.extend(each.__closure__ or ())  # and not its module, which refers to everything
        elif isinstance(each, np.ndarray) and each.base is not None:
            waiting.append(each.base)  # a view
        else:
            total += sys.getsizeof(each, 0)
            waiting.extend(gc.get_referents(each))
    return total


class Kept:
    """The latest answers to questions, as many as fit into the room; the one asked for longest ago goes first."""

    def __init__(self, room: int) -> None:
        self.room = room
        self.answers: OrderedDict = OrderedDict()  # question: (answer, bytes)

    def __call__(self, question, solve):
        """Return the answer to a question, by ``solve`` where it is not kept."""
        if question not in self.answers:
            answer = solve()
            self.answers[question] = answer, bytes_of(answer)
        self.answers.move_to_end(question)
        answer = self.answers[question][0]
        while len(self.answers) > 1 and sum(size for _, size in self.answers.values()) > self.room:
            self.answers.popitem(last=False)
        return answer


FIELDS = Kept(ROOM)


def solved_once(solve, kept: Kept = FIELDS):
    """Return a solver that keeps its latest answers; a test of many large fields takes its ``__wrapped__``."""

    @wraps(solve)
    def answer(*given, **options):
        question = pickle.dumps((solve.__module__, solve.__qualname__, given, sorted(options.items())))
        return kept(question, lambda: solve(*given, **options))

    return answer
