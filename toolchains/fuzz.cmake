# libFuzzer with AddressSanitizer and UndefinedBehaviorSanitizer, clang. The libraries are instrumented for coverage
# here; what links the fuzzer's main() is a fuzz target's own affair (tests/CMakeLists.txt).
set(CMAKE_CXX_COMPILER clang++)
set(CMAKE_CXX_FLAGS_INIT
    "-fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow -fno-sanitize-recover=all -fno-omit-frame-pointer")
set(CMAKE_CXX_FLAGS_DEBUG_INIT "-O1 -D_GLIBCXX_ASSERTIONS")
