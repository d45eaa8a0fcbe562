"""Reference rays for tests/it/rays.rs: numerical integration of the ray equations, no arcs.

    pip install numpy scipy && python tests/recipes/rays.py > tests/reference/rays.json

Inside one layer (linear speed) d(x, z, theta)/dt = (c sin, c cos, (dc/dz) sin theta), integrated with scipy's DOP853 at rtol 1e-13;
layers are joined by event detection, so no step crosses a kink.
"""
import json
import numpy as np
from scipy.integrate import solve_ivp

PROFILES = {
    "pool": ([0.0, 1.0, 2.0, 3.5, 6.0], [1482.0, 1482.0, 1480.5, 1476.0, 1475.2]),
    "duct": ([0.5, 20.0, 60.0, 150.0, 400.0], [1521.3, 1519.8, 1492.0, 1496.5, 1502.4]),
    "faster below": ([0.0, 50.0], [1450.0, 1475.0]),
}
RAYS = [  # profile, depth, launch angle from the downward vertical in degrees, one-way time
    *[("pool", 1.6, angle, 0.005) for angle in (0.0, 0.01, 5.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.5, 90.0, 91.0, 95.0)],
    *[("pool", 2.0, angle, 0.002) for angle in (10.0, 80.0, 90.0, 120.0, 140.0)],
    *[("duct", 3.0, angle, 0.2) for angle in (0.0, 12.0, 40.0, 65.0, 80.0)],
    *[("duct", 60.0, angle, 0.3) for angle in (82.0, 85.0, 88.0, 90.5, 93.0, 97.0)],
    *[("duct", 380.0, angle, 0.15) for angle in (100.0, 150.0, 179.0, 180.0)],
    *[("faster below", 2.0, angle, 1.5) for angle in (81.0, 83.0, 86.0, 88.0)],
    *[("faster below", 30.0, angle, 0.1) for angle in (90.0, 89.0, 70.0)],
    *[("faster below", 30.0, angle, 0.25) for angle in (83.0, 85.0, 88.0)],
]


def layers(depth, speed):
    """(top, bottom, speed at top, gradient), constant outside the samples."""
    rows = [(0.0, depth[0], speed[0], 0.0)] if depth[0] > 0 else []
    for k in range(len(depth) - 1):
        rows.append((depth[k], depth[k + 1], speed[k], (speed[k + 1] - speed[k]) / (depth[k + 1] - depth[k])))
    return rows + [(depth[-1], np.inf, speed[-1], 0.0)]


def trace(rows, depth, angle, time):
    state, left, index = np.array([0.0, depth, angle]), time, None
    horizontal = abs(np.cos(angle)) < 1e-12
    for k, (top, bottom, _, gradient) in enumerate(rows):
        down = gradient < 0 if horizontal else np.cos(angle) > 0
        if (top <= depth < bottom) if down else (top < depth <= bottom):
            index = k
    for _ in range(200):
        top, bottom, c0, g = rows[index]
        speed = lambda z: c0 + g * (z - top)
        flow = lambda t, y: [speed(y[1]) * np.sin(y[2]), speed(y[1]) * np.cos(y[2]), g * np.sin(y[2])]
        rise = lambda t, y: y[1] - top
        rise.terminal, rise.direction = True, -1
        sink = lambda t, y: y[1] - bottom
        sink.terminal, sink.direction = True, 1
        events = [rise] + ([sink] if np.isfinite(bottom) else [])
        run = solve_ivp(flow, (0.0, left), state, method="DOP853", rtol=1e-13, atol=1e-13, events=events, max_step=left / 50)
        state, left = run.y[:, -1], left - run.t[-1]
        if run.status == 0:
            return state
        index += -1 if len(run.t_events[0]) else 1
        if index < 0:
            return None
        state[1] = top if len(run.t_events[0]) else bottom
    raise RuntimeError("too many layers")


if __name__ == "__main__":
    out = {"profiles": {k: {"depth_m": d, "speed_m_s": s} for k, (d, s) in PROFILES.items()}, "rays": []}
    for name, depth, degrees, time in RAYS:
        end = trace(layers(*PROFILES[name]), depth, np.radians(degrees), time)
        row = {"profile": name, "depth_m": depth, "launch_deg": degrees, "one_way_s": time}
        row["end"] = None if end is None else {"horizontal_m": end[0], "descent_m": end[1] - depth}
        out["rays"].append(row)
    rows = ",\n".join(json.dumps(r) for r in out["rays"])
    print('{"profiles": ' + json.dumps(out["profiles"]) + ',\n"rays": [\n' + rows + "\n]}")
