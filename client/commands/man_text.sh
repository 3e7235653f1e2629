#!/bin/sh
# Writes a page NAME.SECTION.md, which begins with "# NAME(SECTION): what it is about", as a man page to the standard
# output:
#   man_text.sh LOWDOWN VERSION …/torqued-methods.7.md
# What links to another page becomes its name, torqued-methods(7); other links within the sources stay as words, and
# figures are left out.
set -eu
lowdown=$1 version=$2 page=$3
name=$(basename "$page" .md)
section=${name##*.}
name=${name%.*}
export LC_ALL=C

# man reads by this first line that there are tables
printf '%s\n' "'\\\" t"

# the title becomes NAME, headings rise by one, figures go
awk -v name="$name" '
  /^```/ { code = !code }
  code || /^    / { print; next }
  NR == 1 { sub(/^# [^:]*: /, ""); print "# NAME\n\n" name " - " $0 "\n\n# DESCRIPTION"; next }
  /^!\[/ { figure = 1 }
  figure { if (/\)$/) figure = 0; next }
  { sub(/^##/, "#"); print }' "$page" |
  # links, which may go over the end of a line
  sed -E -z \
    -e 's/\[([a-z.-]+)\(([157])\)\]\([^)]*\)/**\1**(\2)/g' \
    -e 's/\[([^][]*)\]\(([^):]*\/)?([a-z.-]+)\.([57])\.md(#[^)]*)?\)/\1 (**\3**(\4))/g' \
    -e 's/\[([^][]*)\]\([^):]*\)/\1/g' |
  "$lowdown" -s -Tman --parse-no-intraemph --out-no-smarty \
    -m "title=$name" -m "section=$section" -m "source=torqued $version" -m "volume=torqued" |
  # Code is bold, and its hyphens are no places to break a line. Of a table that is too wide for a line of 80 characters
  # the widest columns of words share what the others leave. No word is cut.
  awk '
    function width(cell)
    {
      gsub(/\\f\(..|\\f.|\\&|[\200-\277]/, "", cell)
      gsub(/\\\(..|\\./, "x", cell)
      return length(cell)
    }
    function write_table(    row, column, sum, line, most, widest)
    {
      sum = 3 * columns
      for (column = 1; column <= columns; ++column)
      {
        shares[column] = most_of[column] = 0
        for (row = 1; row <= rows; ++row)
          if (width(cells[row, column]) > most_of[column]) most_of[column] = width(cells[row, column])
        sum += most_of[column]
      }
      while (sum > 74)
      {
        most = 20
        widest = 0
        for (column = 1; column <= columns; ++column)
          if (!shares[column] && alignment[column] ~ /^l/ && most_of[column] > most)
          {
            most = most_of[column]
            widest = column
          }
        if (!widest) break
        shares[widest] = 1
        sum += 20 - most
      }
      print ".TS"
      for (row = 0; row <= 1; ++row)
      {
        line = ""
        for (column = 1; column <= columns; ++column)
          line = line " " substr(alignment[column], 1, 1) (row ? "" : "b") (shares[column] ? "x" : "")
        print substr(line, 2) (row ? "." : "")
      }
      for (row = 1; row <= rows; ++row)
      {
        line = ""
        for (column = 1; column <= columns; ++column)
          line = line "\t" (shares[column] ? "T{\n" cells[row, column] "\nT}" : cells[row, column])
        print substr(line, 2)
        if (row == 1) print "_"
      }
      print ".TE"
    }
    { gsub(/\\fC|\\f\(C[RW]/, "\\fB") }
    /^\.EX/ { example = 1 }
    /^\.EE/ { example = 0 }
    example { gsub(/-/, "\\-") }
    !example {
      rest = $0
      $0 = ""
      while (match(rest, /\\fB[^\\]*/))
      {
        bold = substr(rest, RSTART, RLENGTH)
        gsub(/-/, "\\-", bold)
        $0 = $0 substr(rest, 1, RSTART - 1) bold
        rest = substr(rest, RSTART + RLENGTH)
      }
      $0 = $0 rest
    }
    /^\.TH/ { print; print ".nr HY 0\n.nh\n.ad l"; next }
    /^\.TS/ { getline; getline; getline; split($0, alignment, /[ .]+/); table = 1; rows = 1; column = 1; text = ""; next }
    /^\.TE/ { --rows; write_table(); table = 0; next }
    table && /^T\{$/ { next }
    table && /^T\}/ {
      cells[rows, column] = text
      text = ""
      if (/\|/) { ++column; next }
      columns = column
      ++rows
      column = 1
      next
    }
    table { text = text (text == "" ? "" : " ") $0; next }
    { print }'
