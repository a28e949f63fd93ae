#!/usr/bin/env python3
"""Would the tests notice a mistake? Changes one operator or constant of the physics at a time, builds, and runs the tests
of its room. What no test notices survives, and is listed: each is a gap in the tests, or changes nothing.

usage: mutate.py SOURCE_FOLDER WORK_FOLDER [COUNT] [SEED]

WORK_FOLDER gets a copy of the sources, a build of them, and report.md.
"""
import json
import pathlib
import random
import re
import shutil
import subprocess
import sys

# the tests that answer for a room; quick ones first, as the first that fails decides
TESTS = {
    "bsdf": ["bsdf", "bsdf_lobes", "reference"],
    "sources": ["light", "light_tree", "environment", "validation_direct"],
    "operator": ["operator", "operator_matrix", "solve", "validation_enclosures"],
    "solver": ["solvers", "solve"],
    "receiver": ["shadows", "validation_direct"],
}
CHANGES = [
    (r" \+ ", " - "), (r" - ", " + "), (r" \* ", " / "), (r" / ", " * "),
    (r" < ", " >= "), (r" > ", " <= "), (r" <= ", " > "), (r" >= ", " < "),
    (r" && ", " || "), (r" \|\| ", " && "), (r" == ", " != "), (r" != ", " == "),
    (r"\+=", "-="), (r"-=", "+="),
    (r"\bf_min\(", "f_max("), (r"\bf_max\(", "f_min("),
    (r"(?<![\w.])0\.5f\b", "0.55f"), (r"\bRSV_PI\b", "(1.1f * RSV_PI)"),
]
# which choices are exact and which only fast is not physics
SKIPPED_LINES = re.compile(r"^\s*(//|\*|#|/\*)|rsv_fail|RSV_ASSERT|_Static_assert|for \(|rsv_log|assert\(")
TIMEOUT = 600


def sites(folder):
    """Every place where a line can be changed: file, line number, the line before and after."""
    for room in TESTS:
        for path in sorted((folder / "src" / room).glob("*.[ch]")):
            if path.name.startswith("tables_generate"):
                continue
            for number, line in enumerate(path.read_text().splitlines()):
                code = line.split("//")[0]
                if SKIPPED_LINES.search(line) or '"' in code:
                    continue
                for pattern, other in CHANGES:
                    for match in re.finditer(pattern, code):
                        changed = line[:match.start()] + other + line[match.end():]
                        yield room, path, number, line, changed


def run(command, folder):
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=TIMEOUT)
        return done.returncode
    except subprocess.TimeoutExpired:
        return 124


def known_tests(folder):
    """Programs of tests by the tests' names."""
    listed = subprocess.run(["ctest", "--show-only=json-v1"], cwd=folder, capture_output=True, text=True, check=True)
    return {test["name"]: pathlib.Path(test["command"][0]).name
            for test in json.loads(listed.stdout)["tests"] if test.get("command")}


def verdict(build, tests):
    """"killed by NAME", "does not compile", or "survived". @param tests programs by names"""
    for name, program in tests.items():
        if run(["cmake", "--build", ".", "--parallel", "2", "--target", program], build) != 0:
            return "does not compile"
        if run(["ctest", "-R", f"^{name}$"], build) != 0:
            return f"killed by {name}"
    return "survived"


def tests_of(room, tests):
    return {name: tests[name] for name in TESTS[room] if name in tests}


def try_one(build, site, tests):
    room, path, number, _, changed = site
    text = path.read_text()
    lines = text.splitlines()
    lines[number] = changed
    path.write_text("\n".join(lines) + "\n")
    try:
        return verdict(build, tests_of(room, tests))
    finally:
        path.write_text(text)


def prepare(source, work):
    """A copy of what git knows, built once."""
    copy = work / "source"
    shutil.rmtree(copy, ignore_errors=True)
    files = subprocess.run(["git", "ls-files"], cwd=source, capture_output=True, text=True, check=True).stdout.split("\n")
    for name in filter(None, files):
        target = copy / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source / name, target)
    build = copy / "build" / "release"
    subprocess.run(["cmake", "--preset", "release", "-DRSV_CUDA=OFF", "-DRSV_CLUSTER=OFF"], cwd=copy, check=True,
                   stdout=subprocess.DEVNULL)
    return copy, build


def report(work, results):
    counted = [(site, answer) for site, answer in results if answer != "does not compile"]
    killed = [answer for _, answer in counted if answer != "survived"]
    lines = [f"{len(killed)} of {len(counted)} changes were noticed "
             f"({100 * len(killed) / max(1, len(counted)):.0f} %).", "", "Not noticed:", ""]
    for (room, path, number, before, changed), answer in counted:
        if answer == "survived":
            lines += [f"- {room}/{path.name}:{number + 1}", f"  `{before.strip()}`", f"  `{changed.strip()}`"]
    (work / "report.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


def main():
    source, work = (pathlib.Path(name).resolve() for name in sys.argv[1:3])
    count = int(sys.argv[3]) if len(sys.argv) > 3 else 100
    chance = random.Random(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
    copy, build = prepare(source, work)
    tests = known_tests(build)
    every = list(sites(copy))
    chosen = chance.sample(every, min(count, len(every)))
    for room in sorted({site[0] for site in chosen}):
        if verdict(build, tests_of(room, tests)) != "survived":
            sys.exit(f"the tests of {room} fail without any change")
    results = []
    for k, site in enumerate(chosen):
        results.append((site, try_one(build, site, tests)))
        print(f"{k + 1} of {len(chosen)}: {site[0]}/{site[1].name}:{site[2] + 1}: {results[-1][1]}", flush=True)
    report(work, results)


if __name__ == "__main__":
    main()
