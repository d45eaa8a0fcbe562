"""Makes mistakes that surveyors make to simulated surveys and counts what the verdict says: standard library only.

    python3 tests/recipes/wrong_inputs.py target/release/boresight pool|pool-one|usbl|rail|seabed [SEEDS] [CASE ...]

Each line: the mistake; of how many seeds usable was withdrawn (or the input refused); seeds that passed without a word of the cause
although the mistake moved a parameter by more than 2 sigma from where the same seed's right survey puts it (silent: the bar is 1 in
100); the largest move of those that passed, in sigmas; how often the first finding named the cause; the codes that came first. Seeds
are 1 to SEEDS. `right` makes no mistake. The last line is the sum of all mistakes.
"""
import collections, csv, json, math, os, re, subprocess, sys, tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
SCENARIOS = {"pool": "three-pass-thin", "pool-one": "single-pass-thin", "usbl": "usbl-thin", "rail": "rail-thin", "seabed": "seabed-thin"}


def change(folder, name, column, f, sort=None):
    """f of one column's number, or of a whole row as a dictionary where no column is named; the rows in another order by `sort`."""
    path = os.path.join(folder, name)
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    head = list(rows[0])
    out = []
    for row in rows:
        if column is None:
            row = f(row)
            out += row if isinstance(row, list) else [row] if row else []
        else:
            row[column] = repr(f(float(row[column])))
            out.append(row)
    if sort:
        out.sort(key=sort)
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, list(out[0]) if out else head, lineterminator="\n")
        writer.writeheader()
        writer.writerows(out)


def survey(folder, section, key, value):
    """Sets a key of the survey file, `value` a TOML text or a function of the old text."""
    path = os.path.join(folder, "survey.toml")
    with open(path) as file:
        text = file.read()
    head = f"[{section}]\n"
    at = text.index(head) + len(head)
    end = text.find("\n[", at)
    end = len(text) if end < 0 else end
    body = text[at:end]
    found = re.search(rf"^{key} = (.*)$", body, re.M)
    if found:
        new = value(found.group(1)) if callable(value) else value
        body = body[:found.start()] + f"{key} = {new}" + body[found.end():]
    else:
        body = f"{key} = {value}\n" + body
    with open(path, "w") as file:
        file.write(text[:at] + body + text[end:])


def column(file, name, f):
    return lambda d, _: change(d, file, name, f)


def rows(file, f):
    return lambda d, _: change(d, file, None, f)


def key(section, name, value):
    return lambda d, _: survey(d, section, name, value)


def every(*spoils):
    def all_of_them(d, seed):
        for spoil in spoils:
            spoil(d, seed)
    return all_of_them


def times(factor):
    return lambda text: repr(float(text) * factor)


def vector(f):
    return lambda text: str(f(json.loads(text)))


def exchange(a, b):
    def f(row):
        row[a], row[b] = row[b], row[a]
        return row
    return f


