#!/usr/bin/env python3
"""The binary interface of the library: every public function, structure and constant, as clang sees it.

usage: interface.py SOURCE_FOLDER [LIBRARY]  compares it with tests/interface.txt, and fails where something there is gone or different,
                                             or where LIBRARY does not export exactly the functions that the headers declare
       interface.py SOURCE_FOLDER --write    writes that file: after a release, or a change that is meant
"""
import json
import pathlib
import re
import subprocess
import sys

SKIPPED = 77


def clang(source, headers, *options):
    text = "".join(f'#include "resolvent/{name}"\n' for name in headers)
    command = ["clang", "-fsyntax-only", "-x", "c", "-std=c17", f"-I{source}/include", *options, "-"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def constants(declaration):
    """Names and values of an enumeration."""
    value = -1
    for constant in declaration.get("inner", []):
        if constant["kind"] != "EnumConstantDecl":
            continue
        value += 1
        given = next((inner for inner in constant.get("inner", []) if "value" in inner), None)
        if given:
            value = int(given["value"])
        yield constant["name"], value


def declarations(source, headers):
    tree = json.loads(clang(source, headers, "-Xclang", "-ast-dump=json"))
    for declaration in tree["inner"]:
        name = declaration.get("name", "")
        if declaration["kind"] == "FunctionDecl" and name.startswith("rsv_"):
            kind = "inline" if declaration.get("inline") else "function"
            yield f"{kind} {name}: {declaration['type']['qualType']}"
        if declaration["kind"] == "EnumDecl":
            for constant, value in constants(declaration):
                if constant.startswith("RSV_"):
                    yield f"constant {constant}: {value}"


def layouts(source, headers):
    """A line for each public structure: offset, type and name of its members, then its size."""
    dump = clang(source, headers, "-Xclang", "-fdump-record-layouts-complete")
    for block in dump.split("*** Dumping AST Record Layout")[1:]:
        lines = [line for line in block.splitlines() if "|" in line]
        head = re.match(r"\s*0 \| struct (rsv_\w+)$", lines[0])
        if not head:
            continue
        members, size = [], ""
        for line in lines[1:]:
            offset, text = line.split("|", 1)
            if offset.strip() and text.startswith("   ") and not text.startswith("     "):
                members.append(f"{offset.strip()} {text.strip()}")
            elif "sizeof" in text:
                size = re.search(r"sizeof=(\d+)", text).group(1)
        yield f"struct {head.group(1)}: {'; '.join(members)}; size {size}"


def interface(source):
    headers = sorted(path.name for path in (source / "include" / "resolvent").glob("*.h"))
    return sorted(set(declarations(source, headers)) | set(layouts(source, headers)))


def by_name(lines):
    return dict(line.split(": ", 1) for line in lines)


def has_grown(before, now):
    """Whether a descriptor that begins with its size has got members beyond its old end: all that may happen to one."""
    *old, old_size = before.split("; ")
    *new, _ = now.split("; ")
    added = [int(member.split()[0]) for member in new[len(old):]]
    return (old[0] == "0 size_t size" and new[:len(old)] == old
            and all(offset >= int(old_size.split()[1]) for offset in added))


def compare(before, now):
    broken = False
    for name, meaning in before.items():
        if now.get(name) == meaning or name in now and name.startswith("struct ") and has_grown(meaning, now[name]):
            continue
        broken = True
        print(f"{name} is gone" if name not in now else f"{name} was\n    {meaning}\nand is\n    {now[name]}")
    if broken:
        print("Programs that were compiled before will not work. If that is meant, run `./dev interface`, and say in "
              "CHANGELOG.md how to migrate.")
    return broken


def exported(library):
    """Names of functions and data that a library shows to programs."""
    command = ["readelf", "--symbols", "--wide", library]
    table = subprocess.run(command, capture_output=True, text=True, check=True, env={"LC_ALL": "C"}).stdout
    for line in table.splitlines():
        field = line.split()
        if len(field) == 8 and field[4:6] == ["GLOBAL", "DEFAULT"] and field[6] != "UND":
            yield field[7]


def compare_symbols(library, now):
    declared = {name.split()[1] for name in now if name.startswith("function ")}
    shown = set(exported(library))
    for name in sorted(declared - shown):
        print(f"{name} is declared in a public header, and {library} does not export it")
    for name in sorted(shown - declared):
        print(f"{name} is exported by {library}, and no public header declares it")
    return declared != shown


def main():
    source = pathlib.Path(sys.argv[1])
    record = source / "tests" / "interface.txt"
    try:
        now = interface(source)
    except FileNotFoundError:
        print("skipped: clang is not installed")
        return SKIPPED
    if sys.argv[2:] == ["--write"]:
        record.write_text("\n".join(now) + "\n")
        return 0
    now = by_name(now)
    broken = compare(by_name(record.read_text().splitlines()), now)
    if sys.argv[2:]:
        broken = compare_symbols(sys.argv[2], now) or broken
    return int(broken)


if __name__ == "__main__":
    sys.exit(main())
