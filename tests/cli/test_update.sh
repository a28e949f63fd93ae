#!/usr/bin/env bash
# After an edit of the scene, only rays of rows that the edit may affect are traced again (--checkpoint).
source "$(dirname "$0")/support.sh"
quick=(--quality draft --max-elements 1000 --threads 1)

# edit FROM TO PYTHON: a copy whose JSON, `scene`, the line of Python has changed
edit() {
    python3 - "$@" <<'TEXT' || complain "cannot edit $1"
import json, struct, sys
data = open(sys.argv[1], 'rb').read()
length = struct.unpack('<I', data[12:16])[0]
scene = json.loads(data[20:20 + length])
exec(sys.argv[3])
text = json.dumps(scene).encode()
text += b' ' * (-len(text) % 4)
rest = data[20 + length:]
head = struct.pack('<IIIII', 0x46546c67, 2, 20 + len(text) + len(rest), len(text), 0x4e4f534a)
open(sys.argv[2], 'wb').write(head + text + rest)
TEXT
}

# solve_again SCENE PATTERN: solves with the rows of the scene before; the message about kept rows matches PATTERN
solve_again() {
    succeeds solve "$1" -o "$1.safetensors" --checkpoint rows "${quick[@]}" --stats "$1.json"
    warns "checkpoint: $2 % of the rays of rows kept"
}

# mean SCENE: the mean irradiance that was found
mean() { sed -n 's/.*"mean_irradiance":[^0-9]*\([0-9.e-]*\).*/\1/p' "$1.json"; }

succeeds scene cornell-blocks -o room.glb
edit room.glb painted.glb 'scene["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [.3, .4, .5, 1]'
edit painted.glb moved.glb '[n for n in scene["nodes"] if "short" in n["name"]][0]["translation"] = [0, 0, .03]'
succeeds solve room.glb -o room.safetensors --checkpoint rows "${quick[@]}" --stats room.json
grep -q '"kept_row_rays":[^0-9]*0,' room.json || complain "rows from nowhere"
solve_again painted.glb '\(99\|100\).[0-9]'
solve_again moved.glb '[5-9][0-9].[0-9]'
succeeds solve moved.glb -o full.safetensors "${quick[@]}" --stats full.json
python3 -c "import sys; sys.exit(abs($(mean moved.glb) / $(mean full) - 1) > 0.02)" ||
    complain "another solution than without the rows: $(mean moved.glb) against $(mean full)"
refuses 1 "holds no rows of this scene" solve furnace "${quick[@]}" -o "$out/a.safetensors" --checkpoint rows --resume
finish
