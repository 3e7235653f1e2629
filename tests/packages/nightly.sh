#!/usr/bin/env bash
# What the Debian packages promise, on clean systems of each release, made by mmdebstrap: tools/test --nightly.
# shellcheck disable=SC2016,SC2317 # row calls the steps, and what is quoted is for inner shells
set -euo pipefail
cd "$(dirname "$0")/../.."
case ${1:-} in -*) exec tools/test --help ;; esac
if [ "$(id -u)" -ne 0 ]; then
  echo "tools/test --nightly: packages are installed into folders of their own, which needs root" >&2
  exit 77
fi
tools/install nightly
releases=("$@")
[ $# -gt 0 ] || releases=(bookworm trixie)
unset LCM_DEFAULT_URL
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8
: "${SOURCE_DATE_EPOCH:=$({ [ -e .git ] && git log -1 --format=%ct; } 2> /dev/null || stat --format=%Y CHANGELOG.md)}"
export SOURCE_DATE_EPOCH
out=$PWD/build/nightly
mkdir -p "$out"
: > "$out/table"
# a proxy, for instance, is needed in there, too
apt-config dump | grep -E '^Acquire::(Check|Retries|http|https)' > "$out/apt.conf" || true

# in_tree NETWORK TREE COMMAND...: runs it in there, with the network of its own that tools/private-network makes, or ''
in_tree()
{
  unshare --mount sh -ec '
    network=$1 tree=$2
    shift 2
    mount -t proc proc "$tree/proc"
    mount --rbind /dev "$tree/dev"
    exec $network chroot "$tree" "$@"' in_tree "$@"
}

figure() { echo "$*" > "$work/figure"; }

# Each of these is a row of the table: what is said of it, and what figure() says.

trees()
{
  mmdebstrap --variant=minbase --aptopt="$out/apt.conf" "$release" "$work/clean.tar" ${MIRROR:+"$MIRROR"}
  for tree in build clean booted; do
    mkdir "$work/$tree"
    tar --extract --file "$work/clean.tar" --directory "$work/$tree"
  done
  rm "$work/clean.tar"
  figure "$(chroot "$work/clean" dpkg-query --list | grep -c '^ii') packages"
}

built()
{
  mkdir "$work/build/torqued"
  git ls-files -z --cached --others --exclude-standard | tar --create --null --files-from=- | tar --extract --directory "$work/build/torqued"
  in_tree '' "$work/build" /torqued/tools/package
  cp "$work/build/torqued/build/packages/"*.deb "$debs"
  figure "$(cd "$debs" && for deb in *.deb; do
    echo -n "${deb%%_*} $(($(stat --format=%s "$deb") / 1000)) kB, installed $(dpkg-deb --field "$deb" Installed-Size) kB; "
  done)"
}

checked()
{
  in_tree '' "$work/build" /torqued/tools/package --check
  for deb in "$debs"/*.deb; do
    cmp "$deb" "$work/build/torqued/build/packages/${deb##*/}"
  done
  figure "$(chroot "$work/build" lintian --version): $(grep -c '^E:' "$out/$release-checked.log" || true) errors, $(
    grep -c '^W:' "$out/$release-checked.log" || true) warnings"
}

files_of() { (cd "$work/clean" && find . -xdev ! -path './proc/*' ! -path './dev/*' ! -path './root/packages*' \
  ! -path './var/lib/apt/*' ! -path './var/lib/dpkg/*' ! -path './var/cache/apt/*' ! -path './var/cache/debconf/*' ! -path './var/log/*' | sort); }

answered_in_a_minute()
{
  chroot "$work/clean" ldconfig # which leaves a cache, as after any package with a library
  files_of > "$work/before"
  mkdir "$work/clean/root/packages"
  cp "$debs"/torque*.deb "$work/clean/root/packages"
  began=$(date +%s%N)
  in_tree '' "$work/clean" sh -ec '
    apt-get update
    apt-get install --yes --no-install-recommends /root/packages/torqued_*.deb /root/packages/torquectl_*.deb' < /dev/null
  installed=$(date +%s%N)
  in_tree tools/private-network "$work/clean" sh -ec '
    cd /root/packages
    torqued --config /etc/torqued/torqued.toml &
    trap "kill $!" EXIT
    torquectl gait --robot ck -o walk.csv
    torquectl echo --count 1 > first &
    echo=$!
    torquectl send walk.csv > sent &
    wait $echo
    date +%s%N > answered
    wait $! || [ $? -eq 1 ] # 1: samples were lost, for instance because the machine has much to do
    cat first sent
    grep -q "samples answered" sent'
  milliseconds=$((($(cat "$work/clean/root/packages/answered") - began) / 1000000))
  figure "$((milliseconds / 1000)).$((milliseconds % 1000 / 100)) s from the start of apt, which took $(((installed - began) / 1000000000)) s for $(
    chroot "$work/clean" dpkg-query --list | grep -c '^ii') packages in all"
  [ "$milliseconds" -lt 60000 ]
}

# a service is there and disabled; a user enables it
state() { systemctl --root="$work/clean" is-enabled torqued.service || true; }
disabled()
{
  [ "$(state)" = disabled ]
  systemctl --root="$work/clean" enable torqued.service
  [ "$(state)" = enabled ]
  grep -q "^ExecStart=/usr/bin/torqued --config /etc/torqued/torqued.toml$" "$work/clean/usr/lib/systemd/system/torqued.service"
}

