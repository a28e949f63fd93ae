#compdef resolvent
# Completion of `resolvent` for zsh: commands, their options, the values of options that have a few, and the built-in
# scenes besides files. All of it comes from the program's own help.
_resolvent()
{
    local program=$words[1] command=$words[2] previous=$words[CURRENT-1]
    local -a found
    if ((CURRENT == 2)); then
        found=(${(f)"$($program --help 2>/dev/null | sed -n '/^commands:/,/^$/s/^  \([a-z]*\) */\1:/p')"})
        found+=('--help:explain the program' '--version:print the version')
        _describe command found
    elif [[ $PREFIX == -* ]]; then
        found=(${(f)"$($program $command --help all 2>/dev/null |
            sed -nE 's/^  (--?[a-z][a-z-]*)( [A-Z][^ ]*)* +(.*)/\1:\3/p' | sort -u -t: -k1,1)"})
        _describe option found
    elif [[ $previous == -* ]]; then
        # an invalid value is refused with a list of the valid ones
        found=(${=$($program $command $previous '?' 2>&1 | sed -n 's/.* is not one of \(.*\); see .*/\1/p' | tr -d ,)})
        if (($#found)); then compadd -a found; else _files; fi
    else
        found=(${=$($program --help 2>/dev/null | sed -n 's/.*name of a built-in scene: *//p')})
        compadd -a found
        _files
    fi
}
_resolvent "$@"
