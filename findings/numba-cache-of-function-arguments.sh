#!/usr/bin/env bash
# numba 0.68.1: a function with cache=True that takes compiled functions as arguments, called by one process after another.
# Guess:     the second process loads from the cache what the first has compiled; or nothing of it is cached.
# Behaviour: the type of a function argument is another one in every process, so that each compiles again and adds its
#            entries to the index of the cache. Of the functions named there numba keeps the 128 latest that it has read
#            (NUMBA_FUNCTION_CACHE_SIZE); once the index has more, it cannot be written: the call that has compiled ends
#            in a ReferenceError, in every process from then on.
# Output seen: 40 functions, machine codes after each process: 40, 80, 120, 160; the fifth ends with
#            ReferenceError: underlying object has vanished
# Source:    numba/core/dispatcher.py, class _MemoMixin; numba/core/types/functions.py, WeakType.__getnewargs__.
# Here:      kernels that take the functions of a law are compiled without numba's cache.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet numba==0.68.1 llvmlite==0.50.0 numpy==2.4.6
cd "$folder" && cat > applied.py <<'PYTHON'
from numba import njit


@njit(cache=True)
def apply(function, x):
    return function(x)


def power(exponent):
    return njit(lambda x: x**exponent)


if __name__ == "__main__":
    import applied

    for function in [power(exponent) for exponent in range(40)]:
        applied.apply(function, 2.0)
PYTHON
for codes in 40 80 120 160; do
    NUMBA_CACHE_DIR="$folder/cache" v/bin/python applied.py
    seen=$(find cache -name '*.nbc' | wc -l)
    echo "$seen machine codes"
    [ "$seen" -eq "$codes" ]
done
if NUMBA_CACHE_DIR="$folder/cache" v/bin/python applied.py 2> error; then
    exit 1
fi
tail -n 1 error
grep -q "^ReferenceError: underlying object has vanished$" error
