# AddressSanitizer and UndefinedBehaviorSanitizer, gcc. See README.md in this folder.
set(CMAKE_CXX_COMPILER g++)

# "undefined" does not include float-cast-overflow, which finds coordinates outside the range of a pixel index.
set(CMAKE_CXX_FLAGS_INIT
    "-fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -fno-omit-frame-pointer \
-Wno-maybe-uninitialized")
# With the sanitizers gcc 12 warns falsely of uninitialised values in std::optional and std::regex. The release build keeps the warning.
# -O1: Eigen is unusably slow without inlining. Debug keeps our asserts; the macro adds the standard library's.
set(CMAKE_CXX_FLAGS_DEBUG_INIT "-O1 -D_GLIBCXX_ASSERTIONS")
