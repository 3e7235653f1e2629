# Completion of torqued and torquectl in bash: what their --help lists.

_torqued()
{
  local command=$1 current=$2 previous=$3 subcommand='' help listed
  if [[ ${command##*/} == torquectl ]] && ((COMP_CWORD > 1)); then
    subcommand=${COMP_WORDS[1]}
  fi
  # shellcheck disable=SC2086 # no word where there is no subcommand
  help=$(command "$command" $subcommand --help 2> /dev/null)
  COMPREPLY=()
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(grep -oE -- '^  (-[a-z],)?--[a-z-]+' <<< "$help" | grep -oE -- '--[a-z-]+')" -- "$current")
  elif [[ $previous == --* ]]; then
    # the values that its line lists; else files, as without completion
    listed=$(grep -E -- "^  $previous " <<< "$help" | grep -oE '[a-z0-9-]+(, [a-z0-9-]+){2,}' | tr -d ,)
    mapfile -t COMPREPLY < <(compgen -W "$listed" -- "$current")
  elif [[ ${command##*/} == torquectl && $COMP_CWORD -eq 1 ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p' <<< "$help")" -- "$current")
  fi
}
complete -o default -F _torqued torqued torquectl