def spliced(file, from_part, edit):
    """The file of the same seed with another scenario from a part of its duration on: something happened on the way."""
    def f(folder, seed):
        with tempfile.TemporaryDirectory() as other:
            simulate(edit(scenario_text()), seed, other)
            with open(os.path.join(other, file), newline="") as handle:
                later = list(csv.DictReader(handle))
        with open(os.path.join(folder, file), newline="") as handle:
            first = list(csv.DictReader(handle))
        start, end = float(first[0]["time_s"]), float(first[-1]["time_s"])
        at = start + from_part * (end - start)
        both = [r for r in first if float(r["time_s"]) < at] + [r for r in later if float(r["time_s"]) >= at]
        with open(os.path.join(folder, file), "w", newline="") as handle:
            writer = csv.DictWriter(handle, list(first[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(both)
    return f


def replaced(*files, edit=lambda text: text, seed_by=0):
    """Files of another survey."""
    def f(folder, seed):
        with tempfile.TemporaryDirectory() as other:
            simulate(edit(scenario_text()), seed + seed_by, other)
            for name in files:
                os.replace(os.path.join(other, name), os.path.join(folder, name))
    return f


def another_day(t):
    """The same passes on another sea."""
    return re.sub(r"phase_deg = (-?[\d.]+)", lambda m: f"phase_deg = {float(m.group(1)) + 100}", t)


def text(old, new):
    def f(t):
        assert old in t, old
        return t.replace(old, new)
    return f


def in_pass(number, file, f):
    """f of the time in one pass of the three."""
    def spoil(folder, _):
        with open(os.path.join(folder, file), newline="") as handle:
            all_times = [float(r["time_s"]) for r in csv.DictReader(handle)]
        breaks = [0.5 * (a + b) for a, b in zip(all_times, all_times[1:]) if b - a > 5]
        bounds = [-math.inf] + breaks + [math.inf]
        low, high = bounds[number - 1], bounds[number]
        change(folder, file, None, lambda r: f(r) if low <= float(r["time_s"]) < high else r)
    return spoil


def add(name, value):
    def f(row):
        row[name] = repr(float(row[name]) + value)
        return row
    return f


def drifting(name, at_the_end):
    """A column that drifts away from what it should be, by so much at the end."""
    def spoil(file):
        def f(folder, _):
            with open(os.path.join(folder, file), newline="") as handle:
                times = [float(r["time_s"]) for r in csv.DictReader(handle)]
            first, last = min(times), max(times)
            part = lambda row: (float(row["time_s"]) - first) / (last - first)
            change(folder, file, None, lambda row: add(name, at_the_end * part(row))(row))
        return f
    return spoil


def text_of_survey(*pairs):
    """Replaces text of the survey file."""
    def f(folder, _):
        path = os.path.join(folder, "survey.toml")
        with open(path) as file:
            t = file.read()
        for old, new in pairs:
            t2 = re.sub(old, new, t)
            assert t2 != t, (old, t)
            t = t2
        with open(path, "w") as file:
            file.write(t)
    return f


def body_to_level(roll_deg, pitch_deg, heading_deg):
    """Body (right, forward, up) into east, north, up: heading clockwise, bow up, starboard down."""
    r, p, h = (math.radians(v) for v in (roll_deg, pitch_deg, heading_deg))
    cr, sr, cp, sp, ch, sh = math.cos(r), math.sin(r), math.cos(p), math.sin(p), math.cos(h), math.sin(h)
    return [[ch * cr + sh * sp * sr, sh * cp, ch * sr - sh * sp * cr],
            [-sh * cr + ch * sp * sr, ch * cp, -sh * sr - ch * sp * cr],
            [-cp * sr, sp, cp * cr]]


def of_antenna(arm_m):
    """Positions of the antenna, that far from the INS, in place of those of the INS."""
    def f(row):
        m = body_to_level(*(float(row[k]) for k in ("roll_deg", "pitch_deg", "heading_deg")))
        east, north, up = (sum(m[i][k] * arm_m[k] for k in range(3)) for i in range(3))
        radius = 6.37e6 * math.cos(math.radians(float(row["latitude_deg"])))
        row = add("latitude_deg", math.degrees(north / 6.37e6))(row)
        row = add("longitude_deg", math.degrees(east / radius))(row)
        return add("height_m", up)(row)
    return f


def scale(row, name, factor):
    row[name] = repr(float(row[name]) * factor)
    return row


def angles(row, f):
    for name in ("roll_deg", "pitch_deg", "heading_deg"):
        row[name] = repr(f(float(row[name])))
    return row


def rounded(step, *names):
    """Columns in steps: a file with too few digits."""
    return lambda r: {**r, **{name: repr(round(float(r[name]) / step) * step) for name in names}}


def later(records, *names):
    """Columns of a trajectory as they were so many records earlier."""
    def f(folder, _):
        path = os.path.join(folder, T)
        with open(path, newline="") as file:
            rows_ = list(csv.DictReader(file))
        old = [dict(r) for r in rows_]
        for k, r in enumerate(rows_):
            for name in names:
                r[name] = old[max(0, k - records)][name]
        with open(path, "w", newline="") as file:
            writer = csv.DictWriter(file, list(rows_[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows_)
    return f


def half_way(name, step):
    """A column that jumps in the middle of the survey."""
    def f(folder, _):
        with open(os.path.join(folder, T), newline="") as handle:
            times = [float(r["time_s"]) for r in csv.DictReader(handle)]
        middle = 0.5 * (times[0] + times[-1])
        change(folder, T, None, lambda r: add(name, step)(r) if float(r["time_s"]) > middle else r)
    return f


def depths(row):
    """The depth below the head in place of the range."""
    return dict(row, range_m=repr(float(row["range_m"]) * math.cos(math.radians(float(row["across_angle_deg"])))))


T, M = "trajectory.csv", "multibeam.csv"
PLACE, TURNS = ("latitude_deg", "longitude_deg", "height_m"), ("roll_deg", "pitch_deg", "heading_deg")
ARM = "lever_arm_correction_m = [-0.05, 0.20, -0.11]"
TURN = "correction_deg = { pitch = -1.4, roll = 2.1, yaw = -0.8 }"


def slipped(arm_m=0.0, roll_deg=0.0, yaw_deg=0.0, pitch_deg=0.0, forward_m=0.0, up_m=0.0):
    arm = f"lever_arm_correction_m = [{-0.05 + arm_m}, {0.20 + forward_m}, {-0.11 + up_m}]"
    turn = f"correction_deg = {{ pitch = {-1.4 + pitch_deg}, roll = {2.1 + roll_deg}, yaw = {-0.8 + yaw_deg} }}"
    return lambda t: text(TURN, turn)(text(ARM, arm)(t))


def travel_times(factor):
    def f(folder, _):
        def row(r):
            r["two_way_travel_time_s"] = repr(factor * float(r.pop("range_m")) / 1500.0)
            return r
        change(folder, M, None, row)
        with open(os.path.join(folder, "survey.toml"), "a") as file:
            file.write("\n[sound_speed]\nspeed_m_s = 1500\n")
    return f


def target(old, new):
    def f(folder, _):
        path = os.path.join(folder, "target.toml")
        with open(path) as file:
            t = file.read()
        t2 = re.sub(old, new, t)
        assert t2 != t, (old, t)
        with open(path, "w") as file:
            file.write(t2)
    return f


def arms_exchanged(folder):
    path = os.path.join(folder, "survey.toml")
    with open(path) as file:
        arms = dict(re.findall(r"^\[(multibeam|lidar)\]\n(?:(?!\[).*\n)*?lever_arm_m = (.*)$", file.read(), re.M))
    survey(folder, "multibeam", "lever_arm_m", arms["lidar"])
    survey(folder, "lidar", "lever_arm_m", arms["multibeam"])


def frd(v):
    return [v[1], v[0], -v[2]]


OF_TRAJECTORY = {
    "positions of 6 decimals": ("trajectory|position|noise|scatter", rows(T, rounded(1e-6, *PLACE[:2]))),
    "attitude of 1 decimal": ("trajectory|attitude|noise|scatter", rows(T, rounded(0.1, *TURNS))),
    "heights of 1 decimal": ("trajectory|position|noise|height|scatter", rows(T, rounded(0.1, "height_m"))),
    "attitude two records late": ("attitude|latency|trajectory|scale", later(2, *TURNS)),
    "positions two records late": ("latency|trajectory", later(2, *PLACE)),
    "heights two records late": ("latency|heave|trajectory", later(2, "height_m")),
    "longitude negated": ("origin|outside|azimuth|heading|mirror", column(T, "longitude_deg", lambda v: -v)),
    "roll twice as large": ("attitude_scale|roll", column(T, "roll_deg", lambda v: 2 * v)),
    "height jumps by 0.1 m half-way": ("trajectory|datum|height|line", half_way("height_m", 0.1)),
    "heading jumps by 0.5 deg half-way": ("heading|trajectory|line|pass", half_way("heading_deg", 0.5)),
    "across angle from the horizontal": ("angle|share|misfit|unit", column(M, "across_angle_deg", lambda v: math.copysign(90 - abs(v), v))),
}


POOL = {
    "right": (None, None),
    "attitude in radians": ("radian", rows(T, lambda r: angles(r, math.radians))),
    "attitude in gon": ("attitude|heading|unit", rows(T, lambda r: angles(r, lambda v: v / 0.9))),
    "roll negated": ("sign_of_roll", column(T, "roll_deg", lambda v: -v)),
    "pitch negated": ("sign_of_pitch", column(T, "pitch_deg", lambda v: -v)),
    "heading negated": ("sign_of_heading", column(T, "heading_deg", lambda v: -v)),
    "heading + 180": ("heading|azimuth", column(T, "heading_deg", lambda v: v + 180)),
    "heading magnetic, 5 deg": ("attitude_offset|heading", column(T, "heading_deg", lambda v: v + 5)),
    "heading 0.3 deg off": ("attitude_offset|heading", column(T, "heading_deg", lambda v: v + 0.3)),
    "roll and pitch exchanged": ("roll_and_pitch_exchanged", rows(T, exchange("roll_deg", "pitch_deg"))),
    "heading 0.1 deg off": ("attitude_offset|heading", column(T, "heading_deg", lambda v: v + 0.1)),
    "heading drifts by 0.3 deg": ("attitude_offset|heading|datum|mounting|trajectory", drifting("heading_deg", 0.3)(T)),
    "one pass's heading 0.3 deg off": ("of_pass|heading|trajectory", in_pass(2, T, add("heading_deg", 0.3))),
    "one pass 10 cm too high": ("of_pass|trajectory", in_pass(2, T, add("height_m", 0.1))),
    "roll 3 % large": ("attitude_scale", column(T, "roll_deg", lambda v: v * 1.03)),
    "positions of the antenna": ("trajectory|arm|attitude|scanner", rows(T, of_antenna((0.3, 0.5, 2.0)))),
    "pitch of the INS 0.2 deg off": ("attitude_offset|mounting", column(T, "pitch_deg", lambda v: v + 0.2)),
    "roll of the INS 0.2 deg off": ("attitude_offset|mounting", column(T, "roll_deg", lambda v: v + 0.2)),
    "roll late by 0.1 s": ("attitude|clock|latency", key("trajectory", "time_offset_s", "0.1")),
    "azimuth 180 deg off": ("target_azimuth", key("target", "azimuth_deg", lambda t: repr(float(t) + 180))),
    "azimuth 1 deg off": ("target_azimuth|attitude_offset|heading", key("target", "azimuth_deg", lambda t: repr(float(t) + 1))),
    "origin 50 m off": ("target_origin", key("target.origin", "latitude_deg", lambda t: repr(float(t) + 45e-5))),
    "origin on the geoid": ("target_origin", key("target.origin", "height_m", lambda t: repr(float(t) - 8.0))),
    "heights in feet": ("target|height", column(T, "height_m", lambda v: v / 0.3048)),
    "latitude and longitude exchanged": ("target|latitude|origin|outside", rows(T, exchange("latitude_deg", "longitude_deg"))),
    "sounder arm forward, right, down": ("axes_of_sounder_arm", key("multibeam", "lever_arm_m", vector(frd))),
    "sounder arm x negated": ("size|sounder_arm|sign", key("multibeam", "lever_arm_m", vector(lambda v: [-v[0], v[1], v[2]]))),
    "sounder arm z negated": ("size|sounder_arm|sign", key("multibeam", "lever_arm_m", vector(lambda v: [v[0], v[1], -v[2]]))),
    "sounder arm x and y exchanged": ("size|sounder_arm", key("multibeam", "lever_arm_m", vector(lambda v: [v[1], v[0], v[2]]))),
    "sounder arm in feet": ("size|sounder_arm", key("multibeam", "lever_arm_m", vector(lambda v: [c / 0.3048 for c in v]))),
    "sounder arm y negated": ("size|sounder_arm|sign", key("multibeam", "lever_arm_m", vector(lambda v: [v[0], -v[1], v[2]]))),
    "sounder arm in centimetres": ("arm|size|metres", key("multibeam", "lever_arm_m", vector(lambda v: [c * 100 for c in v]))),
    "sounder turned over": ("size|mounting|sign", key("multibeam.mounting_deg", "roll", times(-1))),
    "sounder looks astern": ("size|mounting|heading", key("multibeam.mounting_deg", "heading", "180.0")),
    "scanner arm forward, right, down": ("axes_of_scanner_arm", key("lidar", "lever_arm_m", vector(frd))),
    "scanner arm x negated": ("scanner", key("lidar", "lever_arm_m", vector(lambda v: [-v[0], v[1], v[2]]))),
    "scanner arm y negated": ("scanner", key("lidar", "lever_arm_m", vector(lambda v: [v[0], -v[1], v[2]]))),
    "scanner arm x and y exchanged": ("scanner", key("lidar", "lever_arm_m", vector(lambda v: [v[1], v[0], v[2]]))),
    "arms of sounder and scanner exchanged": ("arm|size|scanner|share", lambda d, s: arms_exchanged(d)),
    "scanner arm z 5 cm off": ("scanner", key("lidar", "lever_arm_m", vector(lambda v: [v[0], v[1], v[2] + 0.05]))),
    "scanner roll negated": ("scanner", key("lidar.mounting_deg", "roll", times(-1))),
    "scanner heading negated": ("scanner", key("lidar.mounting_deg", "heading", times(-1))),
    "scanner pitch negated": ("scanner", key("lidar.mounting_deg", "pitch", times(-1))),
    "scanner arm in feet": ("scanner", key("lidar", "lever_arm_m", vector(lambda v: [c / 0.3048 for c in v]))),
    "scanner late by 5 ms": ("laser_latency", key("lidar", "time_offset_s", "0.005")),
    "scanner late by 1 s": ("laser_latency|clock|late", key("lidar", "time_offset_s", "1.0")),
    "scanner late by 20 ms": ("laser_latency", key("lidar", "time_offset_s", "0.02")),
    "scanner early by 100 ms": ("laser_latency", key("lidar", "time_offset_s", "-0.1")),
    "sounder late by 5 ms": ("^latency", column(M, "time_s", lambda v: v + 0.005)),
    "sounder late by 20 ms": ("^latency", column(M, "time_s", lambda v: v + 0.02)),
    "sounder late by 100 ms": ("latency|late", column(M, "time_s", lambda v: v + 0.1)),
    "sounder early by 20 ms": ("^latency", column(M, "time_s", lambda v: v - 0.02)),
    "sounder late by 1 s": ("latency|clock|late", column(M, "time_s", lambda v: v + 1)),
    "sounder late by 18 s": ("clock|late|outside|trajectory", column(M, "time_s", lambda v: v + 18)),
    "sounder early by 18 s": ("clock|late|outside|trajectory", column(M, "time_s", lambda v: v - 18)),
    "sounder a day late": ("clock|late|outside|trajectory|day", column(M, "time_s", lambda v: v + 86400)),
    "sounder's clock loses 20 ms on the way": ("latency|of_pass", drifting("time_s", 0.02)(M)),
    "trajectory late by 1 s": ("clock|late|latency|attitude", column(T, "time_s", lambda v: v + 1)),
    "sounder's clock of 0.1 s": ("latency|clock|stamp|repeat", column(M, "time_s", lambda v: math.floor(v * 10) / 10)),
    "times in milliseconds": ("millisecond", column(M, "time_s", lambda v: v * 1000)),
    "one pass late by 50 ms": ("of_pass|latency", in_pass(3, M, add("time_s", 0.05))),
    "ranges 0.3 % long": ("range_scale", column(M, "range_m", lambda v: v * 1.003)),
    "ranges 1 % short": ("range_scale", column(M, "range_m", lambda v: v * 0.99)),
    "ranges 10 cm long": ("range_offset", column(M, "range_m", lambda v: v + 0.1)),
    "ranges doubled": ("range_doubled", column(M, "range_m", lambda v: v * 2)),
    "ranges in feet": ("range_unit", column(M, "range_m", lambda v: v / 0.3048)),
    "ranges in millimetres": ("millimetre", column(M, "range_m", lambda v: v * 1000)),
    "ranges in kilometres": ("range|share|no_soundings", column(M, "range_m", lambda v: v / 1000)),
    "one-way times": ("one_way_time", travel_times(1.0)),
    "travel times at 1450 for 1500 m/s": ("range_scale|sound", travel_times(2 * 1500 / 1450)),
    "range sigma ten times too small": ("noise", key("multibeam", "range_sigma_m", times(0.1))),
    "range sigma ten times too large": ("variance_factor|noise", key("multibeam", "range_sigma_m", times(10))),
    "angle sigma ten times too small": ("noise", key("multibeam", "angle_sigma_deg", times(0.1))),
    "scanner's range sigma ten times too small": ("noise", key("lidar", "range_sigma_m", times(0.1))),
    "drift sigma ten times too small": ("trajectory|variance|pass|datum", key("trajectory", "position_drift_sigma_m", times(0.1))),
    "roll and pitch sigma ten times too small": ("trajectory|variance|noise", every(replaced(T, M, "lidar.laz", edit=text("roll_pitch_sigma_deg = 0.003", "roll_pitch_sigma_deg = 0.03")))),
    "water level 1.5 m too high": ("water_level", key("target", "water_level_m", "1.5")),
    "water level 1.5 m too low": ("water_level", key("target", "water_level_m", "-1.5")),
    "across angle negated": ("across_angle|mirrored", column(M, "across_angle_deg", lambda v: -v)),
    "across and along exchanged": ("angle|no_soundings|share", rows(M, exchange("across_angle_deg", "along_angle_deg"))),
    "across angle rounded to 0.5 deg": ("noise", column(M, "across_angle_deg", lambda v: round(2 * v) / 2)),
    "ranges rounded to 5 cm": ("noise", column(M, "range_m", lambda v: round(20 * v) / 20)),
    "across angle in radians": ("beam_angle|no_soundings", column(M, "across_angle_deg", math.radians)),
    "across angle in gon": ("beam_angle", column(M, "across_angle_deg", lambda v: v / 0.9)),
    "across angle 0.5 % wide": ("beam_angle_scale", column(M, "across_angle_deg", lambda v: v * 1.005)),
    "every sounding twice": ("repeat|duplicate|noise", rows(M, lambda r: [r, dict(r)])),
    "soundings of another day": ("latency|clock|share|no_soundings|size|noise|time", replaced(M, edit=another_day)),
    "trajectory of another day": ("trajectory|target|noise|share|size|scanner|laser|variance", replaced(T, edit=another_day)),
    "pole slips 30 mm before the last pass": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(0.03))),
    "pole slips 0.2 deg in roll": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(0.0, 0.2))),
    "pole slips 0.2 deg in yaw": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(0.0, 0.0, 0.2))),
    "pole slips 0.2 deg in pitch": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(pitch_deg=0.2))),
    "pole slips 30 mm forward": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(forward_m=0.03))),
    "pole slips 30 mm up": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(up_m=0.03))),
    "pole slips 30 mm in the last pass": ("mounting_of_pass.*pass 3|noise|pass", spliced(M, 0.85, slipped(0.03))),
    "pole slips 10 mm": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(0.01))),
    "wall 10 cm longer than stated": ("face|target|datum|noise|scanner", target(r"wall_length_m = 8.0", "wall_length_m = 7.9")),
    "block legs 5 cm shorter than stated": ("face|target|share|scanner", target(r"block_leg_m = 3.0", "block_leg_m = 3.05")),
    "block height 1 % off": ("face|target|height|scanner", target(r"block_height_m = 1.0", "block_height_m = 1.01")),
    **OF_TRAJECTORY,
    "depths for ranges": ("range|depth|misfit|share", rows(M, depths)),
    "sounder arm from the sounder to the INS": ("arm|size", key("multibeam", "lever_arm_m", vector(lambda v: [-c for c in v]))),
    "scanner arm from the scanner to the INS": ("scanner", key("lidar", "lever_arm_m", vector(lambda v: [-c for c in v]))),
    "columns exchanged": ("face|target|column|scanner", lambda d, s: (target(r"minus_y_m = (-?[\d.]+)", r"XX_y_m = \1")(d, s), target("first_block_plus_y", "first_block_minus_y")(d, s), target("first_block_XX", "first_block_plus")(d, s))),
}

