# Bundles the page into the folder `out`, from a copy of its sources beside it:
#   cmake -D out=FOLDER -D earlier=FOLDER -P web/build.cmake
# Where Node.js is missing or fails, the page built earlier is taken. If there is none either,
# a message says so: this never fails.
cmake_minimum_required(VERSION 3.18)

set(copy ${out}-sources)
file(REMOVE_RECURSE ${out} ${copy})

# Runs npm in the copy. Sets `done` to whether that went well.
function(run_npm)
  execute_process(COMMAND ${npm} ${ARGV} WORKING_DIRECTORY ${copy} TIMEOUT 900
    RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(result STREQUAL "0")
    set(done TRUE PARENT_SCOPE)
  else()
    set(done FALSE PARENT_SCOPE)
    message("npm ${ARGV}: ${result}\n${said}")
  endif()
endfunction()

set(done FALSE)
if(CMAKE_HOST_WIN32)
  find_program(npm npm.cmd)
else()
  find_program(npm npm)
endif()
if(npm)
  file(COPY ${CMAKE_CURRENT_LIST_DIR}/ DESTINATION ${copy} PATTERN node_modules EXCLUDE)
  run_npm(ci)
  if(done)
    run_npm(run build -- --out ${out})
  endif()
  file(REMOVE_RECURSE ${copy})
endif()

if(NOT done)
  file(REMOVE_RECURSE ${out})
  if(EXISTS ${earlier}/index.html)
    message("The studio's page is taken as it was built before.")
    file(COPY ${earlier}/ DESTINATION ${out})
  else()
    message("The studio is left out: its page is built by Node.js 18 or later, with npm.")
  endif()
endif()
