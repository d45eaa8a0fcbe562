"""Seabed surveys by a second simulator, written from docs/conventions.md and docs/formats.md alone, and what becomes of them.

    python3 tests/recipes/seabed_surveys.py target/release/boresight [SEEDS] [KIND ...]

Thirteen kinds. The ground has a power-law spectrum (not the Matern field of the joint path), rays bend in layers of 0.25 m, the boat
rolls, pitches, yaws and heaves by sines of its own about a track that it keeps to half a metre. Prints for each kind how many are
usable, the pulls (root mean square of error over stated sigma) of what is reported as determined, the largest of them, the largest
statistic of each score test (`verdict.bounds`) and the first findings of the others; a determined value beyond 4 sigmas is listed as
wrong. SEEDS is a number or FIRST-LAST. Needs numpy.
"""
import collections, json, math, os, subprocess, sys, tempfile
import numpy as np

DEG = math.pi / 180
NAMES = ("pitch", "roll", "yaw", "latency")
PLAIN = dict(depth=14.0, slope=2.0, rough=0.05, boulders=0, waves=0.0, length=240.0, ping=2.5, beams=50, gross=0.02, angles=1.2,
             latency=0.004, deep=0.0, layered=False, arm=0.005, motion=1.0, lines="paper")
KINDS = {
    "paper-like": dict(length=450.0),
    "slope": dict(depth=22.0, length=120.0, slope=12.0, ping=5.0, beams=60, gross=0.05, deep=0.001, layered=True),
    "rocky": dict(rough=0.15, boulders=400),
    "sand waves": dict(waves=0.3),
    "outliers": dict(gross=0.2),
    "far start": dict(angles=5.0),
    "wrong profile": dict(deep=0.006, layered=True),
    "latency": dict(latency=0.05),
    "free lever arm": dict(arm=0.03),
    "flat": dict(rough=0.003, slope=0.0),
    "single line": dict(lines="single"),
    "one speed": dict(lines="one speed"),
    "same direction": dict(lines="same direction"),
}