A, F, C = "attitude.csv", "fixes.csv", "control.csv"


def moved(name, metres, from_part=0.0):
    """A beacon stands elsewhere than surveyed, from a part of the survey on: its travel times and angles of another layout."""
    def f(folder, seed):
        with open(os.path.join(folder, C), newline="") as handle:
            pass
        change(folder, C, None, lambda r: dict(r, x_m=repr(float(r["x_m"]) + metres)) if r["name"] == name else r)
    return f


def exchanged_beacons(row):
    row["beacon"] = {"B1": "B2", "B2": "B1"}.get(row["beacon"], row["beacon"])
    return row


def half(fix_row, f, at=1060.0):
    return f(fix_row) if float(fix_row["time_s"]) > at else fix_row


def local(f):
    """Changes the beacons' east, north and up of the transducer; f of the three."""
    def spoil(folder, _):
        with open(os.path.join(folder, C), newline="") as handle:
            points = list(csv.DictReader(handle))
        place = lambda r: [float(r[k]) for k in ("x_m", "y_m", "z_m")]
        origin = next(place(r) for r in points if r["role"] == "transducer")
        length = math.sqrt(sum(c * c for c in origin))
        up = [c / length for c in origin]
        east = [-up[1], up[0], 0.0]
        east = [c / math.hypot(*east) for c in east]
        north = [up[1] * east[2] - up[2] * east[1], up[2] * east[0] - up[0] * east[2], up[0] * east[1] - up[1] * east[0]]
        axes = (east, north, up)

        def row(r):
            if r["role"] == "transducer":
                return r
            d = [a - b for a, b in zip(place(r), origin)]
            new = f([sum(a * b for a, b in zip(axis, d)) for axis in axes])
            return dict(r, **{k: repr(origin[i] + sum(new[n] * axes[n][i] for n in range(3))) for i, k in enumerate(("x_m", "y_m", "z_m"))})
        change(folder, C, None, row)
    return spoil


