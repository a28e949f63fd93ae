#!/usr/bin/env bash
# The Python package: its wheel is made, installed where nothing of ours is, and tested there; the examples run.
# usage: test_package.sh BUILD_FOLDER
set -uo pipefail
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
python=/usr/bin/python3
export OMP_WAIT_POLICY=passive PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_INDEX=1 PYTHONDONTWRITEBYTECODE=1
failures=0

complain() {
    echo "FAILED: $*"
    failures=$((failures + 1))
}

skip() {
    echo "skipped: $*"
    exit 77
}

[[ -e $build/integrations/python/_native.abi3.so ]] || skip "the Python package is not built; it needs python3-dev and python3-cffi"
$python -c 'import cffi, numpy, scipy, setuptools, wheel, venv, pip' 2>/dev/null ||
    skip "one of python3-cffi, -numpy, -scipy, -setuptools, -wheel, -venv, -pip is not installed"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1

wheel=$(bash "$here/../make_wheel.sh" "$build" "$work/wheels") || complain "no wheel is made"
[[ $wheel == *-cp36-abi3-manylinux_*.whl ]] || complain "its name says that it is for some versions of Python alone: $wheel"

# whether what is loaded lies in the wheel, but for what every Linux has
mkdir unpacked
(cd unpacked && $python -m zipfile -e "$wheel" .)
chmod +x unpacked/resolvent/*.so
env -i ldd unpacked/resolvent/_native.abi3.so |
    grep -v -e 'linux-vdso' -e 'ld-linux' -e '/lib\(c\|m\|dl\|rt\|pthread\|resolv\|gcc_s\|stdc++\)\.so' >needed
! grep -v "$PWD/unpacked" needed || complain "it needs what is not in the wheel"
[[ -n $(ls unpacked/resolvent/licences) ]] || complain "licences of libraries are missing"

# an older Python is told so
$python -m pip download --quiet --no-deps --only-binary :all: --python-version 3.7 --dest old "$wheel" >log 2>&1 &&
    complain "Python 3.7 gets it"
grep -q -i 'requires a different python: 3.7' log ||
    complain "Python 3.7 is not told why it does not get it: $(tail -n 1 log)"

# a clean environment, into which cffi, numpy and scipy come from the system
$python -m venv --system-site-packages --without-pip venv >log 2>&1 || complain "no environment: $(tail -n 1 log)"
$python -m pip --python venv/bin/python install --quiet "$wheel" >log 2>&1 || complain "it cannot be installed: $(tail -n 3 log)"
rm -rf unpacked
venv/bin/python -c 'import resolvent; print("resolvent", resolvent.__version__)' || complain "it cannot be imported"

(cd "$here" && "$work/venv/bin/python" -W error -m unittest --quiet) || complain "see above"
for example in hello_room 'fit_lights --elements 500' 'spectrum --elements 500'; do
    read -r name options <<<"$example"
    venv/bin/python "$here/../examples/$name.py" $options >log 2>&1 || complain "$name: $(tail -n 3 log)"
done
venv/bin/python -c 'import resolvent
resolvent.Scene.builtin("two-rooms").solve("draft", element_target=500).save("rooms.safetensors")'
$python "$here/../examples/operator_file.py" rooms.safetensors >log 2>&1 || complain "operator_file: $(tail -n 3 log)"
venv/bin/python "$here/measure_irradiance.py" 1e5 1.2 || complain "irradiance is slower than in C"

# the 20 lines of the documentation
awk '/^```python$/ { k++; next } /^```$/ { if (k == 1) exit } k == 1' "$here/../../../docs/python.md" >hello.py
[[ -s hello.py ]] || complain "docs/python.md has no program"
venv/bin/python hello.py >log 2>&1 || complain "docs/python.md: $(tail -n 3 log)"
((failures == 0)) && echo "all passed"
exit $((failures > 0))
