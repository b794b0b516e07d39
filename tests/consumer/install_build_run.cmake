# cmake -D... -P: installs a build of plumbline below WORK_DIR, builds slicer/example (CONSUMER_DIR) against it, and runs that.
# Needs BUILD_DIR CONSUMER_DIR WORK_DIR GENERATOR CXX_COMPILER BUILD_TYPE VERSION, and TOOLCHAIN_FILE, which may be empty.
cmake_policy(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with ${result}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --component development --prefix ${WORK_DIR}/prefix)

# A static library that was built with a sanitizer can only be linked with it, so the toolchain file is passed on.
if(TOOLCHAIN_FILE)
  set(compiler -DCMAKE_TOOLCHAIN_FILE=${TOOLCHAIN_FILE})
else()
  set(compiler -DCMAKE_CXX_COMPILER=${CXX_COMPILER})
endif()
run(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${WORK_DIR}/build -G ${GENERATOR} ${compiler}
    -DCMAKE_BUILD_TYPE=${BUILD_TYPE} -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix)
if(NOT output MATCHES "Found plumbline ${VERSION}\n")
  message(FATAL_ERROR "the version found is not ${VERSION}: ${output}")
endif()
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${WORK_DIR}/build/embed)
# A ball of radius 5 mm has 523.6 mm^3.
if(NOT output MATCHES "^100 layers, 52[34] mm\\^3\n$")
  message(FATAL_ERROR "the example printed: ${output}")
endif()

# The installed package names no folder of the build it comes from.
file(GLOB_RECURSE package_files ${WORK_DIR}/prefix/*.cmake)
foreach(file IN LISTS package_files)
  file(READ ${file} text)
  string(FIND "${text}" "${BUILD_DIR}/slicer" at)
  if(NOT at EQUAL -1)
    message(FATAL_ERROR "${file} names ${BUILD_DIR}/slicer")
  endif()
endforeach()