def upside_down(folder, _):
    """A profile of the sound speed whose depths run the wrong way."""
    path = os.path.join(folder, "sound-speed.csv")
    with open(path, newline="") as handle:
        speeds = [r["sound_speed_m_s"] for r in csv.DictReader(handle)][::-1]
    turned = iter(speeds)
    change(folder, "sound-speed.csv", None, lambda r: dict(r, sound_speed_m_s=next(turned)))


def turned_about_up(angle_deg):
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return local(lambda v: [c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]])


USBL = {
    "right": (None, None),
    "attitude in radians": ("attitude_in_radians", rows(A, lambda r: angles(r, math.radians))),
    "roll negated": ("sign_of_roll|attitude", column(A, "roll_deg", lambda v: -v)),
    "pitch negated": ("sign_of_pitch|attitude", column(A, "pitch_deg", lambda v: -v)),
    "heading negated": ("sign_of_heading|heading", column(A, "heading_deg", lambda v: -v)),
    "heading + 180": ("size|heading", column(A, "heading_deg", lambda v: v + 180)),
    "roll and pitch exchanged": ("roll_and_pitch|attitude", rows(A, exchange("roll_deg", "pitch_deg"))),
    "attitude late by 1 s": ("^latency", column(A, "time_s", lambda v: v + 1)),
    "attitude of another day": ("attitude|heading|latency", replaced(A, edit=another_day)),
    "attitude sigma ten times too small": ("attitude|noise", every(key("attitude", "roll_pitch_sigma_deg", times(0.1)), key("attitude", "heading_sigma_deg", times(0.1)))),
    "x negated": ("sign_of_x|axes|size", column(F, "x_angle_deg", lambda v: 180 - v)),
    "y negated": ("sign_of_y|axes|size", column(F, "y_angle_deg", lambda v: 180 - v)),
    "x and y exchanged": ("axes_exchanged|size", rows(F, exchange("x_angle_deg", "y_angle_deg"))),
    "angles in radians": ("angle", rows(F, lambda r: scale(scale(r, "x_angle_deg", math.pi / 180), "y_angle_deg", math.pi / 180))),
    "angles in gon": ("angle|share|fix", rows(F, lambda r: scale(scale(r, "x_angle_deg", 1 / 0.9), "y_angle_deg", 1 / 0.9))),
    "one-way times": ("half_time|one_way|time", column(F, "two_way_travel_time_s", lambda v: v / 2)),
    "times doubled": ("two_way_time|time", column(F, "two_way_travel_time_s", lambda v: v * 2)),
    "times in milliseconds": ("time|millisecond", column(F, "two_way_travel_time_s", lambda v: v * 1000)),
    "turn-around 1 ms forgotten": ("range_offset|turn", column(F, "two_way_travel_time_s", lambda v: v + 0.001)),
    "sound speed 1 % off": ("prior|range|sound", column("sound-speed.csv", "sound_speed_m_s", lambda v: v * 1.01)),
    "sound speed in feet": ("sound", column("sound-speed.csv", "sound_speed_m_s", lambda v: v / 0.3048)),
    "a beacon moved by 1 m": ("beacon", moved("B1", 1.0)),
    "a beacon moved by 0.3 m": ("beacon|noise|prior", moved("B1", 0.3)),
    "a beacon moved by 0.1 m": ("beacon|noise|prior", moved("B1", 0.1)),
    "two beacons exchanged": ("beacon", rows(F, exchanged_beacons)),
    "two beacons exchanged half-way": ("beacon", rows(F, lambda r: half(r, exchanged_beacons))),
    "angle sigma ten times too small": ("noise", key("fixes", "angle_sigma_deg", times(0.1))),
    "angle sigma ten times too large": ("variance_factor|noise", key("fixes", "angle_sigma_deg", times(10))),
    "range sigma ten times too small": ("noise", key("fixes", "range_sigma_m", times(0.1))),
    "every fix twice": ("repeat|duplicate", rows(F, lambda r: [r, dict(r)])),
    "nominal speed 1450 for 1500": ("speed|angle|scale", key("fixes", "nominal_speed_m_s", "1450.0")),
    "attitude in gon": ("heading|size|unit", rows(A, lambda r: angles(r, lambda v: v / 0.9))),
    "fixes late by 18 s": ("latency|clock|outside", column(F, "time_s", lambda v: v + 18)),
    "fixes late by 0.3 s": ("latency", column(F, "time_s", lambda v: v + 0.3)),
    "angles from the other side": ("angle|size|axes", rows(F, lambda r: dict(r, x_angle_deg=repr(90 - float(r["x_angle_deg"])), y_angle_deg=repr(90 - float(r["y_angle_deg"]))))),
    "times 0.2 ms short": ("range_offset|turn|prior", column(F, "two_way_travel_time_s", lambda v: v - 0.0002)),
    "sound speed 0.3 % off": ("prior|range|sound|transducer", column("sound-speed.csv", "sound_speed_m_s", lambda v: v * 1.003)),
    "profile upside down": ("prior|range|sound|transducer", upside_down),
    "beacons' east and north exchanged": ("size|beacon|axes|mirrored", local(lambda v: [v[1], v[0], v[2]])),
    "beacons' east negated": ("size|beacon|axes|mirrored", local(lambda v: [-v[0], v[1], v[2]])),
    "beacons above the transducer": ("size|beacon|depth|above", local(lambda v: [v[0], v[1], -v[2]])),
    "beacons 0.3 m too deep": ("prior|range|transducer|beacon", local(lambda v: [v[0], v[1], v[2] - 0.3])),
    "beacons in feet": ("range|unit|beacon|prior|half_time|time", local(lambda v: [c / 0.3048 for c in v])),
    "beacons 2 % too far apart": ("range|scale|beacon|prior|transducer", local(lambda v: [1.02 * v[0], 1.02 * v[1], v[2]])),
    "beacons named round the square": ("size|beacon", rows(F, lambda r: dict(r, beacon={"B1": "B2", "B2": "B3", "B3": "B4", "B4": "B1"}.get(r["beacon"], r["beacon"])))),
    "heading magnetic, 5 deg": ("heading", column(A, "heading_deg", lambda v: v + 5)),
    "heading drifts by 2 deg": ("heading|attitude|latency|noise", drifting("heading_deg", 2.0)(A)),
    "transducer 0.3 m too deep": ("prior|range|transducer|beacon", rows(C, lambda r: dict(r, z_m=repr(float(r["z_m"]) - 0.3)) if r["role"] == "transducer" else r)),
    "transducer survey 0.2 m off": ("prior|range|transducer", rows(C, lambda r: dict(r, x_m=repr(float(r["x_m"]) + 0.2)) if r["role"] == "transducer" else r)),
}

