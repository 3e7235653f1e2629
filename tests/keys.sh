#!/bin/bash
# The keys of files in the pages that list them are those that the programs know, and flags and reasons those of the
# messages; and the methods. $1: torqued; $2: torquectl; $3 to $6: the pages torqued.toml(5), torqued-robot(5),
# torqued-messages(7) and torqued-methods(7).
set -eu
export LC_ALL=C
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

compare() # WHAT: what the page has, $folder/page, and what the program has, $folder/program
{
  [ "$(wc -l < "$folder/program")" -ge 1 ]
  if ! diff "$folder/page" "$folder/program" > "$folder/differences"; then
    echo "$1: the page (<) and the program (>) differ:" >&2
    cat "$folder/differences" >&2
    exit 1
  fi
}

# the configuration: each table's name, its keys and their defaults, in the program's order
sed -nE 's/^`\[([a-z_]+)\]`$/[\1]/p; s/^\| `([a-z_]+)` \| `([^`]*)` \|.*/\1 = \2/p' "$3" > "$folder/page"
"$1" --print-config | sed -nE '/^\[/p; s/^([a-z_]+ = .*)  #.*/\1/p' > "$folder/program"
compare "$3"

# A robot: a key that no table knows is refused with those that it does. Which they are depends on the kind of joint.
known() # ROBOT: the keys that are known where it has the key nonsense
{
  printf '%s\n' "$1" > "$folder/robot.toml"
  "$2" model --robot "$folder/robot.toml" 2>&1 | sed -n 's/.*nonsense: is not known here; known are: //p' | sed 's/, /\n/g'
}
page_keys() # HEADING: the keys of the tables from there to the next heading, or to a table that is called otherwise
{
  awk -v heading="$1" '$0 == heading { inside = 1; next } /^## / || /^A stroke/ { inside = 0 } inside' "$page" |
    sed -nE 's/^\| `([a-z_]+)` \|.*/\1/p' | grep -vxE 'floating|fixed|revolute|rolling|parallel|slide' | sort
}
page=$4
link='name = "a"
[[link]]
name = "trunk"
joint = "floating"
mass = 1.0
inertia = 1.0'

page_keys '## Keys of the file' > "$folder/page"
known "nonsense = 1
$link" "$2" | sort -u > "$folder/top"
printf 'name = "a"\nurdf = "robot.urdf"\nnonsense = 1\n' > "$folder/robot.toml"
echo '<robot name="a"><link name="b"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link></robot>' > "$folder/robot.urdf"
"$2" model --robot "$folder/robot.toml" 2>&1 | sed -n 's/.*nonsense: is not known here; known are: //p' | sed 's/, /\n/g' |
  sort -u - "$folder/top" > "$folder/program"
compare "$4, the file"

page_keys '## Links' > "$folder/page"
for joint in floating fixed revolute rolling parallel slide; do
  rest='parent = "trunk"
at = [0.0, 0.0]
parent_radius = 0.1
child_radius = 0.1'
  [ $joint = rolling ] || rest=${rest%%parent_radius*}
  [ $joint != floating ] || rest=
  known "name = \"a\"
[[link]]
name = \"b\"
joint = \"$joint\"
$rest
mass = 1.0
inertia = 1.0
nonsense = 1" "$2" > "$folder/$joint"
  [ -s "$folder/$joint" ]
done
sort -u "$folder"/{floating,fixed,revolute,rolling,parallel,slide} > "$folder/program"
compare "$4, links"

awk '/^A stroke/ { inside = 1 } /^## / { inside = 0 } inside' "$page" | sed -nE 's/^\| `([a-z_]+)` \|.*/\1/p' | sort > "$folder/page"
known "$link
draw = [{ from = [0.0, 0.0], to = [0.0, 1.0], nonsense = 1 }]" "$2" | sort -u > "$folder/program"
compare "$4, strokes"

page_keys '## Actuators' > "$folder/page"
known "$link
[[actuator]]
name = \"a\"
on = \"b\"
against = \"c\"
nonsense = 1" "$2" | sort -u > "$folder/program"
compare "$4, actuators"

page_keys '## Feet' > "$folder/page"
known "$link
[[foot]]
side = \"left\"
link = \"trunk\"
friction = 0.5
heel = [0.0, 0.0]
toe = [0.1, 0.0]
nonsense = 1" "$2" | sort -u > "$folder/program"
compare "$4, feet"

types=$(dirname "$5")
numbered() # TYPE: the numbered names of its file
{
  sed -nE 's/^ *const int32_t ([A-Z_]+) = ([0-9]+);.*/\1 \2/p' "$types/$1.lcm"
}
cells() # HEADING: what the first cells of the table there name
{
  awk -v heading="$1" '$0 == heading { inside = 1; next } /^## / { inside = 0 } inside' "$page" |
    sed -nE 's/^\| ([A-Z][^|]*) \|.*/\1/p' | sed 's/, /\n/g' | sort
}
page=$5
cells '## Flags' > "$folder/page"
numbered torque_command_t | grep -vx 'PRIOR 4096' | sort > "$folder/program"
compare "$5, flags"
cells '## Rejections' > "$folder/page"
numbered rejection_t | sort > "$folder/program"
compare "$5, rejections"

# the methods: each has its cell in the first table of the page
awk '/^\| method \| chooses/ { inside = 1; next } !/^\|/ { inside = 0 } inside' "$6" | sed -E 's/^\| ([^|]*) \|.*/\1/' |
  grep -o '`[a-z-]*`' | tr -d '\140' | sort > "$folder/page"
"$1" --robot ck --method nonsense 2>&1 | tr ' ,;' '\n\n\n' | grep -xE '[a-z]+-[a-z]+|constrained' | sort -u > "$folder/program" || true
compare "$6, methods"
