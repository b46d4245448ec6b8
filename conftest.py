"""Tests compute on one BLAS thread each: matrices are small, and threads that wait for each other cost four times the time."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
