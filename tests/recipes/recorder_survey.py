"""A seabed survey in the files of a recorder, with its navigation from the recorder or beside it, from a known mounting.

Written from the formats' descriptions alone, without a look at this program's readers and writers: frames, cones of two arrays, records and
checksums are this script's own. Needs numpy. Its soundings are those of a ground of sixteen sines, sent and heard at two moments by two
arrays apart, in water of one speed. The soundings of one seed are the same in every format but for what a format rounds.

    python3 tests/recipes/recorder_survey.py 1 folder [all|all-big|all-dual|kmall|kmall-0|kmall-dual|s7k|xtf] [sbet|smrmsg|novatel|novatel-ascii|pos-mv|pos-mv-102|own]
    boresight calibrate folder/survey.toml

The correction put in is pitch 0.9, roll -0.5, yaw 1.1 deg, about the body's axes, the same for both arrays. `s7k` and `xtf` know one sector
and have one; `xtf` has one mounting for both arrays, 0.119 m apart. The dual ones have two heads, turned by 30 deg to port and to starboard, each
with a correction of its own, the second's pitch -0.6, roll 0.8, yaw -0.7 deg; both ping together. `own` takes what the recorder itself holds of attitude and position.
"""

import datetime
import os
import struct
import sys
import zlib

import numpy as np

DEG = np.pi / 180
SPEED = 1490.0
CORRECTION = np.array([0.9, -0.5, 1.1]) * DEG
TRANSMITTER = (np.array([0.2, -0.1, 0.3]) * DEG, np.array([0.35, -1.2, -1.1]))  # roll, pitch, heading; right, forward, up
RECEIVER = (np.array([-0.15, 0.1, 359.7]) * DEG, np.array([0.35, -1.0, -1.1]))
# two heads: roll, pitch, heading; right, forward, up; the second one's correction
PORT = (np.array([30.0, 0.4, -0.6]) * DEG, np.array([-0.30, -1.1, -1.15]))
STARBOARD = (np.array([-30.0, -0.3, 0.5]) * DEG, np.array([0.40, -1.0, -1.05]))
SECOND = np.array([-0.6, 0.8, -0.7]) * DEG
ORIGIN = (30.5, 122.3, 12.0)
LINES = [(0, 0, 0.0, 2.5), (0, 150, 180.0, 2.5), (18, 0, 0.0, 2.5), (0, 150, 180.0, 4.0)]  # east, north, course, speed
LENGTH = 150.0
DAY = 1708992000  # 2024-02-27, UTC
BEGIN_S = 36000.0  # of the first line, seconds of the day
BEAMS = 48
RANGE_SIGMA, ANGLE_SIGMA = 0.008, 0.03 * DEG
ATTITUDE_SIGMA, HEADING_SIGMA, POSITION_SIGMA = 0.003 * DEG, 0.01 * DEG, 0.004

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


class Navigation:
    """What an INS states of one line, 100 times a second: place, angles, geodetic coordinates."""

    def __init__(self, boat, seconds, random):
        self.boat = boat
        self.t = np.arange(boat.begin_s - 2, boat.begin_s + seconds + 2, 0.01)
        place, roll, pitch, heading = boat.pose(self.t)
        self.roll = roll + random.normal(0, ATTITUDE_SIGMA, len(self.t))
        self.pitch = pitch + random.normal(0, ATTITUDE_SIGMA, len(self.t))
        self.heading = heading + random.normal(0, HEADING_SIGMA, len(self.t))
        self.place = place + random.normal(0, POSITION_SIGMA, place.shape)
        self.heave = place[:, 2]
        self.latitude, self.longitude, self.height = geodetic(*self.place.T)
        self.velocity = np.gradient(place, 0.01, axis=0)


