# Bash completion for all Multi-Tetra programs, based on their --help-all. Without the package:
#   source docker/debian/completion.bash
_multitetra() {
  local program=${COMP_WORDS[0]} current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
  local commands command= word help value=
  commands=$("$program" --help 2>/dev/null | sed -n '/^Subcommands:/,/^$/s/^  \([a-z-]*\) .*/\1/p')
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    if grep -qx -- "$word" <<<"$commands"; then command=$word; break; fi
  done
  help=$("$program" $command --help-all 2>/dev/null)
  if [[ $previous == -* ]]; then   # "--option VALUE" has a single space; after a flag there are more.
    value=$(sed -nE "s/^  ([^ ]*,)?$previous ([^ ]+).*/\2/p" <<<"$help" | head -n 1)
  fi
  case "$value" in
    FILE*) COMPREPLY=($(compgen -f -- "$current")) ;;
    DIR*) COMPREPLY=($(compgen -d -- "$current")) ;;
    *\|*) COMPREPLY=($(compgen -W "${value//|/ }" -- "$current")) ;;
    ?*) ;;   # A number or a name: no completion.
    *)
      if [[ $current == -* ]]; then
        COMPREPLY=($(compgen -W "$(grep -oE '^  [^ ]+' <<<"$help" | tr ',' '\n' | grep -o -- '-.*')" -- "$current"))
      elif [[ -z $command && -n $commands ]]; then
        COMPREPLY=($(compgen -W "$commands" -- "$current"))
      else
        COMPREPLY=($(compgen -f -- "$current"))
      fi ;;
  esac
}
complete -o filenames -F _multitetra multitetra multitetra-client multitetra-gateway multitetra-load multitetra-server
