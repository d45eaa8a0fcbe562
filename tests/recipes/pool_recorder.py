"""A pool survey's soundings again in the files of a recorder, by the writers of recorder_survey.py. Needs numpy.

Takes a pool survey whose soundings are a CSV with ranges and whose trajectory is an SBET, and lets a sounder with two arrays at one place hear
every sounding anew: sent at its time from the true mounting (`truth.json`) to where it struck, heard where the boat is by then. The installation
record in the file has the nominal mounting.

    python3 tests/recipes/pool_recorder.py SURVEY-FOLDER folder [all|kmall|s7k|xtf] [sbet|own]
    boresight calibrate folder/survey.toml

`own` leaves the SBET out: the trajectory is then what the recorder's file holds. XTF has no sound speed: the survey file says it.
"""

import csv
import itertools
import json
import os
import shutil
import struct
import sys
import tomllib
from types import SimpleNamespace

import numpy as np

import recorder_survey as recorder
from recorder_survey import DEG, SPEED, S7k, Kmall, KongsbergAll, Xtf, attitude

recorder.DAY = 1709424000  # 2024-03-03, a Sunday: seconds of the week are those of the day


def fsd(angles, arm):
    """Kongsberg's order: forward, starboard, down; roll, pitch, heading."""
    return (arm[1], arm[0], -arm[2], *angles)


class PoolAll(KongsbergAll):
    def __init__(self, angles, arm):
        self.arrays = fsd(angles, arm)

    def begin(self, time_s, line):
        array = lambda name: "".join(f"{name}{key}={value:.4f}," for key, value in zip("XYZRPH", self.arrays))
        text = f"WLZ=0.00,SMH=217,STC=0,{array('S1')}{array('S2')}P1X=0.00,P1Y=0.00,P1Z=0.00,P1D=0.000,P1T=0,P1M=0,"
        text += "MSX=0.00,MSY=0.00,MSZ=0.00,MSR=0.00,MSP=0.00,MSG=0.00,MSD=0,APS=0,ARO=2,AHE=2,AHS=2,GCG=0.00,"
        (_, _), cast = KongsbergAll.begin(self, time_s, line)
        return [(time_s, self.datagram(0x49, time_s, line, self.pack("H", 0) + text.encode())), cast]


class PoolKmall(Kmall):
    def __init__(self, angles, arm):
        values = "".join(f"{key}={value:.4f};" for key, value in zip("XYZRPH", fsd(angles, arm)))
        self.trai = f"TRAI_TX1:N=217;{values}S=1.0;,\nTRAI_RX1:N=217;{values}G=0;,\n"


class PoolS7k(S7k):
    def __init__(self, angles, arm):
        self.arrays = ((np.array(angles) * DEG, np.array(arm)),) * 2


class PoolXtf(Xtf):
    def __init__(self, angles, arm):
        self.arrays = ((np.array(angles) * DEG, np.array(arm)),) * 2


WRITERS = {"all": PoolAll, "kmall": PoolKmall, "s7k": PoolS7k, "xtf": PoolXtf}


def trajectory(path):
    """Columns of an SBET; place in metres east, north, up of the first record."""
    with open(path, "rb") as file:
        rows = np.array(list(struct.iter_unpack("<17d", file.read())))
    recorder.ORIGIN = (rows[0, 1] / DEG, rows[0, 2] / DEG, rows[0, 3])
    a, e2 = 6378137.0, 0.00669437999014
    n = a / np.sqrt(1 - e2 * np.sin(rows[:, 1]) ** 2)
    earth = np.stack(
        [
            (n + rows[:, 3]) * np.cos(rows[:, 1]) * np.cos(rows[:, 2]),
            (n + rows[:, 3]) * np.cos(rows[:, 1]) * np.sin(rows[:, 2]),
            (n * (1 - e2) + rows[:, 3]) * np.sin(rows[:, 1]),
        ],
        -1,
    )
    (sl, cl), (so, co) = [(np.sin(x), np.cos(x)) for x in rows[0, 1:3]]
    level = np.array([[-so, co, 0], [-sl * co, -sl * so, cl], [cl * co, cl * so, sl]])
    return SimpleNamespace(
        t=rows[:, 0],
        place=(earth - earth[0]) @ level.T,
        roll=rows[:, 7],
        pitch=rows[:, 8],
        heading=np.unwrap(rows[:, 9] - rows[:, 10]),
        latitude=rows[:, 1] / DEG,
        longitude=rows[:, 2] / DEG,
        height=rows[:, 3],
        heave=rows[:, 3] - rows[:, 3].mean(),
        velocity=np.zeros((len(rows), 3)),
        boat=SimpleNamespace(line=(0, 0, 0.0, 1.0)),
    )