upgraded()
{
  before=$(chroot "$work/clean" dpkg-query --show --showformat='${Version}' torqued)
  echo 'log_level = "debug"' >> "$work/clean/etc/torqued/torqued.toml"
  in_tree '' "$work/build" env REVISION=2 /torqued/tools/package
  cp "$work/build/torqued/build/packages/"torque*-2~*.deb "$work/clean/root/packages"
  # nobody to ask: a question would end this
  in_tree '' "$work/clean" sh -ec 'apt-get install --yes --no-install-recommends /root/packages/*-2~*.deb' < /dev/null
  figure "$before -> $(chroot "$work/clean" dpkg-query --show --showformat='${Version}' torqued)"
  grep -q 'log_level = "debug"' "$work/clean/etc/torqued/torqued.toml"
  [ "$(find "$work/clean/etc/torqued" -type f | wc -l)" -eq 1 ]
  [ "$(state)" = enabled ]
  [ -z "$(chroot "$work/clean" dpkg --verify torquectl)" ]
}

purged()
{
  # apt keeps a library that something else only suggests
  in_tree '' "$work/clean" sh -ec '
    apt-get purge --yes torqued torquectl
    apt-get autoremove --purge --yes --option APT::AutoRemove::SuggestsImportant=false \
      --option APT::AutoRemove::RecommendsImportant=false' < /dev/null
  files_of > "$work/after"
  diff "$work/before" "$work/after"
  figure "$(wc -l < "$work/after") files before and after"
}

# in a container that systemd has started
services()
{
  mkdir "$work/booted/root/packages"
  cp "$debs"/torque*.deb "$work/clean/root/packages/"torqued_*-2~*.deb tests/packages/services.sh "$work/booted/root/packages"
  in_tree '' "$work/booted" sh -ec '
    apt-get update
    apt-get install --yes --no-install-recommends systemd systemd-sysv iproute2 /root/packages/torque*-1~*.deb' < /dev/null
  status=0
  timeout 120 systemd-nspawn --quiet --directory "$work/booted" --boot --private-network --keep-unit --register=no -- \
    systemd.run=/root/packages/services.sh \
    systemd.run_success_action=exit systemd.run_failure_action=exit < /dev/null || status=$?
  cat "$work/booted/root/packages/services.log"
  return "$status"
}

# a client of one's own: CMake and pkg-config, C++ and Python
client()
{
  cp "$debs"/*.deb "$work/clean/root/packages"
  in_tree '' "$work/clean" sh -ec '
    apt-get install --yes --no-install-recommends cmake make g++ pkg-config python3-minimal \
      /root/packages/torqued_*-1~*.deb /root/packages/libtorqued-client-dev_*.deb
    cd /root/packages
    cmake -S /usr/share/doc/torqued/example -B by_cmake -D CMAKE_BUILD_TYPE=Release
    cmake --build by_cmake
    c++ /usr/share/doc/torqued/example/controller.cpp $(pkg-config --cflags --libs torqued-client) -o by_pkg_config' < /dev/null
  in_tree tools/private-network "$work/clean" sh -ec '
    torqued --config /etc/torqued/torqued.toml &
    trap "kill $!" EXIT
    cd /root/packages
    by_cmake/controller | grep "^torques "
    ./by_pkg_config | grep "^torques "
    PYTHONPATH=/usr/share/torqued/python python3 -c "import torqued; print(torqued.desired_state_t.decode(torqued.desired_state_t().encode()))"'
}

# row WHAT STEP: runs a step and prints its row; not once one of this release has gone wrong that the others need. To be
# called as a plain command, because bash ignores errors in the whole of what stands before && or in a condition.
failed=0
row()
{
  rm -f "$work/figure"
  held=NO
  if [ -n "$stopped" ]; then
    figure "not reached"
  else
    set +e
    (set -e && "$2") > "$out/$release-$2.log" 2>&1
    status=$?
    set -e
    if [ $status -eq 0 ]; then
      held=yes
    else
      tail -n 20 "$out/$release-$2.log" >&2
      case $2 in trees | built | answered_in_a_minute) stopped=yes ;; esac
    fi
  fi
  [ $held = yes ] || failed=1
  printf '%-9s %-3s  %-45s %s\n' "$release" $held "$1" "$(cat "$work/figure" 2> /dev/null)" | tee -a "$out/table"
}

work=''
trap '[ -z "$work" ] || rm -rf --one-file-system "$work"' EXIT
for release in "${releases[@]}"; do
  work=$(mktemp -d "$out/$release.XXXXXX")
  chmod 755 "$work"
  debs=$out/$release-packages
  rm -rf "$debs"
  mkdir "$debs"
  stopped=''
  row 'clean systems, by mmdebstrap' trees
  row 'packages are built' built
  row 'built twice: same bytes; lintian: no warning' checked
  row 'first answer within 60 s' answered_in_a_minute
  row 'the service is there, and disabled' disabled
  row 'an upgrade keeps what the user set' upgraded
  row 'services: started, restarted, stopped' services
  row 'a purge leaves nothing' purged
  row 'a client can be built' client
  rm -rf --one-file-system "$work"
  work=''
done
echo
cat "$out/table"
echo "packages and logs: ${out#"$PWD"/}"
exit $failed