class Ping:
    """One ping: its beams as rounded in the file. Angles positive to port and forward, in radians."""

    def __init__(self, boat, t0, number, terrain, sectors, head, random):
        arrays, correction, half = head
        self.t0, self.number = t0, number
        port = np.round(np.linspace(half, -half, BEAMS) * 100) / 100 * DEG
        self.port = port
        if sectors == 3:
            self.sector = np.where(np.abs(port) > 25 * DEG, np.where(port > 0, 0, 2), 1)
            self.delay, self.tilt = np.array([0.0, 0.002, 0.004]), np.array([0.5, 0.0, -0.5]) * DEG
        else:
            self.sector, self.delay, self.tilt = np.zeros(BEAMS, int), np.zeros(1), np.zeros(1)
        sent, along = t0 + self.delay[self.sector], self.tilt[self.sector]
        across = -port + random.normal(0, ANGLE_SIGMA, BEAMS)
        true = exponential(correction)
        place, *angles = boat.pose(sent)
        self.transmitted = place, angles
        body = attitude(*angles)
        f, transmitter = body @ true @ attitude(*arrays[0][0]) @ [0, 1, 0], place + body @ arrays[0][1]
        two_way = np.full(BEAMS, 0.015)
        for _ in range(3):
            place, *angles = boat.pose(sent + two_way)
            body = attitude(*angles)
            s, receiver = body @ true @ attitude(*arrays[1][0]) @ [1, 0, 0], place + body @ arrays[1][1]
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
        self.two_way = np.where(gross, measured * random.uniform(0.7, 1.1, BEAMS), measured)


CAST = [0, 5, 10, 20, 40, 100, 500, 12000]
hundredths = lambda angle: round((angle / DEG % 360) * 100) % 36000


def calendar(t):
    """The date and time of seconds of the survey's day."""
    return datetime.datetime.fromtimestamp(DAY + t, datetime.timezone.utc)


class OneHead:
    def heads(self):
        """Of each head: the mountings of both arrays, the correction, half the swath (deg)."""
        return [(self.arrays, CORRECTION, 62)]


