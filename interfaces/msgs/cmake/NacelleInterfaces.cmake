# SPDX-License-Identifier: Apache-2.0
# C++ from ROS 2 interface definitions.
#
#   nacelle_generate_interfaces(<ros package> DIRECTORY <dir> [DEPENDS <ros package> ...] [NO_INSTALL])
#
# <dir> holds msg/*.msg, srv/*.srv and action/*.action. Makes the shared library target nacelle_msgs_<ros package>
# (nacelle::msgs_<ros package>, libnacelle_msgs_<ros package>.so); its headers are <package/msg/name.hpp>. Packages
# whose messages are named in the definitions are found by themselves; DEPENDS adds others. A user's own package:
#
#   find_package(nacelle_msgs REQUIRED)
#   nacelle_generate_interfaces(my_robot_msgs DIRECTORY interfaces)
#   target_link_libraries(my_node PRIVATE nacelle::msgs_my_robot_msgs)
include_guard(GLOBAL)
include(GNUInstallDirs)

# In the source tree the generator is beside this folder, installed it is beside this file. The functions are used in
# directories that do not see this one's variables, so that what they need is kept globally.
if(EXISTS ${CMAKE_CURRENT_LIST_DIR}/../generator/generate.py)
  cmake_path(SET _generator NORMALIZE ${CMAKE_CURRENT_LIST_DIR}/../generator)
else()
  set(_generator ${CMAKE_CURRENT_LIST_DIR}/generator)
endif()
set_property(GLOBAL PROPERTY NACELLE_GENERATOR_DIR ${_generator})
# Below a prefix: <package>/{msg,srv,action}.
set_property(GLOBAL PROPERTY NACELLE_DEFINITIONS_SUBDIR share/nacelle/interfaces)

