#!/usr/bin/env bash
# Manual pages out of what the program says of itself, so that both say the same.
# usage: man_pages.sh PROGRAM FOLDER
set -euo pipefail
program=$1 folder=$2
mkdir -p "$folder"
version=$("$program" --version)

# page NAME SUMMARY: a manual page around the text on standard input
page() {
    printf '.TH %s 1 "" "%s" "User Commands"\n' "${1^^}" "$version"
    printf '.SH NAME\n%s \\- %s\n.SH DESCRIPTION\n.nf\n' "${1//-/\\-}" "$2"
    sed -e 's/\\/\\e/g' -e "s/^[.']/\\\\\\&&/" -e 's/-/\\-/g'
    printf '.fi\n.SH FILES\n%s\n' 'Pages named docs/... lie in share/doc/resolvent/docs below the folder that was installed to:'
    printf '%s\n.SH SEE ALSO\n' 'those of a Debian package in /usr/share/doc/resolvent/docs.'
}

overview=$("$program" --help)
others=()
while read -r command summary; do
    {
        "$program" "$command" --help all | page "resolvent-$command" "$summary"
        echo '.BR resolvent (1)'
    } >"$folder/resolvent-$command.1"
    others+=("resolvent-$command")
done < <(sed -n '/^commands:/,/^$/s/^  \([a-z]\)/\1/p' <<<"$overview")
{
    page resolvent "global illumination by solving the light-transport operator" <<<"$overview"
    printf '.BR %s (1),\n' "${others[@]}" | sed '$s/,$//'
} >"$folder/resolvent.1"
