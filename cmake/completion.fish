# Completion of `resolvent` for fish: commands, their options, the values of options that have a few, and the built-in
# scenes besides files. All of it comes from the program's own help.
function __resolvent_words
    set -l words (commandline -opc)
    set -l program $words[1]
    set -l current (commandline -ct)
    if test (count $words) -eq 1
        $program --help 2>/dev/null | sed -n '/^commands:/,/^$/s/^  \([a-z]*\) */\1\t/p'
        printf '%s\n' --help --version
    else if string match -q -- '-*' $current
        $program $words[2] --help all 2>/dev/null |
            sed -nE 's/^  (--?[a-z][a-z-]*)( [A-Z][^ ]*)* +(.*)/\1\t\3/p' | sort -u
    else if string match -q -- '-*' $words[-1]
        # an invalid value is refused with a list of the valid ones
        set -l values ($program $words[2] $words[-1] '?' 2>&1 |
            sed -n 's/.* is not one of \(.*\); see .*/\1/p' | string split ', ')
        if test (count $values) -gt 0
            printf '%s\n' $values
        else
            __fish_complete_path $current
        end
    else
        $program --help 2>/dev/null | sed -n 's/.*name of a built-in scene: *//p' | string split ' '
        __fish_complete_path $current
    end
end
complete -c resolvent -f -a '(__resolvent_words)'
