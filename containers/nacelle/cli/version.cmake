# SPDX-License-Identifier: Apache-2.0
# Writes cli/version.cpp: the version, and the commit as far as it is known. Runs at each build, and writes only what has changed.
#   cmake -DVERSION=0.1.0 -DOUTPUT=FILE -P version.cmake
set(commit "$Format:%H$")  # of an archive that git has made
if(commit MATCHES "^[0-9a-f]+$")
  string(SUBSTRING "${commit}" 0 12 commit)
else()
  set(commit "")
  set(ENV{GIT_OPTIONAL_LOCKS} 0)
  set(git git -c safe.directory=* -C ${CMAKE_CURRENT_LIST_DIR})
  # A copy of these sources may lie in another repository.
  execute_process(COMMAND ${git} rev-parse --show-prefix OUTPUT_VARIABLE prefix ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed AND prefix STREQUAL "containers/nacelle/cli/\n")
    execute_process(COMMAND ${git} describe --always --dirty --abbrev=12 --exclude=* OUTPUT_VARIABLE commit ERROR_QUIET
                    OUTPUT_STRIP_TRAILING_WHITESPACE)
  endif()
endif()
if(commit)
  string(APPEND VERSION " (${commit})")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [=[
#include "cli/version.hpp"

const char* nacelle::cli::program_version() { return "@VERSION@"; }
]=])
