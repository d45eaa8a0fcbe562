"""A seabed survey as Kongsberg .all files with an SBET, from a known mounting.

Written from the format's description alone, without a look at this program's readers and writers: frames, cones of two arrays, datagrams and
checksums are this script's own. Needs numpy. Its soundings are those of a ground of sixteen sines, sent and heard at two moments by two
arrays apart, in water of one speed.

    python3 tests/recipes/kongsberg_survey.py 1 folder
    boresight calibrate folder/survey.toml

The correction put in is pitch 0.9, roll -0.5, yaw 1.1 deg, about the body's axes, the same for both arrays.
"""

import datetime
import os
import struct
import sys

import numpy as np

DEG = np.pi / 180
SPEED = 1490.0
CORRECTION = np.array([0.9, -0.5, 1.1]) * DEG
TRANSMITTER = (np.array([0.2, -0.1, 0.3]) * DEG, np.array([0.35, -1.2, -1.1]))  # roll, pitch, heading; right, forward, up
RECEIVER = (np.array([-0.15, 0.1, 359.7]) * DEG, np.array([0.35, -1.0, -1.1]))
ORIGIN = (30.5, 122.3, 12.0)
LINES = [(0, 0, 0.0, 2.5), (0, 150, 180.0, 2.5), (18, 0, 0.0, 2.5), (0, 150, 180.0, 4.0)]  # east, north, course, speed
LENGTH = 150.0
DAY = 1708992000  # 2024-02-27, UTC
BEAMS = 48
RANGE_SIGMA, ANGLE_SIGMA = 0.008, 0.03 * DEG
ATTITUDE_SIGMA, HEADING_SIGMA, POSITION_SIGMA = 0.003 * DEG, 0.01 * DEG, 0.004

INSTALLATION = (
    "WLZ=0.00,SMH=217,STC=0,S1X=-1.20,S1Y=0.35,S1Z=1.10,S1H=0.30,S1R=0.20,S1P=-0.10,"
    "S2X=-1.00,S2Y=0.35,S2Z=1.10,S2H=359.70,S2R=-0.15,S2P=0.10,P1X=0.00,P1Y=0.00,P1Z=0.00,P1D=0.000,P1T=0,P1M=0,"
    "MSX=0.00,MSY=0.00,MSZ=0.00,MSR=0.00,MSP=0.00,MSG=0.00,MSD=0,APS=0,ARO=2,AHE=2,AHS=2,GCG=0.00,"
)

SURVEY = """name = "kongsberg"
procedure = "seabed"

[multibeam]
paths = ["line1.all", "line2.all", "line3.all", "line4.all"]
range_sigma_m = 0.008
angle_sigma_deg = 0.03

[trajectory]
path = "nav.sbet"
time = "gps-week"
roll_pitch_sigma_deg = 0.003
"""


def turn(axis, angle):
    """Rotations about one axis (0 x, 1 y, 2 z), one for each angle."""
    c, s = np.cos(angle), np.sin(angle)
    result = np.zeros(np.shape(angle) + (3, 3))
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    result[..., axis, axis] = 1
    result[..., i, i] = result[..., j, j] = c
    result[..., i, j], result[..., j, i] = -s, s
    return result


def attitude(roll, pitch, heading):
    return turn(2, -np.asarray(heading)) @ turn(0, np.asarray(pitch)) @ turn(1, np.asarray(roll))


def exponential(v):
    angle = np.linalg.norm(v)
    x, y, z = v / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def geodetic(east, north, up):
    """Latitude and longitude (deg) and height of local coordinates about the origin, WGS84."""
    a, f = 6378137.0, 1 / 298.257223563
    e2 = f * (2 - f)
    sl, cl = np.sin(ORIGIN[0] * DEG), np.cos(ORIGIN[0] * DEG)
    so, co = np.sin(ORIGIN[1] * DEG), np.cos(ORIGIN[1] * DEG)
    n = a / np.sqrt(1 - e2 * sl**2)
    x = (n + ORIGIN[2]) * cl * co - so * east - sl * co * north + cl * co * up
    y = (n + ORIGIN[2]) * cl * so + co * east - sl * so * north + cl * so * up
    z = (n * (1 - e2) + ORIGIN[2]) * sl + cl * north + sl * up
    p, latitude, height = np.hypot(x, y), np.arctan2(z, np.hypot(x, y) * (1 - e2)), 0
    for _ in range(8):
        n = a / np.sqrt(1 - e2 * np.sin(latitude) ** 2)
        height = p / np.cos(latitude) - n
        latitude = np.arctan2(z, p * (1 - e2 * n / (n + height)))
    return latitude / DEG, np.arctan2(y, x) / DEG, height


