"""Makes models/rails/*.toml from the dimensions on the drawings: tangent arcs and lines, x right, z up, origin on top of the head.

Needs numpy and scipy. Run from the repository's root: python3 tests/recipes/rail_profiles.py
Prints the area of each cross-section, to be held against the published one.
"""
import numpy as np
from scipy.optimize import fsolve


class Line:
    def __init__(self, point, direction):
        self.p, self.d = np.array(point, float), np.array(direction, float) / np.hypot(*direction)
        self.n = np.array([-self.d[1], self.d[0]])  # left of the direction: outside

    def distance(self, q):
        return self.n @ (np.asarray(q) - self.p)

    def foot(self, q):
        return self.p + self.d * (self.d @ (np.asarray(q) - self.p))


class Circle:
    def __init__(self, centre, radius, convex):
        self.c, self.r, self.sign = np.array(centre, float), radius, 1 if convex else -1

    def distance(self, q):
        return self.sign * (np.hypot(*(np.asarray(q) - self.c)) - self.r)

    def foot(self, q):
        u = np.asarray(q) - self.c
        return self.c + u / np.hypot(*u) * self.r


def fillet(a, b, radius, convex, guess):
    """Circle of this radius tangent to a and b."""
    side = -radius if convex else radius
    centre = fsolve(lambda q: [a.distance(q) - side, b.distance(q) - side], guess, xtol=1e-13)
    return Circle(centre, radius, convex), a.foot(centre), b.foot(centre)


def crown(x1, x2, half_width):
    """R300, R80, R13 and the 1:20 flank; x1 and x2 are the tangent points, half_width is where the flank begins."""
    a1 = np.arcsin(x1 / 300)
    c80 = np.array([x1 - 80 * np.sin(a1), -300 + 220 * np.cos(a1)])
    a2 = np.arcsin((x2 - c80[0]) / 80)
    c13 = c80 + 67 * np.array([np.sin(a2), np.cos(a2)])
    a3 = np.pi / 2 - np.arctan(0.05)
    ends = [np.array([300 * np.sin(a1), -300 + 300 * np.cos(a1)]), c80 + 80 * np.array([np.sin(a2), np.cos(a2)]),
            c13 + 13 * np.array([np.sin(a3), np.cos(a3)])]
    return ends, abs(ends[2][0] - half_width)


def tangent_point(half_width):
    """x of the R80 to R13 joint for which the flank begins at half_width."""
    return lambda x1: float(fsolve(lambda x2: crown(x1, x2[0], half_width)[0][2][0] - half_width, [25.5])[0])


def build(start, elements):
    """[(name, end, signed radius)] -> area by Green's theorem of twice the half section."""
    area, before = 0.0, np.array(start)
    for _, end, radius in elements + [("closing", (0.0, elements[-1][1][1]), 0), ("axis", start, 0)]:
        end = np.array(end)
        area += 0.5 * (before[0] * end[1] - end[0] * before[1])
        if radius:
            half = np.arcsin(np.hypot(*(end - before)) / 2 / abs(radius))
            area -= np.sign(radius) * 0.5 * radius**2 * (2 * half - np.sin(2 * half))
        before = end
    return abs(2 * area)


def chn60():
    ends, off = crown(10.0, tangent_point(35.4)(10.0), 35.4)
    assert off < 1e-9
    flank = Line(ends[2], (0.05, -1))
    under = Line((36.5, -48.5 + 36.5 / 3), (-3, -1))
    web = Circle((408.25, -97.0), 400.0, False)
    slope = Line((8.25, -145.5 - 8.25 / 3), (3, -1))
    toe = Line((75, -164), (9, -1))
    edge = Line((75, -164), (0, -1))
    base = Line((75, -176), (-1, 0))
    _, a, b = fillet(flank, under, 2.0, True, (34, -35))
    _, c, d = fillet(under, web, 25.0, False, (34, -75))
    _, e, f = fillet(web, slope, 20.0, False, (30, -130))
    _, g, h = fillet(slope, toe, 40.0, False, (50, -120))
    _, i, j = fillet(toe, edge, 4.0, True, (71, -167))
    _, k, l = fillet(edge, base, 2.0, True, (73, -174))
    return [("crown R300", ends[0], 300), ("shoulder R80", ends[1], 80), ("corner R13", ends[2], 13), ("flank 1:20", a, 0),
            ("jaw R2", b, 2), ("underside 1:3", c, 0), ("upper fillet R25", d, -25), ("web R400", e, -400), ("web R20", f, -20),
            ("foot 1:3", g, 0), ("foot R40", h, -40), ("foot 1:9", i, 0), ("toe R4", j, 4), ("toe", k, 0), ("heel R2", l, 2)]


