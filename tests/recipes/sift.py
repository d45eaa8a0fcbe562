"""Reference keypoints and matches for tests/it/seabed.rs: OpenCV's SIFT on two pictures that both sides compute.

    pip install opencv-python-headless && python tests/recipes/sift.py > tests/reference/sift.json

The pictures are one texture of sines, the second moved by 3.4 columns to the right and 2.7 rows up. OpenCV sees 8-bit grey.
"""
import json
import math

import cv2
import numpy as np

WIDTH, HEIGHT, SHIFT = 220, 160, (3.4, -2.7)


def waves():
    """Forty waves of 4 to 20 pixels: (columns, rows, phase), angles in radians per pixel."""
    state, list_ = 12345, []
    for _ in range(40):
        numbers = []
        for _ in range(3):
            state = (1103515245 * state + 12345) % 2**31
            numbers.append(state / 2**31)
        rate, turn = 2 * math.pi / (4 + 16 * numbers[0]), 2 * math.pi * numbers[1]
        list_.append((rate * math.cos(turn), rate * math.sin(turn), 2 * math.pi * numbers[2]))
    return list_


def picture(shift):
    column, row = np.meshgrid(np.arange(WIDTH) - shift[0], np.arange(HEIGHT) - shift[1])
    total = sum(np.sin(a * column + b * row + phase) for a, b, phase in waves())
    return np.clip(np.round(127 + 18 * total), 0, 255).astype(np.uint8)


def main():
    sift = cv2.SIFT_create()
    found = [sift.detectAndCompute(picture(shift), None) for shift in ((0.0, 0.0), SHIFT)]
    (first, one), (second, two) = found
    pairs = cv2.BFMatcher(cv2.NORM_L2).knnMatch(one, two, k=2)
    back = {m.queryIdx: m.trainIdx for m in cv2.BFMatcher(cv2.NORM_L2).match(two, one)}
    good = [m for m, n in pairs if m.distance < 0.8 * n.distance and back[m.trainIdx] == m.queryIdx]
    shifts = np.array([np.subtract(second[m.trainIdx].pt, first[m.queryIdx].pt) for m in good])
    places = sorted({(round(k.pt[0], 3), round(k.pt[1], 3)) for k in first})
    near = np.hypot(*(shifts - SHIFT).T) < 1.0
    print(json.dumps({
        "opencv": cv2.__version__,
        "keypoints": [len(first), len(second)],
        "matches": len(good),
        "within_a_pixel": int(near.sum()),
        "median_shift": np.median(shifts, axis=0).round(4).tolist(),
        "places": places,
    }))


main()
