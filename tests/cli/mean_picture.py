"""mean_picture.py A.hdr B.hdr C.hdr ...: whether the first picture is the mean of the others, within the rounding of
RGBE, and is none of them."""
import sys


def read(path):
    """Largest channel first found by exponent: a list of (r, g, b) of a file without run lengths."""
    data = open(path, "rb").read()
    body = data[data.index(b"\n", data.index(b"\n\n") + 2) + 1:]
    scale = [2.0 ** (e - 136) if e else 0 for e in range(256)]
    return [[(channel + 0.5) * scale[body[k + 3]] for channel in body[k:k + 3]] + [scale[body[k + 3]]]
            for k in range(0, len(body), 4)]


mean, *others = [read(path) for path in sys.argv[1:]]
moved = 0
for pixel, *parts in zip(mean, *others):
    step = pixel[3] + max(part[3] for part in parts)
    for c in range(3):
        if abs(pixel[c] - sum(part[c] for part in parts) / len(parts)) > step:
            sys.exit("%s is not the mean: %r, of %r" % (sys.argv[1], pixel, parts))
    moved += any(abs(pixel[c] - parts[0][c]) > 3 * step for c in range(3))
sys.exit(0 if moved else "nothing moves")
