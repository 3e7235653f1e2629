"""Every table that torquectl writes, and each motion that ships, by the one line that numpy needs.

  read_tables.py CSV...
"""

import sys
import warnings

import numpy

warnings.simplefilter("error")
for path in sys.argv[1:]:
    table = numpy.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
    with open(path, encoding="utf-8") as file:
        header, rows = next(file).rstrip("\n").split(","), [line for line in file if not line.startswith("#")]
    assert list(table.dtype.names) == header, path
    assert table.shape == (len(rows),), path
