#!/usr/bin/env bash
# The sample that reads an operator file with numpy arrives at our solution.
samples=$(cd "$(dirname "$0")/../../samples/python" && pwd)
source "$(dirname "$0")/support.sh"

python3 -c 'import numpy, scipy' 2>/dev/null || {
    echo "skipped: python3 with numpy and scipy is not installed"
    exit 77
}
succeeds solve two-rooms -o rooms.safetensors --quality draft
python3 "$samples/solve_operator.py" rooms.safetensors || complain "another solution"
finish