def uic60():
    ends, off = crown(10.228, tangent_point(36.0)(10.228), 36.0)
    assert off < 1e-9
    flank = Line(ends[2], (0.05, -1))
    under = Line((30, -51 + 30 / 2.75), (-2.75, -1))
    upper = Circle((128.25, -172 + 91.1), 120.0, False)
    lower = Circle((128.25, -172 + 60.0), 120.0, False)
    slope = Line((20, -172 + 31.785 - 20 / 2.75), (2.75, -1))
    toe = Line((75, -160.5), (14, -1))
    edge = Line((75, -160.5), (0, -1))
    base = Line((75, -172), (-1, 0))
    _, a, b = fillet(flank, under, 3.0, True, (34, -35))
    _, c, d = fillet(under, upper, 7.0, False, (20, -52))
    _, e, f = fillet(lower, slope, 7.0, False, (20, -138))
    _, g, h = fillet(slope, toe, 40.0, False, (55, -115))
    _, i, j = fillet(toe, edge, 4.0, True, (71, -164))
    _, k, l = fillet(edge, base, 2.0, True, (73, -170))
    return [("crown R300", ends[0], 300), ("shoulder R80", ends[1], 80), ("corner R13", ends[2], 13), ("flank 1:20", a, 0),
            ("jaw R3", b, 3), ("underside 1:2.75", c, 0), ("upper fillet R7", d, -7), ("upper web R120", (8.25, -172 + 91.1), -120),
            ("web", (8.25, -112.0), 0), ("lower web R120", e, -120), ("lower fillet R7", f, -7), ("foot 1:2.75", g, 0),
            ("foot R40", h, -40), ("foot 1:14", i, 0), ("toe R4", j, 4), ("toe", k, 0), ("heel R2", l, 2)]


HEAD = """# {title}
# Half cross-section from the middle of the head's top to the heel, mirrored by the reader: x right, z up, millimetres, origin on top of the head.
# radius_mm: positive where the rail bulges (turning right), negative where it is hollow; absent for a straight line. The arc is the shorter one.
{source}
# Coordinates are the tangent points that follow from these dimensions (tests/recipes/rail_profiles.py), to 1e-6 mm.

name = "{name}"
symmetric = true
line_region = "{line}"
arc_region = "{arc}"
start_mm = [0.0, 0.0]
"""


def write(path, elements, **words):
    with open(path, "w", encoding="utf-8") as out:
        out.write(HEAD.format(**words))
        for name, end, radius in elements:
            out.write(f'\n[[element]]\nname = "{name}"\nto_mm = [{end[0]:.6f}, {end[1]:.6f}]\n')
            if radius:
                out.write(f"radius_mm = {float(radius)}\n")
    print(path, f"area {build((0.0, 0.0), elements) / 100:.3f} cm2")


write("models/rails/chn60.toml", chn60(), title="CHN60, the Chinese 60 kg/m rail", name="CHN60", line="flank 1:20", arc="web R20",
      source="""# Source: section of the 60 kg/m rail in GB/T 2585 and TB/T 2344: height 176, head 73, foot 150, web 16.5, crown R300 (20 wide), R80, R13,
# flank 1:20 from a head width of 70.8, underside 1:3 meeting the axis 48.5 below the top, web R400, web fillet R20, foot 1:3 meeting the
# axis 30.5 above the base and 1:9 from 12 at the edge; area 77.45 cm2.
# Assumed, because no text at hand gives it: jaw R2, upper fillet R25, foot R40, toe R4, heel R2, and that the web is thinnest half-way
# between 48.5 and 145.5 below the top.""")
write("models/rails/uic60.toml", uic60(), title="UIC 60 (60E1)", name="UIC60", line="flank 1:20", arc="corner R13",
      source="""# Source: section 60E1 of EN 13674-1 (UIC 861-3): height 172, head 72, foot 150, web 16.5, crown R300 (20.456 wide), R80, R13, flank 1:20 from
# a head width of 72, underside 1:2.75 meeting the axis 51 below the top, web R120 and fillets R7, foot 1:2.75 and 1:14 from 11.5 at the
# edge; area 76.70 cm2. The ends of the straight web (60 and 91.1 above the base), the height 31.785 where the foot's 1:2.75 meets the axis
# and R40 between the foot's slopes were read off the published outline of 60E1 in the open software "rolland" and agree with it to 0.05.
# Assumed: jaw R3, toe R4, heel R2.""")