def datagram(kind, time_s, counter, body):
    """A datagram of an EM 2040 with serial number 217, its length and checksum."""
    day = datetime.datetime.fromtimestamp(DAY, datetime.timezone.utc)
    date = day.year * 10000 + day.month * 100 + day.day
    core = struct.pack("<BBHIIHH", 2, kind, 2040, date, round(time_s * 1000), counter & 0xFFFF, 217) + body
    core += b"\0" * (len(core) % 2 == 0) + b"\x03"
    core += struct.pack("<H", sum(core[1:-1]) & 0xFFFF)
    return struct.pack("<I", len(core)) + core


class Boat:
    """A boat in waves on one line."""

    def __init__(self, line, begin_s, waves):
        self.line, self.begin_s, self.waves = line, begin_s, waves

    def pose(self, t):
        """Position, roll, pitch, heading."""
        east, north, course, speed = self.line
        wave = lambda k, size: size * np.sin(2 * np.pi * t / self.waves[k][1] + self.waves[k][0])
        heading = course * DEG + wave(6, 0.8) * DEG
        along = (t - self.begin_s) * speed
        place = [east + along * np.sin(course * DEG), north + along * np.cos(course * DEG), wave(4, 0.15) + wave(5, 0.05)]
        roll, pitch = (wave(0, 2.0) + wave(1, 0.8)) * DEG, (wave(2, 1.0) + wave(3, 0.4)) * DEG
        return np.stack(place, -1), roll, pitch, heading


