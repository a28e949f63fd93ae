#!/usr/bin/env bash
# The headless engine loop on a file that the program wrote.
# usage: test_runtime.sh PROGRAM ENGINE_LOOP
source "$(dirname "$0")/support.sh"
program_of_engine=$2

succeeds solve cornell-blocks -o rooms.safetensors --quality draft
"$program_of_engine" rooms.safetensors 12 >stdout 2>stderr || complain "the engine loop fails"
says 'frame  11: mean green irradiance [0-9.]* W/m2 at [0-9]* elements'
succeeds bake cornell-blocks -o lit.glb --to vertex --operator --quality draft
"$program_of_engine" lit.operator.safetensors 12 >stdout 2>stderr || complain "the engine loop fails with receivers"
says 'frame  11: mean green irradiance [0-9.]* W/m2 at [0-9]* vertices'
"$program_of_engine" /dev/null >stdout 2>stderr && complain "an empty file is taken for an operator"
warns 'too short'
succeeds bench relight --json
says '"ms":'
finish
