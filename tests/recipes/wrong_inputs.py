"""Makes mistakes that surveyors make to simulated surveys and counts what the verdict says: standard library only.

    python3 tests/recipes/wrong_inputs.py target/release/boresight pool|pool-one|usbl|rail [SEEDS] [CASE ...]

Each line: the mistake; of how many seeds usable was withdrawn (or the input refused); seeds that passed without a word of the cause
although the mistake moved a parameter by more than 2 sigma from where the same seed's right survey puts it (silent: the bar is 1 in
100); the largest move of those that passed, in sigmas; how often the first finding named the cause; the codes that came first. Seeds
are 1 to SEEDS. `right` makes no mistake. The last line is the sum of all mistakes.
"""
import collections, csv, json, math, os, re, subprocess, sys, tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
SCENARIOS = {"pool": "three-pass-thin", "pool-one": "single-pass-thin", "usbl": "usbl-thin", "rail": "rail-thin"}


def change(folder, name, column, f):
    """f of one column's number, or of a whole row as a dictionary where no column is named."""
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


def scale(row, name, factor):
    row[name] = repr(float(row[name]) * factor)
    return row


def angles(row, f):
    for name in ("roll_deg", "pitch_deg", "heading_deg"):
        row[name] = repr(f(float(row[name])))
    return row


T, M = "trajectory.csv", "multibeam.csv"
ARM = "lever_arm_correction_m = [-0.05, 0.20, -0.11]"
TURN = "correction_deg = { pitch = -1.4, roll = 2.1, yaw = -0.8 }"


def slipped(arm_m=0.0, roll_deg=0.0, yaw_deg=0.0):
    arm = f"lever_arm_correction_m = [{-0.05 + arm_m}, 0.20, -0.11]"
    turn = f"correction_deg = {{ pitch = -1.4, roll = {2.1 + roll_deg}, yaw = {-0.8 + yaw_deg} }}"
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
    "roll of the INS 0.2 deg off": ("attitude_offset|mounting", column(T, "roll_deg", lambda v: v + 0.2)),
    "roll late by 0.1 s": ("attitude|clock|latency", key("trajectory", "time_offset_s", "0.1")),
    "azimuth 180 deg off": ("target_azimuth", key("target", "azimuth_deg", lambda t: repr(float(t) + 180))),
    "origin 50 m off": ("target_origin", key("target.origin", "latitude_deg", lambda t: repr(float(t) + 45e-5))),
    "origin on the geoid": ("target_origin", key("target.origin", "height_m", lambda t: repr(float(t) - 8.0))),
    "heights in feet": ("target|height", column(T, "height_m", lambda v: v / 0.3048)),
    "latitude and longitude exchanged": ("target|latitude|origin|outside", rows(T, exchange("latitude_deg", "longitude_deg"))),
    "sounder arm forward, right, down": ("axes_of_sounder_arm", key("multibeam", "lever_arm_m", vector(frd))),
    "sounder arm x negated": ("size|sounder_arm|sign", key("multibeam", "lever_arm_m", vector(lambda v: [-v[0], v[1], v[2]]))),
    "sounder arm z negated": ("size|sounder_arm|sign", key("multibeam", "lever_arm_m", vector(lambda v: [v[0], v[1], -v[2]]))),
    "sounder arm x and y exchanged": ("size|sounder_arm", key("multibeam", "lever_arm_m", vector(lambda v: [v[1], v[0], v[2]]))),
    "sounder arm in feet": ("size|sounder_arm", key("multibeam", "lever_arm_m", vector(lambda v: [c / 0.3048 for c in v]))),
    "scanner arm forward, right, down": ("axes_of_scanner_arm", key("lidar", "lever_arm_m", vector(frd))),
    "scanner arm x negated": ("scanner", key("lidar", "lever_arm_m", vector(lambda v: [-v[0], v[1], v[2]]))),
    "scanner arm y negated": ("scanner", key("lidar", "lever_arm_m", vector(lambda v: [v[0], -v[1], v[2]]))),
    "scanner arm x and y exchanged": ("scanner", key("lidar", "lever_arm_m", vector(lambda v: [v[1], v[0], v[2]]))),
    "arms of sounder and scanner exchanged": ("arm|size|scanner|share", lambda d, s: arms_exchanged(d)),
    "scanner arm z 5 cm off": ("scanner", key("lidar", "lever_arm_m", vector(lambda v: [v[0], v[1], v[2] + 0.05]))),
    "scanner roll negated": ("scanner", key("lidar.mounting_deg", "roll", times(-1))),
    "scanner heading negated": ("scanner", key("lidar.mounting_deg", "heading", times(-1))),
    "scanner late by 20 ms": ("laser_latency", key("lidar", "time_offset_s", "0.02")),
    "scanner early by 100 ms": ("laser_latency", key("lidar", "time_offset_s", "-0.1")),
    "sounder late by 5 ms": ("^latency", column(M, "time_s", lambda v: v + 0.005)),
    "sounder late by 20 ms": ("^latency", column(M, "time_s", lambda v: v + 0.02)),
    "sounder late by 100 ms": ("latency|late", column(M, "time_s", lambda v: v + 0.1)),
    "sounder early by 20 ms": ("^latency", column(M, "time_s", lambda v: v - 0.02)),
    "sounder late by 1 s": ("latency|clock|late", column(M, "time_s", lambda v: v + 1)),
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
    "across angle in radians": ("beam_angle|no_soundings", column(M, "across_angle_deg", math.radians)),
    "across angle in gon": ("beam_angle", column(M, "across_angle_deg", lambda v: v / 0.9)),
    "across angle 0.5 % wide": ("beam_angle_scale", column(M, "across_angle_deg", lambda v: v * 1.005)),
    "every sounding twice": ("repeat|duplicate|noise", rows(M, lambda r: [r, dict(r)])),
    "soundings of another day": ("latency|clock|share|no_soundings|size|noise|time", replaced(M, edit=another_day)),
    "trajectory of another day": ("trajectory|target|noise|share|size|scanner|laser|variance", replaced(T, edit=another_day)),
    "pole slips 30 mm before the last pass": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(0.03))),
    "pole slips 0.2 deg in roll": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(0.0, 0.2))),
    "pole slips 0.2 deg in yaw": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(0.0, 0.0, 0.2))),
    "pole slips 10 mm": ("mounting_of_pass.*pass 3", spliced(M, 0.64, slipped(0.01))),
    "wall 10 cm longer than stated": ("face|target|datum|noise|scanner", target(r"wall_length_m = 8.0", "wall_length_m = 7.9")),
    "block legs 5 cm shorter than stated": ("face|target|share|scanner", target(r"block_leg_m = 3.0", "block_leg_m = 3.05")),
    "block height 1 % off": ("face|target|height|scanner", target(r"block_height_m = 1.0", "block_height_m = 1.01")),
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


