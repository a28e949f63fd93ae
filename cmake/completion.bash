# Completion of `resolvent` for bash: commands, their options, the values of options that have a few, and the built-in
# scenes besides files. All of it comes from the program's own help.
_resolvent()
{
    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
    local program=${COMP_WORDS[0]} command=${COMP_WORDS[1]} words
    if ((COMP_CWORD == 1)); then
        words=$("$program" --help 2>/dev/null | sed -n '/^commands:/,/^$/s/^  \([a-z]*\).*/\1/p')
        COMPREPLY=($(compgen -W "$words --help --version" -- "$current"))
    elif [[ $current == -* ]]; then
        words=$("$program" "$command" --help all 2>/dev/null | grep -oE -- '(^|[ ,])--?[a-z][a-z-]*' | sort -u)
        COMPREPLY=($(compgen -W "$words --help" -- "$current"))
    elif [[ $previous == -* ]]; then
        # an invalid value is refused with a list of the valid ones
        words=$({ "$program" "$command" "$previous" '?' 2>&1 || :; } |
            sed -n 's/.* is not one of \(.*\); see .*/\1/p')
        COMPREPLY=($(compgen -W "${words//,/}" -- "$current" || :))
    else
        words=$("$program" --help 2>/dev/null | sed -n 's/.*name of a built-in scene: *//p')
        COMPREPLY=($(compgen -W "$words" -- "$current"; compgen -f -- "$current" || :))
    fi
}
complete -o default -F _resolvent resolvent
