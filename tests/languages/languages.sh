#!/bin/sh
# A log and tables, read in Python and in Java. $1: torquectl; $2: a trajectory; $3: the folder of Python types; $4: lcm.jar and
# torqued.jar, as a class path; $5: a Python with numpy.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
here=$(dirname "$0")
"$1" eval "$2" --robot human-subject01 -o "$folder/walk.lcm" > /dev/null
"$1" export "$folder/walk.lcm" -o "$folder/walk.csv" > /dev/null
"$1" eval "$2" --robot human-subject01 -o "$folder/answers.csv" > /dev/null
cmp "$folder/walk.csv" "$folder/answers.csv"
PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$3 "$5" "$here/read_log.py" "$folder/walk.lcm" "$folder/walk.csv" | tee "$folder/python"
# its complaints are of the charts of lcm-spy, which are not here
java -cp "$4" "$here/SpyTypes.java" "$folder/walk.lcm" 2> "$folder/complaints" | tail -1 | tee "$folder/java"
grep -F 'TORQUED_COMMAND torqued.torque_command_t=447, TORQUED_DESIRED torqued.desired_state_t=447, TORQUED_MODEL torqued.model_info_t=1' "$folder/java" > /dev/null
# tables, all of which numpy reads by one line
"$1" gait --robot ck -o "$folder/gait.csv" 2> /dev/null
for command in eval wrenches project; do
  "$1" $command "$folder/gait.csv" -o "$folder/$command.csv" > /dev/null
done
"$5" "$here/read_tables.py" "$folder"/*.csv "$(dirname "$2")"/../*/*.csv
# both add up the same torques
[ "$(tail -1 "$folder/python")" = "$(sed 's/.* //' "$folder/java")" ] || { cat "$folder/complaints"; exit 1; }
