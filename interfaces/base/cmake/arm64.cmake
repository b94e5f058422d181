# SPDX-License-Identifier: Apache-2.0
# Toolchain file: compiles for Debian's arm64 on another machine, against the files of a sysroot (.ci/sysroot), and runs what was
# built under qemu-user. ./dev build --arch arm64 passes it; by hand:
#
#   cmake -DCMAKE_TOOLCHAIN_FILE=interfaces/base/cmake/arm64.cmake -DNACELLE_SYSROOT=$(.ci/sysroot) ...
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES NACELLE_SYSROOT)
if(NOT EXISTS "${NACELLE_SYSROOT}/usr/include")
  message(FATAL_ERROR "NACELLE_SYSROOT='${NACELLE_SYSROOT}' holds no Debian: pass the folder that .ci/sysroot prints")
endif()
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_SYSROOT ${NACELLE_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
# The processor of a Pi 4, whose atomic operations are pairs of load-exclusive and store-exclusive.
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -cpu cortex-a72 -L ${NACELLE_SYSROOT})
