# AddressSanitizer and UndefinedBehaviorSanitizer, gcc. See README.md in this folder.
set(CMAKE_CXX_COMPILER g++)

# float-cast-overflow is not in "undefined", but a coordinate that leaves the range of a pixel index is what we look for.
set(CMAKE_CXX_FLAGS_INIT
    "-fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -fno-omit-frame-pointer \
-Wno-maybe-uninitialized")
# gcc 12 takes what the sanitizers add to std::optional and std::regex for uses of values that nobody has set; the release build has
# the warning.
# -O1: Eigen is unusably slow without inlining. Debug keeps our asserts, the macro adds those of the standard library.
set(CMAKE_CXX_FLAGS_DEBUG_INIT "-O1 -D_GLIBCXX_ASSERTIONS")