def navigation(boat, seconds, random):
    """Datagrams of attitude, position and height, and the records of an SBET."""
    t = np.arange(boat.begin_s - 2, boat.begin_s + seconds + 2, 0.01)
    place, roll, pitch, heading = boat.pose(t)
    roll = roll + random.normal(0, ATTITUDE_SIGMA, len(t))
    pitch = pitch + random.normal(0, ATTITUDE_SIGMA, len(t))
    heading = heading + random.normal(0, HEADING_SIGMA, len(t))
    measured = place + random.normal(0, POSITION_SIGMA, place.shape)
    hundredths = lambda angle: round((angle / DEG % 360) * 100) % 36000
    written = []
    for k in range(0, len(t), 100):
        rows = range(k, min(k + 100, len(t)))
        body = struct.pack("<H", len(rows))
        for q in rows:
            after = round(t[q] * 1000) - round(t[k] * 1000)
            angles = round(roll[q] / DEG * 100), round(pitch[q] / DEG * 100)
            body += struct.pack("<HHhhhH", after, 0, *angles, round(-place[q, 2] * 100), hundredths(heading[q]))
        written.append((t[k], datagram(0x41, t[k], k // 100, body + b"\0")))
    latitude, longitude, height = geodetic(measured[:, 0], measured[:, 1], measured[:, 2])
    for q in range(0, len(t), 5):
        where = round(latitude[q] * 2e7), round(longitude[q] * 1e7)
        motion = 4, int(boat.line[3] * 100), int(boat.line[2] * 100), hundredths(heading[q])
        written.append((t[q], datagram(0x50, t[q], q, struct.pack("<iiHHHHBB", *where, *motion, 0x81, 0))))
        written.append((t[q], datagram(0x68, t[q], q, struct.pack("<iB", round(height[q] * 100), 0))))
    return written, (t, latitude, longitude, height, roll, pitch, heading)


def ping(boat, t0, number, terrain, random):
    """One ping: three sectors, its beams as rounded in the file."""
    port = np.round(np.linspace(62, -62, BEAMS) * 100) / 100 * DEG
    sector = np.where(np.abs(port) > 25 * DEG, np.where(port > 0, 0, 2), 1)
    delay, tilt = np.array([0.0, 0.002, 0.004]), np.array([0.5, 0.0, -0.5]) * DEG
    sent, along, across = t0 + delay[sector], tilt[sector], -port + random.normal(0, ANGLE_SIGMA, BEAMS)
    true = exponential(CORRECTION)
    place, *angles = boat.pose(sent)
    body = attitude(*angles)
    f, transmitter = body @ true @ attitude(*TRANSMITTER[0]) @ [0, 1, 0], place + body @ TRANSMITTER[1]
    two_way = np.full(BEAMS, 0.015)
    for _ in range(3):
        place, *angles = boat.pose(sent + two_way)
        body = attitude(*angles)
        s, receiver = body @ true @ attitude(*RECEIVER[0]) @ [1, 0, 0], place + body @ RECEIVER[1]
        middle = 0.5 * (transmitter + receiver)
        down = np.cross(s, f)
        down /= -np.linalg.norm(down, axis=-1)[:, None]
        # the bed is on the transmit cone about the one array and on the receive cone about the other
        reach, q = np.full(BEAMS, 12.0), (f * s).sum(-1)
        bed = middle + reach[:, None] * down / np.cos(across)[:, None]
        for _ in range(120):
            a = np.sin(along) * np.linalg.norm(bed - transmitter, axis=-1) + ((transmitter - middle) * f).sum(-1)
            b = np.sin(across) * np.linalg.norm(bed - receiver, axis=-1) + ((receiver - middle) * s).sum(-1)
            u, v = (a - q * b) / (1 - q * q), (b - q * a) / (1 - q * q)
            bed = middle + u[:, None] * f + v[:, None] * s + reach[:, None] * down
            error = bed[:, 2] - terrain(bed[:, 0], bed[:, 1])
            reach = reach + 0.5 * error / -down[:, 2]
        assert np.abs(error).max() < 1e-4, "a beam does not find the bed"
        two_way = (np.linalg.norm(bed - transmitter, axis=-1) + np.linalg.norm(bed - receiver, axis=-1)) / SPEED
    measured = two_way + random.normal(0, RANGE_SIGMA, BEAMS) * 2 / SPEED
    gross = random.random(BEAMS) < 0.01
    measured = np.where(gross, measured * random.uniform(0.7, 1.1, BEAMS), measured)
    body = struct.pack("<HHHHfI", round(SPEED * 10), 3, BEAMS, BEAMS, 15000.0, 0)
    for j in range(3):
        body += struct.pack("<hHfffHBBf", round(tilt[j] / DEG * 100), 0, 0.0002, delay[j], 300e3, 0, 0, j, 5000.0)
    for j in range(BEAMS):
        body += struct.pack("<hBBHBbfhbB", round(port[j] / DEG * 100), sector[j], 0, 10, 20, 0, measured[j], -200, 0, 0)
    return datagram(0x4E, t0, number, body + b"\0")


def main(seed, folder):
    os.makedirs(folder, exist_ok=True)
    random = np.random.default_rng(seed)
    lengths = np.exp(random.uniform(np.log(1.5), np.log(60), 16))
    turns, phases = random.uniform(0, 2 * np.pi, (2, 16))

    def terrain(x, y):
        place = np.cos(turns) * x[..., None] + np.sin(turns) * y[..., None]
        waves = 0.012 * lengths**0.75 * np.sin(2 * np.pi * place / lengths + phases)
        return -10 + 0.03 * x - 0.02 * y + waves.sum(-1)

    waves = [(random.uniform(0, 6.28), random.uniform(4.0, 7.0)) for _ in range(8)]
    begin_s, records = 36000.0, []
    for number, line in enumerate(LINES):
        boat, seconds = Boat(line, begin_s, waves), LENGTH / line[3]
        installation = struct.pack("<H", 0) + INSTALLATION.encode()
        depths = [0, 5, 10, 20, 40, 100, 500, 12000]
        cast = struct.pack("<IIHH", 20240227, int(begin_s - 30), len(depths), 1)
        cast += b"".join(struct.pack("<II", depth * 100, round(SPEED * 10)) for depth in depths)
        written, record = navigation(boat, seconds, random)
        written.append((begin_s - 3, datagram(0x49, begin_s - 3, number + 1, installation)))
        written.append((begin_s - 3, datagram(0x55, begin_s - 3, 1, cast)))
        for k, t0 in enumerate(np.arange(begin_s, begin_s + seconds, 0.4)):
            t0 = round(t0 * 1000) / 1000
            written.append((t0, ping(boat, t0, k, terrain, random)))
        written.sort(key=lambda item: item[0])
        with open(f"{folder}/line{number + 1}.all", "wb") as file:
            file.writelines(item[1] for item in written)
        records.append(record)
        begin_s += seconds + 60
    day = datetime.datetime.fromtimestamp(DAY, datetime.timezone.utc).isoweekday() % 7
    with open(f"{folder}/nav.sbet", "wb") as file:
        for t, latitude, longitude, height, roll, pitch, heading in records:
            for q in range(len(t)):
                place = t[q] + day * 86400 + 18, latitude[q] * DEG, longitude[q] * DEG, height[q]
                course = (heading[q] + np.pi) % (2 * np.pi) - np.pi
                file.write(struct.pack("<17d", *place, 0, 0, 0, roll[q], pitch[q], course, *[0] * 7))
    with open(f"{folder}/survey.toml", "w", encoding="utf-8") as file:
        file.write(SURVEY)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
