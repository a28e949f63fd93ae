#!/usr/bin/env bash
# The benchmark that starts processes of its own; how fast they are is no test's business.
source "$(dirname "$0")/support.sh"

if [[ ! -e $(dirname "$program")/libresolvent_mpi.so ]] || ! command -v mpirun >/dev/null; then
    echo "skipped: there is no mpirun, or no plug-in for it (./dev cluster)"
    exit 77
fi
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
succeeds bench cluster terraces:5000 --repeat 1
says '^  2 processes have [0-9.]* of the speed of 2 threads in assembly, [0-9.]* in solving'
says '^  terraces:20000 *4 x 1'
finish
