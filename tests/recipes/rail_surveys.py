"""Rail surveys by a second simulator, written from docs/rail.md alone, and how many of their calibrations are silently wrong.

    python3 tests/recipes/rail_surveys.py target/release/boresight [SURVEYS] [chn60|uic60] [GAP_MM]

Each survey: two profilers whose mountings are up to 5 deg and 3 mm off, sweeps of 2.5 deg with play, 15 % dust in front of the rail,
a third of the fan hidden in half of the profiles, every constant of the stand drawn by its sigma. Prints how many are usable, the
pulls, the largest error of a usable one in its sigmas, and first findings of the others. Standard library only.
"""
import collections, json, math, os, random, subprocess, sys, tempfile, tomllib

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
DEG = math.pi / 180


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def applied(a, v):
    return [sum(a[i][k] * v[k] for k in range(3)) for i in range(3)]


def transposed(a):
    return [list(row) for row in zip(*a)]


def about(axis, angle):
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    m = [[float(r == k) for k in range(3)] for r in range(3)]
    m[i][i], m[i][j], m[j][i], m[j][j] = c, -s, s, c
    return m


def attitude(roll, pitch, heading):
    """Body into level: z up; heading clockwise, bow up, starboard down."""
    return product(product(about(2, -heading), about(0, pitch)), about(1, roll))


def angles(m):
    return math.atan2(-m[2][0], m[2][2]), math.asin(m[2][1]), math.atan2(m[0][1], m[1][1])


def pieces(name):
    """Lines and arcs of the whole section in metres, left and right."""
    with open(os.path.join(ROOT, f"models/rails/{name}.toml"), "rb") as file:
        model = tomllib.load(file)
    found, at = [], model["start_mm"]
    for element in model["element"]:
        a, b, r = at, element["to_mm"], element.get("radius_mm")
        for side in (1, -1):
            p, q = [side * a[0] / 1e3, a[1] / 1e3], [side * b[0] / 1e3, b[1] / 1e3]
            centre = None
            if r:
                d = [q[0] - p[0], q[1] - p[1]]
                half = math.hypot(*d) / 2
                h = math.sqrt((r / 1e3) ** 2 - half**2)
                turn = -side if r > 0 else side  # the centre lies right of the way where the rail bulges, mirrored on the left
                n = [-d[1] / (2 * half), d[0] / (2 * half)]
                centre = [(p[i] + q[i]) / 2 + turn * h * n[i] for i in (0, 1)]
            found.append((p, q, centre, abs(r) / 1e3 if r else None))
        at = b
    return found


def hit(section, o, d):
    """Distance along a ray to the nearest piece; x and z count, the rail is endless."""
    best = None
    for p, q, centre, radius in section:
        if centre is None:
            e = (q[0] - p[0], q[1] - p[1])
            w = (p[0] - o[0], p[1] - o[1])
            det = d[0] * e[1] - d[1] * e[0]
            if det == 0:
                continue
            t, u = (w[0] * e[1] - w[1] * e[0]) / det, (w[0] * d[1] - w[1] * d[0]) / det
            candidates = [t] if 0 <= u <= 1 else []
        else:
            w = (o[0] - centre[0], o[1] - centre[1])
            a, b, c = d[0] ** 2 + d[1] ** 2, w[0] * d[0] + w[1] * d[1], w[0] ** 2 + w[1] ** 2 - radius**2
            if b * b < a * c:
                continue
            root = math.sqrt(b * b - a * c)
            middle = ((p[0] + q[0]) / 2 - centre[0], (p[1] + q[1]) / 2 - centre[1])
            least = middle[0] * (p[0] - centre[0]) + middle[1] * (p[1] - centre[1])
            candidates = [t for t in ((-b - root) / a, (-b + root) / a) if middle[0] * (w[0] + t * d[0]) + middle[1] * (w[1] + t * d[1]) >= least]
        for t in candidates:
            if t > 1e-6 and (best is None or t < best):
                best = t
    return best


