#!/bin/bash
# In a container with systemd, torqued and torquectl: what becomes of the services when the newer package beside this is
# installed over them, and when it is removed. What this writes is in services.log beside it.
exec > "${0%.sh}.log" 2>&1
set -eux
newer=$(echo "${0%/*}"/torqued_*-2~*.deb)
ip link set lo up multicast on
ip route add 224.0.0.0/4 dev lo
cp /etc/torqued/torqued.toml /etc/torqued/left.toml
main() { systemctl show --property MainPID --value "$1"; }

[ "$(systemctl is-enabled torqued)" = disabled ]
[ "$(main torqued)" -eq 0 ]
systemctl enable --now torqued
systemctl start torqued@left
torquectl status --lcm-url 'udpm://239.255.76.67:7667?ttl=0'

# what runs is started anew
before=$(main torqued) left=$(main torqued@left)
dpkg --install "$newer"
[ "$(systemctl is-active torqued torqued@left | sort --unique)" = active ]
[ "$(main torqued)" -ne "$before" ]
[ "$(main torqued@left)" -ne "$left" ]

# what does not, is not
systemctl stop torqued@left
dpkg --install "$newer"
[ "$(main torqued@left)" -eq 0 ]

systemctl start torqued@left
dpkg --remove torqued
[ "$(main torqued)" -eq 0 ]
[ "$(main torqued@left)" -eq 0 ]
