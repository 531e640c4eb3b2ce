"""One BLAS thread: the matrices are small, and threads of several libraries in one process slow each other down."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