P, TB = "profiles.csv", "table.csv"


def uic60(folder, _):
    with open(os.path.join(ROOT, "models/rails/uic60.toml")) as file:
        t = file.read()
    with open(os.path.join(folder, "rail.toml"), "w") as file:
        file.write(t)


def worn(depth_mm):
    """The measured points of the head's right side lie deeper: wear of a good rail model by that much."""
    def f(folder, _):
        path = os.path.join(folder, "rail.toml")
        with open(path) as file:
            t = file.read()
        t = t.replace("to_mm = [35.400000, -14.192852]", f"to_mm = [{35.4 + depth_mm:.6f}, -14.192852]")
        t = t.replace("to_mm = [36.431062, -34.814087]", f"to_mm = [{36.431062 + depth_mm:.6f}, -34.814087]")
        with open(path, "w") as file:
            file.write(t)
    return f


def profilers_exchanged(row):
    row["profiler"] = {"1": "2", "2": "1"}.get(row["profiler"], row["profiler"])
    return row


def a_position_late(folder, _):
    """The table's angles stand in the row after their own."""
    last = {}

    def row(r):
        own = (r["heading_deg"], r["pitch_deg"])
        if last:
            r["heading_deg"], r["pitch_deg"] = last["own"]
        last["own"] = own
        return r
    change(folder, TB, None, row)


