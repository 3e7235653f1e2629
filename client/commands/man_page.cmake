# Writes a man page from what a program says of itself:
#   cmake -D PROGRAM=… -D SUBCOMMAND=… -D VERSION=… -D HELP2MAN=… -D PAGE=…/torquectl-send.1
#         -D SEE_ALSO="torqued(1) torqued-signs(7)" -P man_page.cmake
execute_process(COMMAND ${PROGRAM} ${SUBCOMMAND} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
get_filename_component(name ${PROGRAM} NAME)
get_filename_component(folder ${PAGE} DIRECTORY)
get_filename_component(page ${PAGE} NAME_WE)
string(REGEX MATCH "^[^\n]*" summary "${help}")
string(REGEX REPLACE "^${name} " "" summary "${summary}")

# help2man would fill the lines of an example
string(FIND "${help}" "\nExample" example_at)
set(example "")
if(example_at GREATER -1)
  string(SUBSTRING "${help}" ${example_at} -1 example)
  string(SUBSTRING "${help}" 0 ${example_at} help)
  string(REPLACE "\\" "\\e" example "${example}")
  set(example "[example]\n.nf${example}.fi\n\n")
endif()
string(REGEX REPLACE "([^ ]+)([(][0-9][)])" ".BR \\1 \\2" see_also "${SEE_ALSO}")
string(REGEX REPLACE "([)]) " "\\1,\n" see_also "${see_also}")
string(APPEND example "[see also]\n.ad l\n.nh\n${see_also}\n")
file(WRITE ${folder}/${page}.example "${example}")
file(WRITE ${folder}/${page}.help "${help}\n")
file(WRITE ${folder}/${page} "#!/bin/sh\ncat \"$0.help\"\n")
file(CHMOD ${folder}/${page} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
execute_process(
  COMMAND ${HELP2MAN} --no-info --section=1 --version-string=${VERSION} "--name=${summary}" --output=${PAGE}
          --include=${folder}/${page}.example ${folder}/${page}
  COMMAND_ERROR_IS_FATAL ANY)
