"""Reference values of the plane fit: numpy's singular value decomposition of the centred coordinates.

Prints the points and values that src/geometry/plane.rs holds. Run with numpy 2.4.6: python3 tests/recipes/plane_fit.py
"""
import numpy as np

rng = np.random.default_rng(20151120)
normal = np.array([-1.0, 1.0, 0.05]) / np.linalg.norm([-1.0, 1.0, 0.05])
along = np.cross([0, 0, 1.0], normal)
along /= np.linalg.norm(along)
up = np.cross(normal, along)
n = 12
points = (np.array([431.25, -1207.5, 38.0]) + rng.uniform(-0.8, 0.8, (n, 1)) * along
          + rng.uniform(-0.3, 0.3, (n, 1)) * up + rng.normal(0, 0.012, (n, 1)) * normal)
points = np.round(points, 4)
mean = points.mean(axis=0)
_, s, vt = np.linalg.svd(points - mean)
found = vt[2] * np.sign(vt[2] @ normal)
print("POINTS", [list(map(float, p)) for p in points])
print("normal", *map(repr, map(float, found)))
print("offset", repr(float(found @ mean)))
print("sum of squares", repr(float(s[2] ** 2)), "in plane", repr(float(s[0] ** 2)), repr(float(s[1] ** 2)))