class KongsbergAll(OneHead):
    """EM 2040, serial number 217."""

    ending, sectors, arrays = "all", 3, (TRANSMITTER, RECEIVER)
    order, serial = "<", 217

    def pack(self, layout, *values):
        return struct.pack(self.order + layout, *values)

    def datagram(self, kind, time_s, counter, body):
        day = calendar(0)
        date = day.year * 10000 + day.month * 100 + day.day
        core = self.pack("BBHIIHH", 2, kind, 2040, date, round(time_s * 1000), counter & 0xFFFF, self.serial) + body
        core += b"\0" * (len(core) % 2 == 0) + b"\x03"
        core += self.pack("H", sum(core[1:-1]) & 0xFFFF)
        return self.pack("I", len(core)) + core

    def begin(self, time_s, line):
        text = (
            "WLZ=0.00,SMH=217,STC=0,S1X=-1.20,S1Y=0.35,S1Z=1.10,S1H=0.30,S1R=0.20,S1P=-0.10,"
            "S2X=-1.00,S2Y=0.35,S2Z=1.10,S2H=359.70,S2R=-0.15,S2P=0.10,P1X=0.00,P1Y=0.00,P1Z=0.00,P1D=0.000,P1T=0,P1M=0,"
            "MSX=0.00,MSY=0.00,MSZ=0.00,MSR=0.00,MSP=0.00,MSG=0.00,MSD=0,APS=0,ARO=2,AHE=2,AHS=2,GCG=0.00,"
        )
        cast = self.pack("IIHH", 20240227, int(time_s), len(CAST), 1)
        cast += b"".join(self.pack("II", depth * 100, round(SPEED * 10)) for depth in CAST)
        yield time_s, self.datagram(0x49, time_s, line, self.pack("H", 0) + text.encode())
        yield time_s, self.datagram(0x55, time_s, 1, cast)

    def navigation(self, n):
        for k in range(0, len(n.t), 100):
            rows = range(k, min(k + 100, len(n.t)))
            body = self.pack("H", len(rows))
            for q in rows:
                after = round(n.t[q] * 1000) - round(n.t[k] * 1000)
                angles = round(n.roll[q] / DEG * 100), round(n.pitch[q] / DEG * 100)
                body += self.pack("HHhhhH", after, 0, *angles, round(-n.heave[q] * 100), hundredths(n.heading[q]))
            yield n.t[k], self.datagram(0x41, n.t[k], k // 100, body + b"\0")
        for q in range(0, len(n.t), 5):
            where = round(n.latitude[q] * 2e7), round(n.longitude[q] * 1e7)
            motion = 4, int(n.boat.line[3] * 100), int(n.boat.line[2] * 100), hundredths(n.heading[q])
            yield n.t[q], self.datagram(0x50, n.t[q], q, self.pack("iiHHHHBB", *where, *motion, 0x81, 0))
            yield n.t[q], self.datagram(0x68, n.t[q], q, self.pack("iB", round(n.height[q] * 100), 0))

    def ping(self, p):
        body = self.pack("HHHHfI", round(SPEED * 10), len(p.delay), BEAMS, BEAMS, 15000.0, 0)
        for j, delay in enumerate(p.delay):
            body += self.pack("hHfffHBBf", round(p.tilt[j] / DEG * 100), 0, 0.0002, delay, 300e3, 0, 0, j, 5000.0)
        for j in range(BEAMS):
            body += self.pack("hBBHBbfhbB", round(p.port[j] / DEG * 100), p.sector[j], 0, 10, 20, 0, p.two_way[j], -200, 0, 0)
        return self.datagram(0x4E, p.t0, p.number, body + b"\0")

    def header(self):
        return b""


class BigEndianAll(KongsbergAll):
    order = ">"


DUAL = [((PORT, PORT), CORRECTION, 32), ((STARBOARD, STARBOARD), SECOND, 32)]


class DualAll(KongsbergAll):
    """Two heads that send and receive, serial numbers 217 and 218, one installation record (STC=2)."""

    def heads(self):
        return DUAL

    def begin(self, time_s, line):
        written = list(KongsbergAll.begin(self, time_s, line))
        text = "WLZ=0.00,SMH=217,STC=2,"
        for prefix, (angles, arm) in (("S1", PORT), ("S2", STARBOARD)):
            roll, pitch, heading = angles / DEG
            text += f"{prefix}X={arm[1]:.2f},{prefix}Y={arm[0]:.2f},{prefix}Z={-arm[2]:.2f},"
            text += f"{prefix}H={heading % 360:.2f},{prefix}R={roll:.2f},{prefix}P={pitch:.2f},"
        text += "P1X=0.00,P1Y=0.00,P1Z=0.00,P1D=0.000,P1T=0,P1M=0,MSX=0.00,MSY=0.00,MSZ=0.00,MSR=0.00,MSP=0.00,MSG=0.00,MSD=0,APS=0,ARO=2,AHE=2,AHS=2,GCG=0.00,"
        return [(time_s, self.datagram(0x49, time_s, line, self.pack("H", 218) + text.encode()))] + written[1:]

    def ping(self, p):
        self.serial = 217 + p.head
        datagram = KongsbergAll.ping(self, p)
        self.serial = 217
        return datagram


class Kmall(OneHead):
    """EM 2040; the parts of an MRZ as long as in its version 2."""

    ending, sectors, arrays = "kmall", 3, (TRANSMITTER, RECEIVER)
    version, info_bytes, sector_bytes = 2, 152, 48
    trai = (
        "TRAI_TX1:N=217;X=-1.200;Y=0.350;Z=1.100;R=0.200;P=-0.100;H=0.300;S=1.0;"
        "IPX=0;IPY=0;IPZ=0;ICX=0;ICY=0;ICZ=0;ISX=0;ISY=0;ISZ=0;,\n"
        "TRAI_RX1:N=217;X=-1.000;Y=0.350;Z=1.100;R=-0.150;P=0.100;H=359.700;G=0;IX=0;IY=0;IZ=0;,\n"
    )

    def datagram(self, kind, version, time_s, body):
        whole = int(np.floor(time_s))
        size = 24 + len(body)
        stamp = DAY + whole, round((time_s - whole) * 1e9)
        return struct.pack("<I4sBBHII", size, kind, version, 1, 2040, *stamp) + body + struct.pack("<I", size)

    def begin(self, time_s, _line):
        text = (
            "OSCV:Empty,EMXV:EM2040,PU_0,SN=217,IP=1,TYPE=CPU,VERS:(none),SERIALno:TX=1,SERIALno:RX=2,\n"
            + self.trai
            + "POSI_1:X=0.000;Y=0.000;Z=0.000;D=0.000;G=WGS84;T=DATAGRAM;C=ON;F=SIMRAD90,GGA;Q=ON;I=ETH;U=ACTIVE;,\n"
            "ATTI_1:X=0.000;Y=0.000;Z=0.000;R=0.000;P=0.000;H=0.000;D=0.000;M=RP;F=KMB;I=ETH;U=ACTIVE;,\n"
            "EMXI:SSNL=0;SWLZ=0.000;,"
        ).encode()
        text = struct.pack("<HHH", 6 + len(text), 1, 1) + text
        yield time_s, self.datagram(b"#IIP", 0, time_s, text + b"\0" * (-len(text) % 4))
        cast = struct.pack("<HH4sIdd", 28, len(CAST), b"S00 ", DAY + int(time_s), ORIGIN[0], ORIGIN[1])
        cast += b"".join(struct.pack("<ffIff", depth, SPEED, 0, 0, 0) for depth in CAST)
        yield time_s, self.datagram(b"#SVP", 1, time_s, cast)

    def navigation(self, n):
        for k in range(0, len(n.t), 100):
            rows = range(k, min(k + 100, len(n.t)))
            body = struct.pack("<HBBHHHH", 12, 1, 1, 1, len(rows), 132, 0x1F)
            for q in rows:
                whole = int(np.floor(n.t[q]))
                body += struct.pack("<4sHHIII", b"#KMB", 120, 1, DAY + whole, round((n.t[q] - whole) * 1e9), 0)
                body += struct.pack("<ddf", n.latitude[q], n.longitude[q], n.height[q])
                body += struct.pack("<4f", n.roll[q] / DEG, n.pitch[q] / DEG, n.heading[q] / DEG % 360, -n.heave[q])
                v = n.velocity[q]
                body += struct.pack("<3f3f7f3f", 0, 0, 0, v[1], v[0], -v[2], *[0.01] * 7, 0, 0, 0)
                body += struct.pack("<IIf", DAY + whole, 0, 0)
            yield n.t[k], self.datagram(b"#SKM", 1, n.t[k], body)
        for q in range(0, len(n.t), 5):
            whole = int(np.floor(n.t[q]))
            body = struct.pack("<HHHH", 8, 1, 0, 0)
            body += struct.pack("<IIf", DAY + whole, round((n.t[q] - whole) * 1e9), 0.05)
            body += struct.pack("<ddfff", n.latitude[q], n.longitude[q], n.boat.line[3], n.boat.line[2], n.height[q])
            yield n.t[q], self.datagram(b"#SPO", 0, n.t[q], body + b"$GPGGA,0,0\0\0")

    def ping(self, p):
        place, (roll, pitch, heading) = p.transmitted
        latitude, longitude, height = geodetic(*place[0])
        body = struct.pack("<HH", 1, 1)
        count, head = len(self.heads()), p.head
        body += struct.pack("<HHBBBBBBBB", 12, p.number & 0xFFFF, count, head, 1, 0, head, head, count, 0)
        info = bytearray(self.info_bytes)
        struct.pack_into("<Hxxf", info, 0, self.info_bytes, 2.5)
        struct.pack_into("<HH", info, 92, len(p.delay), self.sector_bytes)
        struct.pack_into("<fffffff", info, 96, heading[0] / DEG % 360, SPEED, 1.1, 0, 0, 0, 0)
        struct.pack_into("<ddf", info, 124, latitude, longitude, height)
        body += bytes(info)
        for j, delay in enumerate(p.delay):
            sector = bytearray(self.sector_bytes)
            struct.pack_into("<BBBBffffff", sector, 0, j, 0, j, 0, delay, p.tilt[j] / DEG, 200, 1, 1, 300e3)
            body += bytes(sector)
        receiver = bytearray(32)
        struct.pack_into("<HHHH", receiver, 0, 32, BEAMS, BEAMS, 120)
        body += bytes(receiver)
        for j in range(BEAMS):
            sounding = bytearray(120)
            struct.pack_into("<HBBB", sounding, 0, j, p.sector[j], 0, 1)
            struct.pack_into("<ffff", sounding, 72, p.port[j] / DEG, 0, p.two_way[j], 0)
            body += bytes(sounding)
        return self.datagram(b"#MRZ", self.version, p.t0, body)

    def header(self):
        return b""


class OldKmall(Kmall):
    version, info_bytes, sector_bytes = 0, 144, 36


class DualKmall(Kmall):
    """Two heads that send and receive."""

    def heads(self):
        return DUAL

    @property
    def trai(self):
        text = ""
        for number, (angles, arm) in ((1, PORT), (2, STARBOARD)):
            roll, pitch, heading = angles / DEG
            text += f"TRAI_HD{number}:N={216 + number};X={arm[1]:.3f};Y={arm[0]:.3f};Z={-arm[2]:.3f};"
            text += f"R={roll:.3f};P={pitch:.3f};H={heading % 360:.3f};G=0;ITX=0;ITY=0;ITZ=0;IRX=0;IRY=0;IRZ=0;,\n"
        return text


class S7k(OneHead):
    """SeaBat with two arrays on one mounting record."""

    ending, sectors, arrays = "s7k", 1, (TRANSMITTER, RECEIVER)

    def record(self, kind, time_s, body, version=1):
        now = calendar(int(np.floor(time_s)))
        time = struct.pack("<HHfBB", now.year, now.timetuple().tm_yday, now.second + time_s % 1, now.hour, now.minute)
        head = struct.pack("<HHIIII", 5, 60, 0xFFFF, 64 + len(body) + 4, 0, 0) + time
        head += struct.pack("<HIIHHIHHIII", version, kind, 7125 if kind not in (1003, 1012, 1013, 1016) else 0, 0, 0, 0, 1, 0, 0, 0, 0)
        data = head + body
        assert len(head) == 64
        return data + struct.pack("<I", sum(data) & 0xFFFFFFFF)

    def header(self):
        text = lambda value, length: value.encode().ljust(length, b"\0")
        body = bytes(16) + struct.pack("<HH", 1, 0) + bytes(16) + struct.pack("<II", 0, 1)
        body += text("recipe", 64) + text("1", 16) + text("", 64) + text("", 128) + struct.pack("<IH", 7125, 0)
        return self.record(7200, BEGIN_S - 4, body)

    def begin(self, time_s, _line):
        body = struct.pack("<f", 400e3) + b"".join(struct.pack("<H128s", 3, b"1.0") for _ in range(4))
        for angles, arm in self.arrays:
            signed = (np.asarray(angles) + np.pi) % (2 * np.pi) - np.pi
            body += struct.pack("<6f", *arm, *signed)
        body += struct.pack("<6fH3fHf", *[0] * 6, 0, 0, 0, 0, 0, 0)
        yield time_s, self.record(7030, time_s, body)
        cast = struct.pack("<BBHddI", 1, 0, 0, ORIGIN[0] * DEG, ORIGIN[1] * DEG, len(CAST))
        cast += b"".join(struct.pack("<ff", depth, SPEED) for depth in CAST)
        yield time_s, self.record(1009, time_s, cast)

    def navigation(self, n):
        for k in range(0, len(n.t), 50):
            rows = range(k, min(k + 50, len(n.t)))
            body = struct.pack("<B", len(rows))
            for q in rows:
                after = round((n.t[q] - n.t[k]) * 1000)
                body += struct.pack("<Hffff", after, n.roll[q], n.pitch[q], n.heave[q], n.heading[q] % (2 * np.pi))
            yield n.t[k], self.record(1016, n.t[k], body)
        for q in range(0, len(n.t), 5):
            where = n.latitude[q] * DEG, n.longitude[q] * DEG, n.height[q]
            yield n.t[q], self.record(1003, n.t[q], struct.pack("<IfdddBBBBB", 0, 0, *where, 0, 0, 4, 0, 9))

    def ping(self, p):
        settings = bytearray(156)
        struct.pack_into("<QIHfff", settings, 0, 1, p.number, 0, 400e3, 34482.76, 0)
        struct.pack_into("<f", settings, 146, SPEED)
        rate = 34482.7578125  # a number that 32 bits hold
        body = struct.pack("<QIHIIBIfff", 1, p.number, 0, BEAMS, 26, 1, 0, rate, p.tilt[0], 0) + bytes(60)
        assert len(body) == 99
        for j in range(BEAMS):
            body += struct.pack("<HffIIff", j, p.two_way[j] * rate, -p.port[j], 0, 3, 0, 0)
        return self.record(7000, p.t0, bytes(settings)) + self.record(7027, p.t0, body)


class Xtf(OneHead):
    """An R2Sonic 2026 in a QINSy XTF, both arrays of one mounting."""

    ending, sectors = "xtf", 1
    arrays = (TRANSMITTER, (TRANSMITTER[0], TRANSMITTER[1] - attitude(*TRANSMITTER[0]) @ [0, 0.119, 0]))

    def header(self):
        head = bytearray(1024)
        struct.pack_into("<BB8s8s16s", head, 0, 123, 1, b"recipe", b"1", b"R2Sonic")
        struct.pack_into("<HH", head, 164, 3, 0)
        struct.pack_into("<H", head, 168, 1)
        angles, arm = self.arrays[0]
        struct.pack_into("<B", head, 256, 3)
        struct.pack_into("<6f", head, 256 + 48, arm[0], arm[1], -arm[2], angles[2] / DEG, angles[1] / DEG, angles[0] / DEG)
        return bytes(head)

    def packet(self, kind, body, channels=0):
        size = 14 + len(body)
        padded = size + -size % 64
        return struct.pack("<HBBHHHI", 0xFACE, kind, 0, channels, 0, 0, padded) + body + bytes(padded - size)

    def begin(self, time_s, _line):
        return ()

    def navigation(self, n):
        for q in range(len(n.t)):
            ticks = round(n.t[q] * 1000)
            now = calendar(ticks // 1000)
            body = struct.pack("<IIIIffff", 0, 0, 0, 0, n.pitch[q] / DEG, n.roll[q] / DEG, n.heave[q], 0)
            body += struct.pack("<If", ticks, n.heading[q] / DEG % 360)
            body += struct.pack("<HBBBBBHB", now.year, now.month, now.day, now.hour, now.minute, now.second, ticks % 1000, 0)
            yield n.t[q], self.packet(3, body)
            if q % 5 == 0:
                body = struct.pack("<HBBBBBH", now.year, now.month, now.day, now.hour, now.minute, now.second, ticks % 1000 * 10)
                body += struct.pack("<dddffffB", n.latitude[q], n.longitude[q], n.height[q], 0, 0, 0, 0, 0)
                yield n.t[q], self.packet(107, body)

    def ping(self, p):
        section = lambda name, data: name + struct.pack(">H", 4 + len(data)) + data
        whole = int(np.floor(p.t0))
        head = bytearray(112)
        struct.pack_into(">12s12sIIIff", head, 0, b"2026", b"100001", DAY + whole, round((p.t0 - whole) * 1e9), p.number, 0.4, SPEED)
        struct.pack_into(">f", head, 44, 400e3)
        struct.pack_into(">H", head, 110, BEAMS)
        step = 0.01 * DEG
        scale = 6e-7  # 65 535 of them are 39 ms: the outermost beams take up to 29
        starboard = -p.port
        # the angles of the file rise, from port to starboard; their sums are rounded, not the steps
        steps = np.diff(np.round((starboard - starboard[0]) / step), prepend=0).astype(int)
        roll = np.interp(p.t0, *self.rolled)
        times = np.clip(np.round(p.two_way / scale), 0, 65535).astype(int)
        data = section(b"H0", bytes(head))
        data += section(b"R0", struct.pack(">f", scale) + struct.pack(f">{BEAMS}H", *times))
        data += section(b"A2", struct.pack(">8f", starboard[0], step, roll, 0.119, 0, 0, 0, 0) + struct.pack(f">{BEAMS}H", *steps))
        data += section(b"Q0", bytes([0x77]) * (4 * ((BEAMS + 7) // 8)))
        bathymetry = b"BTH0" + struct.pack(">II", 12 + len(data), 1) + data
        now = calendar(whole)
        ahead = struct.pack("<HBBBBBBH", now.year, now.month, now.day, now.hour, now.minute, now.second, int(p.t0 % 1 * 100), now.timetuple().tm_yday)
        return self.packet(65, ahead.ljust(242, b"\0") + bathymetry, 1)


FORMATS = {
    "all": KongsbergAll,
    "all-big": BigEndianAll,
    "all-dual": DualAll,
    "kmall": Kmall,
    "kmall-0": OldKmall,
    "kmall-dual": DualKmall,
    "s7k": S7k,
    "xtf": Xtf,
}
WEEKDAY = calendar(0).isoweekday() % 7
LEAP = 18


def sbet(lines, folder):
    with open(f"{folder}/nav.sbet", "wb") as file:
        for n in lines:
            for q in range(len(n.t)):
                place = n.t[q] + WEEKDAY * 86400 + LEAP, n.latitude[q] * DEG, n.longitude[q] * DEG, n.height[q]
                course = (n.heading[q] + np.pi) % (2 * np.pi) - np.pi
                file.write(struct.pack("<17d", *place, 0, 0, 0, n.roll[q], n.pitch[q], course, *[0] * 7))
    return 'path = "nav.sbet"\ntime = "gps-week"\nroll_pitch_sigma_deg = 0.003\n'


def smrmsg(lines, folder):
    """The same with a file of accuracies, once a second: metres, metres a second, minutes of arc."""
    with open(f"{folder}/smrmsg.out", "wb") as file:
        for n in lines:
            for t in n.t[::100]:
                angles = ATTITUDE_SIGMA / DEG * 60, ATTITUDE_SIGMA / DEG * 60, HEADING_SIGMA / DEG * 60
                place = t + WEEKDAY * 86400 + LEAP, *[POSITION_SIGMA] * 3
                file.write(struct.pack("<10d", *place, 0.01, 0.01, 0.01, *angles))
    return sbet(lines, folder).replace("roll_pitch_sigma_deg = 0.003", 'accuracies = "smrmsg.out"')


def crc32(data):
    """NovAtel's: reflected, begun at zero, not turned round at the end."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def novatel(lines, folder):
    week_0, begin = divmod(DAY + LEAP - 315964800, 604800)
    with open(f"{folder}/ins.gps", "wb") as file:
        for n in lines:
            for q in range(len(n.t)):
                week, seconds = divmod(week_0 * 604800 + begin + n.t[q], 604800)
                east, north, up = n.velocity[q]
                body = struct.pack("<Iddddddd", int(week), seconds, n.latitude[q], n.longitude[q], n.height[q], north, east, up)
                body += struct.pack("<dddI", n.roll[q] / DEG, n.pitch[q] / DEG, n.heading[q] / DEG % 360, 3)
                whole = struct.pack("<3BBHHI", 0xAA, 0x44, 0x13, len(body), 508, int(week), round(seconds * 1000)) + body
                file.write(whole + struct.pack("<I", crc32(whole)))
    return 'path = "ins.gps"\nroll_pitch_sigma_deg = 0.003\n'


def novatel_ascii(lines, folder):
    week_0, begin = divmod(DAY + LEAP - 315964800, 604800)
    with open(f"{folder}/ins.txt", "w", encoding="ascii", newline="") as file:
        for n in lines:
            for q in range(len(n.t)):
                week, seconds = divmod(week_0 * 604800 + begin + n.t[q], 604800)
                east, north, up = n.velocity[q]
                text = f"INSPVAA,COM1,0,50.0,FINESTEERING,{week:.0f},{seconds:.3f},02000000,54e2,16248;{week:.0f},{seconds:.9f},"
                text += f"{n.latitude[q]:.11f},{n.longitude[q]:.11f},{n.height[q]:.4f},{north:.4f},{east:.4f},{up:.4f},"
                text += f"{n.roll[q] / DEG:.9f},{n.pitch[q] / DEG:.9f},{n.heading[q] / DEG % 360:.9f},INS_SOLUTION_GOOD"
                file.write(f"#{text}*{crc32(text.encode()):08x}\r\n")
    return 'path = "ins.txt"\nroll_pitch_sigma_deg = 0.003\n'


def pos_mv(lines, folder, group=1):
    with open(f"{folder}/pos.000", "wb") as file:
        for n in lines:
            for q in range(len(n.t)):
                seconds = (n.t[q] + WEEKDAY * 86400) % 604800
                east, north, up = n.velocity[q]
                angles = n.roll[q] / DEG, n.pitch[q] / DEG, n.heading[q] / DEG % 360, 0
                body = struct.pack("<dddBB", seconds, seconds, 0, 2, 0)
                body += struct.pack("<ddd", n.latitude[q], n.longitude[q], n.height[q])
                if group == 1:
                    body += struct.pack("<fff4d", north, east, -up, *angles) + struct.pack("<8fB", *[0] * 8, 0) + b"\0"
                else:
                    h = n.heading[q]
                    along, across = east * np.sin(h) + north * np.cos(h), east * np.cos(h) - north * np.sin(h)
                    body += struct.pack("<fff4d", along, across, -up, *angles)
                    body += struct.pack("<f", n.heave[q]) + struct.pack("<6f", *[0] * 6) + b"\0\0"
                whole = struct.pack("<4sHH", b"$GRP", group, len(body) + 4) + body
                sixteen = sum(struct.unpack(f"<{len(whole) // 2}H", whole)) + struct.unpack("<H", b"$#")[0]
                file.write(whole + struct.pack("<H", -sixteen & 0xFFFF) + b"$#")
    return 'path = "pos.000"\ntime = "utc-week"\nroll_pitch_sigma_deg = 0.003\n'


NAVIGATION = {
    "sbet": sbet,
    "smrmsg": smrmsg,
    "novatel": novatel,
    "novatel-ascii": novatel_ascii,
    "pos-mv": pos_mv,
    "pos-mv-102": lambda lines, folder: pos_mv(lines, folder, 102),
    "own": lambda *_: "roll_pitch_sigma_deg = 0.003\n",
}


def main(seed, folder, recorder="all", navigation="sbet"):
    os.makedirs(folder, exist_ok=True)
    random = np.random.default_rng(seed)
    lengths = np.exp(random.uniform(np.log(1.5), np.log(60), 16))
    turns, phases = random.uniform(0, 2 * np.pi, (2, 16))

    def terrain(x, y):
        place = np.cos(turns) * x[..., None] + np.sin(turns) * y[..., None]
        waves = 0.012 * lengths**0.75 * np.sin(2 * np.pi * place / lengths + phases)
        return -10 + 0.03 * x - 0.02 * y + waves.sum(-1)

    waves = [(random.uniform(0, 6.28), random.uniform(4.0, 7.0)) for _ in range(8)]
    begin_s, records, form = BEGIN_S, [], FORMATS[recorder]()
    for number, line in enumerate(LINES):
        boat, seconds = Boat(line, begin_s, waves), LENGTH / line[3]
        record = Navigation(boat, seconds, random)
        form.rolled = record.t, record.roll
        written = list(form.navigation(record)) + list(form.begin(begin_s - 3, number + 1))
        for k, t0 in enumerate(np.arange(begin_s, begin_s + seconds, 0.4)):
            t0 = round(t0 * 1000) / 1000
            for number_of_head, head in enumerate(form.heads()):
                ping = Ping(boat, t0, k, terrain, form.sectors, head, random)
                ping.head = number_of_head
                written.append((t0, form.ping(ping)))
        written.sort(key=lambda item: item[0])
        with open(f"{folder}/line{number + 1}.{form.ending}", "wb") as file:
            file.write(form.header())
            file.writelines(item[1] for item in written)
        records.append(record)
        begin_s += seconds + 60
    names = ", ".join(f'"line{number + 1}.{form.ending}"' for number in range(len(LINES)))
    with open(f"{folder}/survey.toml", "w", encoding="utf-8") as file:
        file.write(f'name = "{recorder} {navigation}"\nprocedure = "seabed"\n\n')
        file.write(f"[multibeam]\npaths = [{names}]\nrange_sigma_m = 0.008\nangle_sigma_deg = 0.03\n\n")
        file.write("[trajectory]\n" + NAVIGATION[navigation](records, folder))
        if recorder == "xtf":
            file.write('\n[sound_speed]\nprofile = "cast.csv"\n')
            with open(f"{folder}/cast.csv", "w", encoding="utf-8") as cast:
                cast.writelines(["depth_m,sound_speed_m_s\n"] + [f"{depth},{SPEED}\n" for depth in CAST])


if __name__ == "__main__":
    main(int(sys.argv[1]), *sys.argv[2:])
