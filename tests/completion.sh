#!/bin/bash
# What bash offers after some words. $1: client/commands/completion.bash; $2, $3: torqued and torquectl.
set -u
# shellcheck disable=SC1090
source "$1"
torqued=$2 torquectl=$3

offers() # EXPECTED WORD... : the last word is the one that is being written
{
  local expected=$1
  shift
  COMP_WORDS=("$@")
  COMP_CWORD=$(($# - 1))
  _torqued "${COMP_WORDS[0]}" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
  if [ "${COMPREPLY[*]}" != "$expected" ]; then
    echo "after \"$*\": found \"${COMPREPLY[*]}\"; expected \"$expected\"" >&2
    exit 1
  fi
}

offers 'send status' "$torquectl" s
offers '--robot --rate' "$torquectl" gait --r
offers '--loop --lowpass --lcm-url' "$torquectl" send --l
offers 'rk rabbit' "$torquectl" gait --robot r
offers 'constrained' "$torquectl" report walk.csv --method c
offers '' "$torquectl" send walk
offers '' "$torquectl" eval --config x
offers '--prefix --print-config' "$torqued" --pr
offers 'human-subject01' "$torqued" --robot h
offers 'debug' "$torqued" --log-level d
