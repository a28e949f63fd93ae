"""A folder as a pack file of Godot 4: pack.py FOLDER OUT.pck"""
import hashlib
import os
import struct
import sys


def main(folder, out):
    files = (os.path.join(at, name) for at, _, names in os.walk(folder) for name in names)
    paths = sorted(os.path.relpath(file, folder) for file in files)
    entries = [(f"res://{path}".encode(), open(os.path.join(folder, path), "rb").read()) for path in paths]
    padded = [name + bytes(-len(name) % 4) for name, _ in entries]
    start = 96 + 4 + sum(4 + len(name) + 36 for name in padded)
    start += -start % 16
    with open(out, "wb") as file:
        file.write(b"GDPC" + struct.pack("<4I", 2, 4, 0, 0) + struct.pack("<IQ", 0, start) + bytes(64))
        file.write(struct.pack("<I", len(entries)))
        offset = 0
        for name, (_, data) in zip(padded, entries):
            file.write(struct.pack("<I", len(name)) + name + struct.pack("<QQ", offset, len(data)))
            file.write(hashlib.md5(data).digest() + struct.pack("<I", 0))
            offset += len(data)
        file.write(bytes(start - file.tell()))
        for _, data in entries:
            file.write(data)


if __name__ == "__main__":
    main(*sys.argv[1:])