def about(axis, angle):
    """Right-handed turns about an axis, one matrix for each angle."""
    angle = np.atleast_1d(angle)
    c, s, m = np.cos(angle), np.sin(angle), np.zeros((angle.size, 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    m[:, axis, axis], m[:, i, i], m[:, j, j], m[:, i, j], m[:, j, i] = 1, c, c, -s, s
    return m


def attitude(roll, pitch, heading):
    return about(2, -heading) @ about(0, pitch) @ about(1, roll)


def turn(v):
    angle = np.linalg.norm(v)
    x, y, z = np.asarray(v) / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k


class Ground:
    """Heights: plane, power-law roughness on a grid of 0.25 m, boulders, sand waves; east from -90 to 166, north from -32 to 480 m."""

    STEP, WEST, SOUTH, COLUMNS, ROWS = 0.25, -90.0, -32.0, 1024, 2048

    def __init__(self, kind, draw):
        self.kind, self.azimuth = kind, draw.uniform(0, 2 * math.pi)
        ky, kx = np.meshgrid(np.fft.fftfreq(self.ROWS, self.STEP), np.fft.rfftfreq(self.COLUMNS, self.STEP), indexing="ij")
        k = np.hypot(kx, ky)
        amplitude = (k**2 + (1 / 25.0) ** 2) ** -0.8 * np.exp(-((k * 0.6) ** 2))
        noise = draw.standard_normal(k.shape) + 1j * draw.standard_normal(k.shape)
        grid = np.fft.irfft2(noise * amplitude, s=(self.ROWS, self.COLUMNS))
        self.grid = grid * kind["rough"] / np.std(grid)
        area = self.COLUMNS * self.ROWS * self.STEP**2
        for _ in range(int(kind["boulders"] * area / 1e4)):
            row, column, radius = draw.uniform(20, self.ROWS - 20), draw.uniform(20, self.COLUMNS - 20), draw.uniform(0.4, 1.0)
            y, x = np.ogrid[int(row) - 14:int(row) + 15, int(column) - 14:int(column) + 15]
            bump = np.exp(-(((x - column) ** 2 + (y - row) ** 2) * self.STEP**2) / radius**2)
            self.grid[int(row) - 14:int(row) + 15, int(column) - 14:int(column) + 15] += 0.6 * radius * bump
        self.crest = draw.uniform(0, 2 * math.pi)

    def height(self, x, y):
        u, v = (x - self.WEST) / self.STEP, (y - self.SOUTH) / self.STEP
        i, j = np.floor(u).astype(int), np.floor(v).astype(int)
        a, b = u - i, v - j
        cubic = lambda t: (-t * (1 - t) ** 2 / 2, 1 + t * t * (1.5 * t - 2.5), t * (0.5 + t * (2 - 1.5 * t)), t * t * (t - 1) / 2)
        wx, wy, z = cubic(a), cubic(b), 0.0
        for n in range(4):
            for m in range(4):
                z = z + wx[m] * wy[n] * self.grid[(j + n - 1) % self.ROWS, (i + m - 1) % self.COLUMNS]
        along = (x - 20) * math.sin(self.azimuth) + (y - self.kind["length"] / 2) * math.cos(self.azimuth)
        z = z - self.kind["depth"] + math.tan(self.kind["slope"] * DEG) * along
        if self.kind["waves"]:
            phase = (x * math.sin(self.crest) + y * math.cos(self.crest)) * 2 * math.pi / 14.0
            z = z + self.kind["waves"] * (np.sin(phase) + 0.25 * np.sin(2 * phase + 0.6))
        return z


def sines(draw, sigma):
    """A stationary motion of eight sines between 3.5 and 9 s."""
    rate, phase = 2 * math.pi / draw.uniform(3.5, 9.0, 8), draw.uniform(0, 2 * math.pi, 8)
    amplitude = sigma * math.sqrt(2 / 8)
    return lambda t: amplitude * np.sin(np.multiply.outer(t, rate) + phase).sum(axis=-1)


def drift(draw, t, sigma, tau):
    """Gauss-Markov, stationary."""
    keep, x = np.exp(-np.diff(t, prepend=t[0]) / tau), np.empty(t.size)
    shock = draw.standard_normal(t.size)
    x[0] = sigma * shock[0]
    for k in range(1, t.size):
        x[k] = keep[k] * x[k - 1] + sigma * math.sqrt(1 - keep[k] ** 2) * shock[k]
    return x


def tracks(kind):
    """Name, track's east, whether northward, speed."""
    beside = 1.9 * kind["depth"]
    return {
        "paper": [("1", 0, True, 2.0), ("2", beside, False, 2.0), ("3", 0, True, 3.5), ("4", beside, True, 2.0)],
        "one speed": [("1", 0, True, 2.5), ("2", 0, False, 2.5), ("3", beside, True, 2.5)],
        "single": [("1", 0, True, 2.0)],
        "same direction": [("1", 0, True, 2.0), ("2", 0, True, 3.5)],
    }[kind["lines"]]


def geodetic(points, latitude, longitude, height):
    """East, north, up about an origin on WGS84 into degrees and metres, and the turn from the origin's axes to the local ones."""
    a, f = 6378137.0, 1 / 298.257223563
    e2 = f * (2 - f)
    axes = lambda b, l: np.array([[-math.sin(l), math.cos(l), 0], [-math.sin(b) * math.cos(l), -math.sin(b) * math.sin(l), math.cos(b)],
                                  [math.cos(b) * math.cos(l), math.cos(b) * math.sin(l), math.sin(b)]])
    n = a / math.sqrt(1 - e2 * math.sin(latitude) ** 2)
    origin = np.array([(n + height) * math.cos(latitude) * math.cos(longitude), (n + height) * math.cos(latitude) * math.sin(longitude),
                       (n * (1 - e2) + height) * math.sin(latitude)])
    x, y, z = (origin + points @ axes(latitude, longitude)).T
    l, p = np.arctan2(y, x), np.hypot(x, y)
    b, h = np.full(x.size, latitude), np.zeros(x.size)
    for _ in range(8):
        n = a / np.sqrt(1 - e2 * np.sin(b) ** 2)
        h = p * np.cos(b) + z * np.sin(b) - a * np.sqrt(1 - e2 * np.sin(b) ** 2)
        b = np.arctan2(z, p * (1 - e2 * n / (n + h)))
    turns = np.array([axes(bk, lk) for bk, lk in zip(b, l)]) @ axes(latitude, longitude).T
    return b, l, h, turns


def speed(kind, depth):
    return 1500.0 - 0.35 * np.maximum(depth - 3, 0) + 0.8 * np.exp(-depth / 3) if kind["layered"] else np.full_like(depth, 1500.0)


def shoot(kind, ground, start, down):
    """One-way times of rays through layers of 0.25 m until they meet the ground. `down`: unit vectors; times nan where none meets."""
    sine, flat = np.hypot(down[:, 0], down[:, 1]), np.stack([down[:, 0], down[:, 1]])
    flat = flat / np.maximum(sine, 1e-12)
    depth, way, time = -start[:, 2], np.zeros(len(down)), np.zeros(len(down))
    slowness = sine / speed(kind, depth)
    open_, found = np.ones(len(down), bool), np.full(len(down), np.nan)
    over = lambda w, d: -d - ground.height(start[:, 0] + flat[0] * w, start[:, 1] + flat[1] * w)
    for _ in range(400):
        c = speed(kind, depth + 0.125)
        s = slowness * c
        open_ &= s < 0.985
        cosine = np.sqrt(np.maximum(1 - s * s, 1e-4))
        step_way, step_time = 0.25 * s / cosine, 0.25 / (c * cosine)
        after = over(way + step_way, depth + 0.25)
        hit = open_ & (after <= 0)
        if hit.any():
            low, high = np.zeros(hit.sum()), np.ones(hit.sum())
            for _ in range(22):
                middle = (low + high) / 2
                w, d = way[hit] + middle * step_way[hit], depth[hit] + middle * 0.25
                above = -d - ground.height(start[hit, 0] + flat[0, hit] * w, start[hit, 1] + flat[1, hit] * w) > 0
                low, high = np.where(above, middle, low), np.where(above, high, middle)
            found[hit] = time[hit] + (low + high) / 2 * step_time[hit]
            open_ &= ~hit
        if not open_.any():
            break
        way, depth, time = way + step_way, depth + 0.25, time + step_time
    return found


def survey(folder, name, seed):
    kind = {**PLAIN, **KINDS[name]}
    draw = np.random.default_rng([seed, list(KINDS).index(name)])
    ground = Ground(kind, draw)
    correction = draw.uniform(0.6, 1, 3) * draw.choice([-1, 1], 3) * kind["angles"] * DEG
    nominal = attitude(0.0, 0.0, 0.0)[0]
    mounting, arm = turn(correction) @ nominal, np.array([0.3, -1.1, -1.0])
    said_arm = arm + np.array([kind["arm"], kind["arm"], 0.01]) * draw.standard_normal(3)
    m = kind["motion"]
    roll, pitch, yaw = sines(draw, 2.0 * m * DEG), sines(draw, 1.0 * m * DEG), sines(draw, 1.2 * m * DEG)
    heave, sway = sines(draw, 0.12 * m), sines(draw, 0.10 * m)
    lines, rows, records, shots, clock, ping = [], [], [], [], 3000.0, 0
    for line, east, north, knots in tracks(kind):
        span = kind["length"] / knots
        wander, course = draw.uniform(0.3, 0.6), 0.0 if north else math.pi
        phase = draw.uniform(0, 2 * math.pi)

        def pose(t, clock=clock, span=span, east=east, north=north, knots=knots, wander=wander, phase=phase, course=course):
            run = (t - clock) * knots
            along = run if north else kind["length"] - run
            x = east + wander * np.sin(run / 40 + phase) + sway(t)
            return np.stack([x, along, heave(t)], axis=-1), attitude(roll(t), pitch(t), course + yaw(t))

        tide = 0.03 * draw.standard_normal()
        t = np.arange(clock - 3, clock + span + 3, 0.02)
        p, body = pose(t)
        p = p + 0.002 * draw.standard_normal(p.shape)
        p = p + np.stack([drift(draw, t, s, 120.0) for s in (0.01, 0.01, 0.015)], axis=-1) - [0, 0, tide]
        small = [drift(draw, t, s, tau) + white * draw.standard_normal(t.size)
                 for s, tau, white in ((0.004 * DEG, 120.0, 0.003 * DEG), (0.004 * DEG, 120.0, 0.003 * DEG), (0.012 * DEG, 200.0, 0.005 * DEG))]
        body = body @ about(0, small[0]) @ about(1, small[1]) @ about(2, small[2])
        b, l, h, turns = geodetic(p, 43.1 * DEG, 5.9 * DEG, 48.0)
        local = turns @ body
        records.append(np.stack([t, b / DEG, l / DEG, h, np.arctan2(-local[:, 2, 0], local[:, 2, 2]) / DEG,
                                 np.arcsin(local[:, 2, 1]) / DEG, np.arctan2(local[:, 0, 1], local[:, 1, 1]) / DEG % 360], axis=-1))
        epochs = np.arange(clock, clock + span, 1 / kind["ping"])
        p, body = pose(np.repeat(epochs, kind["beams"]))
        across = np.tile(np.linspace(-63, 63, kind["beams"]), epochs.size) * DEG
        beam = np.stack([np.sin(across), 0 * across, -np.cos(across)], axis=-1)
        head = body @ mounting
        one_way = shoot(kind, ground, p + body @ arm, np.einsum("nij,nj->ni", head, beam))
        sigma = 0.05 * DEG * (1 + (np.abs(across) / (60 * DEG)) ** 3)
        measured = across + sigma * draw.standard_normal(across.size)
        one_way = one_way + 0.012 / 1500 * draw.standard_normal(across.size)
        bad = draw.random(across.size) < kind["gross"] / 2
        begins = np.flatnonzero(draw.random(across.size) < kind["gross"] / 2 / 8)
        off = np.where(bad, draw.uniform(0.02, 0.35, across.size) * draw.choice([-1, 1], across.size), 0)
        for k in begins:
            off[k:k + 8] = draw.uniform(-0.25, -0.03)
        one_way = one_way * (1 + off)
        for k in np.flatnonzero(np.isfinite(one_way)):
            shots.append(f"{epochs[k // kind['beams']] + kind['latency']:.4f},{ping + k // kind['beams']},{k % kind['beams']},"
                         f"{measured[k] / DEG:.4f},0,{2 * one_way[k]:.7f}\n")
        ping += epochs.size
        lines.append(f'[[line]]\nname = "{line}"\nstart_s = {clock - 1}\nend_s = {clock + span + 1}\n')
        clock += span + 60
    with open(os.path.join(folder, "trajectory.csv"), "w") as file:
        file.write("time_s,latitude_deg,longitude_deg,height_m,roll_deg,pitch_deg,heading_deg\n")
        for r in np.concatenate(records):
            file.write("%.3f,%.11f,%.11f,%.5f,%.6f,%.6f,%.6f\n" % tuple(r))
    with open(os.path.join(folder, "multibeam.csv"), "w") as file:
        file.write("time_s,ping,beam,across_angle_deg,along_angle_deg,two_way_travel_time_s\n")
        file.writelines(shots)
    with open(os.path.join(folder, "sound_speed.csv"), "w") as file:
        file.write("depth_m,sound_speed_m_s\n")
        for d in np.arange(0, 60.1, 0.5):
            file.write(f"{d},{float(speed(kind, np.array(d))) * (1 + kind['deep'] * max(d - 1.0, 0) / 20):.5f}\n")
    with open(os.path.join(folder, "survey.toml"), "w") as file:
        file.write(f'''name = "{name} {seed}"
procedure = "seabed"
[site]
origin = {{ latitude_deg = 43.1, longitude_deg = 5.9, height_m = 48.0 }}
line_height_sigma_m = 0.03
[trajectory]
path = "trajectory.csv"
position_sigma_m = 0.002
position_drift_sigma_m = 0.01
height_drift_sigma_m = 0.015
drift_correlation_time_s = 120.0
roll_pitch_sigma_deg = 0.003
roll_pitch_drift_sigma_deg = 0.004
roll_pitch_correlation_time_s = 120.0
heading_sigma_deg = 0.005
heading_drift_sigma_deg = 0.012
heading_correlation_time_s = 200.0
[sound_speed]
profile = "sound_speed.csv"
profile_sigma = 0.002
[multibeam]
path = "multibeam.csv"
lever_arm_m = {[round(float(x), 4) for x in said_arm]}
lever_arm_sigma_m = [{kind["arm"]}, {kind["arm"]}, 0.01]
mounting_deg = {{ roll = 0.0, pitch = 0.0, heading = 0.0 }}
range_sigma_m = 0.012
angle_sigma_deg = 0.05
angle_sigma_growth = 1.0
max_angle_deg = 62.0
{"".join(lines)}''')
    return mounting, nominal, kind["latency"]


def errors(result, truth):
    """Errors of what the joint path calls determined, in its sigmas and in degrees or milliseconds."""
    mounting, nominal, latency = truth
    solution = result["solutions"]["joint"]
    found = {p["name"]: p for p in solution["parameters"] if p["determined"] and p["name"].split()[-1] in NAMES}
    true = mounting @ nominal.T
    angle = math.acos((np.trace(true) - 1) / 2)
    log = np.array([true[2, 1] - true[1, 2], true[0, 2] - true[2, 0], true[1, 0] - true[0, 1]]) * angle / (2 * math.sin(angle)) / DEG
    due = dict(zip(NAMES, (*log, latency * 1000)))
    off = {}
    for name, p in found.items():
        scale = {"deg": 1.0, "ms": 1.0, "s": 1000.0, "rad": 1 / DEG}[p["unit"]]
        short = name.split()[-1]
        value = p["correction"] if p.get("correction") is not None else p["value"]
        off[short] = ((value * scale - due[short]) / (p["sigma"] * scale), value * scale - due[short])
    return off


def main():
    program, seeds = os.path.abspath(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "5"
    first, last = map(int, seeds.split("-")) if "-" in seeds else (1, int(seeds))
    for name in sys.argv[3:] or KINDS:
        pulls, offs, lost, wrong, usable = collections.defaultdict(list), collections.defaultdict(list), collections.Counter(), [], 0
        tests = collections.Counter()
        for seed in range(first, last + 1):
            with tempfile.TemporaryDirectory() as folder:
                truth = survey(folder, name, seed)
                command = [program, "calibrate", os.path.join(folder, "survey.toml"), "--out", os.path.join(folder, "out"), "--json"]
                end = subprocess.run(command + ["--method", "joint"], capture_output=True, text=True)
            if end.returncode not in (0, 1):
                lost[f"exit {end.returncode}: {end.stderr[:300]}"] += 1
                continue
            result = json.loads(end.stdout)
            usable += result["usable"]
            if not result["usable"]:
                refusals = [f["code"] for f in result["verdict"]["findings"] if f["severity"] in ("refuses", "withdraws")]
                lost[", ".join(refusals) or "nothing"] += 1
            for test in result["verdict"].get("bounds", []):
                tests[test["code"]] = max(tests[test["code"]], round(test.get("chi_square") or 0, 1))
            for key, (pull, off) in errors(result, truth).items():
                pulls[key].append(pull)
                offs[key].append(off)
                if abs(pull) > 4:
                    wrong.append(f"seed {seed} {key} {pull:.1f}")
        root = lambda all_: math.sqrt(sum(x * x for x in all_) / len(all_))
        words = [f"{k} {root(pulls[k]):.2f} (mean {np.mean(pulls[k]):.2f}, largest {max(pulls[k], key=abs):.1f}, rms {root(offs[k]):.4f}, {len(pulls[k])})"
                 for k in NAMES if pulls[k]]
        print(f"{name}: {usable} of {last - first + 1} usable; pulls: {'; '.join(words) or 'none'}; wrong: {wrong}; others: {dict(lost)}; score tests: {dict(tests.most_common(4))}",
              flush=True)


if __name__ == "__main__":
    main()