# Debian's Python, whatever else is in PATH: only it sees python3-rosidl. -I ignores PYTHONPATH and user packages.
function(_nacelle_find_generator_python)
  if(NACELLE_PYTHON_CHECKED)
    return()
  endif()
  find_program(NACELLE_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
  if(NOT NACELLE_PYTHON)
    message(FATAL_ERROR "Nacelle's message generator needs /usr/bin/python3: "
                        "apt install python3 python3-rosidl python3-empy")
  endif()
  # rosidl's own modules import em, which python3-rosidl does not depend on.
  foreach(probe "em;python3-empy" "rosidl_adapter.parser, rosidl_pycommon, rosidl_parser.parser;python3-rosidl")
    list(GET probe 0 modules)
    list(GET probe 1 debian_package)
    execute_process(COMMAND ${NACELLE_PYTHON} -I -c "import ${modules}" RESULT_VARIABLE failed ERROR_VARIABLE said)
    if(failed)
      message(FATAL_ERROR "${NACELLE_PYTHON} cannot import ${modules}: apt install ${debian_package}\n${said}")
    endif()
  endforeach()
  set(NACELLE_PYTHON_CHECKED ON CACHE INTERNAL "The generator's Python has its modules")
endfunction()

# Asks the generator what it would make of packages, given as <package>=<directory>. One process for many: each costs
# 0.1 s.
function(_nacelle_list_interfaces)
  _nacelle_find_generator_python()
  get_property(generator_dir GLOBAL PROPERTY NACELLE_GENERATOR_DIR)
  execute_process(COMMAND ${NACELLE_PYTHON} -I ${generator_dir}/generate.py list --package ${ARGN}
                  OUTPUT_VARIABLE listed RESULT_VARIABLE failed ERROR_VARIABLE said)
  if(failed)
    message(FATAL_ERROR "${ARGN}: ${said}")
  endif()
  # Four lines for each package, each line a list.
  string(REPLACE ";" "\\;" listed "${listed}")
  string(REPLACE "\n" ";" listed "${listed}")
  set(index 0)
  foreach(named ${ARGN})
    string(REGEX REPLACE "=.*" "" package "${named}")
    foreach(what HEADERS SOURCES FILES USES)
      list(GET listed ${index} line)
      math(EXPR index "${index} + 1")
      set_property(GLOBAL PROPERTY NACELLE_INTERFACE_${what}_${package} "${line}")
    endforeach()
    set_property(GLOBAL PROPERTY NACELLE_INTERFACE_LISTED_${package} "${named}")
  endforeach()
endfunction()

# What the generator would make of one package, in the variables headers, sources, files and uses of the caller.
macro(_nacelle_get_interfaces package directory)
  get_property(_listed GLOBAL PROPERTY NACELLE_INTERFACE_LISTED_${package})
  if(NOT _listed STREQUAL "${package}=${directory}")
    _nacelle_list_interfaces(${package}=${directory})
  endif()
  get_property(headers GLOBAL PROPERTY NACELLE_INTERFACE_HEADERS_${package})
  get_property(sources GLOBAL PROPERTY NACELLE_INTERFACE_SOURCES_${package})
  get_property(files GLOBAL PROPERTY NACELLE_INTERFACE_FILES_${package})
  get_property(uses GLOBAL PROPERTY NACELLE_INTERFACE_USES_${package})
endmacro()

# Where the definitions of a package are: made in this build, or installed in a prefix.
function(_nacelle_find_definitions package result)
  get_property(directory GLOBAL PROPERTY NACELLE_DEFINITIONS_${package})
  get_property(subdir GLOBAL PROPERTY NACELLE_DEFINITIONS_SUBDIR)
  if(NOT directory)
    # This file is in <prefix>/lib/cmake/nacelle_msgs, or a level deeper with lib/<architecture>.
    cmake_path(SET own_prefix NORMALIZE ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../../..)
    set(prefixes ${CMAKE_PREFIX_PATH} $ENV{CMAKE_PREFIX_PATH} ${own_prefix} ${CMAKE_INSTALL_PREFIX} /usr/local /usr)
    string(REPLACE ":" ";" prefixes "${prefixes}")
    foreach(prefix ${prefixes})
      foreach(root ${prefix} ${prefix}/..)
        if(NOT directory AND IS_DIRECTORY ${root}/${subdir}/${package})
          set(directory ${root}/${subdir}/${package})
        endif()
      endforeach()
    endforeach()
  endif()
  set(${result} "${directory}" PARENT_SCOPE)
endfunction()

function(nacelle_generate_interfaces package)
  cmake_parse_arguments(A "NO_INSTALL" "DIRECTORY" "DEPENDS" ${ARGN})
  if(NOT A_DIRECTORY OR A_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "nacelle_generate_interfaces(<ros package> DIRECTORY <dir> [DEPENDS <ros package> ...] "
                        "[NO_INSTALL])")
  endif()
  cmake_path(ABSOLUTE_PATH A_DIRECTORY BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE OUTPUT_VARIABLE directory)
  _nacelle_get_interfaces(${package} ${directory})
  if(NOT files)
    message(FATAL_ERROR "${package}: no definition in ${directory}/msg, ${directory}/srv or ${directory}/action")
  endif()
  # A changed definition may name other packages; a changed folder holds other definitions.
  foreach(kind msg srv action)
    if(IS_DIRECTORY ${directory}/${kind})
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${directory}/${kind})
    endif()
  endforeach()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})
  set_property(GLOBAL PROPERTY NACELLE_DEFINITIONS_${package} ${directory})

  set(depends_arguments "")
  set(libraries "")
  set(all_files ${files})
  set(own_headers ${headers})
  set(own_sources ${sources})
  set(pending ${uses} ${A_DEPENDS})
  set(known ${package})
  while(pending)
    list(POP_FRONT pending next)
    if(next IN_LIST known)
      continue()
    endif()
    list(APPEND known ${next})
    _nacelle_find_definitions(${next} next_directory)
    if(NOT next_directory OR NOT TARGET nacelle::msgs_${next})
      message(FATAL_ERROR "${package} uses messages of '${next}', which is neither generated in this build nor found: "
                          "find_package() what provides nacelle::msgs_${next}, and generate it before ${package}")
    endif()
    list(APPEND depends_arguments ${next}=${next_directory})
    list(APPEND libraries nacelle::msgs_${next})
    _nacelle_get_interfaces(${next} ${next_directory})
    list(APPEND all_files ${files})
    list(APPEND pending ${uses})
  endwhile()

  set(output ${PROJECT_BINARY_DIR}/nacelle_interfaces)
  list(TRANSFORM own_headers PREPEND ${output}/)
  list(TRANSFORM own_sources PREPEND ${output}/)
  get_property(generator_dir GLOBAL PROPERTY NACELLE_GENERATOR_DIR)
  file(GLOB generator ${generator_dir}/*.py)
  set(stamp ${output}/${package}.stamp)
  # The stamp is what the build looks at: files whose text did not change keep their time, and nothing is compiled
  # again.
  add_custom_command(
    OUTPUT ${stamp} BYPRODUCTS ${own_sources} ${own_headers}
    COMMAND ${NACELLE_PYTHON} -I ${generator_dir}/generate.py generate --package ${package}=${directory}
            --output ${output} --depends ${depends_arguments}
    COMMAND ${CMAKE_COMMAND} -E touch ${stamp}
    DEPENDS ${all_files} ${generator}
    COMMENT "Generating messages of ${package}"
    VERBATIM)

  set(target nacelle_msgs_${package})
  set(compiled ${own_sources})
  nacelle_unite(compiled ${target})
  add_library(${target} SHARED ${compiled} ${stamp})
  # Copies and tables: -O2 takes twice as long to compile and is no faster (the codec is in libnacelle_msgs_runtime).
  set(NACELLE_LEVEL -O1)
  set(NACELLE_READS_NO_BYTES ON)
  nacelle_target_defaults(${target})
  target_compile_options(${target} PRIVATE $<$<CONFIG:RelWithDebInfo>:-g1>)
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${output}/include>
                                              $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/nacelle/msgs>)
  target_link_libraries(${target} PUBLIC nacelle::msgs_runtime ${libraries})
  set_property(GLOBAL APPEND PROPERTY NACELLE_MESSAGE_PACKAGES ${target})
  if(A_NO_INSTALL)
    add_library(nacelle::msgs_${package} ALIAS ${target})
    return()
  endif()
  # Found beside each other wherever they are installed; a program's own RUNPATH does not reach its libraries'
  # libraries.
  nacelle_library_version(${target})
  nacelle_rpath("$ORIGIN" ${target})
  _nacelle_register(${target} msgs_${package})
  install(DIRECTORY ${output}/include/${package} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/nacelle/msgs)
  get_property(subdir GLOBAL PROPERTY NACELLE_DEFINITIONS_SUBDIR)
  foreach(kind msg srv action)
    if(IS_DIRECTORY ${directory}/${kind})
      install(DIRECTORY ${directory}/${kind} DESTINATION ${subdir}/${package}
              FILES_MATCHING PATTERN "*.${kind}")
    endif()
  endforeach()
endfunction()
