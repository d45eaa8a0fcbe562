"""Reference values for tests/it/proj.rs, from PROJ through pyproj.

    pip install pyproj && python tests/recipes/proj.py > tests/reference/proj.json

Written with 3.7.2 / PROJ 9.5.1. Angles in degrees, lengths in metres, all digits of a double.
"""
import json
import pyproj
from pyproj import Transformer

WGS84, CGCS2000 = "+a=6378137 +rf=298.257223563", "+a=6378137 +rf=298.257222101"
ELLIPSOIDS = {"WGS84": WGS84, "CGCS2000": CGCS2000}
LATITUDES = [-90, -89.999, -75.3, -60, -45, -30.25, -12.5, -0.001, 0, 1e-7, 9.81, 24.5, 31.2, 39.9, 45, 58.7, 72.25, 85, 89.9999, 90]
LONGITUDES = [-180, -123.4, -75.2, -0.001, 0, 3.3, 117.0, 121.48, 179.99]
HEIGHTS = [-11000, -50, 0, 12.345, 8848, 20000]


def geocentric():
    for name, ellipsoid in ELLIPSOIDS.items():
        cart = Transformer.from_pipeline(f"+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart {ellipsoid}")
        for i, lat in enumerate(LATITUDES):
            for j, height in enumerate(HEIGHTS):
                lon = LONGITUDES[(i + 2 * j) % len(LONGITUDES)]
                yield [name, lat, lon, height, *cart.transform(lon, lat, height)]


def utm():
    for name, ellipsoid in ELLIPSOIDS.items():
        for zone in (1, 18, 31, 51, 60, -1, -21, -50, -60):
            south = " +south" if zone < 0 else ""
            forward = Transformer.from_pipeline(
                f"+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=utm +zone={abs(zone)}{south} {ellipsoid}")
            for lat in (0.0, 0.5, 12.25, 31.2, 45.0, 60.5, 84.0):
                for off in (-3.5, -3.0, -1.2, 0.0, 0.001, 2.0, 3.0):
                    lat_signed = -lat if zone < 0 else lat
                    lon = -183 + 6 * abs(zone) + off
                    if -180 <= lon <= 180:
                        yield [name, zone, lat_signed, lon, *forward.transform(lon, lat_signed)]


def topocentric():
    points = [(0, 0, 0), (0.001, -0.002, 35.0), (-0.4, 0.3, -4000.0), (0.02, 0.05, 0.0)]
    for name, ellipsoid in ELLIPSOIDS.items():
        for lat0, lon0, h0 in [(31.2, 121.48, 12.5), (-45.0, -75.2, -20.0), (0.0, 179.999, 0.0), (78.9, 11.9, 45.0), (-33.86, 151.2, 300.0)]:
            cart = f"+step +proj=cart {ellipsoid}"
            enu = Transformer.from_pipeline(
                "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
                f"{cart} +step +proj=topocentric {ellipsoid} +lon_0={lon0} +lat_0={lat0} +h_0={h0}")
            for dlat, dlon, dh in points:
                lat, lon, h = lat0 + dlat, lon0 + dlon, h0 + dh
                yield [name, lat0, lon0, h0, lat, lon, h, *enu.transform(lon, lat, h)]


def block(rows):
    return "[\n" + ",\n".join(json.dumps(r) for r in rows) + "\n]"


if __name__ == "__main__":
    print('{"made_with": ' + json.dumps(f"pyproj {pyproj.__version__}, PROJ {pyproj.proj_version_str}"))
    print(',"geocentric": ' + block(geocentric()))
    print(',"utm": ' + block(utm()))
    print(',"topocentric": ' + block(topocentric()) + "}")
