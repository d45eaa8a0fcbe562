"""What an independent reader (GDAL, through rasterio) finds in a surface that `apply` wrote, beside the cloud written with it.

    boresight apply survey.toml --calibration out/result.json --out cloud.las --surface bed.tif --cell 2
    python3 tests/recipes/surface.py bed.tif cloud.las

Prints the reference system, the bands, and by how much mean, count and standard deviation of cells of which no point was left out differ
from those of the cloud's points, gridded here. Needs rasterio and numpy; the cloud as .las, read here by its header.
"""
import struct, sys
import numpy as np, rasterio


def points(path):
    """Coordinates of a LAS 1.4 file of point format 6."""
    data = open(path, "rb").read()
    begin, = struct.unpack_from("<I", data, 96)
    length, = struct.unpack_from("<H", data, 105)
    count, = struct.unpack_from("<Q", data, 247)
    scale, offset = struct.unpack_from("<3d", data, 131), struct.unpack_from("<3d", data, 155)
    rows = np.frombuffer(data, np.uint8, count * length, begin).reshape(count, length)
    return np.ascontiguousarray(rows[:, :12]).view("<i4").reshape(-1, 3) * scale + offset


def main():
    with rasterio.open(sys.argv[1]) as surface:
        print(f"EPSG {surface.crs.to_epsg()}, {surface.width} by {surface.height} cells of {surface.res[0]} m, nodata {surface.nodata}")
        print(f"bands: {surface.descriptions}, {surface.dtypes}, {surface.compression}")
        mean, count, deviation = surface.read()
        left, top, cell = surface.bounds.left, surface.bounds.top, surface.res[0]
    xyz = points(sys.argv[2])
    column = np.floor((xyz[:, 0] - left) / cell).astype(int)
    row = np.floor((top - xyz[:, 1]) / cell).astype(int)
    inside = (column >= 0) & (column < mean.shape[1]) & (row >= 0) & (row < mean.shape[0])
    at, z = row[inside] * mean.shape[1] + column[inside], xyz[inside, 2]
    n = np.bincount(at, minlength=mean.size).astype(float)
    with np.errstate(all="ignore"):
        centre = np.bincount(at, z, mean.size) / n
        about = np.bincount(at, (z - centre[at]) ** 2, mean.size)
        same = n == count.ravel()
        print(f"{len(xyz)} points, {np.nansum(count):.0f} in the surface; {same.sum()} of {np.isfinite(mean).sum()} cells have them all")
        print(f"largest difference: mean {np.abs(mean.ravel() - centre)[same].max():.6f} m, "
              f"standard deviation {np.nanmax(np.abs(deviation.ravel() - np.sqrt(about / (n - 1)))[same & (n > 1)]):.6f} m")


if __name__ == "__main__":
    main()