RAIL = {
    "right": (None, None),
    "UIC60 for CHN60": ("other_rail", uic60),
    "head 0.2 mm narrower than its model": ("rail_element|noise", worn(0.2)),
    "INS heading 5 deg off": ("ins_attitude|prior", column(A, "heading_deg", lambda v: v + 5)),
    "INS heading 0.5 deg off": ("ins_attitude|prior", column(A, "heading_deg", lambda v: v + 0.5)),
    "INS roll negated": ("sign_of_ins_roll", column(A, "roll_deg", lambda v: -v)),
    "INS pitch negated": ("ins_attitude|noise|sign|INS", column(A, "pitch_deg", lambda v: -v)),
    "INS heading negated": ("ins_attitude|noise|sign|INS", column(A, "heading_deg", lambda v: -v)),
    "INS roll and pitch exchanged": ("ins_attitude|noise|INS|exchanged", rows(A, exchange("roll_deg", "pitch_deg"))),
    "INS in radians": ("ins_attitude|noise|INS|radian", rows(A, lambda r: angles(r, math.radians))),
    "table heading negated": ("table|sign", column(TB, "heading_deg", lambda v: -v)),
    "table pitch negated": ("table|sign", column(TB, "pitch_deg", lambda v: -v)),
    "table axes exchanged": ("table", rows(TB, exchange("heading_deg", "pitch_deg"))),
    "table in radians": ("table|radian", rows(TB, lambda r: scale(scale(r, "heading_deg", math.pi / 180), "pitch_deg", math.pi / 180))),
    "table sigma ten times too small": ("table", key("table", "angle_sigma_deg", times(0.1))),
    "lateral negated": ("sign|mirrored|lateral", column(P, "y_m", lambda v: -v)),
    "height negated": ("sign|share|vertical|height|coarse", column(P, "z_m", lambda v: -v)),
    "points in millimetres": ("milli|unit|share|coarse", rows(P, lambda r: scale(scale(r, "y_m", 1000), "z_m", 1000))),
    "points 0.2 % large": ("scale|noise|element|prior", rows(P, lambda r: scale(scale(r, "y_m", 1.002), "z_m", 1.002))),
    "lateral 1 % large": ("scale|noise|element|prior", column(P, "y_m", lambda v: v * 1.01)),
    "profilers exchanged": ("profiler|exchanged|share|size|coarse", rows(P, profilers_exchanged)),
    "point sigma ten times too small": ("noise", lambda d, s: [survey(d, "[profiler]", k, times(0.1)) for k in ("lateral_sigma_m", "vertical_sigma_m")]),
    "pivot of the body 20 mm off": ("prior|pivot", key("table", "pivot_body_m", "[0.0, 0.02, -0.1]")),
    "rail heading 1 deg off": ("prior|rail|ins", key("rail.orientation_deg", "heading", "1.0")),
    "profiles late by 2 s": ("time|share|coarse|noise|position", column(P, "time_s", lambda v: v + 2)),
    "lateral of one profiler negated": ("sign|mirrored|lateral|profiler|share|coarse", rows(P, lambda r: scale(r, "y_m", -1) if r["profiler"] == "1" else r)),
    "points in inches": ("milli|unit|share|coarse|size", rows(P, lambda r: scale(scale(r, "y_m", 1 / 0.0254), "z_m", 1 / 0.0254))),
    "one profiler's points 1 % large": ("scale|noise|element|prior|share", rows(P, lambda r: scale(scale(r, "y_m", 1.01), "z_m", 1.01) if r["profiler"] == "1" else r)),
    "table heading 1 % large": ("table|ins|noise|prior", column(TB, "heading_deg", lambda v: v * 1.01)),
    "table pitch 1 % large": ("table|ins|noise|prior", column(TB, "pitch_deg", lambda v: v * 1.01)),
    "table heading 0.5 deg off": ("table|ins|prior", column(TB, "heading_deg", lambda v: v + 0.5)),
    "table pitch 0.1 deg off": ("table|ins|prior", column(TB, "pitch_deg", lambda v: v + 0.1)),
    "table a position late": ("table|time|share|coarse|noise|ins", a_position_late),
    "INS heading drifts by 0.1 deg": ("ins_attitude|noise|table", drifting("heading_deg", 0.1)(A)),
    "INS heading + 180": ("ins_attitude|prior|noise", column(A, "heading_deg", lambda v: v + 180)),
    "INS roll 0.2 deg off": ("ins_attitude|prior", column(A, "roll_deg", lambda v: v + 0.2)),
    "INS roll 1 deg off": ("ins_attitude|prior", column(A, "roll_deg", lambda v: v + 1.0)),
    "INS pitch 0.2 deg off": ("ins_attitude|prior", column(A, "pitch_deg", lambda v: v + 0.2)),
    "INS late by 7 s": ("ins_attitude|noise|table|time", column(A, "time_s", lambda v: v + 7)),
    "rail rolled 0.2 deg": ("prior|rail|ins", key("rail.orientation_deg", "roll", "0.2")),
    "rail pitched 0.2 deg": ("prior|rail|ins", key("rail.orientation_deg", "pitch", "0.2")),
    "pivot above the rail 5 mm off": ("prior|pivot", key("table", "pivot_rail_m", "[0.0, 0.105]")),
    "arms of the profilers exchanged": ("size|sign|share|coarse|arm", text_of_survey((r"lever_arm_m = \[-0.3, ", "lever_arm_m = [X, "), (r"lever_arm_m = \[0.3, ", "lever_arm_m = [-0.3, "), (r"lever_arm_m = \[X, ", "lever_arm_m = [0.3, "))),
    "mounting roll signs exchanged": ("size|sign|share|coarse|mounting", lambda d, s: flipped_mountings(d)),
}


def flipped_mountings(folder):
    path = os.path.join(folder, "survey.toml")
    with open(path) as file:
        t = file.read()
    t = t.replace("roll = -55.0", "roll = X").replace("roll = 55.0", "roll = -55.0").replace("roll = X", "roll = 55.0")
    with open(path, "w") as file:
        file.write(t)


