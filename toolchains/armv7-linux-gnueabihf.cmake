# 32-bit ARM boards with a floating-point unit: Debian's armhf. See README.md in this folder.
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(triplet arm-linux-gnueabihf)
set(debian_arch armhf)
include(${CMAKE_CURRENT_LIST_DIR}/debian_sysroot.cmake)
# gcc notes where gcc 7 changed how arguments are passed. No code here was compiled by an older one.
# On 32 bits gcc 12 takes a std::string_view or std::string for up to 4 GiB long, and warns inside the library that no object
# is so large. The 64-bit builds keep these warnings.
set(CMAKE_CXX_FLAGS_INIT "-Wno-psabi -Wno-stringop-overflow -Wno-stringop-overread -Wno-array-bounds -Wno-restrict")
# Debian 12's cross compiler fills the memory when it reads the precompiled headers of the tests.
set(PLUMBLINE_PRECOMPILE_TESTS OFF)
# ctest runs the tests under this.
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-arm;-L;${PLUMBLINE_SYSROOT})
