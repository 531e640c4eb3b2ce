"""Anderson's acceleration of a fixed-point iteration (D. G. Anderson, J. ACM 12 (1965) 547; Walker and Ni 2011)."""

import numpy as np


class Mixing:
    """The next guess of x = g(x) from the last few guesses and what they left, f = g(x) - x."""

    def __init__(self, depth: int):
        self.depth, self.guesses, self.left = depth, [], []

    def following(self, x: np.ndarray, f: np.ndarray, share: float = 1.0) -> np.ndarray:
        """Return the next guess; x, f: real arrays (n,); `share` of the step where nothing is known of earlier ones."""
        self.guesses.append(x)
        self.left.append(f)
        if len(self.left) > self.depth + 1:
            del self.guesses[0], self.left[0]
        if len(self.left) == 1:
            return x + share * f
        dx, df = (np.diff(np.array(each), axis=0) for each in (self.guesses, self.left))
        gram = df @ df.T
        gram += 1e-14 * np.trace(gram) * np.eye(len(gram))
        weights = np.linalg.solve(gram, df @ f)
        return x + share * f - weights @ (dx + share * df)
