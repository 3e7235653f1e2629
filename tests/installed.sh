#!/bin/sh
# Installs the build tree given as $1 into a folder of its own, builds the example controller against that, outside of
# the source tree, by CMake and by pkg-config, and runs it with the installed daemon. Needs a bus: tools/private-network.
set -eu
build=$1
folder=$(mktemp -d)
torqued=''
trap 'kill $torqued 2> /dev/null || true; rm -rf "$folder"' EXIT
cmake --install "$build" --prefix "$folder/usr" > "$folder/install.log"

# the daemon alone, with its man pages; and nothing as long as something is not built
cmake --install "$build" --component torqued --prefix "$folder/daemon" > "$folder/component.log"
[ "$(cd "$folder/daemon" && find . -type f ! -path './share/man/*' | sort | tr '\n' ' ')" = \
  './bin/torqued ./lib/systemd/system/torqued.service ./lib/systemd/system/torqued@.service ./share/bash-completion/completions/torqued ./share/doc/torqued/realtime.conf ' ]
if [ -d "$build/client/man" ]; then
  for page in man1/torqued.1 man5/torqued.toml.5 man5/torqued-robot.5 man7/torqued-running.7; do
    ls "$folder/daemon/share/man/$page"
  done
  [ ! -e "$folder/daemon/share/man/man1/torquectl.1" ]
fi
for file in libtorqued-client.a torqued.jar man/torqued-motion.5 python/torqued/__init__.py; do
  grep -q "/$file" "$build/cmake_install.cmake" || continue # of a part that was left out
  sed "s|/$file|/nothing|" "$build/cmake_install.cmake" > "$folder/broken.cmake"
  if cmake -D CMAKE_INSTALL_PREFIX="$folder/nothing" -P "$folder/broken.cmake" > "$folder/broken.log" 2>&1; then exit 1; fi
  tr -s ' \n' ' ' < "$folder/broken.log" | grep 'nothing is not built, and nothing was installed'
  [ ! -e "$folder/nothing" ]
done

cp -r "$folder"/usr/share/doc/torqued/example "$folder/example"
cmake -S "$folder/example" -B "$folder/build" -D CMAKE_PREFIX_PATH="$folder/usr" -D CMAKE_BUILD_TYPE=Release > "$folder/cmake.log"
cmake --build "$folder/build" > "$folder/build.log"

# a man page of each subcommand, with its name, its options and its example as they are
if [ -d "$build/client/man" ]; then
  for subcommand in $("$folder/usr/bin/torquectl" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
    page=$folder/usr/share/man/man1/torquectl-$subcommand.1
    grep -q 'OPTIONS' "$page"
    grep -q '^  torquectl' "$page" || grep -q 'torquectl '"$subcommand" "$page"
  done
  grep -q '^Example' "$folder/usr/share/man/man1/torquectl-send.1"
  grep -q '^torqued  *\\-  *hears desired' "$folder/usr/share/man/man1/torqued.1"
fi

# the measured walk, with its licence
[ -f "$folder/usr/share/torqued/trajectories/subject01-walk/walk.csv" ]
grep -q 'Creative Commons' "$folder/usr/share/torqued/trajectories/subject01-walk/README.md"

# where the package is, it says itself; this one has been put elsewhere
PKG_CONFIG_PATH=$(dirname "$(find "$folder/usr" -name torqued-client.pc)")
export PKG_CONFIG_PATH
# shellcheck disable=SC2046 # words on purpose
c++ -std=c++17 -Wall -Wextra -Werror "$folder/example/controller.cpp" -o "$folder/by_pkg_config" \
  $(pkg-config --cflags --libs --define-variable=prefix="$folder/usr" torqued-client)
# and into a shared library, as of a plugin
# shellcheck disable=SC2046 # words on purpose
c++ -std=c++17 -fPIC -shared "$folder/example/controller.cpp" -o "$folder/plugin.so" -Wl,--no-undefined \
  $(pkg-config --cflags --libs --define-variable=prefix="$folder/usr" torqued-client)

"$folder/usr/bin/torqued" --robot ck 2> "$folder/torqued.log" &
torqued=$!
for controller in "$folder/build/controller" "$folder/by_pkg_config"; do
  "$controller" > "$folder/output"
  cat "$folder/output"
  [ "$(grep -c '^torques ' "$folder/output")" -ge 4 ] # of 400 instants every fiftieth: on a busy machine some are silent
  sleep 0.3
done
# without torques it lets go, and says why: nobody answers, then a daemon of another robot
stdbuf -oL "$folder/build/controller" > "$folder/output" &
controller=$!
while kill -0 $controller && ! grep -q '^torques ' "$folder/output"; do sleep 0.05; done
kill -KILL $torqued
wait $torqued || true
sleep 0.3
"$folder/usr/bin/torqued" --robot rk 2> "$folder/torqued.log" &
torqued=$!
wait $controller
grep -q '^no torques: torqued is silent$' "$folder/output"
grep -q '^no torques: model_id is .*; expected .*, that of rk, or 0$' "$folder/output"
tail -n 1 "$folder/output" | grep -q '^no torques: the motion is over$'
kill -TERM $torqued
wait $torqued
torqued=''
if "$folder/build/controller" nonsense:// 2> "$folder/output"; then exit 1; fi
grep 'controller: the LCM bus cannot be opened: lcm_url is "nonsense://"' "$folder/output"
