#!/bin/bash
# Does what a page tells its reader to do: runs its ```sh blocks, one after another in one shell and an empty folder, with
# what the build tree $1 installs, and looks in their output for each line of the blocks between them, in their order; …
# stands for any text. $2: the page; $3: the README, whose C++ must compile, too. Needs a bus: tools/private-network.
set -eu
build=$1 page=$2 readme=$3
folder=$(mktemp -d)
trap 'kill $(cat "$folder/daemon" 2> /dev/null) 2> /dev/null || true; rm -rf "$folder"' EXIT
cmake --install "$build" --prefix "$folder/usr" > "$folder/install.log"
export PATH=$folder/usr/bin:$PATH
PKG_CONFIG_PATH=$(dirname "$(find "$folder/usr" -name torqued-client.pc)")
export PKG_CONFIG_PATH

mkdir "$folder/here"
awk '/^```/ { sh = /^```sh$/; next } sh' "$page" > "$folder/commands"
awk '/^```/ { inside = !inside; text = inside && /^```$/; next } text' "$page" > "$folder/expected"
# a page without either would pass everything
if [ "$(wc -l < "$folder/commands")" -lt 50 ] || [ "$(grep -c '[^ …]' "$folder/expected")" -lt 10 ]; then
  echo "tutorial: $page has $(wc -l < "$folder/commands") lines of commands and $(wc -l < "$folder/expected") of what they print" >&2
  exit 1
fi

# a daemon is left behind only where a command fails
echo 'trap '\''[ $? -eq 0 ] || echo "${torqued:-}" > ../daemon'\'' EXIT' | cat - "$folder/commands" > "$folder/script"
if ! (cd "$folder/here" && sh -eu ../script) > "$folder/output" 2>&1; then
  cat "$folder/output"
  echo "tutorial: a command failed; above is what was printed before" >&2
  exit 1
fi
cat "$folder/output"

line_number=0
mapfile -t output < "$folder/output"
while IFS= read -r expected; do
  pattern=$(printf '%s' "$expected" | sed 's/[][*?\\]/\\&/g; s/…/*/g')
  [ "$pattern" != '*' ] || continue
  # shellcheck disable=SC2053 # a pattern on purpose
  while ((line_number < ${#output[@]})) && [[ ${output[line_number]} != $pattern ]]; do ((++line_number)); done
  if ((line_number == ${#output[@]})); then
    echo "tutorial: nothing printed is like this line, or not after the lines before it: $expected" >&2
    exit 1
  fi
done < "$folder/expected"

awk '/^```/ { cpp = /^```cpp$/; next } cpp' "$readme" > "$folder/readme.cpp"
# shellcheck disable=SC2046 # words on purpose
c++ -std=c++17 -Wall -Wextra -Werror "$folder/readme.cpp" -o "$folder/readme" $(pkg-config --cflags --libs torqued-client)
