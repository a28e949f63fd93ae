"""The document of an operator file, changed: change_document.py KIND IN OUT [OTHER]. The checksum is computed anew."""
import hashlib, json, struct, sys


def read(path):
    raw = open(path, "rb").read()
    n = int.from_bytes(raw[:8], "little")
    header = json.loads(raw[8:8 + n])
    notes = header.pop("__metadata__")
    return notes, {k: (e, bytearray(raw[8 + n + e["data_offsets"][0]:8 + n + e["data_offsets"][1]])) for k, e in header.items()}


def write(path, notes, tensors):
    at, header = 0, {"__metadata__": {**notes, "sha256": "0" * 64}}
    for name, (entry, data) in tensors.items():
        header[name] = {**entry, "data_offsets": [at, at + len(data)]}
        at += len(data)
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    raw = struct.pack("<Q", len(text)) + text + b"".join(data for _, data in tensors.values())
    digest = hashlib.sha256(raw).hexdigest().encode()
    open(path, "wb").write(raw.replace(b"0" * 64, digest, 1))


def set_document(tensors, data):
    entry, _ = tensors["document.glb"]
    tensors["document.glb"] = ({**entry, "shape": [len(data)]}, data)


def chunks(data):
    at = 12
    while at < len(data):
        size, kind = struct.unpack_from("<I4s", data, at)
        yield kind, bytes(data[at + 8:at + 8 + size])
        at += 8 + size


def archive(parts):
    body = b"".join(struct.pack("<I4s", len(d), k) + d for k, d in parts)
    return b"glTF" + struct.pack("<2I", 2, 12 + len(body)) + body


def change_json(data, change):
    parts = list(chunks(data))
    root = json.loads(parts[0][1])
    change(root)
    text = json.dumps(root).encode()
    return archive([(b"JSON", text + b" " * (-len(text) % 4))] + parts[1:])


def cycle(root):
    root["nodes"][0]["children"] = [0]


def rename(root):
    for material in root["materials"]:
        material["name"] = "another " + material["name"]


def odd_mesh(root):
    root["nodes"][0]["mesh"] = 1000


def far_view(root):
    root["bufferViews"][0]["byteOffset"] = 1 << 40


if __name__ == "__main__":
    kind, source, target = sys.argv[1:4]
    notes, tensors = read(source)
    document = tensors["document.glb"][1]
    if kind == "cut":
        set_document(tensors, document[:len(document) // 2])
    elif kind == "no-buffers":
        set_document(tensors, archive([part for part in chunks(document) if part[0] not in (b"FILE", b"BIN\0")]))
    elif kind == "text":
        set_document(tensors, b"this is no document of anything ")
    elif kind == "other":
        set_document(tensors, read(sys.argv[4])[1]["document.glb"][1])
    elif kind == "far-triangle":
        struct.pack_into("<I", tensors["document.triangle"][1], 0, 1 << 30)
    elif kind == "far-instance":
        struct.pack_into("<I", tensors["document.instance"][1], 0, 1 << 30)
    elif kind == "twice":
        tensors["document.triangle"][1][0:4] = tensors["document.triangle"][1][4:8]
    elif kind == "without":
        for name in [name for name in tensors if name.startswith("document.")]:
            del tensors[name]
    elif kind == "half":
        del tensors["document.instance"]
    else:
        set_document(tensors, change_json(document, {"cycle": cycle, "rename": rename, "odd-mesh": odd_mesh, "far-view": far_view}[kind]))
    write(target, notes, tensors)
