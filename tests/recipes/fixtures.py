"""Cuts the committed fixtures under tests/data out of the two simulated development surveys (python3, numpy, laspy[lazrs]).

usage: fixtures.py FOLDER-OF-THE-SURVEYS tests/data
"""
import pathlib, shutil, sys
import laspy, numpy as np

source, out = map(pathlib.Path, sys.argv[1:])


def laser(survey, name, window, step):
    points = laspy.read(source / survey / "lidar.laz")
    keep = np.zeros(len(points), bool)
    for begin, end in window:
        keep |= (points.gps_time >= begin) & (points.gps_time < end)
    rows = np.flatnonzero(keep)[::step]
    points.points = points.points[rows]
    points.write(out / name / "lidar.laz")


def soundings(survey, name, window, step):
    lines = (source / survey / "multibeam.csv").read_text().splitlines()
    rows = [r for r in lines[1:] if any(b <= float(r.split(",")[0]) < e for b, e in window)]
    (out / name / "multibeam.csv").write_text("\n".join([lines[0], *rows[::step]]) + "\n")


def common(survey, name):
    (out / name).mkdir(parents=True, exist_ok=True)
    for file in ["survey.toml", "target.toml"]:
        shutil.copyfile(source / survey / file, out / name / file)


window = [(1010.0, 1012.4)]
common("single-pass", "csv")
lines = (source / "single-pass" / "trajectory.csv").read_text().splitlines()
rows = [r for r in lines[1:] if 1009.9 <= float(r.split(",")[0]) <= 1012.5]
(out / "csv" / "trajectory.csv").write_text("\n".join([lines[0], *rows]) + "\n")
laser("single-pass", "csv", window, 12)
soundings("single-pass", "csv", window, 29)

records = np.fromfile(source / "three-pass" / "trajectory.out", "<f8").reshape(-1, 17)
gap = int(np.argmax(np.diff(records[:, 0])))
cut = np.concatenate([records[gap - 790 : gap + 1 : 10], records[gap + 1 : gap + 801 : 10]])
common("three-pass", "sbet")
cut.tofile(out / "sbet" / "trajectory.out")
t = cut[:, 0]
hole = int(np.argmax(np.diff(t)))
window = [(t[0], t[hole]), (t[hole + 1], t[-1])]
print(len(t), "records, gap from", t[hole], "to", t[hole + 1], "wander", cut[0, 10])
laser("three-pass", "sbet", window, 60)
soundings("three-pass", "sbet", window, 191)
for path in sorted(out.glob("*/*")):
    print(path, path.stat().st_size)