def survey(folder, seed, rail, gap_m):
    draw = random.Random(seed)
    normal = lambda sigma: draw.gauss(0.0, sigma)
    section = pieces(rail)
    exp3 = lambda sigmas: product(product(about(0, normal(sigmas[0])), about(1, normal(sigmas[1]))), about(2, normal(sigmas[2])))
    level, seat, rail_turn = exp3([0.01 * DEG, 0.01 * DEG, 0.05 * DEG]), exp3([0.1 * DEG] * 3), exp3([0.01 * DEG, 0.01 * DEG, 0.02 * DEG])
    pivot_body = [normal(2e-4), normal(2e-4), -0.1 + normal(2e-4)]
    pivot_rail = [normal(2e-4), 0.1 + normal(2e-4)]
    nominal = [(-55.0, [-0.30, 0.05, -0.10]), (55.0, [0.30, 0.05, -0.10])]
    mountings = []
    for roll, arm in nominal:
        rotation = attitude((roll + draw.uniform(-5, 5)) * DEG, draw.uniform(-5, 5) * DEG, draw.uniform(-5, 5) * DEG)
        mountings.append((rotation, [arm[0] + draw.uniform(-3e-3, 3e-3), arm[1] + normal(2e-3), arm[2] + draw.uniform(-3e-3, 3e-3)]))
    steps = [-5 + 2.5 * k for k in range(5)]
    positions = [(h + draw.uniform(-0.2, 0.2), 0.0) for h in steps] + [(0.0, p + draw.uniform(-0.2, 0.2)) for p in steps]
    with open(os.path.join(folder, "table.csv"), "w") as table, open(os.path.join(folder, "att.csv"), "w") as ins, open(os.path.join(folder, "profiles.csv"), "w") as profiles:
        table.write("from_s,to_s,heading_deg,pitch_deg\n")
        ins.write("time_s,roll_deg,pitch_deg,heading_deg\n")
        profiles.write("time_s,profiler,y_m,z_m\n")
        for k, (h, p) in enumerate(positions):
            start = 100 + 7 * k
            table.write(f"{start},{start + 2},{h:.4f},{p:.4f}\n")
            heading, pitch = h * DEG + normal(0.005 * DEG), p * DEG + normal(0.005 * DEG)
            upright = product(level, about(2, -heading))
            turned = product(upright, about(0, pitch))
            body = product(turned, seat)
            for i in range(20):
                roll_, pitch_, heading_ = angles(body)
                ins.write(f"{start + 0.05 + 0.1 * i:.2f},{roll_ / DEG + normal(0.01):.7f},{pitch_ / DEG + normal(0.01):.7f},{heading_ / DEG + normal(0.02):.7f}\n")
            for number, (rotation, arm) in enumerate(mountings):
                place = applied(body, [a - b for a, b in zip(arm, pivot_body)])
                place = [place[i] + gap_m * (upright[i][1] - turned[i][1]) for i in range(3)]
                o = applied(transposed(rail_turn), place)
                turn = product(transposed(rail_turn), product(body, rotation))
                hidden = draw.uniform(0, 0.67) if draw.random() < 0.5 else 2.0
                for ray in range(70):
                    part = (ray + 0.5) / 70
                    angle = (part - 0.5) * 40 * DEG
                    s = [math.sin(angle), 0.0, -math.cos(angle)]
                    d = applied(turn, s)
                    range_m = hit(section, (o[0] + pivot_rail[0], o[2] + pivot_rail[1]), (d[0], d[2]))
                    if range_m is None or hidden <= part < hidden + 0.33:
                        continue
                    if draw.random() < 0.15:
                        range_m -= draw.uniform(0, 0.02)
                    profiles.write(f"{start + 1},{number + 1},{s[0] * range_m + normal(5e-5):.8f},{s[2] * range_m + normal(5e-5):.8f}\n")
    profilers = "".join(
        f'[[profiler]]\nname = "{name}"\nlever_arm_m = {arm}\nlateral_sigma_m = 5e-5\nvertical_sigma_m = 5e-5\nalong_sigma_m = 0.002\n'
        f"mounting_deg = {{ roll = {roll}, pitch = 0, heading = 0 }}\n" for name, (roll, arm) in zip(("left", "right"), nominal))
    with open(os.path.join(folder, "survey.toml"), "w") as file:
        file.write(f'''name = "second simulator"
procedure = "rail"
[rail]
model = "{os.path.abspath(os.path.join(ROOT, "models/rails", rail + ".toml"))}"
orientation_sigma_deg = [0.01, 0.01, 0.02]
profile_sigma_m = 5e-6
[profiles]
path = "profiles.csv"
[attitude]
path = "att.csv"
roll_pitch_sigma_deg = 0.01
heading_sigma_deg = 0.02
[table]
path = "table.csv"
angle_sigma_deg = 0.005
level_sigma_deg = 0.01
zero_sigma_deg = 0.05
seating_sigma_deg = 0.1
pivot_body_m = [0.0, 0.0, -0.1]
pivot_body_sigma_m = 0.0002
pivot_rail_m = [0.0, 0.1]
pivot_rail_sigma_m = 0.0002
{profilers}''')
    return mountings


