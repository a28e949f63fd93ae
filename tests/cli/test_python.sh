#!/usr/bin/env bash
# The sample that reads an operator file with numpy arrives at our solution.
source "$(dirname "$0")/support.sh"
samples=$here/../../samples/python

# the first of a user's own Python and the system's that has both
for python in python3 /usr/bin/python3 ''; do
    "${python:-false}" -c 'import numpy, scipy' 2>/dev/null && break
done
if [[ -z $python ]]; then
    echo "skipped: python3 with numpy and scipy is not installed"
    exit 77
fi
succeeds solve two-rooms -o rooms.safetensors --quality draft
"$python" "$samples/solve_operator.py" rooms.safetensors || complain "another solution"
succeeds relight rooms.safetensors --light lamp=0.25 -o evening.safetensors
"$python" "$samples/solve_operator.py" rooms.safetensors --light lamp=0.25 --with evening.safetensors \
    --spectrum spectrum.svg || complain "another solution under another light, or a norm above the albedo"
[[ -s spectrum.svg ]] || complain "no spectrum was drawn"
finish
