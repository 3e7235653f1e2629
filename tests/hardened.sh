#!/bin/sh
# The programs given are hardened as Debian's are: position-independent, with a global offset table that is written before
# they begin and never after, a guard on the stack, and checked calls of the C library.
set -eu
export LC_ALL=C
for program in "$@"; do
  elf=$(readelf --wide --file-header --program-headers --dynamic --dyn-syms "$program")
  for sign in 'Type: *DYN ' 'FLAGS_1.* PIE' 'FLAGS_1.* NOW' 'GNU_RELRO' ' __stack_chk_fail@' ' __[a-z]*_chk@'; do
    if ! printf '%s\n' "$elf" | grep -q "$sign"; then
      echo "$program is not hardened: readelf shows no \"$sign\"" >&2
      exit 1
    fi
  done
done
