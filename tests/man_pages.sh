#!/bin/sh
# man shows each page of the documentation, without a warning, and no link is left in it that leads nowhere. $1: man; $2: the
# source directory; $3: where the man pages are.
set -eu
man=$1 source=$2 pages=$3
problems=$(mktemp)
trap 'rm -f "$problems"' EXIT
count=0
for page in $(cd "$source" && find client lcmtypes service tests -name '*.[57].md'); do
  name=$(basename "$page" .md)
  text=$(MANWIDTH=100 MAN_KEEP_FORMATTING='' "$man" --warnings --local-file "$pages/$name" 2> "$problems" || true)
  if [ -s "$problems" ]; then
    cat "$problems" >&2
    echo "man_pages: man warns of $name" >&2
    exit 1
  fi
  case $text in
    *NAME*"${name%.*} - "*) ;;
    *) echo "man_pages: $name does not begin with its name and subject" >&2; exit 1 ;;
  esac
  tables=$(grep -c '^|[-:| ]*$' "$source/$page" || true)
  if [ "$(grep -c '^\.TS' "$pages/$name")" -ne "$tables" ]; then
    echo "man_pages: $page has $tables tables, and $name $(grep -c '^\.TS' "$pages/$name")" >&2
    exit 1
  fi
  # each heading is there, to the last
  grep '^##' "$source/$page" | sed 's/^#* //; s/[`*]//g' | while IFS= read -r heading; do
    printf '%s\n' "$text" | tr -s ' \n' ' ' | grep -qiF -- "${heading%%[^a-zA-Z ]*}" || { echo "man_pages: $name lacks $heading" >&2; exit 1; }
  done
  if printf '%s\n' "$text" | grep -n '\.md\|](' >&2; then
    echo "man_pages: $name has links of the sources" >&2
    exit 1
  fi
  count=$((count + 1))
done
[ $count -ge 10 ]