def in_line(number, file, f):
    """f of the rows of one line of a seabed survey."""
    def spoil(folder, _):
        with open(os.path.join(folder, "survey.toml")) as handle:
            spans = re.findall(r"start_s = (.*)\nend_s = (.*)\n", handle.read())
        low, high = map(float, spans[number - 1])
        change(folder, file, None, lambda r: f(r) if low <= float(r["time_s"]) <= high else r)
    return spoil


def range_column(folder):
    with open(os.path.join(folder, M)) as file:
        head = file.readline()
    return "range_m" if "range_m" in head else "two_way_travel_time_s"


def ranges(f):
    return lambda d, _: change(d, M, range_column(d), f)


def heave(row):
    """The heave of a boat with the other sign; the mean height of the scenario's site is its origin's."""
    return dict(row, height_m=repr(24.0 - float(row["height_m"])))


def speeds(f):
    def spoil(folder, _):
        name = next(n for n in os.listdir(folder) if n.startswith("sound") and n.endswith(".csv"))
        change(folder, name, "sound_speed_m_s", f)
    return spoil


def lines_exchanged(folder, _):
    """The soundings of two lines with each other's stamps."""
    with open(os.path.join(folder, "survey.toml")) as handle:
        spans = [tuple(map(float, s)) for s in re.findall(r"start_s = (.*)\nend_s = (.*)\n", handle.read())]
    (a, b), (c, d) = spans[0], spans[3]

    def row(r):
        t = float(r["time_s"])
        by = c - a if a <= t <= b else a - c if c <= t <= d else 0.0
        return dict(r, time_s=repr(t + by))
    change(folder, M, None, row, sort=lambda r: float(r["time_s"]))


SEABED = {
    "right": (None, None),
    "attitude in radians": ("attitude|radian|misfit|prior", rows(T, lambda r: angles(r, math.radians))),
    "roll negated": ("sign_of_roll", column(T, "roll_deg", lambda v: -v)),
    "pitch negated": ("sign_of_pitch", column(T, "pitch_deg", lambda v: -v)),
    "heading negated": ("sign_of_heading", column(T, "heading_deg", lambda v: -v)),
    "heading + 180": ("heading", column(T, "heading_deg", lambda v: v + 180)),
    "roll and pitch exchanged": ("roll_and_pitch", rows(T, exchange("roll_deg", "pitch_deg"))),
    "heading 2 deg off": ("heading", column(T, "heading_deg", lambda v: v + 2)),
    "heading drifts by 1 deg": ("heading|scatter|misfit", drifting("heading_deg", 1.0)(T)),
    "roll 3 % large": ("attitude|scatter|misfit|prior", column(T, "roll_deg", lambda v: v * 1.03)),
    "roll drifts by 0.1 deg": ("drift|scatter|misfit|prior", drifting("roll_deg", 0.1)(T)),
    "roll of one line 0.1 deg off": ("line|scatter|misfit|prior", in_line(2, T, add("roll_deg", 0.1))),
    "pitch of one line 0.3 deg off": ("line|scatter|misfit|prior", in_line(2, T, add("pitch_deg", 0.3))),
    "heading of one line 1 deg off": ("line|scatter|misfit|prior", in_line(2, T, add("heading_deg", 1.0))),
    "heave negated": ("heave|prior", rows(T, heave)),
    "heave 20 % large": ("heave|prior", rows(T, lambda r: dict(r, height_m=repr(12 + 1.2 * (float(r["height_m"]) - 12))))),
    "a tide of 0.3 m on a line": ("height|line|prior|misfit", in_line(2, T, add("height_m", 0.3))),
    "a tide of 0.3 m within a line": ("height|scatter|misfit|prior", drifting("height_m", 0.5)(T)),
    "positions of the antenna": ("arm|scatter|misfit|prior|heave", rows(T, of_antenna((0.3, 0.5, 2.0)))),
    "positions of one line 1 m off": ("line|scatter|misfit|prior", in_line(2, T, add("latitude_deg", 1e-5))),
    "latitude and longitude exchanged": ("latitude|origin|outside", rows(T, exchange("latitude_deg", "longitude_deg"))),
    "arm x and y exchanged": ("arm|prior", key("multibeam", "lever_arm_m", vector(lambda v: [v[1], v[0], v[2]]))),
    "arm y negated": ("arm|prior", key("multibeam", "lever_arm_m", vector(lambda v: [v[0], -v[1], v[2]]))),
    "arm z negated": ("arm|prior|heave", key("multibeam", "lever_arm_m", vector(lambda v: [v[0], v[1], -v[2]]))),
    "arm forward, right, down": ("arm|prior", key("multibeam", "lever_arm_m", vector(frd))),
    "late by 20 ms more": ("latency", column(M, "time_s", lambda v: v + 0.02)),
    "late by 1 s": ("latency|clock|late|misfit|prior|size", column(M, "time_s", lambda v: v + 1)),
    "late by 18 s": ("latency|clock|late|outside|misfit|overlap", column(M, "time_s", lambda v: v + 18)),
    "one line late by 50 ms": ("latency|line|scatter|misfit|prior", in_line(3, M, add("time_s", 0.05))),
    "clock of 0.1 s": ("latency|clock|stamp|misfit|prior|repeat", column(M, "time_s", lambda v: math.floor(v * 10) / 10)),
    "ranges 0.5 % long": ("range_scale|prior|misfit", ranges(lambda v: v * 1.005)),
    "ranges 2 % long": ("range_scale|prior|misfit", ranges(lambda v: v * 1.02)),
    "ranges 10 cm long": ("range_offset|prior|misfit", ranges(lambda v: v * (1 + 0.1 / 12) )),
    "ranges doubled": ("range|prior|misfit", ranges(lambda v: v * 2)),
    "ranges halved": ("range|prior|misfit|one_way", ranges(lambda v: v / 2)),
    "sound speed 1 % off": ("profile|prior|range_scale|speed", speeds(lambda v: v * 1.01)),
    "across angle negated": ("across_angle|mirrored|misfit", column(M, "across_angle_deg", lambda v: -v)),
    "across angle 1 % wide": ("beam_angle|prior|misfit|scatter", column(M, "across_angle_deg", lambda v: v * 1.01)),
    "across angle in gon": ("beam_angle|prior|misfit|scatter", column(M, "across_angle_deg", lambda v: v / 0.9)),
    "across angle in radians": ("beam_angle|angle|misfit", column(M, "across_angle_deg", math.radians)),
    "two lines exchanged": ("line|misfit|prior|overlap|clock", lines_exchanged),
    "pole slips 0.3 deg in roll before the last line": ("line|misfit|prior|scatter", in_line(4, M, add("across_angle_deg", 0.3))),
    "range sigma ten times too small": ("noise|misfit", key("multibeam", "range_sigma_m", times(0.1))),
    "angle sigma ten times too small": ("noise|misfit", key("multibeam", "angle_sigma_deg", times(0.1))),
    "range sigma ten times too large": ("noise|misfit", key("multibeam", "range_sigma_m", times(10))),
    "every sounding twice": ("repeat|duplicate|noise", rows(M, lambda r: [r, dict(r)])),
    **OF_TRAJECTORY,
    "arm from the sounder to the INS": ("arm|prior|heave", key("multibeam", "lever_arm_m", vector(lambda v: [-c for c in v]))),
    "trajectory of another day": ("misfit|prior|scatter|overlap", replaced(T, edit=lambda t: t.replace("period_s = 5.0", "period_s = 6.1"))),
}

