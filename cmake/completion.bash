# Completion of `resolvent` for bash: commands, and the options that each explains in its --help.
_resolvent()
{
    local current=${COMP_WORDS[COMP_CWORD]} program=${COMP_WORDS[0]}
    if ((COMP_CWORD == 1)); then
        local commands
        commands=$("$program" --help 2>/dev/null | sed -n '/^commands:/,/^$/s/^  \([a-z]*\).*/\1/p')
        COMPREPLY=($(compgen -W "$commands --help --version" -- "$current"))
    elif [[ $current == -* ]]; then
        local options
        options=$("$program" "${COMP_WORDS[1]}" --help 2>/dev/null | grep -oE -- '(^|[ ,])--?[a-z][a-z-]*')
        COMPREPLY=($(compgen -W "$options --help" -- "$current"))
    fi
}
complete -o default -F _resolvent resolvent