def errors(result, mountings):
    joint = result["solutions"]["joint"]
    sigma = {p["name"]: p["sigma"] * (DEG if p["unit"] == "deg" else 1) for p in joint["parameters"] if p["sigma"]}
    found = {}
    for mounting, (rotation, arm) in zip(joint["mountings"], mountings):
        m = product(mounting["rotation_matrix"], transposed(rotation))
        turn = (0.5 * (m[2][1] - m[1][2]), 0.5 * (m[0][2] - m[2][0]), 0.5 * (m[1][0] - m[0][1]))
        off = [a - b for a, b in zip(mounting["lever_arm_m"], arm)]
        for part, error in zip(("pitch", "roll", "yaw", "lx", "lz"), (*turn, off[0], off[2])):
            name = f'{mounting["name"]} {part}'
            found[name] = error / sigma[name]
    return found


def main():
    program, count = os.path.abspath(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 500
    rail, gap_m = sys.argv[3] if len(sys.argv) > 3 else "chn60", float(sys.argv[4]) / 1e3 if len(sys.argv) > 4 else 0.0
    usable, lost, by_reference, pulls = [], collections.Counter(), collections.Counter(), collections.defaultdict(float)
    for seed in range(1, count + 1):
        with tempfile.TemporaryDirectory() as folder:
            mountings = survey(folder, seed, rail, gap_m)
            command = [program, "calibrate", os.path.join(folder, "survey.toml"), "--out", os.path.join(folder, "out"), "--json", "--threads", "1"]
            end = subprocess.run(command, capture_output=True, text=True)
        if end.returncode not in (0, 1):
            lost["exit 2: " + end.stderr[:200]] += 1
            continue
        result = json.loads(end.stdout)
        reference = result["solutions"]["reference"]
        by_reference["usable" if reference and reference["usable"] else str((reference or {}).get("message"))] += 1
        if not result["usable"]:
            lost[result["verdict"]["findings"][0]["code"]] += 1
            continue
        error = errors(result, mountings)
        usable.append((max(abs(e) for e in error.values()), seed))
        for name, e in error.items():
            pulls[name] += e * e
    print(f"{rail}, gap {1e3 * gap_m} mm: {len(usable)} of {count} usable")
    print("largest errors, sigmas (seed):", ", ".join(f"{e:.1f} ({seed})" for e, seed in sorted(usable, reverse=True)[:8]))
    print("pulls:", ", ".join(f"{name} {math.sqrt(p / max(1, len(usable))):.2f}" for name, p in pulls.items()))
    print("others:", dict(lost))
    print("reference path:", dict(by_reference.most_common(6)))


main()
