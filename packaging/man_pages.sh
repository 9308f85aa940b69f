#!/bin/sh
# Writes the manual pages of plait, from what the program itself prints for --help.
#
#   man_pages.sh PROGRAM DIRECTORY [OTHER...]
#
# makes DIRECTORY/plait.1.gz, DIRECTORY/plait-COMMAND.1.gz for each command, and a page for each other
# program.
set -eu

program=$1
directory=$2
shift 2
version=$("$program" --version)

commands() {
  "$program" --help | awk '/^Subcommands:/ { inside = 1; next } /^$/ { inside = 0 } inside { print $1 }'
}

# page NAME [COMMAND]: reads --help. The first line says what the command does, the second is its
# usage; "Word:" begins a section, and what is indented under it is a table of terms, an example or
# text. A long term has its explanation on the next line.
page() {
  awk -v name="$1" -v version="$version" -v commands="$(commands | tr '\n' ' ')" '
    function quoted(text) {
      gsub(/\\/, "\\\\e", text)
      gsub(/-/, "\\-", text)
      gsub(/\047/, "\\(aq", text)
      if (text ~ /^[.]/) text = "\\\\&" text
      return text
    }
    function section(title) { print ".SH " toupper(title) }
    NR == 1 {
      printf ".TH %s 1 \"\" \"%s\" \"User Commands\"\n", toupper(quoted(name)), version
      section("name")
      print quoted(name) " \\- " quoted(tolower(substr($0, 1, 1)) substr($0, 2))
      next
    }
    /^Usage: / {
      section("synopsis")
      $1 = ""
      print ".B" quoted($0)
      next
    }
    /^(Positionals|Options|Subcommands|Backends|Kinds):$/ {
      table = 1
      code = 0
      title = substr($1, 1, length($1) - 1)
      if (title == "Positionals") title = "arguments"
      if (title == "Subcommands") title = "commands"
      section(title)
      next
    }
    /^Examples:$/ { table = 0; code = 1; section("examples"); print ".nf"; next }
    /^$/ {
      if (code) print ".fi"
      table = 0
      code = 0
      waiting = 1
      next
    }
    { sub(/^  --threads N=[0-9]+/, "  --threads N") }  # its default is a matter of the machine
    table && match($0, /^  [^ ].*[^ ]  +/) {
      at = match(substr($0, 3), /  +/)
      print ".TP\n.B " quoted(substr($0, 3, at - 1))
      rest = substr($0, 2 + at)
      sub(/^ +/, "", rest)
      print quoted(rest)
      next
    }
    table && /^  [^ ]/ { print ".TP\n.B " quoted(substr($0, 3)); next }
    code { print quoted(substr($0, 3)); next }
    {
      if (waiting && !table) {
        if (!described++) section("description")
        else print ".PP"
        waiting = 0
      }
      sub(/^ +/, "")
      print quoted($0)
    }
    END {
      if (code) print ".fi"
      section("see also")
      count = split(commands, all, " ")
      line = name == "plait" ? "" : ".BR plait (1)"
      for (i = 1; i <= count; ++i)
        if ("plait-" all[i] != name) {
          if (line != "") line = line ",\n"
          line = line ".BR plait\\-" all[i] " (1)"
        }
      print line
    }' >"$directory/$1.1"
}

mkdir -p "$directory"
rm -f "$directory"/plait*.1*
"$program" --help | page plait
for command in $(commands); do
  "$program" "$command" --help | page "plait-$command"
done
for other in "$@"; do
  "$other" --help | page "${other##*/}"
done
gzip -9n "$directory"/plait*.1
