"""The eikonal equation on the cost map of the benchmark `routes`, solved by scikit-fmm's fast marching.

cargo bench -p p21 --bench routes -- --raster map.bin
python3 -m venv venv && venv/bin/pip install scikit-fmm
venv/bin/python research/p21/benches/eikonal.py map.bin
"""

import sys
import time

import numpy
import skfmm

numbers = numpy.fromfile(sys.argv[1], dtype="<f8")
side, start_x, start_y, goal_x, goal_y, _ = numbers[:6]
side = int(side)
pace = numbers[6:].reshape(side, side)
# Contour 0 around the start; what is forbidden is masked.
rows, columns = numpy.mgrid[0:side, 0:side] + 0.5
away = numpy.hypot(columns - start_x, rows - start_y) - 1.0
closed = ~numpy.isfinite(pace)
phi = numpy.ma.MaskedArray(away, closed)
speed = numpy.where(closed, 0.0, 1.0 / numpy.where(closed, 1.0, pace))
times = []
for _ in range(5):
    started = time.process_time()
    travel = skfmm.travel_time(phi, speed, dx=1.0)
    times.append(time.process_time() - started)
goal = travel[int(goal_y), int(goal_x)]
print(f"scikit-fmm {skfmm.__version__}: {1e3 * sorted(times)[2]:.1f} ms, {goal:.4f} Sol to the middle of the goal")
