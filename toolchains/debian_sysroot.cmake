# Shared by the cross builds. Set `triplet` (such as aarch64-linux-gnu) and `debian_arch` before including it.
# toolchains/make_sysroot makes the sysroot; PLUMBLINE_SYSROOT names another one.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_LIBRARY_ARCHITECTURE ${triplet})
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)

if(NOT PLUMBLINE_SYSROOT)
  if(DEFINED ENV{PLUMBLINE_SYSROOTS})
    set(PLUMBLINE_SYSROOT $ENV{PLUMBLINE_SYSROOTS}/${debian_arch})
  elseif(DEFINED ENV{XDG_CACHE_HOME})
    set(PLUMBLINE_SYSROOT $ENV{XDG_CACHE_HOME}/plumbline/sysroot/${debian_arch})
  else()
    set(PLUMBLINE_SYSROOT $ENV{HOME}/.cache/plumbline/sysroot/${debian_arch})
  endif()
endif()
if(NOT EXISTS ${PLUMBLINE_SYSROOT}/usr/include)
  message(FATAL_ERROR "no sysroot in ${PLUMBLINE_SYSROOT}: run toolchains/make_sysroot ${debian_arch}")
endif()
# try_compile() reads this file again, without the cache.
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES PLUMBLINE_SYSROOT)

set(PLUMBLINE_DEBIAN_ARCHITECTURE ${debian_arch})

set(CMAKE_SYSROOT ${PLUMBLINE_SYSROOT})
set(CMAKE_FIND_ROOT_PATH ${PLUMBLINE_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
