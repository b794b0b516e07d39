# 64-bit ARM boards: Debian's arm64. See README.md in this folder.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(triplet aarch64-linux-gnu)
set(debian_arch arm64)
include(${CMAKE_CURRENT_LIST_DIR}/debian_sysroot.cmake)
# ctest runs the tests under this.
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64;-L;${PLUMBLINE_SYSROOT})
