"""The commands of this room, one file each.

Their matrices are tall and narrow, a few parameters wide: on one thread they are at least as fast, and on a machine that
has other work four times faster than on two. Whoever sets the number of threads is not overruled.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