def pose(n, t):
    """Place and body axes at times."""
    between = lambda column: np.interp(t, n.t, column)
    place = np.stack([between(column) for column in n.place.T], -1)
    return place, attitude(between(n.roll), between(n.pitch), between(n.heading))


def heard(n, mounting, t, across, along, length):
    """Angle to starboard against the receive array, and two-way time, of soundings sent at `t`."""
    head, arm = mounting
    place, body = pose(n, t)
    direction = np.stack([np.sin(across) * np.cos(along), np.sin(along), -np.cos(across) * np.cos(along)], -1)
    sender = place + body @ arm
    struck = sender + np.einsum("kij,kj->ki", body @ head, direction * length[:, None])
    two_way, angle = 2 * length / SPEED, None
    for _ in range(4):
        place, body = pose(n, t + two_way)
        back = struck - place - body @ arm
        way = np.linalg.norm(back, axis=-1)
        angle = np.arcsin(((body @ head)[:, :, 0] * back).sum(-1) / way)
        two_way = (length + way) / SPEED
    return angle, two_way


def main(source, folder, form="all", navigation="sbet"):
    os.makedirs(folder, exist_ok=True)
    with open(f"{source}/survey.toml", "rb") as file:
        survey = tomllib.load(file)
    sonar = survey["multibeam"]
    degrees = [sonar["mounting_deg"][key] for key in ("roll", "pitch", "heading")]
    with open(f"{source}/truth.json", "rb") as file:
        truth = json.load(file)
    mounting = np.array(truth["rotation_matrix"]), np.array(truth["lever_arm_m"])
    n = trajectory(f"{source}/{survey['trajectory']['path']}")
    writer = WRITERS[form](degrees, sonar["lever_arm_m"])
    begin = n.t[0] - 1
    recorder.BEGIN_S, writer.rolled = begin, (n.t, n.roll)
    written = list(writer.navigation(n)) + list(writer.begin(begin, 1))
    with open(f"{source}/{sonar['path']}", newline="", encoding="utf-8") as file:
        rows = np.array([[float(value) for value in row] for row in list(csv.reader(file))[1:]])
    angle, two_way = heard(n, mounting, rows[:, 0], rows[:, 3] * DEG, rows[:, 4] * DEG, rows[:, 5])
    for number, of in itertools.groupby(range(len(rows)), key=lambda k: rows[k, 1]):
        of = list(of)
        recorder.BEAMS = len(of)
        t0 = round(rows[of[0], 0] * 1000) / 1000
        place, _ = pose(n, rows[of, 0])
        ping = SimpleNamespace(
            t0=t0, number=int(number), head=0, port=-angle[of], two_way=two_way[of], sector=np.zeros(len(of), int),
            delay=np.zeros(1), tilt=np.zeros(1), transmitted=(place, (np.zeros(1), np.zeros(1), np.zeros(1))),
        )  # fmt: skip
        written.append((t0, writer.ping(ping)))
    written.sort(key=lambda item: item[0])
    with open(f"{folder}/pool.{form}", "wb") as file:
        file.write(writer.header())
        file.writelines(item[1] for item in written)
    own = navigation == "own"
    for name in (survey["target"]["model"], survey["lidar"]["path"], survey["trajectory"]["path"]):
        if not (own and name == survey["trajectory"]["path"]):
            shutil.copyfile(f"{source}/{name}", f"{folder}/{name}")
    with open(f"{source}/survey.toml", encoding="utf-8") as file:
        lines = file.read().splitlines()
    said, section = [], ""
    for line in lines:
        section = line if line.startswith("[") else section
        key = line.split(" = ")[0]
        if section == "[multibeam]" and key in ("lever_arm_m", "mounting_deg"):
            continue
        if section == "[multibeam]" and key == "path":
            line = f'path = "pool.{form}"'
        if section == "[trajectory]" and key == "path":
            line = "" if own else line + '\ntime = "utc-week"'
        if section == "[lidar]" and key == "path" and own:
            line += '\ntime = "utc-week"'
        said.append(line)
    with open(f"{folder}/survey.toml", "w", encoding="utf-8") as file:
        file.write("\n".join(said) + "\n")
        if form == "xtf":
            file.write(f"\n[sound_speed]\nspeed_m_s = {SPEED}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
