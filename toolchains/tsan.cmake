# ThreadSanitizer, clang. gcc's OpenMP run time can't be used under it: see README.md in this folder.
set(CMAKE_CXX_COMPILER clang++)
set(CMAKE_CXX_FLAGS_INIT "-fsanitize=thread -fno-omit-frame-pointer")
set(CMAKE_CXX_FLAGS_DEBUG_INIT "-O1 -D_GLIBCXX_ASSERTIONS")
