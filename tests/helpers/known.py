"""Table III of the paper, as counts: rows perceived, columns signaled, in the order of `EMOTIONS`."""

import numpy as np

TABLE_III = np.array(
    [
        [29, 8, 4, 2, 2, 6],
        [5, 26, 4, 1, 0, 0],
        [4, 0, 25, 6, 7, 2],
        [3, 6, 9, 18, 16, 7],
        [3, 2, 2, 12, 18, 1],
        [1, 3, 1, 6, 2, 29],
    ]
)