CASES = {"pool": POOL, "pool-one": POOL, "usbl": USBL, "rail": RAIL, "seabed": SEABED}


def scenario_text():
    with open(os.path.join(ROOT, "models/scenarios", SCENARIOS[WHICH] + ".toml")) as file:
        return file.read()


def simulate(t, seed, folder):
    path = os.path.join(folder, "scenario.toml")
    with open(path, "w") as file:
        file.write(t)
    made = os.path.join(folder, "made")
    subprocess.run([PROGRAM, "simulate", path, "--out", made, "--seed", str(seed), "--quiet", "--threads", "1"], check=True)
    for name in os.listdir(made):
        os.replace(os.path.join(made, name), os.path.join(folder, name))


def turn_between(a, b):
    """Rotation vector of a b^T, small angles."""
    m = [[sum(a[i][k] * b[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    return [0.5 * (m[2][1] - m[1][2]), 0.5 * (m[0][2] - m[2][0]), 0.5 * (m[1][0] - m[0][1])]


LATENCY = {"s": 1.0, "ms": 1e-3}


def estimates(result):
    """Rotation and lever arm of every mounting, the sigma of every parameter in radians, metres and seconds, and the latency."""
    joint = result["solutions"]["joint"]
    sigma = {p["name"]: p["sigma"] * (math.pi / 180 if p["unit"] == "deg" else 1) for p in joint["parameters"] if p["sigma"]}
    latency = [p["value"] * LATENCY[p["unit"]] for p in joint["parameters"] if p["name"] == "latency" and p["sigma"]]
    sigma.update({p["name"]: p["sigma"] * LATENCY[p["unit"]] for p in joint["parameters"] if p["name"] == "latency" and p["sigma"]})
    return [(m["name"], m["rotation_matrix"], m.get("lever_arm_m")) for m in joint["mountings"]], sigma, latency


def moved_by(found, right):
    """How far the mistake moved a parameter at most, in the sigmas that its own result states."""
    (mountings, sigma, latency), worst = found, 0.0
    if latency and right[2]:
        worst = abs(latency[0] - right[2][0]) / sigma["latency"]
    for (name, rotation, arm), (_, right_rotation, right_arm) in zip(mountings, right[0]):
        prefix = name + " " if len(mountings) > 1 else ""
        pairs = list(zip(("pitch", "roll", "yaw"), turn_between(rotation, right_rotation)))
        if arm and right_arm:
            pairs += list(zip(("lx", "ly", "lz"), (a - b for a, b in zip(arm, right_arm))))
        for part, error in pairs:
            if prefix + part in sigma:
                worst = max(worst, abs(error) / sigma[prefix + part])
    return worst


RIGHT = {}


def right(seed):
    """Estimates of the survey of a seed without a mistake."""
    if seed not in RIGHT:
        with tempfile.TemporaryDirectory() as folder:
            simulate(scenario_text(), seed, folder)
            RIGHT[seed] = estimates(json.loads(calibrated(folder).stdout))
    return RIGHT[seed]


def calibrated(folder):
    command = [PROGRAM, "calibrate", os.path.join(folder, "survey.toml"), "--method", "joint", "--out", os.path.join(folder, "out"), "--json", "--threads", "1"]
    return subprocess.run(command, capture_output=True, text=True)


def tried(name, expected, spoil, seed):
    """Whether it passed, the largest error in sigmas if so, whether the cause came first, what came first."""
    with tempfile.TemporaryDirectory() as folder:
        simulate(scenario_text(), seed, folder)
        if spoil:
            spoil(folder, seed)
        end = calibrated(folder)
        if end.returncode not in (0, 1):
            first = "exit 2: " + end.stderr.strip().replace("\n", " ").replace(folder, "")[:160]
            return False, 0.0, bool(expected and re.search(expected, first, re.I)), first if expected else first
        result = json.loads(end.stdout)
        findings = result["verdict"]["findings"]
        first = f"{findings[0]['code']}: {findings[0]['seen']} {findings[0]['advice']}" if findings else ""
        named = bool(expected and findings and re.search(expected, findings[0]["code"] + " " + (findings[0]["seen"] if ".*" in expected else ""), re.I))
        passed = result["usable"]
        return passed, moved_by(estimates(result), right(seed)) if passed else 0.0, named, first


def main():
    global PROGRAM, WHICH
    PROGRAM, WHICH = os.path.abspath(sys.argv[1]), sys.argv[2]
    seeds = int(sys.argv[3]) if len(sys.argv) > 3 else 10
    wanted, total = sys.argv[4:], [0, 0, 0, 0]
    print("| mistake | withdrawn | silent | largest move of those that passed | cause first | first codes |\n|---|---|---|---|---|---|")
    for name, (expected, spoil) in CASES[WHICH].items():
        if wanted and not any(name.startswith(w) for w in wanted):
            continue
        if WHICH == "pool-one" and "pass" in name or WHICH == "pool-one" and "pole" in name:
            continue
        outcomes = [tried(name, expected, spoil, seed) for seed in range(1, seeds + 1)]
        withdrawn = sum(not o[0] for o in outcomes)
        silent = sum(o[0] and o[1] > 2 and not o[2] for o in outcomes)
        if spoil:
            counts = [len(outcomes), withdrawn, silent, sum(o[2] for o in outcomes)]
            total = [a + b for a, b in zip(total, counts)]
        codes = collections.Counter(o[3].split(":")[0] or "none" for o in outcomes)
        said = ", ".join(f"{code} {count}" for code, count in codes.most_common(4))
        print(f"| {name} | {withdrawn} of {seeds} | {silent} | {max(o[1] for o in outcomes):.1f} | {sum(o[2] for o in outcomes)} | {said} |", flush=True)
        if os.environ.get("WORDS"):
            for o in outcomes[:2]:
                print("    ", o[3][:300])
    print(f"| all mistakes | {total[1]} of {total[0]} | {total[2]} | | {total[3]} | |")


main()