RAIL = {
    "right": (None, None),
    "UIC60 for CHN60": ("other_rail", uic60),
    "head 0.2 mm narrower than its model": ("rail_element|noise", worn(0.2)),
    "INS heading 5 deg off": ("ins_attitude|prior", column(A, "heading_deg", lambda v: v + 5)),
    "INS heading 0.5 deg off": ("ins_attitude|prior", column(A, "heading_deg", lambda v: v + 0.5)),
    "INS roll negated": ("ins_attitude|noise", column(A, "roll_deg", lambda v: -v)),
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
    "mounting roll signs exchanged": ("size|sign|share|coarse|mounting", lambda d, s: flipped_mountings(d)),
}


def flipped_mountings(folder):
    path = os.path.join(folder, "survey.toml")
    with open(path) as file:
        t = file.read()
    t = t.replace("roll = -55.0", "roll = X").replace("roll = 55.0", "roll = -55.0").replace("roll = X", "roll = 55.0")
    with open(path, "w") as file:
        file.write(t)


CASES = {"pool": POOL, "pool-one": POOL, "usbl": USBL, "rail": RAIL}


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


def estimates(result):
    """Rotation and lever arm of every mounting, and the sigma of every parameter in radians and metres."""
    joint = result["solutions"]["joint"]
    sigma = {p["name"]: p["sigma"] * (math.pi / 180 if p["unit"] == "deg" else 1) for p in joint["parameters"] if p["sigma"]}
    return [(m["name"], m["rotation_matrix"], m.get("lever_arm_m")) for m in joint["mountings"]], sigma


def moved_by(found, right):
    """How far the mistake moved a parameter at most, in the sigmas that its own result states."""
    (mountings, sigma), worst = found, 0.0
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
