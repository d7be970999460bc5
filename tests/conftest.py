"""Settings that all tests share."""

import os

# numpy reads these when it is first imported; two test processes on two processors leave no room for more threads
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from hypothesis import settings  # noqa: E402 - some strategies import numpy

# no deadline: how long an example takes says more about the machine than about the code
settings.register_profile("testbed", deadline=None, print_blob=True)
settings.load_profile("testbed")
