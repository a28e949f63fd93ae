#!/usr/bin/env bash
# The commands of "Start here" do what the page says they do.
# usage: test_docs.sh PROGRAM PAGE
source "$(dirname "$0")/support.sh"

page=$2
PATH=$(dirname "$program"):$PATH
sed -n '/^```sh$/,/^```$/{/^```/d;p}' "$page" >commands.sh
[[ -s commands.sh ]] || complain "the page holds no commands"
bash -euo pipefail commands.sh >log 2>&1 || {
    complain "a command of the page failed"
    tail -n 5 log
}
for picture in spheres room again evening evening-00 evening-05; do
    [[ -s $picture.png ]] || complain "$picture.png is missing"
done
# pages that it points to
grep -o '](\([^)#]*\)' "$page" | cut -c3- | while read -r target; do
    [[ -e $(dirname "$page")/$target ]] || echo "$target"
done >missing
[[ ! -s missing ]] || complain "links to nothing: $(cat missing)"
finish
