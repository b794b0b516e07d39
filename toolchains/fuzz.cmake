# libFuzzer with AddressSanitizer and UndefinedBehaviorSanitizer, clang. This instruments the libraries for coverage; each fuzz target
# links the fuzzer's main() itself (tests/CMakeLists.txt).
set(CMAKE_CXX_COMPILER clang++)
set(CMAKE_CXX_FLAGS_INIT
    "-fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow -fno-sanitize-recover=all -fno-omit-frame-pointer")
set(CMAKE_CXX_FLAGS_DEBUG_INIT "-O1 -D_GLIBCXX_ASSERTIONS")
